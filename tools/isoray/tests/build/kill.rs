//! Builds that are killed.

use std::process::Child;
use std::time::{Duration, Instant};

use crate::inputs::{built, is_part, least, noise, wait_for_part};
use crate::sandbox::Sandbox;

const INPUT: &str = "build in.raw --dims 256,256,160 --type u8 -o out.ovol --threads 2";

/// A folder with a volume that takes a while, and how to build it with as much as possible spooled.
fn slow() -> (Sandbox, String) {
    let sandbox = Sandbox::with("in.raw", &noise(256 * 256 * 160, 3));
    let least = least(&sandbox, INPUT);
    (sandbox, format!("{INPUT} --memory {least}"))
}

fn spawn(sandbox: &Sandbox, line: &str) -> Child {
    sandbox.command(line.split(' ')).spawn().unwrap()
}

/// Kills and waits; whether it was in time.
fn kill(child: &mut Child) -> bool {
    child.kill().unwrap();
    !child.wait().unwrap().success()
}

/// A build after all the killed ones works as if nothing had been.
fn assert_next_run_cleans_up(sandbox: &Sandbox, line: &str, expected: &[u8]) {
    sandbox.succeeds(line);
    assert_eq!(sandbox.names(), ["in.raw", "out.ovol"]);
    assert!(sandbox.read("out.ovol") == expected);
    sandbox.succeeds("check out.ovol");
}

#[test]
fn killed_at_any_moment_a_build_leaves_no_output() {
    const KILLS: u32 = 20;
    let (sandbox, line) = slow();
    let begin = Instant::now();
    let expected = built(&sandbox, &line, "out.ovol");
    let duration = begin.elapsed();
    let (mut in_time, mut strays) = (0, 0);
    for n in 0..KILLS {
        let mut child = spawn(&sandbox, &line);
        // Anywhere in the n-th twentieth: fractional parts of multiples of the golden ratio.
        let within = (f64::from(n) * 0.618_033_988_75).fract();
        std::thread::sleep(duration.mul_f64((f64::from(n) + within) / f64::from(KILLS)));
        let was_in_time = kill(&mut child);
        let names = sandbox.names();
        let parts = names.iter().filter(|name| is_part(name)).count();
        // A run removes what those before it have left.
        assert!(parts <= 1, "{names:?}");
        let output = names.iter().any(|name| name == "out.ovol");
        assert_eq!(names.len(), 1 + parts + usize::from(output), "{names:?}");
        if output {
            assert!(sandbox.read("out.ovol") == expected, "an output that is not whole");
            std::fs::remove_file(sandbox.path("out.ovol")).unwrap();
        } else {
            assert!(was_in_time, "a build that succeeded without an output");
        }
        in_time += u32::from(was_in_time);
        strays += parts;
    }
    println!("{in_time} of {KILLS} killed in time, {strays} unfinished files seen, {duration:?} a build");
    // The first is killed before the program has even started.
    assert!(in_time > 0);
    assert_next_run_cleans_up(&sandbox, &line, &expected);
}

#[test]
fn what_a_killed_build_leaves_the_next_one_removes() {
    let (sandbox, line) = slow();
    let expected = built(&sandbox, &line, "out.ovol");
    for delay in [0, 5, 20] {
        let mut child = spawn(&sandbox, &line);
        let seen = wait_for_part(&sandbox, &mut child).is_some();
        std::thread::sleep(Duration::from_millis(delay));
        if seen && kill(&mut child) {
            let names = sandbox.names();
            assert!(names.iter().any(|name| is_part(name)), "{names:?}");
            assert!(!names.contains(&"out.ovol".to_owned()), "{names:?}");
        } else {
            println!("SKIPPED: the build was over before it could be killed");
            child.wait().unwrap();
        }
        assert_next_run_cleans_up(&sandbox, &line, &expected);
        std::fs::remove_file(sandbox.path("out.ovol")).unwrap();
    }
}
