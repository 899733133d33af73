//! `.vtk`: text and binary, all kinds of arrays, and every way to be wrong.

use glam::DVec3;
use isoray_grid::ScalarType;
use isoray_io::{Dataset, Endian, OpenOptions, ReadError, SampleType};

use crate::damaged::fails;
use crate::make::{SAMPLES, body, read, text_body, write};
use crate::make_vtk::{legacy_header, legacy_type};
use crate::round_trips::{check, open, spacing};

fn named(name: &str, component: Option<usize>) -> OpenOptions {
    OpenOptions { field: Some(name.to_owned()), component, ..Default::default() }
}

fn numbers(ascii: bool, sample: SampleType, components: usize) -> Vec<u8> {
    match (ascii, components) {
        (true, 1) => text_body().into_iter().map(|b| if b == b',' { b' ' } else { b }).collect(),
        (true, _) => {
            let all = body(SampleType::U8, Endian::Little, components, true);
            all.iter().map(|v| format!("{v} ")).collect::<String>().into_bytes()
        }
        (false, _) => body(sample, Endian::Big, components, true),
    }
}

#[test]
fn all_types() {
    let dir = tempfile::tempdir().unwrap();
    for sample in SampleType::ALL {
        for ascii in [false, true] {
            let header = legacy_header(ascii);
            let array = format!("SCALARS s {}\nLOOKUP_TABLE default\n", legacy_type(sample));
            let numbers = numbers(ascii, sample, 1);
            let parts = [header.as_bytes(), array.as_bytes(), &numbers, b"\nMETADATA\nINFORMATION 0\n\n"];
            let dataset = open(&write(dir.path(), "a.vtk", &parts));
            check(&dataset, sample.scalar(), 0);
            assert_eq!(spacing(&dataset), DVec3::new(1.0, 2.0, 0.5));
            assert_eq!(dataset.index_to_world().transform_point3(DVec3::ZERO), DVec3::new(1.0, 2.0, 3.0));
        }
    }
}

#[test]
fn scalars_that_vtk_writes_as_colours() {
    let dir = tempfile::tempdir().unwrap();
    let array = b"COLOR_SCALARS s 1\n";
    let samples = numbers(false, SampleType::U8, 1);
    let vector = [b"\nVECTORS v char\n".as_slice(), &[0; 3 * SAMPLES]].concat();
    let header = legacy_header(false);
    let parts = [header.as_bytes(), array, &samples, &vector];
    check(&open(&write(dir.path(), "c.vtk", &parts)), ScalarType::U8, 0);
}

/// A file with arrays of every kind.
fn all_kinds(ascii: bool) -> Vec<u8> {
    let sample = SampleType::I16;
    let three = numbers(ascii, sample, 3);
    let bytes = numbers(ascii, SampleType::U8, 3);
    let table: Vec<u8> = if ascii { b"0 0 0 1 1 1 1 1".to_vec() } else { vec![9; 8] };
    let bits: Vec<u8> = if ascii { b"1 ".repeat(SAMPLES) } else { vec![0; 8] };
    let time: Vec<u8> = if ascii { b"0.5".to_vec() } else { 0.5f64.to_be_bytes().to_vec() };
    let one = numbers(ascii, sample, 1);
    // Spelled as old files do, with dimensions after an array of the whole file.
    let start = legacy_header(ascii)
        .replace("SPACING", "aspect_ratio")
        .replace("\nDIMENSIONS", "\nFIELD FieldData 1\nTIME 1 1 double\nDIMENSIONS");
    let (before, after) = start.split_once("double\n").unwrap();
    [
        before.as_bytes(),
        b"double\n",
        &time,
        b"\n",
        after.as_bytes(),
        b"VECTORS v short\r\n",
        &three,
        b"\nCOLOR_SCALARS colours 3\n",
        &bytes,
        b"\nLOOKUP_TABLE t 2\n",
        &table,
        b"\nSCALARS flags bit\nLOOKUP_TABLE default\n",
        &bits,
        b"\nFIELD attributes 2\na%20b 3 60 short\n",
        &three,
        b"\nMETADATA\nINFORMATION 1\nNAME x LOCATION y\nDATA 2 0 1\n\nlast 1 60 short\n",
        &one,
        b"\nCELL_DATA 24\nSCALARS c unsigned_char 1\nLOOKUP_TABLE default\n",
        &if ascii { b"7 ".repeat(24) } else { vec![7; 24] },
    ]
    .concat()
}

