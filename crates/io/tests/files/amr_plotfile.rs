//! Plotfiles: every variant, and every way to be wrong.

use std::path::Path;

use glam::DVec3;
use isoray_amr::Centering;
use isoray_io::{AmrDataset, AmrLevel, Endian, ReadError, SampleType, Warning};

use crate::make_amr::{Plotfile, check_outline, edit, expected};

fn check(plotfile: &Plotfile) {
    let dir = tempfile::tempdir().unwrap();
    let folder = plotfile.write(dir.path(), "plt");
    assert!(AmrDataset::recognises(&folder) && AmrDataset::recognises(&folder.join("Header")));
    for path in [folder.clone(), folder.join("Header")] {
        let dataset = AmrDataset::open(&path).unwrap();
        assert_eq!((dataset.format(), dataset.path()), ("AMReX plotfile", path.as_path()));
        let names: Vec<_> = dataset.fields().iter().map(|f| f.name.as_str()).collect();
        assert_eq!(names, plotfile.names);
        assert_eq!(
            dataset.levels(),
            [
                AmrLevel { ratio: Some(2), boxes: 2, cells: 512 },
                AmrLevel { ratio: None, boxes: 2, cells: 8 * 8 * 4 + 8 * 4 * 4 }
            ]
        );
        for (component, name) in names.iter().enumerate() {
            assert_eq!(dataset.field(Some(name)).unwrap().centering, plotfile.centering);
            let (patches, warnings) = dataset.read_with_warnings(Some(name)).unwrap();
            assert_eq!(warnings, []);
            check_outline(&patches, plotfile.centering, plotfile.shift);
            assert_eq!(patches.patches, expected(component, plotfile.centering, plotfile.shift));
            let lowest = DVec3::splat(f64::from(plotfile.shift));
            let corner = DVec3::new(1.0, 2.0, 3.0);
            let edges = DVec3::new(0.5, 1.0, 2.0);
            let place = if plotfile.place_of_zero { corner + lowest * edges } else { corner };
            assert_eq!(patches.index_to_world.transform_point3(lowest), place);
            assert_eq!(patches.index_to_world.transform_vector3(DVec3::ONE), edges);
        }
    }
}

#[test]
fn numbers_of_all_kinds() {
    for sample in [SampleType::F32, SampleType::F64] {
        for endian in [Endian::Little, Endian::Big] {
            for version in 1..=4 {
                check(&Plotfile { sample, endian, version, ..Plotfile::default() });
            }
        }
    }
}

#[test]
fn header_variants() {
    check(&Plotfile { first: "NavierStokes-V1.1", ..Plotfile::default() });
    check(&Plotfile { names: vec!["a"], ..Plotfile::default() });
    for ratios in ["2 2", "2 2 4 ", "(2,2,2)", " (2, 2,2) (2,2,2)"] {
        check(&Plotfile { ratios, ..Plotfile::default() });
    }
    for shift in [-3, 5] {
        for place_of_zero in [true, false] {
            check(&Plotfile { shift, place_of_zero, ..Plotfile::default() });
        }
    }
}

#[test]
fn ghost_cells_and_corners() {
    for ghosts in [[1; 3], [2; 3], [1, 0, 2]] {
        for centering in [Centering::Cells, Centering::Vertices] {
            for version in [1, 2] {
                check(&Plotfile { ghosts, centering, version, ..Plotfile::default() });
            }
        }
    }
    check(&Plotfile { centering: Centering::Vertices, ..Plotfile::default() });
}

#[test]
fn a_single_level_has_no_ratio() {
    let dir = tempfile::tempdir().unwrap();
    for (number, line) in ["\n", ""].into_iter().enumerate() {
        let folder = Plotfile::default().write(dir.path(), &format!("single{number}"));
        let header = folder.join("Header");
        edit(&header, "\n0.125\n1\n", "\n0.125\n0\n");
        edit(&header, "5 10 19\n2\n", &format!("5 10 19\n{line}"));
        edit(&header, "\n0.25 0.5 1\n", "\n");
        let dataset = AmrDataset::open(&folder).unwrap();
        assert_eq!(dataset.levels(), [AmrLevel { ratio: None, boxes: 2, cells: 512 }]);
        let patches = dataset.read(Some("density")).unwrap();
        assert!(patches.ratios.is_empty() && patches.patches == expected(0, Centering::Cells, 0)[..2]);
    }
}

