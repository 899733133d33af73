//! Time series: building, describing and checking them.

use std::fs::{self, File};
use std::path::Path;
use std::time::{Duration, SystemTime};

use crate::files::{RAW_FLAGS, ball, nrrd};
use crate::sandbox::{Outcome, Sandbox};

/// The ball, darker by the number of the step.
pub(crate) fn step(n: u8) -> Vec<u8> {
    ball().into_iter().map(|sample| sample.saturating_sub(5 * n)).collect()
}

/// Steps 1, 2 and 10, raw.
fn raw_steps() -> Sandbox {
    let sandbox = Sandbox::new();
    for n in [10, 1, 2] {
        sandbox.write(&format!("s{n}.raw"), &step(n));
    }
    sandbox
}

/// The line that builds them.
const BUILD: &str = "build s*.raw --dims 12,10,11 --type u8 -o s.ovol.d";

/// The same, built.
pub(crate) fn built() -> Sandbox {
    let sandbox = raw_steps();
    sandbox.succeeds(BUILD);
    sandbox
}

fn npy(samples: &[u8]) -> Vec<u8> {
    let mut header = b"{'descr': '|u1', 'fortran_order': False, 'shape': (11, 10, 12), }".to_vec();
    header.resize(117, b' ');
    header.push(b'\n');
    [b"\x93NUMPY\x01\x00".as_slice(), &(header.len() as u16).to_le_bytes(), &header, samples].concat()
}

/// A TIFF file of one page, 12 by 10 pixels.
fn tiff(samples: &[u8]) -> Vec<u8> {
    const TAGS: [[u16; 2]; 7] = [[256, 12], [257, 10], [258, 8], [259, 1], [262, 1], [273, 98], [279, 120]];
    let mut file = [b"II*\0".as_slice(), &8u32.to_le_bytes(), &7u16.to_le_bytes()].concat();
    for [tag, value] in TAGS {
        // One SHORT each.
        let entry = [tag, 3, 1, 0, value, 0];
        file.extend(entry.iter().flat_map(|word| word.to_le_bytes()));
    }
    file.extend([0; 4]);
    [file.as_slice(), samples].concat()
}

/// Names in a folder, sorted.
fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// Names of the steps that were kept.
fn kept(text: &str) -> Vec<&str> {
    let lines = text.lines().filter_map(|line| line.strip_suffix(".ovol: kept"));
    lines.map(|line| line.split_once("] ").unwrap().1).collect()
}

/// Makes a file's last change another.
fn touch(path: &Path) {
    let modified = SystemTime::UNIX_EPOCH + Duration::from_secs(1_000_000_000);
    File::options().write(true).open(path).unwrap().set_modified(modified).unwrap();
}

fn info(sandbox: &Sandbox, series: &str) -> serde_json::Value {
    serde_json::from_str(&sandbox.succeeds(&format!("info {series} --json"))).unwrap()
}

#[test]
fn patterns_and_lists_are_in_the_order_of_their_numbers() {
    let sandbox = raw_steps();
    sandbox.write("s03.raw", &step(3));
    sandbox.write("t.raw", &step(0));
    for (inputs, expected) in [
        ("s*.raw", &["s1", "s2", "s03", "s10"][..]),
        ("s10.raw s2.raw s1.raw s2.raw", &["s1", "s2", "s10"]),
        ("s?.raw t.raw", &["s1", "s2", "t"]),
        ("s%d.raw", &["s1", "s2", "s10"]),
        ("s%02d.raw", &["s03", "s10"]),
        ("./s1%d.raw", &["s10"]),
    ] {
        let text = sandbox.succeeds(&format!("build {inputs} {RAW_FLAGS} -o out.ovol.d"));
        let (count, lines) = (expected.len(), text.lines().collect::<Vec<_>>());
        assert_eq!(lines.len(), count + 1, "{text}");
        for (n, (line, name)) in lines.iter().zip(expected).enumerate() {
            assert!(line.starts_with(&format!("[{}/{count}] {name}.ovol: ", n + 1)), "{inputs}: {text}");
            assert!(line.contains(" of 1.29 KiB (") && line.ends_with(" million voxels/s"), "{text}");
        }
        assert!(lines[count].starts_with(&format!("out.ovol.d: {count} step")), "{text}");
        assert!(lines[count].contains(", 0 kept, 12x10x11 u8 samples, "), "{text}");
        let info = info(&sandbox, "out.ovol.d");
        let files: Vec<_> = info["steps"].as_array().unwrap().iter().map(|s| s["file"].as_str()).collect();
        assert!(files.iter().map(|f| f.unwrap()).eq(expected.iter().map(|n| format!("{n}.ovol"))), "{info}");
        fs::remove_dir_all(sandbox.path("out.ovol.d")).unwrap();
    }
}

