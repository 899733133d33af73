//! Outputs that cannot be written, and what the program prints.

use std::fs::File;

use crate::files::{ball_nrrd, with_ovol};
use crate::sandbox::{Sandbox, finish};

#[test]
fn output_folder_is_missing() {
    let sandbox = with_ovol();
    let part = "there is no folder missing";
    sandbox.fails(1, "render ball.nrrd --isovalue 9 -o missing/out.png", &["missing/out.png", part]);
    sandbox.fails(1, "render ball.ovol --isovalue 9 -o missing/out.exr", &["missing/out.exr", part]);
    sandbox.fails(1, "build ball.nrrd -o missing/out.ovol", &["missing/out.ovol", part]);
    let line = "render ball.nrrd --isovalue 9 --size 8x8 --stats missing/s.json -o out.png";
    sandbox.fails(1, line, &["missing/s.json", part]);
}

#[test]
fn output_folder_is_a_file() {
    let sandbox = Sandbox::with("ball.nrrd", &ball_nrrd());
    let part = "there is no folder ball.nrrd";
    sandbox.fails(1, "render ball.nrrd --isovalue 9 -o ball.nrrd/out.png", &[part]);
    sandbox.fails(1, "build ball.nrrd -o ball.nrrd/out.ovol", &[part]);
}

#[test]
fn output_is_a_folder() {
    let sandbox = Sandbox::with("ball.nrrd", &ball_nrrd());
    for name in ["out.png", "out.ovol", "s.json"] {
        std::fs::create_dir(sandbox.path(name)).unwrap();
    }
    let part = "found a folder";
    sandbox.fails(1, "render ball.nrrd --isovalue 9 -o out.png", &["out.png", part]);
    sandbox.fails(1, "build ball.nrrd -o out.ovol", &["out.ovol", part]);
    sandbox.fails(1, "render ball.nrrd --isovalue 9 --stats s.json -o a.png", &["s.json", part]);
}

#[cfg(target_os = "linux")]
#[test]
fn output_folder_cannot_be_written() {
    // Not even the administrator can create a file here.
    let sandbox = Sandbox::with("ball.nrrd", &ball_nrrd());
    let part = "no file can be created there";
    sandbox.fails(1, "render ball.nrrd --isovalue 9 -o /proc/out.png", &["/proc/out.png", part, "caused by"]);
    sandbox.fails(1, "build ball.nrrd -o /proc/out.ovol", &["/proc/out.ovol", part, "caused by"]);
    sandbox.fails(1, "render ball.nrrd --stats /proc/s.json -o a.png", &["/proc/s.json", part]);
}

#[cfg(target_os = "linux")]
#[test]
fn devices_are_not_replaced() {
    let sandbox = Sandbox::with("ball.nrrd", &ball_nrrd());
    std::os::unix::fs::symlink("/dev/null", sandbox.path("out.png")).unwrap();
    std::os::unix::fs::symlink("/dev/null", sandbox.path("out.ovol")).unwrap();
    let part = "found a device or pipe";
    sandbox.fails(1, "render ball.nrrd --isovalue 9 -o out.png", &["out.png", part]);
    sandbox.fails(1, "build ball.nrrd -o out.ovol", &["out.ovol", part]);
    sandbox.fails(1, "render ball.nrrd --isovalue 9 --stats out.ovol -o a.png", &["out.ovol", part]);
}

#[test]
fn inputs_are_not_replaced() {
    let sandbox = with_ovol();
    sandbox.write("scan.png", &ball_nrrd());
    let before = sandbox.read("ball.nrrd");
    let part = "is an input";
    sandbox.fails(1, "build ball.nrrd -o ball.nrrd", &["ball.nrrd", part]);
    sandbox.fails(1, "build ball.ovol -o ./ball.ovol", &["ball.ovol", part]);
    sandbox.fails(1, "render scan.png --isovalue 9 -o scan.png", &["scan.png", part]);
    sandbox.fails(1, "render ball.nrrd --isovalue 9 -o a.png --stats ball.nrrd", &["ball.nrrd", part]);
    sandbox.fails(2, "render ball.nrrd --isovalue 9 -o a.png --stats a.png", &["a.png", "--stats"]);
    assert_eq!(sandbox.read("ball.nrrd"), before);
}

#[test]
fn old_outputs_are_replaced_by_success_alone() {
    let sandbox = Sandbox::with("ball.nrrd", &ball_nrrd());
    sandbox.write("out.png", b"old");
    sandbox.fails(1, "render gone.nrrd -o out.png", &["gone.nrrd"]);
    assert_eq!(sandbox.read("out.png"), b"old");
    sandbox.succeeds("render ball.nrrd --isovalue 100 --size 8x8 -o out.png");
    assert!(sandbox.read("out.png").starts_with(b"\x89PNG"));
}

#[cfg(target_os = "linux")]
#[test]
fn full_and_closed_standard_output() {
    let sandbox = with_ovol();
    for line in ["info ball.nrrd", "info ball.ovol --json", "check ball.ovol", "build ball.nrrd -o b.ovol"] {
        let full = File::options().write(true).open("/dev/full").unwrap();
        let outcome = finish(sandbox.command(line.split(' ')).stdout(full));
        assert_eq!(outcome.code, 1, "{line}: {outcome:?}");
        assert!(outcome.stderr.starts_with("error: standard output: cannot be written\n"), "{outcome:?}");
        // The reader is gone before anything is written.
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let outcome = finish(sandbox.command(line.split(' ')).stdout(writer));
        assert!(outcome.code == 0 && outcome.stderr.is_empty(), "{line}: {outcome:?}");
    }
    let full = File::options().write(true).open("/dev/full").unwrap();
    assert_eq!(finish(sandbox.command(["info", "gone"]).stderr(full)).code, 1);
}

#[test]
fn info_tells_what_is_there() {
    let sandbox = with_ovol();
    for file in ["ball.nrrd", "ball.ovol"] {
        let text = sandbox.succeeds(&format!("info {file}"));
        for part in [file, "12 x 10 x 11", "u8", "world bounds", "0, 0, 0  to  11, 9, 10", "histogram", "%"] {
            assert!(text.contains(part), "no '{part}' in {text}");
        }
        let json: serde_json::Value =
            serde_json::from_str(&sandbox.succeeds(&format!("info {file} --json"))).unwrap();
        assert_eq!(json["dims"], serde_json::json!([12, 10, 11]));
        assert_eq!(json["type"], "u8");
        assert_eq!(json["raw_bytes"], 1320);
        assert_eq!(json["octree_bytes"], sandbox.read("ball.ovol").len());
        let counts = json["histogram"].as_array().unwrap().iter().map(|n| n.as_u64().unwrap());
        assert_eq!(counts.sum::<u64>(), 1320);
    }
    assert!(sandbox.succeeds("check ball.ovol").contains("ball.ovol: sound: 12x10x11 u8"));
}

#[test]
fn what_the_build_uses_of_the_processor() {
    let sandbox = Sandbox::new();
    let told = sandbox.succeeds("info --cpu");
    assert!(
        told.contains(std::env::consts::ARCH) && told.contains("build uses") && told.contains("lanes"),
        "{told}"
    );
    let json: serde_json::Value = serde_json::from_str(&sandbox.succeeds("info --cpu --json")).unwrap();
    // Or it would not run.
    let extensions = json["extensions"].as_array().unwrap();
    assert!(extensions.iter().all(|e| e["offered"] == true || e["used"] == false), "{json}");
    sandbox.fails(2, "info", &["FILE"]);
    sandbox.fails(2, "info --cpu ball.ovol", &["--cpu"]);
}
