//! One typed error each for every way in which a file can be wrong; each names the file.

use std::path::Path;

use isoray_io::{Dataset, Endian, OpenOptions, RawLayout, ReadError, SampleType};

use crate::make::{Nifti, body, gzip, meta_header, nrrd_header, read, text_body, write, zlib};

const SAMPLE: SampleType = SampleType::I16;

/// The error of opening or reading the file, which must name it and contain `expected`.
pub(crate) fn fails(path: &Path, expected: &str) -> ReadError {
    let result = Dataset::open(path, &OpenOptions::default());
    let error = match result {
        Err(error) => error,
        Ok(dataset) => read(&dataset, 1).expect_err(expected),
    };
    let text = error.to_string();
    let name = path.file_stem().unwrap().to_str().unwrap();
    assert!(
        text.contains(name) && text.contains(expected) && !text.contains('\n'),
        "{text}: not '{expected}'"
    );
    error
}

pub(crate) fn raw(dims: [u32; 3], skip: u64) -> OpenOptions {
    let layout = RawLayout { dims, sample: SAMPLE, endian: Endian::Big, skip, spacing: None, origin: None };
    OpenOptions { raw: Some(layout), ..Default::default() }
}

#[test]
fn files_of_no_format() {
    let dir = tempfile::tempdir().unwrap();
    assert!(matches!(fails(&dir.path().join("gone.nrrd"), "cannot open"), ReadError::Io { .. }));
    assert!(matches!(fails(&write(dir.path(), "empty.nrrd", &[]), "empty file"), ReadError::Empty { .. }));
    let unknown = write(dir.path(), "a.raw", &[&[1; 99]]);
    assert!(matches!(fails(&unknown, "--dims NX,NY,NZ and --type"), ReadError::UnknownFormat { .. }));
    fails(&write(dir.path(), "b.nrrd", &[b"NRDR0004\n"]), "expected NRRD0001 to NRRD0005, found 'NRDR0004'");
    fails(&write(dir.path(), "b.nrrd", &[b"NRRD0009\n"]), "found 'NRRD0009'");
    fails(&write(dir.path(), "b.mhd", &[b"no fields\n"]), "'Key = value'");
    fails(&write(dir.path(), "b.nii", &[&[7; 400]]), "expected 348 and n+1 or ni1");
    fails(&write(dir.path(), "b.nii", &[&[7; 40]]), "after 40 bytes");
    fails(&write(dir.path(), "b.nii.gz", &[&gzip(&[7; 40])]), "after 40 bytes");
    fails(&write(dir.path(), "b.nii.gz", &[&gzip(&[7; 400])[..12]]), "after 0 bytes");
    fails(dir.path(), if cfg!(feature = "tiff") { "a directory of TIFF slices" } else { "cannot" });
}

#[test]
fn raw_layouts() {
    let dir = tempfile::tempdir().unwrap();
    let path = write(dir.path(), "a.raw", &[&[1; 119]]);
    let error = Dataset::open(&path, &raw([5, 4, 3], 0)).unwrap_err();
    assert!(error.to_string().ends_with("expected 120 bytes of samples, found 119"), "{error}");
    let error = Dataset::open(&path, &raw([5, 4, 2], u64::MAX)).unwrap_err();
    assert!(error.to_string().contains("found 0") || error.to_string().contains("seek"), "{error}");
    for dims in [[0, 4, 3], [u32::MAX; 3], [1 << 21; 3]] {
        assert!(matches!(Dataset::open(&path, &raw(dims, 0)), Err(ReadError::Dims { .. })));
    }
    let mut options = raw([5, 4, 2], 0);
    options.raw.as_mut().unwrap().spacing = Some([1.0, 0.0, 1.0]);
    assert!(Dataset::open(&path, &options).unwrap_err().to_string().contains("no spacing of 0"));
    options = raw([5, 4, 2], 0);
    options.component = Some(1);
    assert!(matches!(Dataset::open(&path, &options), Err(ReadError::NoSuchComponent { .. })));

    let header = nrrd_header(SAMPLE, Endian::Big, "raw");
    let path = write(dir.path(), "a.nrrd", &[header.as_bytes(), b"\n", &[0; 120]]);
    let error = Dataset::open(&path, &raw([5, 4, 3], 0)).unwrap_err();
    assert!(matches!(error, ReadError::NotRaw { format: "NRRD", .. }), "{error}");
    Dataset::open(&path, &raw([5, 4, 3], 3)).unwrap();
}