#[test]
fn rounded_values_are_counted() {
    let dir = tempfile::tempdir().unwrap();
    let folder = Plotfile { names: vec!["a"], ..Plotfile::default() }.write(dir.path(), "plt");
    let data = folder.join("Level_0/Cell_D_00000");
    let mut bytes = std::fs::read(&data).unwrap();
    let end = bytes.len();
    bytes[end - 16..end - 8].copy_from_slice(&0.1f64.to_le_bytes());
    bytes[end - 8..].copy_from_slice(&1e300f64.to_le_bytes());
    std::fs::write(&data, bytes).unwrap();
    let (patches, warnings) = AmrDataset::open(&folder).unwrap().read_with_warnings(None).unwrap();
    assert_eq!(
        warnings,
        [
            Warning::Rounded { path: folder.clone(), samples: 1 },
            Warning::Overflowed { path: folder, samples: 1 }
        ]
    );
    assert_eq!(patches.patches[0].values[254..], [0.1, f32::INFINITY]);
}

/// The error of opening or reading a plotfile, which must name the file in it and contain `expected`.
fn fails(folder: &Path, file: &str, expected: &str) -> ReadError {
    let opened = AmrDataset::open(folder);
    let error = opened.and_then(|d| d.read(Some("density")).map(drop)).expect_err(expected);
    let text = error.to_string();
    assert!(text.contains(&folder.join(file).display().to_string()), "{text}: not {file}");
    assert!(text.contains(expected) && !text.contains('\n'), "{text}: not '{expected}'");
    error
}

/// Text of a `Header` and what stands for it, and the error.
#[rustfmt::skip]
const WRONG_HEADERS: [(&str, &str, &str); 23] = [
    ("HyperCLaw-V1.1", "HyperCLaw-V2.0", "expected HyperCLaw-V1.1 or NavierStokes-V1.1, found 'HyperCLaw-V2.0'"),
    ("\n3\n0.125\n", "\n2\n0.125\n", "expected 3 dimensions, found '2'"),
    ("\n3\n0.125\n", "\n1\n0.125\n", "expected 3 dimensions, found '1'"),
    ("\n5 10 19\n2\n", "\n5 10 19\n3\n", "refinement ratio of level 0: expected 2 or 4, the same along each axis, found 3"),
    ("\n5 10 19\n2\n", "\n5 10 19\n(2,2,4)\n", "expected 2 or 4, the same along each axis, found 2,2,4"),
    ("\n5 10 19\n2\n", "\n5 10 19\n(2,2)\n", "one or three numbers for each level"),
    ("\n5 10 19\n2\n", "\n5 10 19\n\n", "expected one for each level but the finest, found ''"),
    ("\n5 10 19\n2\n", "\n5 10 19\n4\n", "domain of level 1: expected that of the coarser one, refined: (0,0,0) to (31,31,31)"),
    ("(15,15,15) (0,0,0))", "(15,15,15)", "expected a box of cells for each level"),
    ("7 14\n0.5 1 2\n", "7 14\n0.5 1 3\n", "edges of a cell: expected 8 cells along 16, found 3"),
    ("1 2 3\n5 10 19\n", "1 2 3\n5 10 nan\n", "edges of a cell: expected 8 cells along NaN"),
    ("0.25 0.5 1\n0\n", "0.25 0.5 1\n1\n", "this coordinate system is not supported; expected 0, Cartesian"),
    ("\n0.125\n1\n", "\n0.125\n30\n", "finest level: expected fewer than 30"),
    ("\n0.125\n1\n", "\n0.125\n2\n", "refinement ratios: expected one for each level but the finest"),
    ("1 2 0.125\n7\n", "1 3 0.125\n7\n", "place of a box: expected two numbers for each axis, found 'Level_1/Cell'"),
    ("1 2 0.125\n7\n", "1 0 0.125\n7\n", "level 1 with at least one box"),
    ("Level_1/Cell", "Level_9/Cell", "cannot open"),
    ("Level_1/Cell", "/Level_1/Cell", "files of a level: expected a path inside the plotfile"),
    ("Level_1/Cell", "Level_1/../../Cell", "found 'Level_1/../../Cell'"),
    ("Level_1/Cell", "", "a path inside the plotfile, found ''"),
    ("2 4\n4 8\n7 11\n", "2.5 4\n4 8\n7 11\n", "level 1, place of box 0: expected [2, 4, 7]"),
    ("HyperCLaw-V1.1\n2\n", "HyperCLaw-V1.1\n99999999999\n", "expected the name of a component, found the end"),
    ("density\nx velocity\n", "density\n", "number of dimensions: expected a number"),
];

