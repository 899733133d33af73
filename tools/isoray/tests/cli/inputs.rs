//! Files that cannot be read: exit code 1, one error that names the file, no output.

use crate::files::{RAW_FLAGS, ball, ball_mha, ball_nii, ball_nrrd, nrrd};
use crate::sandbox::Sandbox;

/// Every command that reads `file` refuses it with an error that names it and says `parts`.
fn refused(sandbox: &Sandbox, file: &str, parts: &[&str]) {
    let parts = [&[file], parts].concat();
    sandbox.fails(1, &format!("render {file} --isovalue 100 --size 8x8 -o out.png"), &parts);
    sandbox.fails(1, &format!("build {file} -o out.ovol"), &parts);
    sandbox.fails(1, &format!("info {file}"), &parts);
}

#[test]
fn missing_file() {
    let sandbox = Sandbox::new();
    for file in ["gone.nrrd", "gone.ovol", "gone.raw", "no/folder.nii"] {
        refused(&sandbox, file, &["cannot be opened", "caused by: No such file"]);
        sandbox.fails(1, &format!("check {file}"), &[file, "cannot be opened"]);
    }
}

#[test]
fn folder_in_place_of_a_file() {
    let sandbox = Sandbox::new();
    std::fs::create_dir(sandbox.path("scan.nrrd")).unwrap();
    refused(&sandbox, "scan.nrrd", &["directory"]);
    sandbox.fails(1, "check scan.nrrd", &["scan.nrrd"]);
}

#[test]
fn empty_file() {
    let sandbox = Sandbox::new();
    for file in ["a.nrrd", "a.nii", "a.mha", "a.raw", "a"] {
        sandbox.write(file, b"");
        refused(&sandbox, file, &["found an empty file"]);
    }
    sandbox.write("a.ovol", b"");
    refused(&sandbox, "a.ovol", &["not an octree volume"]);
    sandbox.fails(1, "check a.ovol", &["a.ovol", "not an octree volume"]);
}

#[test]
fn truncated_files() {
    for (name, bytes) in [("a.nrrd", ball_nrrd()), ("a.mha", ball_mha()), ("a.nii", ball_nii())] {
        let sandbox = Sandbox::new();
        let header = bytes.len() - ball().len();
        for length in [1, 5, header / 2, header - 1] {
            sandbox.write(name, &bytes[..length]);
            refused(&sandbox, name, &["expected", "found"]);
        }
        for length in [header, header + 1, bytes.len() - 1] {
            sandbox.write(name, &bytes[..length]);
            refused(
                &sandbox,
                name,
                &["expected 1320 bytes of samples", &format!("found {}", length - header)],
            );
        }
        sandbox.write(name, &bytes);
        sandbox.succeeds(&format!("info {name}"));
    }
}

#[test]
fn truncated_gzip_stream() {
    const TOOTH: &[u8] = include_bytes!("../../../../fixtures/tooth/tooth.nrrd");
    let sandbox = Sandbox::with("tooth.nrrd", &TOOTH[..TOOTH.len() / 2]);
    refused(&sandbox, "tooth.nrrd", &["expected"]);
}

#[test]
fn wrong_magic() {
    let sandbox = Sandbox::new();
    sandbox.write("a.nrrd", b"NRDR0004\ntype: uint8\n\n");
    refused(&sandbox, "a.nrrd", &["expected NRRD0001 to NRRD0005", "found 'NRDR0004'"]);
    sandbox.write("a.nii", &[7; 400]);
    refused(&sandbox, "a.nii", &["expected 348"]);
    sandbox.write("a.mha", b"volume of mine\n");
    refused(&sandbox, "a.mha", &["'Key = value'"]);
    sandbox.write("a.ovol", b"ISORAYOW and more");
    refused(&sandbox, "a.ovol", &["expected a file that begins with \"ISORAYOV\""]);
    sandbox.fails(1, "check a.ovol", &["a.ovol", "not an octree volume"]);
    sandbox.write("a.nrrd", &ball_nrrd());
    sandbox.fails(1, "check a.nrrd", &["a.nrrd", "not an octree volume"]);
}

