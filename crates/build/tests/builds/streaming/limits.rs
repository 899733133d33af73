//! Limits on memory.

use isoray_build::{BuildError, FileOptions, build_file};
use isoray_grid::Dims;

use super::sources::{Source, Way, names, samples, with_threads};

#[test]
fn a_refusal_names_the_least_that_does() {
    let dims = Dims::new([40, 70, 20]).unwrap();
    let samples = samples::<u16>(dims);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.ovol");
    for (way, threads) in [(Way::Rows, 1), (Way::Stream, 1), (Way::Rows, 5), (Way::Stream, 5)] {
        with_threads(threads, || {
            let build = |memory| {
                let options = FileOptions { memory: Some(memory), ..FileOptions::default() };
                build_file(&mut Source::new(dims, &samples, way), &path, &options, |_| {})
            };
            let Err(refusal @ BuildError::Limit { needed, .. }) = build(1) else { panic!("{way:?}") };
            let text = refusal.to_string();
            for part in ["40x70x20", &needed.to_string(), &format!("{threads} threads"), "limit is 1"] {
                assert!(text.contains(part), "no '{part}' in {text}");
            }
            assert!(matches!(build(needed - 1), Err(BuildError::Limit { needed: n, .. }) if n == needed));
            assert_eq!(names(folder.path()), [""; 0]);
            build(needed).unwrap();
            std::fs::remove_file(&path).unwrap();
        });
    }
}

/// Nameless files that the process has open in `folder`.
#[cfg(target_os = "linux")]
fn spools(folder: &std::path::Path) -> usize {
    let open = std::fs::read_dir("/proc/self/fd").unwrap().flatten();
    let of_folder = open
        .filter_map(|entry| std::fs::read_link(entry.path()).ok())
        .filter(|target| target.starts_with(folder) && target.to_string_lossy().ends_with("(deleted)"));
    of_folder.count()
}

#[cfg(target_os = "linux")]
#[test]
fn nodes_wait_in_files_where_memory_is_short() {
    let dims = Dims::new([64, 64, 64]).unwrap();
    let samples = samples::<u8>(dims);
    let folder = tempfile::tempdir().unwrap();
    let real = folder.path().canonicalize().unwrap();
    let path = folder.path().join("a.ovol");
    let most = |memory| {
        let options = FileOptions { memory, ..FileOptions::default() };
        let (mut source, mut most) = (Source::new(dims, &samples, Way::Rows), 0);
        let built = build_file(&mut source, &path, &options, |_| most = most.max(spools(&real)));
        match built {
            Ok(_) => Ok(most),
            Err(BuildError::Limit { needed, .. }) => Err(needed),
            Err(other) => panic!("{other}"),
        }
    };
    let needed = most(Some(1)).unwrap_err();
    assert!(most(Some(needed)).unwrap() > 0, "no node was spooled");
    assert_eq!(most(None), Ok(0));
    assert_eq!(names(folder.path()), ["a.ovol"]);
}
