//! Damaged headers: whatever the bytes, reading ends with samples or a typed error.

use std::path::Path;

use isoray_grid::SlabSource;
use isoray_io::{Dataset, Endian, OpenOptions, ReadError, SampleType};
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;

use crate::damage::{Change, apply};
use crate::make::{Nifti, body, gzip, meta_header, nrrd_header, write, zlib};

/// Layers larger than this are not read: a header may state any size.
const MOST_SAMPLES: usize = 1 << 16;

/// Whole valid files to damage, with the extension of each.
fn seeds() -> Vec<(&'static str, Vec<u8>)> {
    let sample = SampleType::I16;
    let big = body(sample, Endian::Big, 1, true);
    let two = body(sample, Endian::Little, 2, true);
    let nrrd = |encoding, data: &[u8]| {
        [nrrd_header(sample, Endian::Big, encoding).as_bytes(), b"line skip: 0\nbyte skip: 0\n\n", data]
            .concat()
    };
    let vector = b"NRRD0005\ntype: short\ndimension: 4\nsizes: 2 5 4 3\nkinds: vector space space space\n\
        space directions: none (1,0,0) (0,1,0) (0,0,1)\nspace origin: (1,2,3)\nendian: little\n\
        encoding: raw\n\n";
    let meta = |compressed, data: &[u8]| {
        let header = meta_header(sample, Endian::Big, compressed, "LOCAL").replace(
            "NDims = 3\n",
            "NDims = 3\nOffset = 1 2 3\nElementNumberOfChannels = 1\nHeaderSize = 0\n",
        );
        [header.as_bytes(), data].concat()
    };
    let nifti = |version| [Nifti::new(version, sample, Endian::Big).bytes(), big.clone()].concat();
    vec![
        ("nrrd", nrrd("raw", &big)),
        ("nrrd", nrrd("gzip", &gzip(&big))),
        ("nrrd", nrrd("text", b"1 2 3 4,5 nan -7 1e9\n")),
        ("nrrd", [vector.as_slice(), &two].concat()),
        ("mha", meta(false, &big)),
        ("mha", meta(true, &zlib(&big))),
        ("nii", nifti(1)),
        ("nii", nifti(2)),
        ("nii.gz", gzip(&nifti(1))),
    ]
}

pub(crate) fn change() -> impl Strategy<Value = Change> {
    let at = 0..900usize;
    prop_oneof![
        (at.clone(), any::<u8>()).prop_map(|(a, b)| Change::Set(a, b)),
        (at.clone(), b'-'..=b'9').prop_map(|(a, b)| Change::Digit(a, b)),
        (at.clone(), prop::collection::vec(any::<u8>(), 1..9)).prop_map(|(a, b)| Change::Insert(a, b)),
        (at.clone(), "[-0-9 .:=e(),%]{1,12}").prop_map(|(a, b)| Change::Insert(a, b.into_bytes())),
        (at.clone(), 1..40usize).prop_map(|(a, n)| Change::Remove(a, n)),
        at.prop_map(Change::Cut),
    ]
}

/// Opens and reads everything of `path`, layer by layer.
pub(crate) fn consume(path: &Path, component: Option<usize>) -> Result<(), ReadError> {
    let dataset = Dataset::open(path, &OpenOptions { component, ..Default::default() })?;
    assert!(dataset.index_to_world().inverse().is_finite());
    if dataset.dims().layer() > MOST_SAMPLES {
        return Ok(());
    }
    match dataset.scalar() {
        isoray_grid::ScalarType::U8 => layers::<u8>(&dataset),
        isoray_grid::ScalarType::I8 => layers::<i8>(&dataset),
        isoray_grid::ScalarType::U16 => layers::<u16>(&dataset),
        isoray_grid::ScalarType::I16 => layers::<i16>(&dataset),
        isoray_grid::ScalarType::F32 => layers::<f32>(&dataset),
    }
}

fn layers<T: isoray_grid::Scalar>(dataset: &Dataset) -> Result<(), ReadError> {
    let mut slabs = dataset.slabs::<T>()?;
    let mut layer = vec![T::default(); dataset.dims().layer()];
    (0..dataset.dims().axes()[2]).try_for_each(|k| slabs.read_layers(k, &mut layer))?;
    let _ = (slabs.warnings(), dataset.mapped::<T>().map(|m| m.len()));
    Ok(())
}

thread_local! {
    /// One folder for all cases.
    static FOLDER: tempfile::TempDir = tempfile::tempdir().unwrap();
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 2000,
        failure_persistence: Some(Box::new(FileFailurePersistence::Off)),
        ..ProptestConfig::default()
    })]

    #[test]
    fn reading_ends_with_samples_or_an_error_that_names_the_file(
        which in 0..9usize,
        changes in prop::collection::vec(change(), 0..4),
        inside in any::<bool>(),
        component in prop::option::of(0..3usize),
    ) {
        let dir = FOLDER.with(|dir| dir.path().to_owned());
        let (extension, mut bytes) = seeds().swap_remove(which);
        // For compressed NIfTI, the header before compression half of the time.
        let pack = inside && extension == "nii.gz";
        if pack {
            bytes = Nifti::new(1, SampleType::U8, Endian::Little).bytes();
            bytes.extend([7; 60]);
        }
        for change in changes {
            apply(&mut bytes, change);
        }
        if pack {
            bytes = gzip(&bytes);
        }
        let path = write(&dir, &format!("m.{extension}"), &[&bytes]);
        if let Err(error) = consume(&path, component) {
            prop_assert!(error.to_string().contains("m."), "{error}");
        }
    }
}

#[test]
fn seeds_are_valid() {
    let dir = tempfile::tempdir().unwrap();
    for (i, (extension, bytes)) in seeds().into_iter().enumerate() {
        let path = write(dir.path(), &format!("s{i}.{extension}"), &[&bytes]);
        let component = (i == 3).then_some(1);
        let result = consume(&path, component);
        // The text seed is short and ill-typed on purpose.
        assert_eq!(result.is_ok(), i != 2, "{i}: {result:?}");
    }
}