#[test]
fn steps_are_the_volumes_that_they_would_be_alone() {
    let sandbox = built();
    sandbox.succeeds(&format!("build s2.raw {RAW_FLAGS} -o alone.ovol"));
    assert!(sandbox.read("alone.ovol") == sandbox.read("s.ovol.d/s2.ovol"));
    assert_eq!(
        names(&sandbox.path("s.ovol.d")),
        ["s1.ovol", "s10.ovol", "s2.ovol", "series.json"],
        "and nothing else"
    );
    // A series can be built again, with loss for instance.
    let text = sandbox.succeeds("build s.ovol.d --tolerance 4 -o lossy.ovol.d");
    assert!(text.contains("[3/3] s10.ovol: "), "{text}");
    assert_eq!(info(&sandbox, "lossy.ovol.d")["steps"][2]["lossless"], false);
    // Of other formats as well; one input makes a series if the output is one.
    sandbox.write("a.npy", &npy(&step(2)));
    let text = sandbox.succeeds("build a.npy -o a.ovol.d");
    assert!(text.contains("a.ovol.d: 1 step, 0 kept"), "{text}");
    assert!(sandbox.read("a.ovol.d/a.ovol") == sandbox.read("alone.ovol"));
}

#[test]
fn slices_are_one_volume() {
    let sandbox = Sandbox::new();
    for (n, samples) in ball().chunks(120).enumerate() {
        sandbox.write(&format!("z{n}.tif"), &tiff(samples));
    }
    sandbox.write("ball.raw", &ball());
    sandbox.succeeds(&format!("build ball.raw {RAW_FLAGS} -o ball.ovol"));
    sandbox.succeeds("build z*.tif -o slices.ovol");
    assert!(sandbox.read("slices.ovol") == sandbox.read("ball.ovol"));
    // Or a series of volumes that have no cells.
    let Outcome { code, stdout, stderr } = sandbox.line("build z%d.tif -o slices.ovol.d");
    assert!(code == 0 && stderr.matches("no cells").count() == 11, "{stderr}");
    assert!(stdout.contains("slices.ovol.d: 11 steps, 0 kept, 12x10x1 u8 samples"), "{stdout}");
}

#[test]
fn inputs_that_are_no_series() {
    let sandbox = raw_steps();
    let flags = RAW_FLAGS;
    for (inputs, part) in [
        ("a*.raw", "a*.raw: expected at least one file that matches, found none"),
        ("s1.raw a%02d.raw", "a%02d.raw: expected at least one file that matches, found none"),
        ("s1.raw gone.raw", "gone.raw: cannot be opened"),
        ("gone/a%d.raw", "gone: cannot list the folder"),
    ] {
        sandbox.fails(1, &format!("build {inputs} {flags} -o out.ovol.d"), &[part]);
    }
    let part = "3 files match: expected an output folder ending in .ovol.d, found out.ovol";
    sandbox.fails(2, &format!("build s*.raw {flags} -o out.ovol"), &[part]);
    sandbox.fails(2, "build -o out.ovol", &["<INPUT>"]);
    sandbox.fails(2, &format!("build s*.raw {flags} --range 9:1 -o out.ovol.d"), &["--range"]);
    sandbox.write("file.ovol.d", b"");
    sandbox.fails(
        1,
        &format!("build s*.raw {flags} -o file.ovol.d"),
        &["expected a folder for the steps of a series, found a file"],
    );
    sandbox.fails(1, &format!("build s*.raw {flags} -o gone/out.ovol.d"), &["there is no folder gone"]);
    sandbox.write(".s.raw", &step(4));
    sandbox.fails(1, &format!("build .s.raw {flags} -o out.ovol.d"), &[".s.raw: would become a hidden file"]);
    // Two inputs that would become the same step.
    sandbox.write("s1.dat", &step(4));
    sandbox.fails(1, &format!("build s1.* {flags} -o out.ovol.d"), &["s1.dat", "s1.raw", "step s1.ovol"]);
}