#[test]
fn raw_file_without_its_layout() {
    let sandbox = Sandbox::with("ball.raw", &ball());
    refused(&sandbox, "ball.raw", &["--dims", "--type"]);
    sandbox.succeeds(&format!("info ball.raw {RAW_FLAGS}"));
}

#[test]
fn raw_file_shorter_than_its_layout() {
    let sandbox = Sandbox::with("ball.raw", &ball());
    for flags in
        ["--dims 12,10,12 --type u8", "--dims 12,10,11 --type u16", "--dims 12,10,11 --type u8 --skip 1"]
    {
        sandbox.fails(
            1,
            &format!("render ball.raw {flags} --isovalue 9 -o out.png"),
            &["ball.raw: expected", "bytes of samples, found 13"],
        );
    }
}

#[test]
fn layout_for_a_file_with_a_header() {
    let sandbox = Sandbox::with("ball.nrrd", &ball_nrrd());
    sandbox.fails(1, &format!("info ball.nrrd {RAW_FLAGS}"), &["ball.nrrd", "found a NRRD header"]);
    sandbox.fails(1, "info ball.nrrd --component 1", &["ball.nrrd", "--component 1"]);
}

#[test]
fn impossible_sizes() {
    let sandbox = Sandbox::with("ball.raw", &ball());
    let cases = [
        ("2097152 2097152 2097152", "overflows the address space"),
        ("4294967296 4294967296 1", "expected fewer than 2^32"),
        ("18446744073709551615 2 2", "expected fewer than 2^32"),
        ("3000000 2 2", "expected 1 to 2097152"),
    ];
    for (sizes, part) in cases {
        sandbox.write("a.nrrd", &nrrd(sizes, "uint8", "raw", &ball()));
        refused(&sandbox, "a.nrrd", &[part]);
    }
    for dims in ["0,10,11", "2097152,2097152,2097152", "3000000,1,1"] {
        let line = format!("info ball.raw --type u8 --dims {dims}");
        sandbox.fails(1, &line, &["ball.raw", &dims.replace(',', "x")]);
    }
}

#[test]
fn a_header_that_claims_much_is_refused_before_memory_is_taken_for_it() {
    let sandbox = Sandbox::new();
    for sizes in ["2000000 2000000 1", "2000000 2000000 100"] {
        sandbox.write("huge.nrrd", &nrrd(sizes, "uint8", "raw", &[]));
        refused(&sandbox, "huge.nrrd", &["expected 4", "found 0"]);
        sandbox.write("huge.nrrd", &nrrd(sizes, "uint8", "gzip", &EMPTY_GZIP));
        refused(&sandbox, "huge.nrrd", &["expected 4", "decompressed samples, found room for at most 20640"]);
    }
}

/// A gzip stream of nothing.
const EMPTY_GZIP: [u8; 20] = [0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 0, 3, 3, 0, 0, 0, 0, 0, 0, 0, 0, 0];

#[test]
fn a_claim_that_the_length_of_the_file_allows_still_takes_no_memory() {
    // The layers of one slab are more than the 2⁴⁷ bytes that a process can address.
    let layers = 9;
    let bytes: u64 = 2_000_000 * 2_000_000 * 4 * layers;
    let sandbox = Sandbox::new();
    let header = nrrd(&format!("2000000 2000000 {layers}"), "float", "gzip", &EMPTY_GZIP);
    sandbox.write("huge.nrrd", &header);
    // A hole, which takes no place on the disk.
    let file = std::fs::File::options().write(true).open(sandbox.path("huge.nrrd")).unwrap();
    file.set_len(bytes / 1032 + 4096).unwrap();
    let needs = format!("needs {bytes} bytes of memory for its layers");
    sandbox.fails(1, "render huge.nrrd --isovalue 1 -o out.png", &["huge.nrrd: cannot be built", &needs]);
    let needs = "a 2000000x2000000x9 volume needs at least";
    sandbox.fails(1, "build huge.nrrd -o out.ovol --memory 2GiB", &["huge.nrrd: cannot be built", needs]);
}
