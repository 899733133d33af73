//! `.vti`: every encoding × header type × byte order × compressor, and every way to be wrong.

use glam::DVec3;
use isoray_grid::ScalarType;
use isoray_io::{Dataset, OpenOptions, ReadError, SampleType};

use crate::damaged::fails;
use crate::make::{SAMPLES, body, read, value, write};
use crate::make_vtk::{Codec, Encoding, Vti};
use crate::round_trips::{ENDIANS, check, open, open_component, spacing};

const ENCODINGS: [Encoding; 4] =
    [Encoding::Ascii, Encoding::Inline, Encoding::AppendedRaw, Encoding::AppendedBase64];
const CODECS: [Codec; 3] = [Codec::None, Codec::Zlib, Codec::Lz4];

fn named(name: &str) -> OpenOptions {
    OpenOptions { field: Some(name.to_owned()), ..Default::default() }
}

#[test]
fn all_variants() {
    let dir = tempfile::tempdir().unwrap();
    for encoding in ENCODINGS {
        for codec in CODECS {
            for endian in ENDIANS {
                for wide in [false, true] {
                    // One block, blocks that end inside a sample, blocks without a rest.
                    for block in [1000, 7, 20] {
                        let vti = Vti { endian, wide, block, ..Vti::new(encoding, codec) };
                        let dataset = open(&write(dir.path(), "a.vti", &[&vti.bytes()]));
                        check(&dataset, ScalarType::I16, 0);
                        assert_eq!(spacing(&dataset), DVec3::new(1.0, 2.0, 0.5));
                        let origin = dataset.index_to_world().transform_point3(DVec3::ZERO);
                        assert_eq!(origin, DVec3::new(1.0, 2.0, 3.0));
                        if codec == Codec::None {
                            break;
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn all_types() {
    let dir = tempfile::tempdir().unwrap();
    for sample in SampleType::ALL {
        for encoding in ENCODINGS {
            let vti = Vti { sample, ..Vti::new(encoding, Codec::Zlib) };
            check(&open(&write(dir.path(), "a.vti", &[&vti.bytes()])), sample.scalar(), 0);
        }
    }
}

#[test]
fn components() {
    let dir = tempfile::tempdir().unwrap();
    for codec in CODECS {
        for encoding in [Encoding::Inline, Encoding::AppendedRaw] {
            let vti = Vti { components: 3, ..Vti::new(encoding, codec) };
            let path = write(dir.path(), "c.vti", &[&vti.bytes()]);
            for component in 0..3 {
                check(&open_component(&path, component), ScalarType::I16, component);
            }
            fails(&path, "file has 3 components; choose one with --component 0..2");
        }
    }
}

#[test]
fn mapped_where_the_samples_are_plain() {
    let dir = tempfile::tempdir().unwrap();
    let plain = Vti { sample: SampleType::U8, ..Vti::new(Encoding::AppendedRaw, Codec::None) };
    let packed = Vti { codec: Codec::Zlib, ..plain };
    for (vti, expected) in [(plain, true), (packed, false)] {
        let dataset = open(&write(dir.path(), "m.vti", &[&vti.bytes()]));
        assert_eq!(dataset.mapped::<u8>().is_some(), expected);
    }
}

/// A file with the given arrays of points and cells, each of one `UInt8` number a point or cell, from 1 on.
fn with_arrays(points: &str, cells: &str) -> String {
    let numbers = |n: usize| (1..=n).map(|i| i.to_string()).collect::<Vec<_>>().join(" ");
    let (five, two) = (numbers(SAMPLES), numbers(24));
    let array = |name: &str, text: &str| {
        format!("<DataArray type=\"UInt8\" Name=\"{name}\" format=\"ascii\">{text}<!-- end --></DataArray>")
    };
    let arrays =
        |names: &str, text: &str| names.split_whitespace().map(|n| array(n, text)).collect::<String>();
    format!(
        "<VTKFile type=\"ImageData\" byte_order=\"LittleEndian\"><ImageData WholeExtent=\"2 6 -1 2 0 2\" \
         Origin=\"10 20 30\" Spacing=\"1 2 4\" Direction=\"0 -1 0 1 0 0 0 0 1\"><Piece Extent=\"2 6 -1 2 0 2\">\
         <PointData>{}</PointData><CellData Scalars=\"b\">{}</CellData></Piece></ImageData></VTKFile>",
        arrays(points, &five),
        arrays(cells, &two)
    )
}

#[test]
fn arrays_and_their_choice() {
    let dir = tempfile::tempdir().unwrap();
    let file = |text: String| write(dir.path(), "f.vti", &[text.as_bytes()]);

    let points = open(&file(with_arrays("vtkGhostType p", "a b")));
    assert_eq!(points.dims().axes(), [5, 4, 3]);
    // Index (1, 1, 1) is point (3, 0, 1) of the grid; the index axes are turned by a quarter.
    let world = points.index_to_world();
    assert_eq!(world.transform_point3(DVec3::ZERO), DVec3::new(12.0, 22.0, 30.0));
    assert_eq!(world.transform_point3(DVec3::ONE), DVec3::new(10.0, 23.0, 34.0));

    // Cells of which one array is active: their centres.
    let cells = open(&file(with_arrays("", "a b")));
    assert_eq!(cells.dims().axes(), [4, 3, 2]);
    let origin = cells.index_to_world().transform_point3(DVec3::ZERO);
    assert_eq!(origin, DVec3::new(10.0 - 2.0 * -0.5, 22.5, 32.0));
    assert_eq!(read(&cells, 1).unwrap().0[23], 24.0);

    let both = file(with_arrays("p q", "a"));
    let error = fails(&both, "found p, q, a; choose one with --field NAME");
    assert!(matches!(error, ReadError::ChooseField { .. }));
    let dims = |name| Dataset::open(&both, &named(name)).unwrap().dims().axes();
    assert_eq!((dims("q"), dims("a")), ([5, 4, 3], [4, 3, 2]));
    let error = Dataset::open(&both, &named("z")).unwrap_err();
    assert!(error.to_string().ends_with("expected one of the arrays p, q, a, found --field z"), "{error}");

    fails(&file(with_arrays("", "")), "expected one array, found none");
    let flat = with_arrays("", "a").replace("-1 2 0 2", "-1 -1 0 6");
    assert_eq!(open(&file(flat)).dims().axes(), [4, 1, 6]);

    let npy = write(dir.path(), "a.mha", &[b"NDims = 3\n"]);
    let error = Dataset::open(&npy, &named("z")).unwrap_err();
    assert!(error.to_string().ends_with("the MetaImage format has no named arrays; leave --field away"));
}

#[test]
fn information_before_and_after_numbers() {
    let dir = tempfile::tempdir().unwrap();
    let key = "<InformationKey name=\"RANGE\"><Value index=\"0\">1</Value></InformationKey>";
    let text =
        with_arrays("p", "").replace("ascii\">", &format!("ascii\">{key} ")).replace("<!-- end -->", key);
    let dataset = open(&write(dir.path(), "i.vti", &[b"\xef\xbb\xbf", text.as_bytes()]));
    let expected: Vec<f32> = (1..=60u8).map(f32::from).collect();
    assert_eq!(read(&dataset, 2).unwrap(), (expected, vec![]));
}

/// What VTK 9 writes for 3×2×2 squares and a time: LZ4 in appended base64 text, and zlib inline.
#[test]
fn written_by_vtk() {
    let dir = tempfile::tempdir().unwrap();
    for (name, text) in [("lz4", include_str!("vtk9_lz4.vti")), ("zlib", include_str!("vtk9_zlib.vti"))] {
        let dataset = open(&write(dir.path(), &format!("{name}.vti"), &[text.as_bytes()]));
        assert_eq!(dataset.dims().axes(), [3, 2, 2]);
        let world = dataset.index_to_world();
        assert_eq!(world.transform_point3(DVec3::ZERO), DVec3::new(-4.0, 11.0, 30.0));
        assert_eq!(world.transform_point3(DVec3::X), DVec3::new(-4.0, 12.0, 30.0));
        assert_eq!(world.transform_point3(DVec3::Y), DVec3::new(-6.0, 11.0, 30.0));
        let expected: Vec<f32> = (0..12u8).map(|i| f32::from(i * i)).collect();
        assert_eq!(read(&dataset, 1).unwrap().0, expected);
    }
}

#[test]
fn elements_that_are_wrong() {
    let dir = tempfile::tempdir().unwrap();
    let text = String::from_utf8(Vti::new(Encoding::Inline, Codec::Lz4).bytes()).unwrap();
    let cases = [
        ("type=\"ImageData\"", "type=\"UnstructuredGrid\"", "this VTK data set is not supported"),
        ("vtkLZ4DataCompressor", "vtkLZMADataCompressor", "found 'vtkLZMADataCompressor'"),
        ("byte_order=\"BigEndian\" ", "", "field 'byte_order', found none"),
        ("BigEndian", "Middle", "LittleEndian or BigEndian"),
        ("UInt64\" comp", "UInt16\" comp", "expected UInt32 or UInt64, found 'UInt16'"),
        ("WholeExtent=\"0 4 0 3 0 2\"", "", "field 'WholeExtent', found none"),
        ("WholeExtent=\"0 4 0 3 0 2\"", "WholeExtent=\"0 4 0 3\"", "six whole numbers"),
        ("Piece Extent=\"0 4 ", "Piece Extent=\"0 2 ", "one Piece of the WholeExtent"),
        ("</Piece>", "</Piece><Piece Extent=\"0 4 0 3 0 2\"></Piece>", "an image in pieces is not supported"),
        ("0 4 0 3 0 2", "4 0 0 3 0 2", "the first not beyond the last"),
        ("0 4 0 3 0 2", "-9223372036854775808 9223372036854775807 0 3 0 2", "the first not beyond the last"),
        ("0 4 0 3 0 2", "0 4 0 3 0 20", "size of the array: expected that of the extent"),
        ("Spacing=\"1 2 0.5\"", "Spacing=\"1 0 1\"", "finite, independent steps"),
        ("Spacing=\"1 2 0.5\"", "Spacing=\"1 2\"", "three numbers"),
        ("Int16", "String", "found 'String'"),
        ("NumberOfComponents=\"1\"", "NumberOfComponents=\"0\"", "number of components"),
        ("NumberOfComponents=\"1\"", "NumberOfComponents=\"x\"", "a whole number"),
        ("s\" NumberOfComponents=\"1\" format=\"binary\"", "s\" format=\"hex\"", "ascii, binary or appended"),
        ("s\" NumberOfComponents=\"1\" format=\"binary\"", "s\" format=\"appended\"", "DataArray offset"),
        (
            "s\" NumberOfComponents=\"1\" format=\"binary\"",
            "s\" format=\"appended\" offset=\"3\"",
            "'AppendedData'",
        ),
        ("</ImageData>", "</Image>", "well-formed elements"),
    ];
    for (old, new, expected) in cases {
        assert!(text.contains(old), "{old}");
        fails(&write(dir.path(), "w.vti", &[text.replace(old, new).as_bytes()]), expected);
    }
    fails(&write(dir.path(), "w.vti", &[b"<VTKFile "]), "well-formed elements");
    fails(&write(dir.path(), "w.vti", &[b"no elements"]), "field 'VTKFile', found none");
    let endless = [b"<VTKFile a=\"".as_slice(), &vec![b'x'; 5 << 20]].concat();
    fails(&write(dir.path(), "w.vti", &[&endless]), "at most 4 MiB");
}

#[test]
fn numbers_that_are_wrong() {
    let dir = tempfile::tempdir().unwrap();
    let samples = body(SampleType::I16, isoray_io::Endian::Big, 1, true);
    let path = |bytes: &[u8]| write(dir.path(), "n.vti", &[bytes]);
    let replaced = |vti: Vti, with: &[u8]| {
        let (whole, array) = (vti.bytes(), vti.encode(&samples, false));
        let at = whole.windows(array.len()).position(|w| w == array).unwrap();
        [&whole[..at], with, &whole[at + array.len()..]].concat()
    };
    let raw = Vti::new(Encoding::AppendedRaw, Codec::None);
    fails(&path(&replaced(raw, &raw.encode(&samples[..100], false))), "found '100 bytes for 120 in the");
    let gone = raw.bytes().windows(2).position(|w| w == b" _").unwrap();
    fails(&path(&raw.bytes()[..gone]), "an underscore before the numbers");
    fails(&path(&raw.bytes()[..gone + 60]), "expected 120 bytes of samples, found ");

    let zlib = Vti::new(Encoding::AppendedRaw, Codec::Zlib);
    let mut packed = zlib.encode(&samples, false);
    let last = packed.len() - 1;
    packed[last] ^= 1;
    assert!(matches!(fails(&path(&replaced(zlib, &packed)), "zlib blocks"), ReadError::Corrupt { .. }));
    fails(&path(&replaced(zlib, &zlib.encode(&samples[..118], false))), "118 bytes in blocks for 120");

    // Sizes that the blocks do not have: words 4, 5 and 6 of the table.
    for codec in [Codec::Zlib, Codec::Lz4] {
        let vti = Vti::new(Encoding::AppendedRaw, codec);
        for (word, size) in [(3, u64::MAX), (3, 0), (3, 1), (4, 1 << 40), (5, 5)] {
            let mut packed = vti.encode(&samples, false);
            packed[8 * word..8 * word + 8].copy_from_slice(&size.to_be_bytes());
            let result = read(&open(&path(&replaced(vti, &packed))), 1);
            assert!(
                matches!(result, Err(ReadError::Corrupt { .. } | ReadError::ShortData { .. })),
                "{result:?}"
            );
        }
        let mut packed = vti.encode(&samples, false);
        packed[..8].copy_from_slice(&(1u64 << 60).to_be_bytes());
        packed[8..16].copy_from_slice(&0u64.to_be_bytes());
        packed[16..24].copy_from_slice(&120u64.to_be_bytes());
        fails(&path(&replaced(vti, &packed)), "table of compressed blocks");
    }
    let ascii = String::from_utf8(Vti::new(Encoding::Ascii, Codec::None).bytes()).unwrap();
    fails(&path(ascii.replace("0, 2, 4,", "0, 2, x,").as_bytes()), "expected a number of the stated type");
    fails(&path(ascii.replace(", 2, 4,", "").as_bytes()), "expected 120 bytes of decoded samples, found 116");
}

#[test]
fn claims_are_refused_when_opened() {
    let dir = tempfile::tempdir().unwrap();
    for codec in [Codec::Zlib, Codec::Lz4] {
        // A table that agrees with a huge extent, in a file of a few hundred bytes.
        let vti = Vti { sample: SampleType::U8, ..Vti::new(Encoding::AppendedRaw, codec) };
        let text = String::from_utf8_lossy(&vti.bytes()).into_owned();
        let header =
            text.split("<FieldData>").next().unwrap().replace("0 4 0 3 0 2", "0 1999999 0 1999999 0 0");
        let size = 2_000_000u64 * 2_000_000;
        let table = [1, size, 0, 10].map(|n: u64| n.to_be_bytes()).concat();
        let rest = "<Piece Extent=\"0 1999999 0 1999999 0 0\"><PointData><DataArray type=\"UInt8\" Name=\"s\" \
            format=\"appended\" offset=\"0\"/></PointData></Piece></ImageData><AppendedData encoding=\"raw\">_";
        let path = write(dir.path(), "claim.vti", &[header.as_bytes(), rest.as_bytes(), &table, &[7; 200]]);
        let error = Dataset::open(&path, &OpenOptions::default()).unwrap_err();
        assert!(matches!(error, ReadError::ShortData { at_most: true, .. }), "{error}");
    }
}

#[test]
fn layers_in_any_order() {
    use isoray_grid::SlabSource;
    let dir = tempfile::tempdir().unwrap();
    for (encoding, codec) in [(Encoding::Inline, Codec::Lz4), (Encoding::AppendedBase64, Codec::Zlib)] {
        let vti = Vti { sample: SampleType::F32, ..Vti::new(encoding, codec) };
        let mut slabs = open(&write(dir.path(), "o.vti", &[&vti.bytes()])).slabs::<f32>().unwrap();
        let mut layer = [0f32; 20];
        for k in [2, 0, 1, 1, 2, 0] {
            slabs.read_layers(k, &mut layer).unwrap();
            assert_eq!(layer[3], value(20 * k as usize + 3, 0) as f32);
        }
    }
}