#[test]
fn steps_that_differ_are_refused_before_anything_is_built() {
    let sandbox = Sandbox::new();
    sandbox.write("a1.nrrd", &nrrd("12 10 11", "uint8", "raw", &ball()));
    let header = |text: &str, body: &[u8]| [text.as_bytes(), body].concat();
    let spaced = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 12 10 11\nspacings: 1 1 2\nencoding: raw\n\n";
    let cases = [
        (nrrd("12 11 10", "uint8", "raw", &ball()), "dimensions: expected 12x10x11, found 12x11x10"),
        (nrrd("12 10 11", "int8", "raw", &ball()), "sample type: expected u8, found i8"),
        (header(spaced, &ball()), "placement: expected axes (1, 0, 0)"),
    ];
    for (file, part) in cases {
        sandbox.write("a2.nrrd", &file);
        let parts = ["a2.nrrd: does not fit a1.nrrd: ", part];
        sandbox.fails(1, "build a*.nrrd -o a.ovol.d", &parts);
    }
    // One that is damaged further in: what was finished before stays, and nothing else.
    sandbox.write("a2.nrrd", &nrrd("12 10 11", "uint8", "text", &[b' '; 4000]));
    let outcome = sandbox.line("build a*.nrrd -o a.ovol.d");
    assert!(outcome.code == 1 && outcome.stderr.contains("a2.nrrd"), "{outcome:?}");
    assert_eq!(names(&sandbox.path("a.ovol.d")), ["a1.ovol", "series.json"]);
    sandbox.write("a1.nrrd", &nrrd("12 10 11", "uint8", "text", &[b' '; 4000]));
    sandbox.fails(1, "build a*.nrrd -o b.ovol.d", &["a1.nrrd"]);
}

#[test]
fn finished_steps_are_kept() {
    let sandbox = built();
    let again = || sandbox.succeeds(BUILD);
    let text = again();
    assert_eq!(kept(&text), ["s1", "s2", "s10"]);
    assert!(text.contains("s.ovol.d: 3 steps, 3 kept") && !text.contains("voxels/s"), "{text}");
    // Missing.
    let whole = sandbox.read("s.ovol.d/s2.ovol");
    fs::remove_file(sandbox.path("s.ovol.d/s2.ovol")).unwrap();
    assert_eq!(kept(&again()), ["s1", "s10"]);
    // Damaged, in its header or further in.
    for at in [20, whole.len() - 1] {
        let mut damaged = whole.clone();
        damaged[at] ^= 1;
        sandbox.write("s.ovol.d/s2.ovol", &damaged);
        let Outcome { code, stdout, stderr } = sandbox.line(BUILD);
        assert!(code == 0 && kept(&stdout) == ["s1", "s10"], "{stdout}");
        assert!(stderr.contains("s2.ovol: damaged") && stderr.contains("; it is built again"), "{stderr}");
    }
    assert!(sandbox.read("s.ovol.d/s2.ovol") == whole);
    // Another input, of another length (which the header check allows) or of another time.
    sandbox.write("s1.raw", &[step(1), vec![0]].concat());
    let outcome = sandbox.line(BUILD);
    assert_eq!(kept(&outcome.stdout), ["s2", "s10"], "{outcome:?}");
    touch(&sandbox.path("s10.raw"));
    let outcome = sandbox.line(BUILD);
    assert_eq!(kept(&outcome.stdout), ["s1", "s2"], "{outcome:?}");
}

#[test]
fn other_flags_build_all_steps_again() {
    let sandbox = built();
    for flags in ["--tolerance 3", "--tolerance 3 --no-lod", "--spacing 1,1,2"] {
        let line = format!("{BUILD} {flags}");
        assert_eq!(kept(&sandbox.succeeds(&line)), [""; 0], "{flags}");
        assert_eq!(
            kept(&sandbox.succeeds(&format!("{line} --threads 2 --memory 1GiB"))),
            ["s1", "s2", "s10"]
        );
    }
    // Without the record nothing is known of the steps.
    fs::remove_file(sandbox.path("s.ovol.d/series.json")).unwrap();
    assert_eq!(kept(&sandbox.succeeds(BUILD)), [""; 0]);
    sandbox.write("s.ovol.d/series.json", b"{\"steps\": 7}");
    let outcome = sandbox.line(BUILD);
    assert!(outcome.code == 0 && kept(&outcome.stdout).is_empty(), "{outcome:?}");
    assert!(outcome.stderr.contains("series.json: cannot be used"), "{outcome:?}");
}

#[test]
fn slices_and_detached_samples_belong_to_an_input() {
    let sandbox = Sandbox::new();
    for z in [1, 2] {
        fs::create_dir(sandbox.path(&format!("t{z}"))).unwrap();
        for (n, samples) in ball().chunks(120).enumerate() {
            sandbox.write(&format!("t{z}/{n}.tif"), &tiff(samples));
        }
    }
    let header = "ObjectType = Image\nNDims = 3\nDimSize = 12 10 11\nElementType = MET_UCHAR\nElementDataFile = u.raw\n";
    sandbox.write("u.mhd", header.as_bytes());
    sandbox.write("u.raw", &ball());
    let again = || sandbox.succeeds("build t1 t2 u.mhd -o t.ovol.d");
    assert!(kept(&again()).is_empty());
    assert_eq!(kept(&again()), ["t1", "t2", "u"]);
    sandbox.write("t2/3.tif", &tiff(&[9; 120]));
    sandbox.write("u.raw", &step(1));
    assert_eq!(kept(&again()), ["t1"]);
}

