//! Files with coarse samples.

use isoray_build::{BuildError, FileOptions, build_file};
use isoray_grid::{DenseVolume, Dims};
use isoray_octree::{AnyVolume, Coarse};

use super::dense::octree;
use crate::octree::volumes::{Content, dense};

#[test]
fn files_are_those_of_the_volume_in_memory() {
    let size = [70, 35, 33];
    let samples = dense::<u16>(size, Content::Blocks);
    let folder = tempfile::tempdir().unwrap();
    let mut lengths = Vec::new();
    for coarse in Coarse::ALL {
        let [path, saved] = ["built.ovol", "saved.ovol"].map(|name| folder.path().join(name));
        let mut source = DenseVolume::new(Dims::new(size).unwrap(), &samples).unwrap();
        let options = FileOptions { coarse, ..FileOptions::default() };
        let (length, meta) = build_file(&mut source, &path, &options, |_| {}).unwrap();
        assert_eq!(meta.coarse, coarse);
        octree(size, &samples, coarse).save(&saved).unwrap();
        assert!(std::fs::read(&path).unwrap() == std::fs::read(&saved).unwrap(), "{coarse:?}");
        AnyVolume::open(&path).unwrap().verify(&path).unwrap();
        lengths.push(length);
    }
    // Values are stored for each child anyway: what they are changes no size.
    assert!(lengths.iter().all(|&length| length == lengths[0]), "{lengths:?}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2, "nothing else is left");
}

#[test]
fn a_file_of_the_wrong_kind_is_refused() {
    let size = [40, 35, 33];
    let samples = dense::<u8>(size, Content::Noise);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.ovol");
    let volume = octree(size, &samples, Coarse::Mean);
    volume.save(&path).unwrap();
    let mut bytes = std::fs::read(&path).unwrap();
    assert_eq!(bytes[15], Coarse::Mean as u8);
    bytes[15] = Coarse::Filtered as u8;
    let table = 32 * u32::from_le_bytes(bytes[28..32].try_into().unwrap()) as usize;
    bytes[164..168].fill(0);
    let checksum = crc32fast::hash(&bytes[..2304 + table]);
    bytes[164..168].copy_from_slice(&checksum.to_le_bytes());
    std::fs::write(&path, &bytes).unwrap();
    assert!(AnyVolume::open(&path).unwrap().verify(&path).is_err());
}

#[test]
fn nodes_that_do_not_fit_the_limit_are_an_error() {
    // Noise has the most nodes; what a limit must allow for anyway is about as much as the pass needs beside them.
    let size = [260, 256, 256];
    let dims = Dims::new(size).unwrap();
    let samples = dense::<u8>(size, Content::Noise);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.ovol");
    let build = |coarse, memory| {
        let mut source = DenseVolume::new(dims, &samples).unwrap();
        let options = FileOptions { coarse, memory: Some(memory), ..FileOptions::default() };
        build_file(&mut source, &path, &options, |_| {})
    };
    let Err(BuildError::Limit { needed: least, .. }) = build(Coarse::Injected, 1) else { panic!() };
    let Err(BuildError::Limit { needed, limit, .. }) = build(Coarse::Mean, least) else {
        panic!("the least that does otherwise is enough")
    };
    assert!(limit == least && needed > least, "{limit} {needed}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "nothing is left");
    assert!(build(Coarse::Mean, needed).is_ok());
}