#[test]
fn wrong_headers() {
    let dir = tempfile::tempdir().unwrap();
    for (number, (old, new, expected)) in WRONG_HEADERS.into_iter().enumerate() {
        let folder = Plotfile::default().write(dir.path(), &format!("h{number}"));
        edit(&folder.join("Header"), old, new);
        fails(&folder, if new == "Level_9/Cell" { "Level_9/Cell_H" } else { "Header" }, expected);
    }
    let folder = Plotfile::default().write(dir.path(), "cut");
    let text = std::fs::read_to_string(folder.join("Header")).unwrap();
    std::fs::write(folder.join("Header"), &text[..150]).unwrap();
    fails(&folder, "Header", "found the end of the header after 150 bytes");
}

/// Text of a `Cell_H` and what stands for it, and the error.
#[rustfmt::skip]
const WRONG_LEVELS: [(&str, &str, &str); 22] = [
    ("(11,11,7) (0,0,0)", "(11,16,7) (0,0,0)", "level 1, box 0: expected cells within the domain, (0,0,0) to (15,15,15), found (4,4,4) to (11,16,7)"),
    ("((4,4,4) (11", "((12,4,4) (11", "a box that is not empty"),
    ("(11,11,7) (0,0,0)", "(11,11,7) (1,0,0)", "values in cells (0,0,0) or at their corners (1,1,1)"),
    ("(11,11,7) (0,0,0)", "(11,11,7) (1,1,1)", "level 1, box 0: expected values in cells"),
    ("((4,4,4) (11,11,7) (0,0,0))", "((4,4) (11,11) (0,0))", "three dimensions"),
    ("((4,4,4) (11,11,7) (0,0,0))", "((4,4,4) (11,11,6) (0,0,0))", "expected a FAB of the box ((4,4,4) (11,11,6) (0,0,0)), found ((4,4,4) (11,11,7) (0,0,0))"),
    ("((4,4,4) (11,11,7) (0,0,0))", "(4,4,4) (11,11,7)", "boxes: expected a box"),
    ("(2 0\n", "(1 0\n", "a parenthesis after as many boxes as stated"),
    ("(2 0\n", "2 0\n", "expected (N 0"),
    ("(2 0\n", "(9999999999 0\n", "boxes: expected a box"),
    (")\n2\n", ")\n3\n", "number of FABs: expected one for each of 2 boxes, found 3"),
    ("1\n1\n2\n0\n", "1\n1\n3\n0\n", "components of level 1: expected 2 as in Header, found 3"),
    ("1\n1\n2\n0\n", "9\n1\n2\n0\n", "version of the file: expected 1 to 4, found '9'"),
    ("1\n1\n2\n0\n", "2\n1\n2\n0\n", "expected how numbers are written"),
    ("1\n1\n2\n0\n", "1\n1\n2\n1\n", "expected a FAB of the box ((3,3,3) (12,12,8) (0,0,0)), found"),
    ("1\n1\n2\n0\n", "1\n1\n2\n-1\n", "number of ghost cells: expected one number"),
    ("Cell_D_00000 0", "Cell_D_00000 -1", "expected FabOnDisk: FILE OFFSET"),
    ("Cell_D_00000 0", "/etc/Cell_D_00000 0", "expected FabOnDisk: FILE OFFSET"),
    ("Cell_D_00000 0", "Cell_D_00000 7", "byte 7: expected a line 'FAB (…)'"),
    ("Cell_D_00000 0", "Cell_D_00000 18446744073709551615", "cannot"),
    ("Cell_D_00001 5", "Cell_D_00000 0", "level 1, box 1: expected values of its own"),
    ("Cell_D_00000 0", "Cell_D_9 0", "Cell_D_9, which cannot be opened"),
];

#[test]
fn wrong_levels() {
    let dir = tempfile::tempdir().unwrap();
    for (number, (old, new, expected)) in WRONG_LEVELS.into_iter().enumerate() {
        let folder = Plotfile::default().write(dir.path(), &format!("l{number}"));
        edit(&folder.join("Level_1/Cell_H"), old, new);
        let file = if expected.contains("FAB of") || expected.contains("byte") || expected == "cannot" {
            "Level_1/Cell_D_00000"
        } else {
            "Level_1/Cell_H"
        };
        fails(&folder, file, expected);
    }
}

