//! `isoray synth`: volumes that the other commands read, and what it refuses.

use crate::sandbox::Sandbox;

const NAMES: [&str; 5] = ["mixing", "marschner-lobb", "sphere", "ramp", "noise"];

#[test]
fn every_volume_is_read_back() {
    let sandbox = Sandbox::new();
    for name in NAMES {
        for sample in ["u8", "u16", "f32"] {
            let made = sandbox.succeeds(&format!("synth {name} --size 12,10,40 --type {sample} -o a.nrrd"));
            assert!(made.starts_with(&format!("a.nrrd: 12x10x40 {sample} samples, ")), "{made}");
            assert_eq!(made.lines().count(), 1, "{made}");
            let info = sandbox.succeeds("info a.nrrd");
            assert!(info.contains("12 x 10 x 40") && info.contains(sample), "{info}");

            let made = sandbox.succeeds(&format!("synth {name} --size 12,10,40 --type {sample} -o a.raw"));
            let flags = made.lines().nth(1).and_then(|line| line.split_once("Read it with ")).unwrap().1;
            assert_eq!(flags, format!("--dims 12,10,40 --type {sample}"));
            let raw = sandbox.succeeds(&format!("info a.raw {flags}"));
            assert_eq!(samples_part(&raw), samples_part(&info));
            assert!(sandbox.read("a.nrrd").ends_with(&sandbox.read("a.raw")));
        }
    }
    assert_eq!(sandbox.names(), ["a.nrrd", "a.raw"]);
}

/// The lines of `info` that tell of values.
fn samples_part(info: &str) -> Vec<&str> {
    let lines: Vec<&str> = info.lines().skip_while(|line| !line.contains("histogram")).collect();
    assert!(!lines.is_empty(), "{info}");
    lines
}

#[test]
fn samples_are_those_of_the_formulas() {
    let sandbox = Sandbox::new();
    let ramp = |flags: &str| {
        sandbox.succeeds(&format!("synth ramp --size 4,3,2 {flags} -o a.raw"));
        sandbox.read("a.raw")
    };
    assert_eq!(&ramp("")[..6], [0, 1, 2, 3, 2, 3]);
    assert_eq!(&ramp("--direction -1,0,0")[..6], [3, 2, 1, 0, 3, 2]);
    assert_eq!(
        &ramp("--direction 0,256,0 --type u16")[..],
        [[0; 8], [0, 1, 0, 1, 0, 1, 0, 1], [0, 2, 0, 2, 0, 2, 0, 2]].concat().repeat(2)
    );
    sandbox.succeeds("synth mixing --size 2,2,64 --type f32 -o a.raw");
    let floats = sandbox.read("a.raw");
    assert_eq!((&floats[..4], &floats[1020..]), (&10f32.to_le_bytes()[..], &240f32.to_le_bytes()[..]));
}

#[test]
fn bytes_depend_on_seed_and_time_alone() {
    let sandbox = Sandbox::new();
    let made = |flags: &str| {
        sandbox.succeeds(&format!("synth {flags} --size 40,30,150 -o a.nrrd"));
        sandbox.read("a.nrrd")
    };
    let default = made("mixing");
    for same in ["mixing --threads 1", "mixing --threads 3", "mixing --seed 0 --time 1 --type u8"] {
        assert!(made(same) == default, "{same}");
    }
    for other in ["mixing --seed 1", "mixing --time 0.9", "mixing --seed 18446744073709551615"] {
        assert!(made(other) != default, "{other}");
    }
    assert!(made("noise") != made("noise --seed 1"));
    assert!(made("noise --threads 1") == made("noise --threads 2"));
}

#[test]
fn time_zero_is_waves_alone() {
    let sandbox = Sandbox::new();
    let stored = |time: &str| {
        sandbox.succeeds(&format!("synth mixing --size 128,128,128 --time {time} -o a.nrrd"));
        sandbox.succeeds("build a.nrrd -o a.ovol");
        sandbox.read("a.ovol").len()
    };
    assert!(stored("0") * 3 < stored("1"));
}

