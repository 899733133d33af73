//! Several builds to one output.

use crate::inputs::{built, noise};
use crate::sandbox::{Sandbox, finish};

const ROUNDS: usize = 8;

#[test]
fn of_several_builds_to_one_output_one_wins_whole() {
    const FLAGS: &str = "--dims 64,70,60 --type u8 -o out.ovol";
    let sandbox = Sandbox::new();
    let lines = ["a.raw", "b.raw", "c.raw"].map(|name| format!("build {name} {FLAGS}"));
    for (seed, name) in (4..).zip(["a.raw", "b.raw", "c.raw"]) {
        sandbox.write(name, &noise(64 * 70 * 60, seed));
    }
    let expected = lines.each_ref().map(|line| built(&sandbox, line, "out.ovol"));
    assert!(expected[0] != expected[1] && expected[1] != expected[2]);
    let mut wins = [0; 3];
    for _ in 0..ROUNDS {
        let outcomes = std::thread::scope(|scope| {
            let runs = lines.each_ref().map(|line| {
                let mut command = sandbox.command(line.split(' '));
                scope.spawn(move || finish(&mut command))
            });
            runs.map(|run| run.join().unwrap())
        });
        for outcome in outcomes {
            assert!(outcome.code == 0 && outcome.stderr.is_empty(), "{outcome:?}");
        }
        let found = sandbox.read("out.ovol");
        let winner = expected.iter().position(|bytes| *bytes == found);
        wins[winner.expect("the output is that of none of the builds")] += 1;
        assert_eq!(sandbox.names(), ["a.raw", "b.raw", "c.raw", "out.ovol"]);
    }
    println!("wins: {wins:?}");
}
