//! Memory while a build runs, as the system counts it.

use std::fs;
use std::time::Duration;

use flate2::Compression;

use crate::inputs::{is_part, least, nrrd};
use crate::sandbox::Sandbox;

/// What was seen of a build while it ran.
#[derive(Debug, Default)]
struct Seen {
    /// Most bytes of anonymous memory.
    anonymous: u64,
    /// Most nameless files open at once.
    spools: usize,
    samples: usize,
}

/// Runs a build and looks at it all the time. What it writes must not be mapped, so that anonymous memory is all that counts.
fn watch(sandbox: &Sandbox, line: &str) -> Seen {
    let mut child = sandbox.command(line.split(' ')).spawn().unwrap();
    let process = format!("/proc/{}", child.id());
    let mut seen = Seen::default();
    while child.try_wait().unwrap().is_none() {
        let status = fs::read_to_string(format!("{process}/status")).unwrap_or_default();
        let anonymous = status.lines().find_map(|l| l.strip_prefix("RssAnon:"));
        if let Some(kib) = anonymous.and_then(|text| text.trim().strip_suffix(" kB")) {
            seen.anonymous = seen.anonymous.max(kib.parse::<u64>().unwrap() << 10);
            seen.samples += 1;
        }
        let maps = fs::read_to_string(format!("{process}/maps")).unwrap_or_default();
        assert!(!maps.lines().any(is_part), "the output is mapped: {maps}");
        let open = fs::read_dir(format!("{process}/fd")).into_iter().flatten().flatten();
        let nameless = open.filter_map(|entry| fs::read_link(entry.path()).ok());
        let spools = nameless.filter(|target| target.to_string_lossy().ends_with("(deleted)")).count();
        seen.spools = seen.spools.max(spools);
        std::thread::sleep(Duration::from_millis(2));
    }
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
    println!("{line}: {seen:?}");
    assert!(seen.samples > 3, "{line}: it was over before it could be looked at");
    seen
}

fn assert_within(sandbox: &Sandbox, line: &str, limit: u64) -> Seen {
    let seen = watch(sandbox, &format!("{line} --memory {limit}"));
    assert!(seen.anonymous <= limit, "{line}: {} bytes, limit {limit}", seen.anonymous);
    seen
}

/// With two limits in MiB, and with the least that does.
fn check(sandbox: &Sandbox, line: &str, limits: [u64; 2]) {
    for limit in limits {
        assert_within(sandbox, line, limit << 20);
    }
    let seen = assert_within(sandbox, line, least(sandbox, line));
    assert!(seen.spools > 0, "no node was spooled");
}

#[test]
fn limits_hold_for_noise_of_floats() {
    let sandbox = Sandbox::new();
    sandbox.succeeds("synth noise --size 320,320,320 --type f32 -o in.nrrd");
    check(&sandbox, "build in.nrrd -o out.ovol --threads 2", [64, 128]);
}

#[test]
fn limits_hold_for_noise_of_bytes() {
    let sandbox = Sandbox::new();
    sandbox.succeeds("synth noise --size 512,512,400 --type u8 -o in.nrrd");
    check(&sandbox, "build in.nrrd -o out.ovol --threads 2", [64, 128]);
}

#[test]
fn limits_hold_for_streams() {
    let sandbox = Sandbox::new();
    sandbox.succeeds("synth mixing --size 600,600,48 --type f32 -o in.raw");
    let samples = sandbox.read("in.raw");
    sandbox.write("in.nrrd", &nrrd([600, 600, 48], "float", &samples, Some(Compression::none())));
    // The first is too low to read one slab while another is worked on.
    check(&sandbox, "build in.nrrd -o out.ovol --threads 3", [96, 192]);
}