#[test]
fn what_makes_no_sense_is_refused() {
    let sandbox = Sandbox::new();
    let cases = [
        ("cube --size 4,4,4 -o a.raw", &["cube", "marschner-lobb"][..]),
        ("mixing -o a.raw", &["--size"]),
        ("mixing --size 4,4,4", &["--output"]),
        ("mixing --size 4,4 -o a.raw", &["--size", "three whole numbers"]),
        ("mixing --size 4,-4,4 -o a.raw", &["--size", "three whole numbers"]),
        ("mixing --size 4,0,4 -o a.raw", &["--size", "4x0x4", "1 to 2097152"]),
        ("mixing --size 2097152,2097152,2097152 -o a.raw", &["--size", "overflows"]),
        ("noise --size 2097152,2097152,1 -o a.raw", &["--size", "takes 4.00 TiB: expected at most 8.00 GiB"]),
        ("mixing --size 4,4,4 --type i8 -o a.raw", &["--type", "u16"]),
        ("mixing --size 4,4,4 --time 1.5 -o a.raw", &["--time", "from 0 to 1, found '1.5'"]),
        ("mixing --size 4,4,4 --time -1 -o a.raw", &["--time", "from 0 to 1"]),
        ("mixing --size 4,4,4 --time nan -o a.raw", &["--time", "from 0 to 1"]),
        ("mixing --size 4,4,4 --seed -1 -o a.raw", &["--seed"]),
        ("ramp --size 4,4,4 --direction 0,0,0 -o a.raw", &["--direction", "not all zero"]),
        ("ramp --size 4,4,4 --direction 1,2 -o a.raw", &["--direction", "three numbers"]),
        ("ramp --size 4,4,4 --direction 1e300,0,0 -o a.raw", &["--direction", "range of f32"]),
        ("mixing --size 4,4,4 -o a.ovol", &["a.ovol", "ends in .nrrd or .raw"]),
        ("mixing --size 4,4,4 -o raw", &["raw", "ends in .nrrd or .raw"]),
        ("sphere --size 4,4,4 --seed 3 -o a.raw", &["--seed: sphere has none, only mixing and noise"]),
        ("noise --size 4,4,4 --time 1 -o a.raw", &["--time: noise has none, only mixing"]),
        ("mixing --size 4,4,4 --direction 1,0,0 -o a.raw", &["--direction: mixing has none, only ramp"]),
        ("mixing --size 4,4,4 --threads 0 -o a.raw", &["--threads", "whole number from 1"]),
    ];
    for (line, parts) in cases {
        sandbox.fails(2, &format!("synth {line}"), parts);
    }
}

#[test]
fn outputs_that_cannot_be_written() {
    let sandbox = Sandbox::with("old", b"old");
    std::fs::create_dir(sandbox.path("folder.raw")).unwrap();
    sandbox.fails(1, "synth noise --size 4,4,4 -o missing/a.raw", &["missing/a.raw", "there is no folder"]);
    sandbox.fails(1, "synth noise --size 4,4,4 -o old/a.raw", &["old/a.raw", "there is no folder"]);
    sandbox.fails(1, "synth noise --size 4,4,4 -o folder.raw", &["folder.raw", "found a folder"]);
}

/// A disk that fills, in the form of a limit on the size of files.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_leaves_nothing() {
    use std::process::Command;

    let sandbox = Sandbox::with("a.nrrd", b"old");
    let script = format!(
        "trap '' XFSZ; ulimit -f 100; exec {} synth mixing --size 64,64,512 -o a.nrrd",
        env!("CARGO_BIN_EXE_isoray")
    );
    let run = Command::new("sh").args(["-c", &script]).current_dir(sandbox.path(".")).output().unwrap();
    let stderr = String::from_utf8(run.stderr).unwrap();
    assert_eq!(run.status.code(), Some(1), "{stderr}");
    assert!(stderr.starts_with("error: a.nrrd: cannot be written\n  caused by: "), "{stderr}");
    assert_eq!(sandbox.names(), ["a.nrrd"]);
    assert_eq!(sandbox.read("a.nrrd"), b"old");
}