#[test]
fn arrays_and_their_choice() {
    let dir = tempfile::tempdir().unwrap();
    for ascii in [false, true] {
        let path = write(dir.path(), "k.vtk", &[&all_kinds(ascii)]);
        for component in 0..3 {
            for name in ["v", "a b"] {
                let dataset = Dataset::open(&path, &named(name, Some(component))).unwrap();
                check(&dataset, ScalarType::I16, component);
            }
        }
        check(&Dataset::open(&path, &named("last", None)).unwrap(), ScalarType::I16, 0);
        let colours = Dataset::open(&path, &named("colours", Some(2))).unwrap();
        check(&colours, if ascii { ScalarType::F32 } else { ScalarType::U8 }, 2);
        let cells = Dataset::open(&path, &named("c", None)).unwrap();
        assert_eq!((cells.dims().axes(), read(&cells, 1).unwrap().0), ([4, 3, 2], vec![7.0; 24]));
        let origin = cells.index_to_world().transform_point3(DVec3::ZERO);
        assert_eq!(origin, DVec3::new(1.5, 3.0, 3.25));
        // The only scalars are of a type that is not read.
        fails(
            &path,
            "this type is not supported; expected integers of 8 to 64 bits, float or double, found 'bit'",
        );
        let error = Dataset::open(&path, &named("TIME", None)).unwrap_err();
        assert!(error.to_string().contains("v, colours, flags, a b, last, c, found --field TIME"), "{error}");
    }
    let two = "SCALARS s char\nLOOKUP_TABLE default\n";
    let ones = "1 ".repeat(SAMPLES);
    let text = format!("{}{two}{ones}\n{}{ones}", legacy_header(true), two.replace(" s ", " r "));
    let error = fails(&write(dir.path(), "t.vtk", &[text.as_bytes()]), "found s, r; choose one with --field");
    assert!(matches!(error, ReadError::ChooseField { .. }));
}

#[test]
fn sections_that_are_wrong() {
    let dir = tempfile::tempdir().unwrap();
    let text = legacy_header(true) + "SCALARS s short 1\nLOOKUP_TABLE default\n" + &"1 ".repeat(SAMPLES);
    let cases = [
        ("# vtk DataFile Version 3.0\n", "# vtk\n", "expected # vtk DataFile Version, found '# vtk'"),
        ("ASCII", "HEX", "expected ASCII or BINARY, found 'HEX'"),
        ("STRUCTURED_POINTS", "UNSTRUCTURED_GRID", "DATASET STRUCTURED_POINTS, found 'UNSTRUCTURED_GRID'"),
        ("DIMENSIONS 5 4 3\n", "", "field 'DIMENSIONS', found none"),
        ("DIMENSIONS 5 4 3", "DIMENSIONS 5 4", "DIMENSIONS: expected a number, found 'ORIGIN'"),
        ("DIMENSIONS 5 4 3", "DIMENSIONS 5 4 9", "found '60 for 5x4x9'"),
        ("DIMENSIONS 5 4 3", "DIMENSIONS 5 4 18446744073709551615", "the first not beyond the last"),
        ("SPACING 1 2 0.5", "SPACING 1 0 1", "finite, independent steps"),
        ("POINT_DATA 60", "POINT_DATA 61", "as many as DIMENSIONS say"),
        ("POINT_DATA 60", "", "a keyword of structured points, found 'SCALARS'"),
        ("SCALARS s short 1", "SCALES s short 1", "found 'SCALES'"),
        ("SCALARS s short 1", "SCALARS s", "a name, a size and a type"),
        ("SCALARS s short 1", "SCALARS s short x", "a name, a size and a type"),
        ("SCALARS s short 1", "SCALARS s short 0", "number of components"),
        ("SCALARS s short 1", "SCALARS s string 1", "found 'string'"),
        ("SCALARS s short 1", "SCALARS s short 2", "all its numbers, found 'the end of the file'"),
        ("LOOKUP_TABLE default", "1 2 3", "expected LOOKUP_TABLE, found '1'"),
        ("SCALARS s short 1", "FIELD f 99999999999\nSCALARS s short 1", "components of an array"),
        (
            "SCALARS s short 1\n",
            "LOOKUP_TABLE t 99999999999999999\nSCALARS s short 1\n",
            "LOOKUP_TABLE: expected",
        ),
    ];
    for (old, new, expected) in cases {
        assert!(text.contains(old), "{old}");
        let name = if old.starts_with('#') { "w.vtk" } else { "w.dat" };
        fails(&write(dir.path(), name, &[text.replace(old, new).as_bytes()]), expected);
    }
    let binary = text.replace("ASCII", "BINARY").replace("short 1", "double 1");
    fails(&write(dir.path(), "w.vtk", &[binary.as_bytes()]), "array: expected all its numbers");
    fails(
        &write(dir.path(), "w.vtk", &[text.replace("1 1 1", "1 x 1").as_bytes()]),
        "number of the stated type",
    );
    let long = text.replace("a title", &"x".repeat(5000));
    fails(&write(dir.path(), "w.vtk", &[long.as_bytes()]), "at most 4096 bytes");
}
