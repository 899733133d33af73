//! VTK overlapping AMR, and octrees as legacy VTK hexahedra.

use std::path::Path;

use glam::DVec3;
use isoray_amr::Centering;
use isoray_io::{AmrDataset, AmrLevel, ReadError, SampleType};

use crate::make::write;
use crate::make_amr::{Hexahedra, check_outline, edit, expected, write_vtk};

#[test]
fn boxes_of_both_forms() {
    let dir = tempfile::tempdir().unwrap();
    for old in [false, true] {
        for centering in [Centering::Cells, Centering::Vertices] {
            let path = write_vtk(dir.path(), &format!("{old}{centering:?}"), old, centering);
            assert!(AmrDataset::recognises(&path));
            let dataset = AmrDataset::open(&path).unwrap();
            assert_eq!(dataset.format(), "VTK overlapping AMR");
            let names: Vec<_> = dataset.fields().iter().map(|f| f.name.as_str()).collect();
            assert_eq!(names, ["density", "x velocity"]);
            assert_eq!(
                dataset.levels(),
                [
                    AmrLevel { ratio: Some(2), boxes: 2, cells: 512 },
                    AmrLevel { ratio: None, boxes: 2, cells: 384 }
                ]
            );
            for (component, name) in names.into_iter().enumerate() {
                let patches = dataset.read(Some(name)).unwrap();
                check_outline(&patches, centering, 0);
                assert_eq!(patches.patches, expected(component, centering, 0));
                let map = patches.index_to_world;
                assert_eq!(map.transform_point3(DVec3::ZERO), DVec3::new(1.0, 2.0, 3.0));
                assert_eq!(map.transform_vector3(DVec3::ONE), DVec3::new(0.5, 1.0, 2.0));
            }
        }
    }
}

#[test]
fn levels_refined_by_four() {
    let dir = tempfile::tempdir().unwrap();
    let path = write_vtk(dir.path(), "four", false, Centering::Cells);
    edit(&path, "0.25 0.5 1", "0.125 0.25 0.5");
    for (file, old, new) in [("1_0.vti", "2 4 7", "1.5 3 5"), ("1_1.vti", "2 4 11", "1.5 3 7")] {
        let piece = dir.path().join("four").join(file);
        edit(&piece, "Spacing=\"0.25 0.5 1\"", "Spacing=\"0.125 0.25 0.5\"");
        edit(&piece, &format!("Origin=\"{old}\""), &format!("Origin=\"{new}\""));
    }
    let dataset = AmrDataset::open(&path).unwrap();
    assert_eq!(dataset.levels()[0].ratio, Some(4));
    let patches = dataset.read(Some("density")).unwrap();
    assert_eq!((&patches.ratios[..], patches.patches), (&[4][..], expected(0, Centering::Cells, 0)));
}

fn fails(path: &Path, name: &str, expected: &str) {
    let opened = AmrDataset::open(path);
    let error = opened.and_then(|d| d.read(Some("density")).map(drop)).expect_err(expected);
    let text = error.to_string();
    assert!(
        text.contains(name) && text.contains(expected) && !text.contains('\n'),
        "{text}: not '{expected}'"
    );
}

/// Whether the old form, text and what stands for it, and the error.
#[rustfmt::skip]
const WRONG_LISTS: [(bool, &str, &str, &str); 17] = [
    (false, "level=\"1\" spacing", "level=\"31\" spacing", "level: expected fewer than 30, found '31'"),
    (false, "level=\"1\" spacing", "spacing", "field 'level', found none"),
    (false, "0.25 0.5 1", "0.25 0.5 2", "spacing of level 1: expected [0.25, 0.5, 1], as the pieces say"),
    (false, "XYZ", "XY", "a mesh of fewer dimensions is not supported"),
    (false, "origin=\"1 2 3\"", "origin=\"1 2\"", "three numbers"),
    (false, "origin=\"1 2 3\"", "origin=\"1 2 5\"", "lowest corner: expected [1, 2, 5]"),
    (false, "type=\"vtkOverlappingAMR\"", "type=\"vtkMultiBlockDataSet\"", "this VTK data set is not supported"),
    (false, "amr_box=\"4 11 4 11 4 7\"", "amr_box=\"4 11 4 11 4 8\"", "cells: expected [8, 8, 5], as the amr_box"),
    (false, "amr_box=\"4 11 4 11 4 7\"", "amr_box=\"4 11 4 11 4 77\"", "level 1, box 0: expected cells within the domain"),
    (false, "amr_box=\"4 11 4 11 4 7\"", "amr_box=\"4 11 4 11 4\"", "six whole numbers"),
    (false, "amr_box=\"4 11 4 11 4 7\"", "amr_box=\"4 11 4 11 4 3\"", "amr_box: expected a box of cells"),
    (false, "amr_box=\"4 11 4 11 4 7\"", "amr_box=\"5 12 4 11 4 7\"", "lowest corner: expected [2.25, 4, 7]"),
    (false, "1_1.vti", "1_7.vti", "1_7.vti, which cannot be opened"),
    (false, "</VTKFile>", "</VTK>", "well-formed elements"),
    (true, "refinement=\"2\"", "refinement=\"4\"", "refinement ratio of level 0: expected 2, as the spacings say, found 4"),
    (true, "group=\"1\" dataset=\"0\"", "group=\"3\" dataset=\"0\"", "level 2: expected at least one DataSet"),
    (true, "group=\"1\" dataset=\"0\"", "dataset=\"0\"", "field 'level', found none"),
];

