//! Published volumes; skipped, loudly, where they are not at hand.

use std::path::PathBuf;

use glam::DVec3;
use isoray_grid::ScalarType;
use isoray_io::{Dataset, Endian, OpenOptions, RawLayout, SampleType};

use crate::make::read;

/// What is known of a volume, computed without this crate.
struct Known {
    file: &'static str,
    dims: [u32; 3],
    scalar: ScalarType,
    spacing: [f64; 3],
    /// Least and largest sample.
    range: [f32; 2],
    /// The sample at half of each size.
    centre: f32,
    /// Sum of all samples; not stated for floating point.
    sum: Option<i64>,
}

fn folder() -> Option<PathBuf> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/volumes");
    if folder.is_dir() {
        Some(folder)
    } else {
        eprintln!("SKIPPED: published volumes are not at {}", folder.display());
        None
    }
}

fn check(known: &Known, raw: Option<RawLayout>) -> Option<Dataset> {
    let path = folder()?.join(known.file);
    if !path.is_file() {
        eprintln!("SKIPPED: {} is not there", path.display());
        return None;
    }
    let dataset = Dataset::open(&path, &OpenOptions { raw, ..Default::default() }).unwrap();
    assert_eq!(dataset.dims().axes(), known.dims);
    assert_eq!(dataset.scalar(), known.scalar);
    let world = dataset.index_to_world();
    let spacing = [DVec3::X, DVec3::Y, DVec3::Z].map(|a| world.transform_vector3(a).length());
    for (found, expected) in spacing.into_iter().zip(known.spacing) {
        assert!((found - expected).abs() < 1e-6 * expected, "{spacing:?}");
    }
    let (samples, warnings) = read(&dataset, 8).unwrap();
    let range = samples.iter().fold([f32::MAX, f32::MIN], |[lo, hi], &s| [lo.min(s), hi.max(s)]);
    assert_eq!(range, known.range, "{}", known.file);
    let [nx, ny, nz] = known.dims.map(|n| n as usize);
    assert_eq!(samples[(nz / 2 * ny + ny / 2) * nx + nx / 2], known.centre, "{}", known.file);
    if let Some(sum) = known.sum {
        assert_eq!(samples.iter().map(|&s| s as i64).sum::<i64>(), sum, "{}", known.file);
    }
    assert_eq!((warnings, dataset.warnings()), (vec![], vec![]));
    Some(dataset)
}

fn raw(dims: [u32; 3], sample: SampleType, spacing: [f64; 3]) -> Option<RawLayout> {
    Some(RawLayout { dims, sample, endian: Endian::Little, skip: 0, spacing: Some(spacing), origin: None })
}

#[test]
fn csafe() {
    let known = Known {
        file: "csafe_heptane.nrrd",
        dims: [302, 302, 302],
        scalar: ScalarType::U8,
        spacing: [1.0, 1.0, 1.0],
        range: [0.0, 255.0],
        centre: 96.0,
        sum: Some(213_899_765),
    };
    check(&known, None);
}

#[test]
fn visible_human() {
    let known = Known {
        file: "visible_human_head.nrrd",
        dims: [512, 512, 234],
        scalar: ScalarType::U8,
        spacing: [1.0, 1.0, 1.0],
        range: [0.0, 255.0],
        centre: 65.0,
        sum: Some(432_333_676),
    };
    check(&known, None);
}

#[test]
fn lidc() {
    let known = Known {
        file: "lidc_0314.nrrd",
        dims: [320, 320, 200],
        scalar: ScalarType::I16,
        spacing: [0.78125, 0.78125, 1.0],
        range: [-1000.0, 1821.0],
        centre: 59.0,
        sum: Some(-6_801_083_123),
    };
    check(&known, None);
}

#[test]
fn stent() {
    let known = Known {
        file: "stent.nrrd",
        dims: [128, 128, 256],
        scalar: ScalarType::F32,
        spacing: [1.0, 1.0, 1.0],
        range: [0.0, 1.0],
        centre: 0.0,
        sum: None,
    };
    check(&known, None);
}

#[test]
fn cthead() {
    let known = Known {
        file: "cthead/cthead.mhd",
        dims: [256, 256, 113],
        scalar: ScalarType::U16,
        spacing: [1.0, 1.0, 2.0],
        range: [0.0, 3272.0],
        centre: 2322.0,
        sum: Some(2_810_724_494),
    };
    check(&known, None);
}

#[test]
fn cranium() {
    let known = Known {
        file: "cranium/cranium_256x256x108_i16le.raw",
        dims: [256, 256, 108],
        scalar: ScalarType::I16,
        spacing: [0.957, 0.957, 1.5],
        range: [-1024.0, 2986.0],
        centre: 3.0,
        sum: Some(-4_147_325_847),
    };
    check(&known, raw(known.dims, SampleType::I16, known.spacing));
}

#[test]
fn tooth() {
    let known = Known {
        file: "tooth/tooth.nhdr",
        dims: [103, 94, 161],
        scalar: ScalarType::U16,
        spacing: [1.0, 1.0, 1.0],
        range: [0.0, 1300.0],
        centre: 783.0,
        sum: Some(821_287_590),
    };
    check(&known, None);
}

#[test]
fn nucleon() {
    let known = Known {
        file: "nucleon_41x41x41_u8.raw",
        dims: [41, 41, 41],
        scalar: ScalarType::U8,
        spacing: [1.0, 1.0, 1.0],
        range: [0.0, 249.0],
        centre: 8.0,
        sum: Some(2_715_326),
    };
    check(&known, raw(known.dims, SampleType::U8, known.spacing));
}

#[test]
fn bonsai() {
    let known = Known {
        file: "bonsai.nii.gz",
        dims: [256, 256, 256],
        scalar: ScalarType::U8,
        spacing: [1.0, 1.0, 1.0],
        range: [0.0, 255.0],
        centre: 69.0,
        sum: Some(225_901_147),
    };
    let dataset = check(&known, None);
    // Its sform puts the middle of the volume at the origin of the world.
    if let Some(dataset) = dataset {
        assert_eq!(dataset.index_to_world().translation, DVec3::new(-127.0, -127.0, -128.0));
    }
}

#[test]
fn engine() {
    let known = Known {
        file: "engine.nii.gz",
        dims: [256, 256, 128],
        scalar: ScalarType::U8,
        spacing: [1.0, 1.0, 1.0],
        range: [0.0, 255.0],
        centre: 136.0,
        sum: Some(173_590_544),
    };
    check(&known, None);
}