#[test]
fn nrrd_fields() {
    let dir = tempfile::tempdir().unwrap();
    let header = nrrd_header(SAMPLE, Endian::Big, "raw");
    let samples = body(SAMPLE, Endian::Big, 1, true);
    let cases = [
        ("sizes: 5 4 3", "sizes: 5 4 0", "expected a positive integer for each axis, found '5 4 0'"),
        ("sizes: 5 4 3", "sizes: 5 4 -3", "found '5 4 -3'"),
        ("sizes: 5 4 3", "sizes: 5 4", "found '5 4'"),
        ("sizes: 5 4 3", "sizes: 5 4 30", "expected 1200 bytes of samples, found 120"),
        ("sizes: 5 4 3", "sizes: 2000000 2000000 2000000", "no volume can have the size"),
        ("sizes: 5 4 3", "sizes: 99999999999 4 3", "found '99999999999x4x3'"),
        (
            "dimension: 3\nsizes: 5 4 3\nspacings: 1 2 0.5",
            "dimension: 2\nsizes: 5 12",
            "found '2 axes, 2 of them",
        ),
        (
            "dimension: 3\nsizes: 5 4 3\nspacings: 1 2 0.5",
            "dimension: 4\nsizes: 5 2 2 3",
            "4 of them spatial",
        ),
        ("dimension: 3", "dimension: 3\nkinds: vector space space", "3 axes, 2 of them spatial"),
        ("dimension: 3", "dimension: 17", "found '17'"),
        ("dimension: 3\n", "", "field 'dimension', found none"),
        ("endian: big\n", "", "field 'endian', found none"),
        ("endian: big", "endian: middle", "expected little or big, found 'middle'"),
        ("type: signed short int", "type: block", "found 'block'"),
        ("encoding: raw", "encoding: bzip2", "expected raw, gzip or ascii, found 'bzip2'"),
        ("encoding: raw", "encoding: hex", "found 'hex'"),
        ("encoding: raw", "encoding: gzip", "expected a gzip or zlib stream"),
        ("encoding: raw", "encoding: gzip\nbyte skip: -1", "-1 only with encoding raw"),
        ("encoding: raw", "encoding: raw\nencoding: raw", "each field once"),
        ("encoding: raw", "encoding: raw\nbyte skip: -2", "found '-2'"),
        ("encoding: raw", "encoding: raw\nline skip: 1000", "lines to skip"),
        ("encoding: raw", "encoding: raw\ndata file: gone.raw", "gone.raw, which cannot be opened"),
        ("encoding: raw", "encoding: raw\ndata file:", "which cannot be opened"),
        ("encoding: raw", "encoding: raw\ndata file: LIST", "a list of data files is not supported"),
        (
            "encoding: raw",
            "encoding: raw\ndata file: f%03d.raw 1 9 1",
            "a list of data files is not supported",
        ),
        ("encoding: raw", "encoding: raw\nno field", "found 'no field'"),
        ("spacings: 1 2 0.5", "spacings: 1 0 1", "finite, independent steps"),
        ("spacings: 1 2 0.5", "spacings: 1 2", "a number for each axis"),
        ("spacings: 1 2 0.5", "space directions: (1,0,0) (1,0,0) (0,0,1)", "finite, independent steps"),
        ("spacings: 1 2 0.5", "space directions: (1,0) (0,1) (1,1)", "a vector of three numbers"),
        ("spacings: 1 2 0.5", "space origin: (1,2)", "one vector of three numbers"),
    ];
    for (old, new, expected) in cases {
        assert!(header.contains(old), "{old}");
        let text = header.replace(old, new);
        fails(&write(dir.path(), "f.nrrd", &[text.as_bytes(), b"\n", &samples]), expected);
    }
    fails(&write(dir.path(), "cut.nrrd", &[header.as_bytes()]), "a blank line before the samples");
}

#[test]
fn nrrd_components_between_and_beyond() {
    let dir = tempfile::tempdir().unwrap();
    let base = "NRRD0005\ntype: short\nendian: little\nencoding: gzip\ndimension: 4\n";
    let between = format!("{base}sizes: 5 2 4 3\nkinds: space vector space space\n\n");
    fails(&write(dir.path(), "m.nrrd", &[between.as_bytes(), &gzip(&[0; 240])]), "first or last");
    for (count, expected) in [("99999", "found '99999'"), ("18446744073709551615", "fewer than 2^63 bytes")] {
        let many = format!("{base}sizes: {count} 5 4 3\nkinds: vector space space space\n\n");
        fails(&write(dir.path(), "m.nrrd", &[many.as_bytes(), &gzip(&[0; 240])]), expected);
    }
}