#[test]
fn wrong_lists_of_boxes() {
    let dir = tempfile::tempdir().unwrap();
    for (number, (old_form, old, new, expected)) in WRONG_LISTS.into_iter().enumerate() {
        let name = format!("w{number}");
        let path = write_vtk(dir.path(), &name, old_form, Centering::Cells);
        edit(&path, old, new);
        fails(&path, &name, expected);
    }
}

#[test]
fn wrong_pieces() {
    let dir = tempfile::tempdir().unwrap();
    let cases = [
        (
            "1_1.vti",
            "Spacing=\"0.25 0.5 1\"",
            "Spacing=\"0.25 0.5 1.5\"",
            "Spacing and Direction: expected [0.25, 0.5, 1]",
        ),
        (
            "1_0.vti",
            "Spacing=\"0.25 0.5 1\"",
            "Spacing=\"0.1 0.2 0.4\"",
            "refinement ratio of level 0: expected 2 or 4",
        ),
        ("1_0.vti", "Spacing=\"0.25 0.5 1\"", "Spacing=\"0.25 0.5 0.5\"", "found 2,2,4"),
        ("0_0.vti", "Spacing=\"0.5 1 2\"", "Spacing=\"0.5 0 2\"", "finite, independent steps"),
        ("1_1.vti", "Name=\"density\"", "Name=\"pressure\"", "expected one of the arrays"),
        (
            "1_1.vti",
            "Name=\"density\" format",
            "Name=\"density\" NumberOfComponents=\"2\" format",
            "decoded samples",
        ),
        ("1_1.vti", "</Piece>", "", "well-formed elements"),
    ];
    for (number, (file, old, new, expected)) in cases.into_iter().enumerate() {
        let name = format!("p{number}");
        let path = write_vtk(dir.path(), &name, false, Centering::Cells);
        edit(&dir.path().join(&name).join(file), old, new);
        fails(&path, &name, expected);
    }
    // Cells in all pieces but one.
    let path = write_vtk(dir.path(), "mixed", false, Centering::Cells);
    write_vtk(dir.path(), "other", false, Centering::Vertices);
    std::fs::copy(dir.path().join("other/1_1.vti"), dir.path().join("mixed/1_1.vti")).unwrap();
    fails(
        &path,
        "mixed/1_1.vti",
        "array 'density': expected [8, 4, 4] values, as in the first piece, found [9, 5, 5]",
    );
}

#[test]
fn octrees_of_hexahedra() {
    let dir = tempfile::tempdir().unwrap();
    for ascii in [true, false] {
        for version in [2, 4, 5] {
            for (sample, voxels) in [(SampleType::F32, true), (SampleType::F64, false)] {
                let made = Hexahedra { ascii, version, sample, voxels, scale: 0.5 };
                let path = write(dir.path(), "octree.vtk", &[&made.bytes()]);
                assert!(AmrDataset::recognises(&path));
                let dataset = AmrDataset::open(&path).unwrap();
                assert_eq!(dataset.format(), "legacy VTK hexahedra");
                let fields: Vec<_> =
                    dataset.fields().iter().map(|f| (f.name.as_str(), f.centering)).collect();
                let (at, of) = (Centering::Vertices, Centering::Cells);
                assert_eq!(fields, [("T", at), ("U:0", at), ("U:1", at), ("U:2", at), ("number", of)]);
                let large = AmrLevel { ratio: Some(2), boxes: 1, cells: 1 };
                assert_eq!(dataset.levels(), [large, AmrLevel { ratio: None, boxes: 8, cells: 8 }]);
                for (component, (name, centering)) in fields.into_iter().enumerate() {
                    let patches = dataset.read(Some(name)).unwrap();
                    assert_eq!((patches.centering, patches.domain), (centering, ([0; 3], [2, 1, 1])));
                    assert_eq!(patches.ratios, [2]);
                    let component = (centering == at).then_some(component);
                    assert_eq!(patches.patches, Hexahedra::expected(component), "{name}");
                    let map = patches.index_to_world;
                    assert_eq!(map.transform_point3(DVec3::ZERO), DVec3::new(-1.0, 0.25, 3.0));
                    assert_eq!(map.transform_vector3(DVec3::ONE), DVec3::ONE);
                }
                assert!(matches!(dataset.read(None), Err(ReadError::ChooseField { .. })));
            }
        }
    }
}

