//! Pages of a mapped file that a picture does not touch.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use isoray_grid::Scalar;
use isoray_octree::{AnyVolume, OctreeVolume, VolumeVisitor};
use isoray_render::{Camera, Image, Scene, render};

use super::{Setting, SkippingRow};
use crate::bench::timer::interleave;
use crate::catalog::{Dense, DenseVisitor, Place};

pub(super) struct Pages<'a>(pub(super) Setting<'a>);

impl DenseVisitor for Pages<'_> {
    type Output = Result<Vec<SkippingRow>>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        let Self(setting) = self;
        let size = setting.size(96, 256);
        let octree = volume.octree()?;
        let folder = tempfile::tempdir().context("no temporary folder")?;
        let path = folder.path().join("volume.ovol");
        octree.save(&path)?;
        let camera = volume.camera(Place::Close, size)?;
        let isovalue = setting.entry.isovalues[0];
        let expected = render(&octree.view(), volume.index_to_world, &camera, &Scene::of(isovalue));
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().context("cannot start a thread")?;
        let show =
            |reads_all| one.install(|| Show { path: &path, camera: &camera, isovalue, reads_all }.run());
        let mut kilobytes = [0.0; 2];
        for (reads_all, kilobytes) in [false, true].into_iter().zip(&mut kilobytes) {
            let (image, resident) = show(reads_all)?;
            ensure!(image == expected, "{}: the mapped file shows another picture", setting.entry.name);
            let Some(resident) = resident else {
                println!("SKIPPED: pages that are not touched; this system does not tell which are resident");
                return Ok(Vec::new());
            };
            *kilobytes = resident;
        }
        let file = octree.file_bytes() as f64 / 1024.0;
        ensure!(kilobytes[0] <= kilobytes[1], "{}: more pages than all of them", setting.entry.name);
        let mut failed = None;
        let mut frame = |reads_all| failed = show(reads_all).err().or(failed.take());
        let frame = std::cell::RefCell::new(&mut frame);
        let times = interleave(
            setting.repeat,
            &mut [&mut || (frame.borrow_mut())(false), &mut || (frame.borrow_mut())(true)],
        );
        if let Some(error) = failed {
            return Err(error);
        }
        let ns = [times[0], times[1]].map(|seconds| seconds * 1e9 / f64::from(size).powi(2));
        let counts =
            [("KB resident, in all", kilobytes), ("% of the file", kilobytes.map(|kb| 100.0 * kb / file))];
        Ok(vec![setting.row("surface close, opened", "pages never touched", ns, &counts)])
    }
}

/// A picture of a file that is opened for it.
struct Show<'a> {
    path: &'a Path,
    camera: &'a Camera,
    isovalue: f32,
    /// Reads all samples first, as from a file that is not mapped.
    reads_all: bool,
}

impl Show<'_> {
    /// The picture, and the kilobytes of the file that are resident in this process then.
    fn run(self) -> Result<(Image, Option<f64>)> {
        AnyVolume::open(self.path)?.visit(self)
    }
}

impl VolumeVisitor for Show<'_> {
    type Output = Result<(Image, Option<f64>)>;

    fn visit<T: Scalar>(self, volume: &OctreeVolume<T>) -> Self::Output {
        let view = volume.view();
        if self.reads_all {
            std::hint::black_box(view.caps().iter().fold(0u8, |all, byte| all ^ byte));
            let levels = isoray_octree::NODE_LEVEL..=view.root_level();
            let masks = levels.flat_map(|level| view.nodes(level)).fold(0, |all, node| all ^ node.mask);
            std::hint::black_box(masks);
        }
        let image = render(&view, volume.meta().index_to_world, self.camera, &Scene::of(self.isovalue));
        Ok((image, resident(self.path)))
    }
}

/// Kilobytes of the file at `path` that are mapped into this process and resident there; where Linux tells it.
///
/// A page that is touched brings those of the cache around it along, sixteen as a rule, so that this is more than what was touched.
fn resident(path: &Path) -> Option<f64> {
    let maps = std::fs::read_to_string("/proc/self/smaps").ok()?;
    resident_in(&maps, path.to_str()?)
}

/// The sum over all mappings of the file in the text of `smaps`.
fn resident_in(maps: &str, path: &str) -> Option<f64> {
    let mut sum = None;
    let mut is_of_file = false;
    for line in maps.lines() {
        let Some((key, rest)) = line.split_once(':').filter(|(key, _)| !key.contains(' ')) else {
            is_of_file = line.ends_with(path);
            continue;
        };
        if is_of_file && key == "Rss" {
            let kilobytes: f64 = rest.trim().strip_suffix("kB")?.trim().parse().ok()?;
            sum = Some(sum.unwrap_or(0.0) + kilobytes);
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mappings_of_the_file_alone_are_summed() {
        const MAPS: &str = "\
7f00-7f80 r--p 00000000 fe:00 12    /a/volume.ovol
Size:                512 kB
Rss:                 128 kB
7f80-7f90 r--p 00000000 fe:00 13    /a/other
Rss:                  64 kB
7f90-7fa0 r--s 00080000 fe:00 12    /a/volume.ovol
Rss:                   4 kB
VmFlags: rd mr mw me
7fb0-7fc0 rw-p 00000000 00:00 0
Rss:                   8 kB";
        assert_eq!(resident_in(MAPS, "/a/volume.ovol"), Some(132.0));
        assert_eq!(resident_in(MAPS, "/a/none"), None);
        assert_eq!(resident_in("", "/a/volume.ovol"), None);
    }
}
