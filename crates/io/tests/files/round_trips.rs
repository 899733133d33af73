//! Every format × type × byte order × compression, components, skips and transforms.

use glam::{DAffine3, DVec3};
use isoray_grid::{ScalarType, SlabSource};
use isoray_io::{Dataset, Endian, OpenOptions, RawLayout, ReadError, SampleType, Warning};

use crate::make::{
    DIMS, Nifti, SAMPLES, body, encode, gzip, meta_header, nrrd_header, read, text_body, value, write, zlib,
};

pub(crate) const ENDIANS: [Endian; 2] = [Endian::Little, Endian::Big];

pub(crate) fn open(path: &std::path::Path) -> Dataset {
    Dataset::open(path, &OpenOptions::default()).unwrap()
}

pub(crate) fn open_component(path: &std::path::Path, component: usize) -> Dataset {
    Dataset::open(path, &OpenOptions { component: Some(component), ..Default::default() }).unwrap()
}

/// Checks size, type, samples of `component` for several slab heights, and that nothing is warned of.
pub(crate) fn check(dataset: &Dataset, scalar: ScalarType, component: usize) {
    let name = dataset.path().display();
    assert_eq!(dataset.dims().axes(), DIMS, "{name}");
    assert_eq!(dataset.scalar(), scalar, "{name}");
    assert_eq!(dataset.raw_bytes(), (SAMPLES * scalar.size()) as u64);
    let expected: Vec<f32> = (0..SAMPLES).map(|s| value(s, component) as f32).collect();
    for thickness in 1..=3 {
        let (found, warnings) = read(dataset, thickness).unwrap();
        assert_eq!(found, expected, "{name}");
        assert_eq!(warnings, [], "{name}");
    }
    assert_eq!(dataset.warnings(), [], "{name}");
}

pub(crate) fn spacing(dataset: &Dataset) -> DVec3 {
    dataset.index_to_world().transform_vector3(DVec3::ONE)
}

#[test]
fn raw() {
    let dir = tempfile::tempdir().unwrap();
    for sample in SampleType::ALL {
        for endian in ENDIANS {
            for skip in [0, 7, 8] {
                let samples = body(sample, endian, 1, true);
                let path = write(dir.path(), "a.raw", &[&vec![1; skip], &samples]);
                let spacing = Some([1.0, 2.0, 0.5]);
                let raw = RawLayout {
                    dims: DIMS,
                    sample,
                    endian,
                    skip: skip as u64,
                    spacing,
                    origin: Some([1.0; 3]),
                };
                let options = OpenOptions { raw: Some(raw), ..Default::default() };
                let dataset = Dataset::open(&path, &options).unwrap();
                check(&dataset, sample.scalar(), 0);
                assert_eq!(dataset.index_to_world().transform_point3(DVec3::ONE), DVec3::new(2.0, 3.0, 1.5));
                let native = endian == Endian::NATIVE || sample.size() == 1;
                let aligned = skip % 8 == 0 || sample.size() == 1;
                let mapped = match sample {
                    SampleType::U16 => dataset.mapped::<u16>().is_some(),
                    SampleType::F32 => dataset.mapped::<f32>().is_some(),
                    SampleType::U8 => dataset.mapped::<u8>().is_some(),
                    SampleType::F64 => dataset.mapped::<f32>().is_some(),
                    _ => continue,
                };
                assert_eq!(mapped, native && aligned && sample != SampleType::F64);
            }
        }
    }
}

#[test]
fn nrrd() {
    let dir = tempfile::tempdir().unwrap();
    for sample in SampleType::ALL {
        for endian in ENDIANS {
            let samples = body(sample, endian, 1, true);
            for (encoding, data) in [
                ("raw", samples.clone()),
                ("gzip", gzip(&samples)),
                ("gz", zlib(&samples)),
                ("ascii", text_body()),
            ] {
                let header = nrrd_header(sample, endian, encoding);
                let attached = write(dir.path(), "a.nrrd", &[header.as_bytes(), b"\n", &data]);
                let dataset = open(&attached);
                check(&dataset, sample.scalar(), 0);
                assert_eq!(spacing(&dataset), DVec3::new(1.0, 2.0, 0.5));

                write(dir.path(), "a.data", &[&data]);
                let field =
                    if endian == Endian::Big { "data file: ./a.data" } else { "datafile:a.data\r\n\r\n" };
                let detached = write(dir.path(), "a.nhdr", &[header.as_bytes(), field.as_bytes()]);
                check(&open(&detached), sample.scalar(), 0);
            }
        }
    }
}