#[test]
fn streams() {
    let dir = tempfile::tempdir().unwrap();
    let header = nrrd_header(SAMPLE, Endian::Big, "gzip");
    let samples: Vec<u8> = (0..120u32).map(|i| ((i * i * 7919) >> 5) as u8).collect();
    let packed = gzip(&samples);
    let nrrd = |data: &[u8]| write(dir.path(), "s.nrrd", &[header.as_bytes(), b"\n", data]);
    fails(&nrrd(b""), "gzip or zlib stream");
    fails(&nrrd(&packed[..60]), "expected 120 bytes of decompressed samples, found");
    fails(&nrrd(&packed[..5]), "expected 120 bytes of decompressed samples, found 0");
    fails(&nrrd(&gzip(&samples[..90])), "expected 120 bytes of decompressed samples, found 90");
    fails(&nrrd(&zlib(&samples[..90])), "expected 120 bytes of decompressed samples, found 90");
    let mut corrupt = packed.clone();
    let checksum = corrupt.len() - 8;
    corrupt[checksum] ^= 1;
    assert!(matches!(fails(&nrrd(&corrupt), "after 120 decoded"), ReadError::Corrupt { .. }));
    fails(&nrrd(&packed[..packed.len() - 3]), "after 120 decoded");
    let mut corrupt = packed;
    corrupt[10] = 0xff;
    assert!(matches!(fails(&nrrd(&corrupt), "gzip or zlib stream"), ReadError::Corrupt { .. }));

    let header = nrrd_header(SAMPLE, Endian::Big, "text");
    let text = |data: &[u8]| write(dir.path(), "t.nrrd", &[header.as_bytes(), b"\n", data]);
    fails(&text(&text_body()[..20]), "bytes of decoded samples");
    let padded = |numbers: &[u8]| [numbers, &[b' '; 120]].concat();
    let error = fails(&text(&padded(b"1 2 three 4")), "expected a number of the stated type");
    assert!(std::error::Error::source(&error).unwrap().to_string().contains("found 'three'"));
    fails(&text(&padded(b"70000 1 2")), "number of the stated type");
    fails(&text(&[b'9'; 10_000]), "number of the stated type");
}

#[test]
fn streams_too_short_for_what_they_claim_are_refused_when_opened() {
    let dir = tempfile::tempdir().unwrap();
    let refused = |encoding: &str, sizes: &str, data: &[u8], expected: &str| {
        let header = nrrd_header(SAMPLE, Endian::Big, encoding).replace("sizes: 5 4 3", sizes);
        let path = write(dir.path(), "claim.nrrd", &[header.as_bytes(), b"\n", data]);
        let error = Dataset::open(&path, &OpenOptions::default()).unwrap_err();
        assert!(matches!(error, ReadError::ShortData { at_most: true, .. }), "{error}");
        assert!(error.to_string().ends_with(expected), "{error}");
    };
    let packed = gzip(&[0; 120]);
    let most = packed.len() * 1032;
    refused(
        "gzip",
        "sizes: 2000000 2000000 1",
        &packed,
        &format!("expected 8000000000000 bytes of decompressed samples, found room for at most {most}"),
    );
    refused("text", "sizes: 5 1 1", b"1 2 3 4", "10 bytes of decoded samples, found room for at most 8");

    // What deflate shrinks most is not refused: 64 MiB of zeros, and one-digit numbers.
    let zeros = vec![0; 64 << 20];
    let header = nrrd_header(SAMPLE, Endian::Big, "gzip").replace("sizes: 5 4 3", "sizes: 512 512 128");
    let path = write(dir.path(), "zeros.nrrd", &[header.as_bytes(), b"\n", &zlib(&zeros)]);
    Dataset::open(&path, &OpenOptions::default()).unwrap();
    let header = nrrd_header(SAMPLE, Endian::Big, "text").replace("sizes: 5 4 3", "sizes: 5 1 1");
    let path = write(dir.path(), "digits.nrrd", &[header.as_bytes(), b"\n", b"1 2 3 4 5"]);
    read(&Dataset::open(&path, &OpenOptions::default()).unwrap(), 1).unwrap();
}

