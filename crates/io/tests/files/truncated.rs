//! Every format cut off at every byte, and with random bytes changed: samples or a typed error.

use std::path::Path;

use isoray_io::SampleType;
use proptest::prelude::*;

use crate::damage::apply;
use crate::make::{body, write};
use crate::make_vtk::{Codec, Encoding, Vti, legacy_header};
use crate::mutations::{change, consume};
use crate::numpy::npy_header;

/// Whole valid files of the formats without seeds among the mutations.
fn seeds() -> Vec<(&'static str, Vec<u8>)> {
    let vti = |encoding, codec| ("vti", Vti::new(encoding, codec).bytes());
    let little = body(SampleType::I16, isoray_io::Endian::Little, 1, true);
    let legacy = |ascii| {
        let numbers: Vec<u8> = if ascii { b"12 ".repeat(60) } else { little.clone() };
        let start = legacy_header(ascii) + "FIELD f 1\nx 1 2 short\n";
        let time: &[u8] = if ascii { b"1 2\n" } else { b"abcd\n" };
        [start.as_bytes(), time, b"SCALARS s short 1\nLOOKUP_TABLE default\n", &numbers].concat()
    };
    #[allow(unused_mut, reason = "some formats are optional")]
    let mut seeds = vec![
        vti(Encoding::Ascii, Codec::None),
        vti(Encoding::Inline, Codec::None),
        vti(Encoding::Inline, Codec::Zlib),
        vti(Encoding::AppendedBase64, Codec::Lz4),
        vti(Encoding::AppendedBase64, Codec::None),
        vti(Encoding::AppendedRaw, Codec::None),
        vti(Encoding::AppendedRaw, Codec::Zlib),
        vti(Encoding::AppendedRaw, Codec::Lz4),
        ("vtk", legacy(true)),
        ("vtk", legacy(false)),
        ("npy", [npy_header(1, "'<i2'", false, "(3, 4, 5)"), little.clone()].concat()),
        ("npy", [npy_header(3, "'<i2'", true, "(5, 4, 3)"), little].concat()),
    ];
    #[cfg(feature = "tiff")]
    seeds.extend(crate::tiff_file::seeds().into_iter().map(|bytes| ("tif", bytes)));
    seeds
}

/// Reads the file; an error must name it.
fn read(path: &Path, component: Option<usize>) -> bool {
    let result = consume(path, component);
    if let Err(error) = &result {
        let text = error.to_string();
        assert!(text.contains("d.") && !text.contains('\n'), "{text}");
    }
    result.is_ok()
}

#[test]
fn cut_anywhere() {
    let dir = tempfile::tempdir().unwrap();
    for (extension, bytes) in seeds() {
        let name = format!("d.{extension}");
        assert!(read(&write(dir.path(), &name, &[&bytes]), None), "{extension}");
        let cuts = (0..bytes.len()).filter(|&n| !read(&write(dir.path(), &name, &[&bytes[..n]]), None));
        // What closes the elements of a `.vti`, and white space at the end, is not needed.
        assert!(cuts.count() > bytes.len() * 4 / 5, "{extension}");
    }
}

#[test]
fn any_byte_changed() {
    let dir = tempfile::tempdir().unwrap();
    for (i, (extension, bytes)) in seeds().into_iter().enumerate() {
        for at in 0..bytes.len() {
            // Another kind of change for each byte and seed; all of them together take seconds.
            let values = [0, bytes[at] ^ 1, 0xff, bytes[at] ^ (1 << (at / 4 % 8))];
            let mut bytes = bytes.clone();
            bytes[at] = values[(at + i) % 4];
            read(&write(dir.path(), &format!("d.{extension}"), &[&bytes]), None);
        }
    }
}

thread_local! {
    /// One folder and one set of seeds for all cases.
    static FOLDER: (tempfile::TempDir, Vec<(&'static str, Vec<u8>)>) = (tempfile::tempdir().unwrap(), seeds());
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 2000,
        failure_persistence: Some(Box::new(proptest::test_runner::FileFailurePersistence::Off)),
        ..ProptestConfig::default()
    })]

    #[test]
    fn changed_in_several_places(
        which in any::<prop::sample::Index>(),
        changes in prop::collection::vec(change(), 1..5),
        component in prop::option::of(0..3usize),
    ) {
        FOLDER.with(|(dir, seeds)| {
            let (extension, mut bytes) = which.get(seeds).clone();
            changes.into_iter().for_each(|change| apply(&mut bytes, change));
            read(&write(dir.path(), &format!("d.{extension}"), &[&bytes]), component);
        });
    }
}
