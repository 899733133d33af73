//! The bytes of a file depend on the volume alone.

use std::fs;
use std::path::Path;

use isoray_build::{BuildError, FileOptions, build, build_file};
use isoray_grid::{DenseVolume, Dims};

use super::sources::{Sample, Source, Way, names, samples, with_threads};

/// A block, parts of one, several strips, several layers of blocks, and all of these.
const SIZES: [[u32; 3]; 8] =
    [[1, 1, 1], [5, 3, 2], [8, 8, 8], [33, 31, 9], [9, 40, 17], [21, 67, 35], [70, 33, 26], [17, 131, 41]];

/// The least limit that such a build takes, as its refusal tells.
fn least<T: Sample>(dims: Dims, samples: &[T], way: Way, path: &Path) -> u64 {
    let options = FileOptions { memory: Some(1), ..FileOptions::default() };
    match build_file(&mut Source::new(dims, samples, way), path, &options, |_| {}) {
        Err(BuildError::Limit { needed, .. }) => needed,
        other => panic!("{dims} {way:?}: {other:?}"),
    }
}

fn check<T: Sample>(size: [u32; 3]) {
    let dims = Dims::new(size).unwrap();
    let samples = samples::<T>(dims);
    let folder = tempfile::tempdir().unwrap();
    let saved = folder.path().join("saved.ovol");
    let mut dense = DenseVolume::new(dims, &samples).unwrap();
    build(&mut dense, glam::DAffine3::IDENTITY, |_| {}).unwrap().save(&saved).unwrap();
    let saved = fs::read(saved).unwrap();
    let path = folder.path().join("built.ovol");
    for threads in [1, 2, 3, 7] {
        for way in [Way::Rows, Way::Stream] {
            with_threads(threads, || {
                let least = least(dims, &samples, way, &path);
                // From one strip for each thread, nothing read ahead and no node in memory, to all there is.
                let limits =
                    [0, 10_000, 200_000, 3_000_000].map(|more| Some(least + more)).into_iter().chain([None]);
                for memory in limits {
                    let options = FileOptions { memory, ..FileOptions::default() };
                    let mut source = Source::new(dims, &samples, way);
                    let (length, _) = build_file(&mut source, &path, &options, |_| {}).unwrap();
                    let built = fs::read(&path).unwrap();
                    assert_eq!(length, built.len() as u64);
                    let case = format!("{dims} {} {way:?}, {threads} threads, {memory:?} bytes", T::TYPE);
                    assert!(built == saved, "{case}: not the bytes of the volume built in memory");
                }
            });
        }
    }
    assert_eq!(names(folder.path()).len(), 2);
}

fn check_all<T: Sample>() {
    SIZES.into_iter().for_each(check::<T>);
}

#[test]
fn bytes_of_u8() {
    check_all::<u8>();
}

#[test]
fn bytes_of_i8() {
    check_all::<i8>();
}

#[test]
fn bytes_of_u16() {
    check_all::<u16>();
}

#[test]
fn bytes_of_i16() {
    check_all::<i16>();
}

#[test]
fn bytes_of_f32() {
    check_all::<f32>();
}