#[test]
fn nrrd_skips() {
    let dir = tempfile::tempdir().unwrap();
    let samples = body(SampleType::U16, Endian::Big, 1, true);
    let cases: [(&str, &str, Vec<u8>); 6] = [
        ("raw", "line skip: 2\nbyte skip: 3", [b"ab\n\n\xff\xff\xff".as_slice(), &samples].concat()),
        ("raw", "byte skip: -1", [b"any number of bytes".as_slice(), &samples].concat()),
        ("gzip", "byteskip: 5", gzip(&[b"12345".as_slice(), &samples].concat())),
        ("gzip", "lineskip: 1", [b"a line\n".as_slice(), &gzip(&samples)].concat()),
        (
            "gzip",
            "space: left-posterior-superior",
            [&gzip(&samples[..50])[..], &gzip(&samples[50..])].concat(),
        ),
        ("text", "line skip: 1", [b"no numbers\n".as_slice(), &text_body()].concat()),
    ];
    for (encoding, skip, data) in cases {
        write(dir.path(), "s.data", &[&data]);
        let header = nrrd_header(SampleType::U16, Endian::Big, encoding);
        let text = format!("{header}{skip}\ndata file: s.data\n");
        let mut dataset = open(&write(dir.path(), "s.nhdr", &[text.as_bytes()]));
        if skip == "byte skip: -1" {
            let attached = format!("{header}{skip}\n\n");
            dataset = open(&write(dir.path(), "s.nrrd", &[attached.as_bytes(), &data]));
        }
        check(&dataset, ScalarType::U16, 0);
    }
}

#[test]
fn nrrd_axes_and_components() {
    let dir = tempfile::tempdir().unwrap();
    let sample = SampleType::I16;
    let base = "NRRD0005\ntype: short\nendian: little\n";
    let directions = "space directions: none (0,0,2) (0,-1,0) (3,0,1)\nspace origin: (5, 6, 7)\n";
    let cases = [
        (
            true,
            "dimension: 4\nsizes: 3 5 4 3\nkinds: vector domain domain domain\nencoding: gzip\n".to_owned(),
            3,
        ),
        (true, format!("dimension: 4\nsizes: 2 5 4 3\n{directions}encoding: raw\n"), 2),
        (false, "dimension: 4\nsizes: 5 4 3 4\nkinds: space space space list\nencoding: raw\n".to_owned(), 4),
        (
            false,
            "dimension: 5\nsizes: 5 4 3 1 2\nkinds: space space space ??? list\nencoding: gz\n".to_owned(),
            2,
        ),
        (true, "dimension: 4\nsizes: 1 5 4 3\nkinds: ??? space space space\nencoding: raw\n".to_owned(), 1),
        (true, "dimension: 4\nsizes: 5 4 3 1\nspacings: 1 1 1 nan\nencoding: raw\n".to_owned(), 1),
    ];
    for (interleaved, fields, components) in cases {
        let samples = body(sample, Endian::Little, components, interleaved);
        let data = if fields.contains("gz") { gzip(&samples) } else { samples };
        let path = write(dir.path(), "c.nrrd", &[base.as_bytes(), fields.as_bytes(), b"\n", &data]);
        for component in 0..components {
            check(&open_component(&path, component), ScalarType::I16, component);
        }
        if components > 1 {
            let error = Dataset::open(&path, &OpenOptions::default()).unwrap_err();
            let text = format!(
                "file has {components} components; choose one with --component 0..{}",
                components - 1
            );
            assert!(error.to_string().ends_with(&text), "{error}");
            let options = OpenOptions { component: Some(components), ..Default::default() };
            assert!(matches!(Dataset::open(&path, &options), Err(ReadError::NoSuchComponent { .. })));
        }
        if fields.contains("directions") {
            let world = open_component(&path, 1).index_to_world();
            assert_eq!(world.transform_point3(DVec3::X), DVec3::new(5.0, 6.0, 9.0));
            assert_eq!(world.transform_point3(DVec3::Z), DVec3::new(8.0, 6.0, 8.0));
        }
    }
}

