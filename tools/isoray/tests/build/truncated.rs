//! Files that become shorter while they are read.

use std::fs::File;

use flate2::Compression;
use isoray_build::{BuildError, FileOptions, build_file};
use isoray_io::{Dataset, OpenOptions, ReadError};

use crate::inputs::{noise, nrrd, wait_for_part};
use crate::sandbox::Sandbox;

const SIZE: [usize; 3] = [40, 50, 60];
const SAMPLES: usize = SIZE[0] * SIZE[1] * SIZE[2];

fn shorten(sandbox: &Sandbox, name: &str, length: usize) {
    let file = File::options().write(true).open(sandbox.path(name)).unwrap();
    file.set_len(length as u64).unwrap();
}

/// Opens the volume, shortens its file to `length` bytes, and builds.
fn error_after(sandbox: &Sandbox, bytes: &[u8], length: usize) -> String {
    sandbox.write("a.nrrd", bytes);
    let path = sandbox.path("a.nrrd");
    let dataset = Dataset::open(&path, &OpenOptions::default()).unwrap();
    let mut slabs = dataset.slabs::<u8>().unwrap();
    shorten(sandbox, "a.nrrd", length);
    let output = sandbox.path("out.ovol");
    let error = build_file(&mut slabs, &output, &FileOptions::default(), |_| {}).unwrap_err();
    assert_eq!(sandbox.names(), ["a.nrrd"]);
    // All samples are there if only the stream's checksum is missing.
    let is_short = matches!(error, BuildError::Source(ReadError::ShortData { .. }));
    let is_cut =
        matches!(error, BuildError::Source(ReadError::Corrupt { decoded, .. }) if decoded == SAMPLES as u64);
    assert!(is_short || is_cut, "{error:?}");
    error.to_string()
}

#[test]
fn a_file_shortened_after_it_was_opened_is_an_error() {
    let sandbox = Sandbox::new();
    let bytes = nrrd(SIZE, "uint8", &noise(SAMPLES, 8), None);
    let header = bytes.len() - SAMPLES;
    for left in [0, 1, SAMPLES / 2, SAMPLES - 1] {
        let error = error_after(&sandbox, &bytes, header + left);
        for part in ["a.nrrd", &SAMPLES.to_string(), &left.to_string()] {
            assert!(error.contains(part), "no '{part}' in {error}");
        }
    }
    let bytes = nrrd(SIZE, "uint8", &noise(SAMPLES, 8), Some(Compression::fast()));
    for length in [header + 100, bytes.len() / 2, bytes.len() - 1] {
        let error = error_after(&sandbox, &bytes, length);
        for part in ["a.nrrd", &SAMPLES.to_string()] {
            assert!(error.contains(part), "no '{part}' in {error}");
        }
    }
}

#[test]
fn a_file_shortened_while_it_is_built_is_an_error() {
    const LARGE: usize = 256 * 256 * 400;
    let sandbox = Sandbox::with("in.raw", &noise(LARGE, 9));
    let line = "build in.raw --dims 256,256,400 --type u8 -o out.ovol --threads 1";
    let mut child = sandbox.command(line.split(' ')).spawn().unwrap();
    wait_for_part(&sandbox, &mut child);
    shorten(&sandbox, "in.raw", 1000);
    let output = child.wait_with_output().unwrap();
    let error = String::from_utf8(output.stderr).unwrap();
    if output.status.success() {
        println!("SKIPPED: the build was over before its input could be shortened");
        return;
    }
    assert_eq!(output.status.code(), Some(1), "{error}");
    assert!(error.starts_with("error: in.raw: ") && error.lines().count() == 1, "{error}");
    for part in [LARGE, 1000] {
        assert!(error.contains(&part.to_string()), "no {part} in {error}");
    }
    assert_eq!(sandbox.names(), ["in.raw"]);
}