#[test]
fn missing_levels_and_truncated_values() {
    let dir = tempfile::tempdir().unwrap();
    let folder = Plotfile::default().write(dir.path(), "gone");
    std::fs::remove_dir_all(folder.join("Level_1")).unwrap();
    assert!(matches!(fails(&folder, "Level_1/Cell_H", "cannot open"), ReadError::Io { .. }));
    let folder = Plotfile::default().write(dir.path(), "gone data");
    std::fs::remove_file(folder.join("Level_0/Cell_D_00001")).unwrap();
    let error = fails(&folder, "Level_0/Cell_H", "Cell_D_00001, which cannot be opened");
    assert!(matches!(error, ReadError::DataFile { .. }));

    for version in [1, 3] {
        let plotfile = Plotfile { version, ..Plotfile::default() };
        let folder = plotfile.write(dir.path(), &format!("cut{version}"));
        let data = folder.join("Level_1/Cell_D_00001");
        let bytes = std::fs::read(&data).unwrap();
        // Both components of 8 × 4 × 4 values; only the first is read.
        for (cut, found) in [(1, 2047), (1000, 1048), (2047, 1)] {
            std::fs::write(&data, &bytes[..bytes.len() - cut]).unwrap();
            match AmrDataset::open(&folder).and_then(|d| d.read(Some("x velocity"))) {
                Err(ReadError::ShortData { path, expected: 2048, found: n, .. }) => {
                    // Without reading it, the line before the values counts as such.
                    assert!(path == data && n >= found);
                }
                other => panic!("{other:?}"),
            }
        }
    }
}

#[test]
fn wrong_fabs() {
    let dir = tempfile::tempdir().unwrap();
    let cases: [(&[u8], &[u8], &str); 6] = [
        (b"FAB (", b"FAB: ", "the oldest kind of FAB is not supported"),
        (b"FAB (", b"BAF (", "expected a line 'FAB (…)', found 'BAF"),
        (b"(64 11 52", b"(64 15 48", "IEEE numbers of 32 or 64 bits"),
        (b"(8 7 6 5 4", b"(7 8 6 5 4", "little- or big-endian"),
        (b" 2\n", b" 3\n", "a FAB with 2 components, found 3"),
        (b" 2\n", b" x\n", "a number of components after the box"),
    ];
    for (number, (old, new, expected)) in cases.into_iter().enumerate() {
        let folder = Plotfile::default().write(dir.path(), &format!("f{number}"));
        let data = folder.join("Level_0/Cell_D_00001");
        let mut bytes = std::fs::read(&data).unwrap();
        let at = bytes.windows(old.len()).position(|w| w == old).unwrap();
        bytes[at..at + old.len()].copy_from_slice(new);
        std::fs::write(&data, bytes).unwrap();
        fails(&folder, "Level_0/Cell_D_00001", expected);
    }
}

#[test]
fn a_field_must_be_named_and_known() {
    let dir = tempfile::tempdir().unwrap();
    let folder = Plotfile::default().write(dir.path(), "plt");
    let dataset = AmrDataset::open(&folder).unwrap();
    let error = dataset.read(None).unwrap_err();
    assert!(
        matches!(&error, ReadError::ChooseField { names, .. } if names == "density, x velocity"),
        "{error}"
    );
    let error = dataset.read(Some("pressure")).unwrap_err();
    let text = error.to_string();
    assert!(text.contains("one of the arrays density, x velocity, found --field pressure"), "{text}");
}

#[test]
fn other_files_are_no_meshes() {
    let dir = tempfile::tempdir().unwrap();
    let empty = dir.path().join("empty");
    std::fs::create_dir(&empty).unwrap();
    std::fs::write(dir.path().join("a.raw"), [1; 99]).unwrap();
    for path in [empty.clone(), dir.path().join("a.raw")] {
        assert!(!AmrDataset::recognises(&path));
        assert!(matches!(AmrDataset::open(&path), Err(ReadError::NoMesh { .. })));
    }
    assert!(matches!(AmrDataset::open(&dir.path().join("gone")), Err(ReadError::Io { .. })));

    std::fs::write(empty.join("info_00004.txt"), "ncpu        =          1\nndim        =          3\n")
        .unwrap();
    std::fs::write(empty.join("amr_00004.out00001"), [0; 8]).unwrap();
    std::fs::write(dir.path().join("DD0010.hierarchy"), "\nGrid = 1\nGridRank          = 3\n").unwrap();
    std::fs::write(dir.path().join("DD0010"), "InitialCycleNumber  = 10\n").unwrap();
    let not_yet = |path: &Path, name: &str| {
        assert!(AmrDataset::recognises(path));
        let error = AmrDataset::open(path).unwrap_err();
        assert!(error.to_string().contains(&format!("{name} output is not supported yet")), "{error}");
    };
    not_yet(&empty, "RAMSES");
    not_yet(&empty.join("info_00004.txt"), "RAMSES");
    for path in [dir.path().to_owned(), dir.path().join("DD0010"), dir.path().join("DD0010.hierarchy")] {
        not_yet(&path, "Enzo");
    }
}