#[test]
fn metaimage() {
    let dir = tempfile::tempdir().unwrap();
    for sample in SampleType::ALL {
        for endian in ENDIANS {
            let samples = body(sample, endian, 1, true);
            for (compressed, data) in
                [(false, samples.clone()), (true, zlib(&samples)), (true, gzip(&samples))]
            {
                let header = meta_header(sample, endian, compressed, "LOCAL");
                let dataset = open(&write(dir.path(), "a.mha", &[header.as_bytes(), &data]));
                check(&dataset, sample.scalar(), 0);
                assert_eq!(spacing(&dataset), DVec3::new(1.0, 2.0, 0.5));

                write(dir.path(), "a.zraw", &[&data]);
                let header = meta_header(sample, endian, compressed, "a.zraw");
                check(&open(&write(dir.path(), "a.mhd", &[header.as_bytes()])), sample.scalar(), 0);
            }
        }
        let header = meta_header(sample, Endian::Big, false, "LOCAL")
            .replace("BinaryData = True", "BinaryData = False");
        check(&open(&write(dir.path(), "t.mha", &[header.as_bytes(), &text_body()])), sample.scalar(), 0);
    }
}

#[test]
fn metaimage_fields() {
    let dir = tempfile::tempdir().unwrap();
    let header = |more: &str| {
        meta_header(SampleType::U16, Endian::Little, false, "LOCAL")
            .replace("NDims = 3\n", &format!("NDims = 3\n{more}\n"))
    };
    let samples = body(SampleType::U16, Endian::Little, 3, true);
    let three = header("ElementNumberOfChannels = 3");
    let path = write(dir.path(), "c.mha", &[three.as_bytes(), &samples]);
    for component in 0..3 {
        check(&open_component(&path, component), ScalarType::U16, component);
    }
    // The first triple is the direction of i.
    let turned = header("TransformMatrix = 0 1 0 -1 0 0 0 0 1\nOffset = 10 20 30");
    let samples = body(SampleType::U16, Endian::Little, 1, true);
    let world = open(&write(dir.path(), "t.mha", &[turned.as_bytes(), &samples])).index_to_world();
    assert_eq!(world.transform_point3(DVec3::X), DVec3::new(10.0, 21.0, 30.0));
    assert_eq!(world.transform_point3(DVec3::Y), DVec3::new(8.0, 20.0, 30.0));

    for (size, before) in [("12", 12), ("-1", 31)] {
        let text = header(&format!("HeaderSize = {size}")).replace("LOCAL", "h.raw");
        write(dir.path(), "h.raw", &[&vec![9; before], &samples]);
        check(&open(&write(dir.path(), "h.mhd", &[text.as_bytes()])), ScalarType::U16, 0);
    }
}

#[test]
fn nifti() {
    let dir = tempfile::tempdir().unwrap();
    for version in [1, 2] {
        for sample in SampleType::ALL {
            for endian in ENDIANS {
                let samples = body(sample, endian, 1, true);
                let mut header = Nifti::new(version, sample, endian);
                let whole = [header.bytes(), samples.clone()].concat();
                let plain = open(&write(dir.path(), "a.nii", &[&whole]));
                assert_eq!(plain.format(), format!("NIfTI-{version}"));
                check(&plain, sample.scalar(), 0);
                assert_eq!(spacing(&plain), DVec3::new(1.0, 2.0, 0.5));
                check(&open(&write(dir.path(), "a.nii.gz", &[&gzip(&whole)])), sample.scalar(), 0);

                header.single = false;
                header.vox_offset = 0.0;
                let path = write(dir.path(), "p.hdr", &[&header.bytes()]);
                let image = write(dir.path(), "p.img", &[&samples]);
                check(&open(&path), sample.scalar(), 0);
                check(&open(&image), sample.scalar(), 0);
            }
        }
    }
}