#[test]
fn rounded_coordinates_keep_their_places() {
    let dir = tempfile::tempdir().unwrap();
    for scale in [1.0 / 3.0, 0.1, 1e-3, 1e4] {
        for (ascii, sample) in [(true, SampleType::F32), (false, SampleType::F32), (false, SampleType::F64)] {
            let made = Hexahedra { scale, sample, ..Hexahedra::new(ascii) };
            let mut bytes = made.bytes();
            if ascii {
                // Six digits, as C prints them.
                let text = String::from_utf8(bytes).unwrap();
                let (head, rest) = text.split_once("float\n").unwrap();
                let (points, rest) = rest.split_once('\n').unwrap();
                let six = |w: &str| format!("{:.5e} ", w.parse::<f64>().unwrap());
                let points: String = points.split_whitespace().map(six).collect();
                bytes = format!("{head}float\n{points}\n{rest}").into_bytes();
            }
            let path = write(dir.path(), "rounded.vtk", &[&bytes]);
            let patches = AmrDataset::open(&path).unwrap().read(Some("T")).unwrap();
            assert_eq!(patches.patches, Hexahedra::expected(Some(0)));
            let edge = patches.index_to_world.matrix3.x_axis.x;
            assert!((edge - 2.0 * scale).abs() < 2e-5 * (3.0 + 2.0 * scale), "{edge} for {scale}");
        }
    }
}

/// Whether version 5, text of an octree and what stands for it, and the error.
#[rustfmt::skip]
const WRONG_HEXAHEDRA: [(bool, &str, &str, &str); 22] = [
    (false, "POINTS 45", "POINTS 4600", "POINTS: expected all its numbers"),
    (false, "POINTS 45", "POINTS 44", "expected a keyword of an unstructured grid"),
    (false, "POINTS 45", "POINTS 99999999999999999999", "POINTS: expected a number"),
    (false, "-1 0.25 3 ", "-1.5 0.25 3 ", "cell 0: expected an axis-aligned cube, found edges [1.0, 0.5, 0.5]"),
    (false, "-1 0.25 3 ", "-1 0.26 3 ", "cell 0: expected corners at multiples of 0.5"),
    (false, "-1 0.25 3 ", "nan 0.25 3 ", "cell 0: expected corners at multiples of 0.5"),
    (false, "-1 0.25 3 ", "inf 0.25 3 ", "cell 0: expected an axis-aligned cube"),
    (false, "-1 0.25 3 ", "-1 zero 3 ", "expected a number of the stated type"),
    (false, "CELLS 9 81\n", "CELLS 9 82\n8 ", "nine numbers for each cell, found '82 numbers for 9 cells'"),
    (false, "8 0 1 6 5 15 16 21 20", "8 0 1 6 5 15 16 21 45", "corners of cell 0: expected points from 0 to 44, found 45"),
    (false, "8 0 1 6 5 15 16 21 20", "8 0 1 6 5 15 16 21 -1", "corners of cell 0: expected points from 0 to 44, found -1"),
    (false, "8 0 1 6 5 15 16 21 20", "8 0 1 6 5 15 16 21 16", "cell 0: expected eight points at the corners of a cube"),
    (false, "8 0 1 6 5 15 16 21 20", "6 0 1 6 5 15 16 21 20", "cell 0: expected 8 corners, found 6"),
    (false, "8 0 1 6 5 15 16 21 20", "8 1 3 13 11 31 33 43 41", "cell 8: expected a cell at a multiple of its edge"),
    (false, "CELL_TYPES 9\n12 ", "CELL_TYPES 9\n10 ", "cell 0: expected a hexahedron (type 12) or voxel (type 11), found type 10"),
    (false, "CELL_TYPES 9\n12 ", "CELL_TYPES 8\n", "CELL_TYPES: expected as many as CELLS say"),
    (false, "CELL_DATA 9", "CELL_DATA 8", "CELL_DATA: expected as many as CELLS say, found '8 for 9'"),
    (false, "POINT_DATA 45", "POINT_DATA 44", "POINT_DATA: expected as many as POINTS say"),
    (false, "CELL_TYPES 9", "CELLS 0 0\nCELL_TYPES 9", "section: expected each section once"),
    (false, "VECTORS U float", "VECTORS U string", "this type is not supported"),
    (true, "0 8 16", "0 7 16", "OFFSETS, number 1: expected 8, with eight corners a cell, found 7"),
    (true, "OFFSETS", "OFFSET", "CELLS: expected OFFSETS, found 'OFFSET'"),
];

#[test]
fn wrong_hexahedra() {
    let dir = tempfile::tempdir().unwrap();
    let text = String::from_utf8(Hexahedra::new(true).bytes()).unwrap();
    let five = String::from_utf8(Hexahedra { version: 5, ..Hexahedra::new(true) }.bytes()).unwrap();
    for (new_form, old, new, expected) in WRONG_HEXAHEDRA {
        let text = if new_form { &five } else { &text };
        assert_eq!(text.matches(old).count(), 1, "{old}");
        let path = write(dir.path(), "h.vtk", &[text.replace(old, new).as_bytes()]);
        let result = AmrDataset::open(&path).and_then(|d| d.read(Some("T")));
        let error = result.expect_err(expected).to_string();
        assert!(error.contains("h.vtk") && error.contains(expected), "{error}: not '{expected}'");
    }
}
