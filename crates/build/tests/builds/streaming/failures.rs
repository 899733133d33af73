//! Sources that fail on the way.

use isoray_build::{BuildError, FileOptions, build, build_file};
use isoray_grid::Dims;

use super::sources::{Source, Way, names, samples, with_threads};

#[test]
fn a_source_that_fails_is_the_error_and_leaves_nothing() {
    let dims = Dims::new([20, 70, 40]).unwrap();
    let samples = samples::<i16>(dims);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.ovol");
    for (way, threads) in [(Way::Rows, 1), (Way::Rows, 3), (Way::Stream, 1), (Way::Stream, 3)] {
        for end in [0, 1, 7, 8, 9, 16, 17, 39] {
            let source = || Source { end, ..Source::new(dims, &samples, way) };
            with_threads(threads, || {
                for memory in [None, Some(1 << 26)] {
                    let options = FileOptions { memory, ..FileOptions::default() };
                    let error = build_file(&mut source(), &path, &options, |_| {}).unwrap_err();
                    assert!(matches!(&error, BuildError::Source(e) if e.layer >= end), "{error:?}");
                }
                let error = build(&mut source(), glam::DAffine3::IDENTITY, |_| {}).unwrap_err();
                assert!(matches!(error, BuildError::Source(_)), "{error:?}");
            });
            assert_eq!(names(folder.path()), [""; 0]);
        }
    }
}

#[test]
fn what_was_there_stays_when_a_build_fails() {
    let dims = Dims::new([20, 20, 20]).unwrap();
    let samples = samples::<u8>(dims);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.ovol");
    std::fs::write(&path, b"old").unwrap();
    let mut source = Source { end: 12, ..Source::new(dims, &samples, Way::Stream) };
    build_file(&mut source, &path, &FileOptions::default(), |_| {}).unwrap_err();
    assert_eq!(std::fs::read(&path).unwrap(), b"old");
    assert_eq!(names(folder.path()), ["a.ovol"]);
}