#[test]
fn steps_without_an_input_are_left() {
    let sandbox = built();
    fs::remove_file(sandbox.path("s2.raw")).unwrap();
    let Outcome { code, stdout, stderr } = sandbox.line(BUILD);
    assert!(code == 0 && kept(&stdout) == ["s1", "s10"], "{stdout}");
    assert!(stderr.starts_with("warning: ") && stderr.lines().count() == 1, "{stderr}");
    assert!(stderr.contains("s2.ovol: no input has this name; it is left"), "{stderr}");
    assert_eq!(info(&sandbox, "s.ovol.d")["steps"].as_array().unwrap().len(), 3);
}

#[test]
fn info_summarises() {
    let sandbox = built();
    let text = sandbox.succeeds("info s.ovol.d");
    for part in [
        "s.ovol.d: series of octree volumes\n",
        "  steps         3\n",
        "  dimensions    12 x 10 x 11\n",
        "  type          u8\n",
        "  world bounds  0, 0, 0  to  11, 9, 10\n",
        "  values        0 to 220\n",
        "s1.ovol: 0 to 220\n",
        "s10.ovol: 0 to 175\n",
        " of 3.87 KiB raw: ",
    ] {
        assert!(text.contains(part), "no {part} in {text}");
    }
    let json = info(&sandbox, "s.ovol.d");
    assert_eq!(
        (&json["dims"][2], &json["type"], &json["raw_bytes"]),
        (&11.into(), &"u8".into(), &3960.into())
    );
    let lengths = ["s1", "s2", "s10"].map(|name| sandbox.read(&format!("s.ovol.d/{name}.ovol")).len());
    assert_eq!(json["octree_bytes"], lengths.iter().sum::<usize>());
    assert_eq!(json["steps"][2]["octree_bytes"], lengths[2]);
    assert_eq!(json["steps"][2]["range"], serde_json::json!([0.0, 175.0]));
    assert_eq!(json["range"], serde_json::json!([0.0, 220.0]));
    sandbox.fails(1, "info gone.ovol.d", &["gone.ovol.d: cannot be read as a folder of octree volumes"]);
    sandbox.fails(2, "info s.ovol.d --component 1", &["a series needs no flags"]);
    fs::create_dir(sandbox.path("none.ovol.d")).unwrap();
    sandbox.fails(1, "info none.ovol.d", &["expected .ovol files, found none"]);
    sandbox.fails(2, "tf preview --volume s.ovol.d -o tf.png", &["s.ovol.d: a series of 3 volumes"]);
}

#[test]
fn check_looks_at_every_step() {
    let sandbox = built();
    let text = sandbox.succeeds("check s.ovol.d");
    assert!(text.starts_with("step 0: s1.ovol: sound\nstep 1: s2.ovol: sound\nstep 2: s10.ovol: sound\n"));
    assert!(text.contains("s.ovol.d: sound: 3 steps of 12x10x11 u8 samples, every "), "{text}");
    let mut damaged = sandbox.read("s.ovol.d/s2.ovol");
    *damaged.last_mut().unwrap() ^= 1;
    sandbox.write("s.ovol.d/s2.ovol", &damaged);
    let Outcome { code, stdout, stderr } = sandbox.line("check s.ovol.d");
    assert_eq!(stdout, "step 0: s1.ovol: sound\nstep 1: s2.ovol: NOT sound\nstep 2: s10.ovol: sound\n");
    assert!(code == 1 && stderr.starts_with("error: s.ovol.d: 1 of 3 steps not sound: "), "{stderr}");
    assert!(stderr.contains("s2.ovol: damaged: the checksum of"), "{stderr}");
    // One that fits no other.
    sandbox.succeeds("build s1.raw --dims 11,12,10 --type u8 -o s.ovol.d/s3.ovol");
    let outcome = sandbox.line("check s.ovol.d");
    assert!(outcome.stderr.contains("2 of 4 steps not sound, the first: "), "{outcome:?}");
    assert!(outcome.stdout.contains("step 2: s3.ovol: NOT sound\n"), "{outcome:?}");
    sandbox.fails(1, "info s.ovol.d", &["s3.ovol: does not fit the first step, ", "11x12x10"]);
}