#[test]
fn metaimage_fields() {
    let dir = tempfile::tempdir().unwrap();
    let header = meta_header(SAMPLE, Endian::Big, false, "LOCAL");
    let samples = body(SAMPLE, Endian::Big, 1, true);
    let cases = [
        ("NDims = 3", "NDims = 2", "expected NDims = 3, found '2'"),
        ("NDims = 3\n", "", "field 'NDims', found none"),
        ("DimSize = 5 4 3", "DimSize = 5 4", "three positive integers"),
        ("DimSize = 5 4 3", "DimSize = 5 4 0", "three positive integers"),
        ("DimSize = 5 4 3", "DimSize = 5 4 9", "expected 360 bytes of samples, found 120"),
        ("MET_SHORT", "MET_OTHER", "found 'MET_OTHER'"),
        ("LOCAL", "LIST", "a list of data files is not supported"),
        ("LOCAL", "slice%03d.raw 1 10 1", "a list of data files is not supported"),
        ("LOCAL", "gone.raw", "gone.raw, which cannot be opened"),
        ("LOCAL", "", "which cannot be opened"),
        ("CompressedData = False", "CompressedData = True", "gzip or zlib stream"),
        ("CompressedData = False", "CompressedData = True\nHeaderSize = -1", "not supported"),
        ("CompressedData = False", "CompressedData = perhaps", "expected True or False"),
        ("ObjectType = Image", "ObjectType = Tube", "found 'Tube'"),
        ("NDims = 3", "NDims = 3\nHeaderSize = -2", "found '-2'"),
        ("NDims = 3", "NDims = 3\nElementNumberOfChannels = 0", "a positive integer, found '0'"),
        ("NDims = 3", "NDims = 3\nTransformMatrix = 1 0 0 1 0 0 0 0 1", "independent steps"),
        ("NDims = 3", "NDims = 3\nTransformMatrix = 1 0 0", "nine numbers"),
        ("ElementSpacing = 1 2 5.000000e-001", "ElementSpacing = 1 2 x", "three numbers"),
        ("ElementDataFile = LOCAL\n", "", "the field ElementDataFile"),
    ];
    for (old, new, expected) in cases {
        assert!(header.contains(old), "{old}");
        let text = header.replace(old, new);
        let data: &[u8] = if new.is_empty() { b"" } else { &samples };
        fails(&write(dir.path(), "f.mha", &[text.as_bytes(), data]), expected);
    }
}

/// A change to a valid header.
type Damage = fn(&mut Nifti);

#[test]
fn nifti_fields() {
    let dir = tempfile::tempdir().unwrap();
    let samples = body(SAMPLE, Endian::Big, 1, true);
    let cases: [(Damage, &str); 10] = [
        (|h| h.dim[0] = 9, "a number of axes, 1 to 7, found '9'"),
        (|h| h.dim[0] = 2, "dim[0] of at least 3, found '2'"),
        (|h| h.dim[3] = -4, "a positive size for each axis, found '[5, 4, -4]'"),
        (|h| h.dim[3] = 0, "a positive size"),
        (|h| h.dim[3] = 30, "expected 1200 bytes of samples, found 120"),
        (|h| h.dim = [7, 5, 4, 3, 30000, 30000, 30000, 30000], "fewer than 2^63 bytes"),
        (|h| h.datatype = 128, "found '128'"),
        (|h| h.vox_offset = 12.0, "vox_offset: expected a whole number"),
        (|h| h.vox_offset = 352.5, "found '352.5'"),
        (|h| h.vox_offset = 353.0, "expected 120 bytes of samples, found 119"),
    ];
    for (damage, expected) in cases {
        let mut header = Nifti::new(1, SAMPLE, Endian::Big);
        damage(&mut header);
        fails(&write(dir.path(), "f.nii", &[&header.bytes(), &samples]), expected);
    }
    let mut header = Nifti::new(1, SAMPLE, Endian::Big);
    fails(&write(dir.path(), "g.nii.gz", &[&gzip(&header.bytes()[..350])]), "before the samples");
    header.single = false;
    let error = fails(&write(dir.path(), "lone.hdr", &[&header.bytes()]), "lone.img, which cannot be opened");
    assert!(matches!(error, ReadError::DataFile { .. }));
}
