use std::io;

use super::*;

#[test]
fn scenes_have_simple_file_names() {
    assert_eq!(file_name("tooth (fixture) at 600, along z", "exr"), "tooth-fixture-at-600-along-z.exr");
}

fn plain(grey: u8) -> Picture {
    Picture { size: [2, 2], rgb: vec![grey; 12] }
}

/// A folder of references, and what is in it.
struct Folder(tempfile::TempDir);

impl Folder {
    fn references(&self, is_update: bool) -> References {
        References::of(self.0.path().join("stored"), self.0.path().join("scratch"), is_update)
    }

    fn with(&self, pictures: &[(&str, Picture)]) -> References {
        let mut references = self.references(true);
        for (scene, picture) in pictures {
            assert_eq!(references.picture((scene, scene), picture, |_| false).unwrap().1, None);
        }
        references
    }

    /// Names and greys.
    fn stored(&self) -> Vec<(String, u8)> {
        let files = fs::read_dir(self.0.path().join("stored")).unwrap().map(|entry| entry.unwrap());
        let grey = |path: &Path| Picture::read(path).unwrap().rgb[0];
        let name = |entry: &fs::DirEntry| entry.file_name().into_string().unwrap();
        let mut stored: Vec<_> = files.map(|entry| (name(&entry), grey(&entry.path()))).collect();
        stored.sort();
        stored
    }
}

fn named(stored: &[(&str, u8)]) -> Vec<(String, u8)> {
    stored.iter().map(|(name, grey)| (format!("{name}.png"), *grey)).collect()
}

#[test]
fn all_references_are_replaced_or_none() {
    let folder = Folder(tempfile::tempdir().unwrap());
    assert_eq!(folder.with(&[("a", plain(1)), ("b", plain(2)), ("c", plain(3))]).store(&[]).unwrap(), 3);
    let first = named(&[("a", 1), ("b", 2), ("c", 3)]);
    assert_eq!(folder.stored(), first);
    // The second one cannot be written.
    let broken = Picture { size: [3, 2], ..plain(9) };
    assert!(folder.with(&[("a", plain(8)), ("b", broken)]).store(&[]).is_err());
    assert_eq!(folder.stored(), first);
    // Whichever move fails, old and new files are where they were. `d` has no old file, and `c` is to go.
    let new = || folder.with(&[("a", plain(7)), ("b", plain(8)), ("d", plain(9))]);
    let orphans = ["c.png".to_owned()];
    for failing in 0..6 {
        let mut count = 0;
        let mut by = |from: &Path, to: &Path| {
            count += 1;
            if count == failing + 1 { Err(io::Error::other("no")) } else { replace::moved(from, to) }
        };
        let error = new().store_by(&orphans, &mut by).unwrap_err();
        assert!(error.to_string().contains("cannot be replaced"), "{error}");
        assert_eq!(folder.stored(), first, "with move {failing} failing");
    }
    assert_eq!(new().store(&orphans).unwrap(), 3);
    assert_eq!(folder.stored(), named(&[("a", 7), ("b", 8), ("d", 9)]));
    assert_eq!(fs::read_dir(folder.0.path().join("scratch")).unwrap().count(), 0);
}

#[test]
fn scenes_with_one_reference_must_look_alike() {
    let folder = Folder(tempfile::tempdir().unwrap());
    let mut references = folder.with(&[("a", plain(1))]);
    let told = |references: &mut References, grey| {
        references.picture(("a", "golden test, another of a"), &plain(grey), |_| false).unwrap().1
    };
    assert_eq!(told(&mut references, 1), None);
    assert!(told(&mut references, 90).unwrap().contains("unlike a.png: 4 pixels differ"));
}

#[test]
fn files_without_a_scene_and_scenes_without_a_file_are_told() {
    let folder = Folder(tempfile::tempdir().unwrap());
    folder.with(&[("a", plain(1)), ("b", plain(2))]).store(&[]).unwrap();
    let mut references = folder.references(false);
    let mut picture = |scene: &str, picture: Picture| {
        references.picture((scene, &format!("golden test, {scene}")), &picture, |_| false).unwrap().1
    };
    assert_eq!(picture("a", plain(1)), None);
    let missing = picture("c", plain(1)).unwrap();
    assert!(missing.contains("c.png") && missing.contains("--update"), "{missing}");
    let wrong = picture("a", Picture { size: [4, 1], ..plain(1) }).unwrap();
    assert!(wrong.contains("a.png") && wrong.contains("the picture [4, 1]"), "{wrong}");
    assert_eq!(references.orphans().unwrap(), ["b.png"]);
}

#[test]
fn pixels_that_graze_may_differ_and_no_others() {
    let hit = |depth: f32| Pixel { depth, normal: Vec3::Z, color: Vec3::ONE.extend(1.0) };
    // A hit, a miss and a hit.
    let stored = [vec![2.0, f32::INFINITY, 3.0], vec![0.0; 3], vec![0.0; 3], vec![1.0, 0.0, 1.0]];
    let allowed = |pixels: [Pixel; 3], grazing: &[usize]| {
        Differences::of(&stored, &pixels, |n| grazing.contains(&n)).are_allowed()
    };
    assert!(allowed([hit(2.0), Pixel::EMPTY, hit(3.0)], &[]));
    // Another side, and another depth.
    for pixels in [[hit(2.0), hit(2.5), hit(3.0)], [hit(2.0), Pixel::EMPTY, hit(3.5)]] {
        let n = if is_hit(&pixels[1]) { 1 } else { 2 };
        assert!(!allowed(pixels, &[]));
        assert!(!allowed(pixels, &[0]), "another pixel grazes");
        assert!(allowed(pixels, &[n]));
    }
}

#[test]
fn pixels_beyond_a_bound_are_told() {
    let mut beyond = Beyond::default();
    assert_eq!(beyond.told(10), "no pixel");
    for (n, by) in [(3, 0.1), (14, 0.3), (25, f64::NAN), (27, 0.7)] {
        beyond.add(n, by, 0.2);
    }
    assert_eq!(beyond.told(10), "3 pixels, the first at (4, 1), the worst at (7, 2) by 7.000e-1");
}
