//! `.npy`: versions, types, byte orders, both orders of axes, and every way to be wrong.

use isoray_grid::ScalarType;
use isoray_io::{Endian, OpenOptions, ReadError, SampleType};

use crate::damaged::fails;
use crate::make::{body, read, write};
use crate::round_trips::{ENDIANS, check, open, open_component};

/// A file up to its samples, which begin at a multiple of 64 bytes.
pub(crate) fn npy_header(version: u8, descr: &str, fortran: bool, shape: &str) -> Vec<u8> {
    let fortran = if fortran { "True" } else { "False" };
    let mut text = format!("{{'descr': {descr}, 'fortran_order': {fortran}, 'shape': {shape}, }}");
    let before = if version == 1 { 10 } else { 12 };
    while (before + text.len() + 1) % 64 != 0 {
        text.push(' ');
    }
    text.push('\n');
    let length = (text.len() as u32).to_le_bytes();
    let length = if version == 1 { &length[..2] } else { &length[..] };
    [b"\x93NUMPY", &[version, 0][..], length, text.as_bytes()].concat()
}

fn descr(sample: SampleType, endian: Endian) -> String {
    let order = match endian {
        _ if sample.size() == 1 => '|',
        Endian::Big => '>',
        Endian::Little => '<',
    };
    let name = sample.name();
    format!("'{order}{}{}'", &name[..1], sample.size())
}

#[test]
fn all_types() {
    let dir = tempfile::tempdir().unwrap();
    for version in 1..=3 {
        for sample in SampleType::ALL {
            for endian in ENDIANS {
                for (fortran, shape) in [(false, "(3, 4, 5)"), (true, "(5, 4, 3)"), (true, "(5,4,3L,)")] {
                    let header = npy_header(version, &descr(sample, endian), fortran, shape);
                    let samples = body(sample, endian, 1, true);
                    let dataset = open(&write(dir.path(), "a.npy", &[&header, &samples]));
                    check(&dataset, sample.scalar(), 0);
                    if sample == SampleType::F32 {
                        assert_eq!(dataset.mapped::<f32>().is_some(), endian == Endian::NATIVE);
                    }
                }
            }
        }
    }
}

#[test]
fn axes_and_components() {
    let dir = tempfile::tempdir().unwrap();
    for (fortran, shape) in [(false, "(3, 4, 5, 2)"), (true, "(5, 4, 3, 2)")] {
        let samples = body(SampleType::I16, Endian::Little, 2, !fortran);
        let path = write(dir.path(), "c.npy", &[&npy_header(1, "'<i2'", fortran, shape), &samples]);
        (0..2).for_each(|component| check(&open_component(&path, component), ScalarType::I16, component));
        fails(&path, "file has 2 components");
    }
    for (fortran, shape) in [(false, "(2, 3)"), (true, "(3, 2)")] {
        let path =
            write(dir.path(), "f.npy", &[&npy_header(1, "'|b1'", fortran, shape), &[0, 1, 1, 0, 0, 1]]);
        let dataset = open(&path);
        assert_eq!(dataset.dims().axes(), [3, 2, 1]);
        assert_eq!(read(&dataset, 1).unwrap().0, [0.0, 1.0, 1.0, 0.0, 0.0, 1.0]);
    }
}

#[test]
fn headers_that_are_wrong() {
    let dir = tempfile::tempdir().unwrap();
    let cases = [
        ("'<f2'", "(3, 4, 5)", "this dtype is not supported"),
        ("'<c16'", "(3, 4, 5)", "found '<c16'"),
        ("'<M8[ns]'", "(3, 4, 5)", "found '<M8[ns]'"),
        ("[('a', '<f4'), ('b', '<f4')]", "(3, 4, 5)", "found '[('a', '<f4')"),
        ("'<f4'", "(60,)", "this shape is not supported"),
        ("'<f4'", "()", "found '[]'"),
        ("'<f4'", "(1, 1, 3, 4, 5)", "or 4 with the components last"),
        ("'<f4'", "(3, 4, 5, 0)", "positive sizes"),
        ("'<f4'", "(3, 0, 5)", "no volume can have the size"),
        ("'<f4'", "(3, -4, 5)", "descr, fortran_order and shape"),
        ("'<f4'", "(3, 4, 6)", "expected 288 bytes of samples, found 240"),
        ("'<f4'", "(3, 4, 5, 18446744073709551615)", "fewer than 2^63 bytes"),
        ("'<f4'", "3", "descr, fortran_order and shape"),
    ];
    let samples = [0; 240];
    for (descr, shape, expected) in cases {
        let path = write(dir.path(), "w.npy", &[&npy_header(1, descr, false, shape), &samples]);
        fails(&path, expected);
    }
    let header = npy_header(2, "'<f4'", false, "(3, 4, 5)");
    for n in [0, 7, 9, 30] {
        let error =
            fails(&write(dir.path(), "w.npy", &[&header[..n]]), if n == 0 { "empty" } else { "NumPy array" });
        assert!(matches!(error, ReadError::Empty { .. } | ReadError::ShortHeader { .. }));
    }
    let mut other = header.clone();
    other[6] = 4;
    fails(&write(dir.path(), "w.npy", &[&other]), "a version from 1 to 3");
    other[6] = 2;
    other[10] = 255;
    fails(&write(dir.path(), "w.npy", &[&other]), "at most 65536 bytes");
    let options = OpenOptions { field: Some("a".to_owned()), ..Default::default() };
    let path = write(dir.path(), "w.npy", &[&header, &samples]);
    let error = isoray_io::Dataset::open(&path, &options).unwrap_err();
    assert!(matches!(error, ReadError::NoFields { format: "NumPy", .. }));
}
