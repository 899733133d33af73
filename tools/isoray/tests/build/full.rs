//! Disks that are full.

use std::process::{Command, Stdio};

use crate::inputs::{built, least, noise};
use crate::sandbox::{Outcome, Sandbox, finish};

const INPUT: &str = "build in.raw --dims 100,80,90 --type u8 --threads 2";

/// A volume, and the bytes of its file.
fn volume() -> (Sandbox, usize) {
    let sandbox = Sandbox::with("in.raw", &noise(100 * 80 * 90, 7));
    let length = built(&sandbox, &format!("{INPUT} -o out.ovol"), "out.ovol").len();
    (sandbox, length)
}

/// Runs a script in the folder, in which `"$@"` is a build of the volume to `output`, with nodes spooled.
fn script(sandbox: &Sandbox, wrapper: &[&str], text: &str, output: &str) -> Outcome {
    let line = format!("{INPUT} -o {output}");
    let line = format!("{line} --memory {}", least(sandbox, &line));
    let words = wrapper.iter().copied().chain(["sh", "-c", text, "sh", env!("CARGO_BIN_EXE_isoray")]);
    let mut words = words.chain(line.split(' '));
    let mut command = Command::new(words.next().unwrap());
    command.args(words).current_dir(sandbox.path("")).env("TMPDIR", sandbox.path(""));
    finish(command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()))
}

/// One error, of the output and of one of `causes`.
fn assert_cannot_write(outcome: &Outcome, output: &str, causes: &[&str]) {
    assert_eq!(outcome.code, 1, "{outcome:?}");
    let mut lines = outcome.stderr.lines();
    let first = lines.next().unwrap();
    assert!(
        first.starts_with("error: ") && first.contains(output) && first.contains("cannot"),
        "{outcome:?}"
    );
    let cause = lines.next().unwrap();
    assert!(cause.starts_with("  caused by: "), "{outcome:?}");
    assert!(causes.iter().any(|part| cause.contains(part)), "{outcome:?}");
    assert_eq!(lines.next(), None, "{outcome:?}");
}

#[test]
fn a_file_that_may_not_grow_is_one_error() {
    let (sandbox, length) = volume();
    // In blocks of 512 bytes or, with some shells, 1024.
    for share in [0, 1, 50, 90, 100, 120] {
        let blocks = (length * share).div_ceil(100 * 1024 * 2);
        let text = format!("trap '' XFSZ; ulimit -f {blocks} || exit 77; exec \"$@\"");
        let outcome = script(&sandbox, &[], &text, "out.ovol");
        if outcome.code == 77 {
            println!("SKIPPED: the shell cannot limit the size of files: {}", outcome.stderr);
            return;
        }
        if share < 120 || outcome.code != 0 {
            assert_cannot_write(&outcome, "out.ovol", &["File too large"]);
            assert_eq!(sandbox.names(), ["in.raw"]);
        }
    }
}

/// A file system of its own in `disk`, of so many bytes; what is in it in the end is printed.
fn on_disk(sandbox: &Sandbox, options: &str) -> Option<Outcome> {
    let text = format!(
        "mount -t tmpfs -o {options} none disk || exit 77; \"$@\" >/dev/null; code=$?; ls -A disk; exit $code"
    );
    let outcome = script(sandbox, &["unshare", "-rm"], &text, "disk/out.ovol");
    if outcome.code == 77 || outcome.stderr.contains("unshare") {
        println!("SKIPPED: no file system can be mounted here: {}", outcome.stderr);
        return None;
    }
    Some(outcome)
}

#[test]
fn a_full_disk_is_one_error_and_nothing_is_left() {
    let (sandbox, length) = volume();
    std::fs::create_dir(sandbox.path("disk")).unwrap();
    if Command::new("unshare").arg("--version").output().is_err() {
        println!("SKIPPED: there is no unshare to mount a file system with");
        return;
    }
    // From no room at all, over caps and spooled nodes, to one page short of enough.
    let pages = length.div_ceil(4096);
    for size in [1, pages / 4, pages / 2, pages * 9 / 10, pages - 1] {
        let Some(outcome) = on_disk(&sandbox, &format!("size={}", size * 4096)) else { return };
        assert_cannot_write(&outcome, "disk/out.ovol", &["No space left"]);
        assert_eq!(outcome.stdout, "", "left on the disk");
    }
    let outcome = on_disk(&sandbox, &format!("size={}", 2 * length + 65536)).unwrap();
    assert_eq!((outcome.code, outcome.stdout.as_str()), (0, "out.ovol\n"), "{outcome:?}");
    let outcome = on_disk(&sandbox, "ro").unwrap();
    assert_cannot_write(&outcome, "disk/out.ovol", &["Read-only"]);
}
