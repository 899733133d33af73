use glam::{DAffine3, DVec3};
use isoray_grid::Dims;

use super::*;
use crate::{Coarse, Fidelity, HISTOGRAM_BINS, Meta, Node, Parts};

fn constant(value: u8, edge: u32, index_to_world: DAffine3) -> OctreeVolume<u8> {
    let root = Node { mins: [value; 8], maxs: [value; 8], values: [value; 8], first: 0.into(), mask: 0 };
    let meta = Meta {
        dims: Dims::new([edge; 3]).unwrap(),
        index_to_world,
        range: Some([f64::from(value); 2]),
        non_finite: 0,
        histogram: Box::new([0; HISTOGRAM_BINS]),
        fidelity: Fidelity::LOSSLESS,
        coarse: Coarse::Injected,
    };
    OctreeVolume::from_parts(meta, Parts { levels: vec![vec![root]], caps: Vec::new() })
}

/// A folder with steps of these names.
fn folder(names: &[&str]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (n, name) in (0..).zip(names) {
        constant(n, 8, DAffine3::IDENTITY).save(&folder.path().join(name)).unwrap();
    }
    folder
}

#[test]
fn steps_are_in_the_order_of_their_numbers() {
    let folder = folder(&["a10.ovol", "a2.ovol", ".a1.ovol", "a1.OVOL", "notes.txt"]);
    std::fs::create_dir(folder.path().join("a3.ovol")).unwrap();
    let series = Series::open(folder.path()).unwrap();
    assert_eq!((0..4).map(|n| series.name(n)).collect::<Vec<_>>(), ["a1.OVOL", "a2.ovol", "a10.ovol", ""]);
    series.check_headers().unwrap();
    assert_eq!(series.step(2).unwrap().meta().range, Some([0.0, 0.0]));
    assert!(matches!(series.step(3), Err(SeriesError::NoStep { step: 3, count: 3, .. })));
}

#[test]
fn folders_that_are_no_series() {
    let empty = tempfile::tempdir().unwrap();
    assert!(matches!(Series::open(empty.path()), Err(SeriesError::Empty(_))));
    assert!(matches!(Series::open(&empty.path().join("gone")), Err(SeriesError::Folder { .. })));
    let damaged = folder(&["a.ovol"]);
    std::fs::write(damaged.path().join("a.ovol"), b"ISORAYOV").unwrap();
    assert!(matches!(Series::open(damaged.path()), Err(SeriesError::Step(_))));
    let names = ["a.ovol.d", "b/A.OVOL.D", "a.ovol.d/", "a.ovol", ".ovol.d", "ovol.d", "a.ovol.d/b"];
    assert_eq!(names.map(|n| is_series(Path::new(n))), [true, true, true, false, false, false, false]);
}

#[test]
fn a_step_that_differs_names_both_files_and_what() {
    let moved = DAffine3::from_translation(DVec3::new(0.0, 0.0, 1e-9));
    for (edge, placement, what, found) in
        [(7, DAffine3::IDENTITY, "dimensions", "7"), (8, moved, "placement", "0.000000001)")]
    {
        let folder = folder(&["a1.ovol", "a2.ovol"]);
        constant(0, edge, placement).save(&folder.path().join("a3.ovol")).unwrap();
        let series = Series::open(folder.path()).unwrap();
        assert!(series.step(1).is_ok());
        for error in [series.step(2).unwrap_err(), series.check_headers().unwrap_err()] {
            let message = error.to_string();
            assert!(matches!(error, SeriesError::Differs { difference, .. } if difference.what == what));
            assert!(["a1.ovol", "a3.ovol", found].iter().all(|part| message.contains(part)), "{message}");
        }
    }
    let folder = folder(&["a1.ovol"]);
    let root = Node { mins: [0i8; 8], maxs: [0; 8], values: [0; 8], first: 0.into(), mask: 0 };
    let meta = constant(0, 8, DAffine3::IDENTITY).meta().clone();
    let other = OctreeVolume::<i8>::from_parts(meta, Parts { levels: vec![vec![root]], caps: Vec::new() });
    other.save(&folder.path().join("a2.ovol")).unwrap();
    let message = Series::open(folder.path()).unwrap().step(1).unwrap_err().to_string();
    assert!(message.ends_with("sample type: expected u8, found i8"), "{message}");
}

#[test]
fn prefetching_reads_the_file_up_to_the_budget() {
    let folder = folder(&["a1.ovol", "a2.ovol"]);
    let series = Series::open(folder.path()).unwrap();
    let length = std::fs::metadata(&series.files()[1]).unwrap().len();
    assert_eq!(series.prefetch(1, PREFETCH_BUDGET).wait(), length);
    assert_eq!(series.prefetch(1, 100).wait(), 100);
    assert_eq!(series.prefetch(7, PREFETCH_BUDGET).wait(), 0);
    std::fs::remove_file(&series.files()[1]).unwrap();
    assert_eq!(series.prefetch(1, PREFETCH_BUDGET).wait(), 0);
}

#[test]
fn prefetching_reads_all_of_a_file_of_several_chunks_and_can_be_stopped() {
    let file = tempfile::NamedTempFile::new().unwrap();
    const LENGTH: u64 = (2 << 20) + 12345;
    std::fs::write(file.path(), vec![1; LENGTH as usize]).unwrap();
    let read = |first, budget, stop: bool| prefetch::read(file.path(), first, budget, &stop.into());
    for first in [0, 1, 1 << 20, LENGTH, u64::MAX] {
        assert_eq!(read(first, u64::MAX, false), LENGTH, "{first}");
        assert_eq!(read(first, LENGTH - 5, false), LENGTH - 5, "{first}");
        assert_eq!(read(first, u64::MAX, true), 0, "{first}");
    }
}