#[test]
fn nifti_components_scale_and_sform() {
    let dir = tempfile::tempdir().unwrap();
    let (sample, endian) = (SampleType::I16, Endian::Big);
    let mut header = Nifti::new(1, sample, endian);
    header.dim = [5, 5, 4, 3, 2, 3, 1, 1];
    let data = [header.bytes(), body(sample, endian, 6, false)].concat();
    let plain = write(dir.path(), "c.nii", &[&data]);
    let packed = write(dir.path(), "c.nii.gz", &[&gzip(&data)]);
    for component in 0..6 {
        check(&open_component(&plain, component), ScalarType::I16, component);
        check(&open_component(&packed, component), ScalarType::I16, component);
    }

    let mut header = Nifti::new(1, sample, endian);
    header.scale = [0.5, -3.0];
    header.sform = Some([[-1.0, 0.0, 0.0, 9.0], [0.0, 2.0, 0.0, 8.0], [0.0, 0.0, 3.0, 7.0]]);
    let path = write(dir.path(), "s.nii", &[&header.bytes(), &body(sample, endian, 1, true)]);
    let dataset = open(&path);
    assert_eq!(dataset.scalar(), ScalarType::F32);
    let (found, _) = read(&dataset, 2).unwrap();
    let expected: Vec<f32> = (0..SAMPLES).map(|s| (value(s, 0) * 0.5 - 3.0) as f32).collect();
    assert_eq!(found, expected);
    let flipped = DAffine3::from_translation(DVec3::new(9.0, 8.0, 7.0))
        * DAffine3::from_scale(DVec3::new(-1.0, 2.0, 3.0));
    assert_eq!(dataset.index_to_world(), flipped);

    header.scale = [1.0, 0.0];
    header.sform = Some([[0.0; 4]; 3]);
    let path = write(dir.path(), "s.nii", &[&header.bytes(), &body(sample, endian, 1, true)]);
    let dataset = open(&path);
    assert_eq!(dataset.scalar(), ScalarType::I16);
    assert_eq!(dataset.warnings(), [Warning::BadTransform { path, transform: "sform" }]);
}

#[test]
fn restarts_and_jumps() {
    let dir = tempfile::tempdir().unwrap();
    let samples = body(SampleType::I32, Endian::Big, 1, true);
    let header = nrrd_header(SampleType::I32, Endian::Big, "gzip");
    let packed = write(dir.path(), "a.nrrd", &[header.as_bytes(), b"\n", &gzip(&samples)]);
    let header = nrrd_header(SampleType::I32, Endian::Big, "raw");
    let plain = write(dir.path(), "b.nrrd", &[header.as_bytes(), b"\n", &samples]);
    for path in [packed, plain] {
        let mut slabs = open(&path).slabs::<f32>().unwrap();
        let mut layer = [0f32; 20];
        for k in [2, 0, 1, 1, 2, 0] {
            slabs.read_layers(k, &mut layer).unwrap();
            assert_eq!(layer[3], value(20 * k as usize + 3, 0) as f32);
        }
        assert!(matches!(slabs.read_layers(3, &mut layer), Err(ReadError::Layers { first: 3, .. })));
        assert!(matches!(slabs.read_layers(0, &mut layer[..7]), Err(ReadError::Layers { samples: 7, .. })));
        slabs.read_layers(3, &mut []).unwrap();
        assert!(matches!(open(&path).slabs::<i16>(), Err(ReadError::WrongType { .. })));
    }
}

#[test]
fn warns_of_lost_digits_and_extra_bytes() {
    let dir = tempfile::tempdir().unwrap();
    let mut samples = body(SampleType::F64, Endian::Little, 1, true);
    samples[..8].copy_from_slice(&encode(0.1, SampleType::F64, Endian::Little));
    samples[8..16].copy_from_slice(&encode(-1e200, SampleType::F64, Endian::Little));
    samples[16..24].copy_from_slice(&encode(f64::NAN, SampleType::F64, Endian::Little));
    samples.extend([0; 5]);
    let header = nrrd_header(SampleType::F64, Endian::Little, "raw");
    let path = write(dir.path(), "w.nrrd", &[header.as_bytes(), b"\n", &samples]);
    let dataset = open(&path);
    assert_eq!(dataset.warnings(), [Warning::ExtraBytes { path: path.clone(), extra: 5 }]);
    let (_, warnings) = read(&dataset, 1).unwrap();
    let rounded = Warning::Rounded { path: path.clone(), samples: 1 };
    assert_eq!(warnings, [rounded, Warning::Overflowed { path, samples: 1 }]);

    let header = nrrd_header(SampleType::F64, Endian::Little, "gzip");
    let path = write(dir.path(), "w.nrrd", &[header.as_bytes(), b"\n", &gzip(&samples)]);
    let (_, warnings) = read(&open(&path), 3).unwrap();
    assert_eq!(warnings[2], Warning::ExtraStream { path });
}
