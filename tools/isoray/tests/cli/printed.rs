//! What the program prints, as kept in `snapshots/`: a change there is one that users see, and is looked at (`cargo insta review`, or by hand).

use crate::files::{ball_nrrd, with_ovol};
use crate::sandbox::{Outcome, Sandbox};

/// Numbers that differ from run to run, or from machine to machine, with the spaces that line them up.
const VARYING: [(&str, &str); 6] = [
    (r" +\d+\.\d+ s\b", " [time] s"),
    (r" +\d+(\.\d+)? (million voxels|Mrays)/s", " [rate] $2/s"),
    (r"\d+ threads?", "[count] threads"),
    (r"\d+ ended", "[count] ended"),
    (
        r"(No such file or directory|The system cannot find the file specified\.) \(os error \d+\)",
        "[no such file]",
    ),
    (
        r"(?m)^(packets|rays alone|nodes/ray|lookups/ray|cells/ray|pieces/ray|error) +\d+\b(\.\d+)?( +\(\d+ of them.*)?",
        "$1 [count]",
    ),
];

/// Compares a text with the stored one of this name.
fn is_as_stored(name: &str, text: &str) {
    let mut settings = insta::Settings::clone_current();
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    VARYING.iter().for_each(|(pattern, by)| settings.add_filter(pattern, *by));
    settings.bind(|| insta::assert_snapshot!(name, text));
}

/// A command with all that it prints.
fn session(sandbox: &Sandbox, lines: &[&str]) -> String {
    let one = |line: &&str| {
        let Outcome { code, stdout, stderr } = sandbox.line(line);
        let code = if code == 0 { String::new() } else { format!("[exit code {code}]\n") };
        format!("$ isoray {line}\n{stdout}{stderr}{code}\n")
    };
    lines.iter().map(one).collect()
}

#[test]
fn help() {
    let sandbox = Sandbox::new();
    is_as_stored("help", &session(&sandbox, &["--help", "check --help", "tf --help"]));
    for command in ["build", "info", "render", "synth"] {
        is_as_stored(&format!("help-{command}"), &session(&sandbox, &[&format!("{command} --help")]));
    }
    is_as_stored("help-tf-preview", &session(&sandbox, &["tf preview --help"]));
}

#[test]
fn the_fixture_described() {
    let fixture = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/tooth/tooth.nrrd");
    let sandbox = Sandbox::with("tooth.nrrd", &std::fs::read(fixture).unwrap());
    let lines = ["info tooth.nrrd", "build tooth.nrrd -o tooth.ovol", "check tooth.ovol"];
    is_as_stored("fixture", &session(&sandbox, &lines));
    is_as_stored("info-ovol", &session(&sandbox, &["info tooth.ovol", "info tooth.ovol --json"]));
    let lines = [
        "render tooth.ovol --isovalue 600.5 --size 64x64 --stats -o out.png",
        "render tooth.ovol --volume --size 64x64 --stats -o out.png",
    ];
    is_as_stored("stats", &session(&sandbox, &lines));
}

#[test]
fn warnings() {
    let sandbox = with_ovol();
    let lines = ["render ball.ovol --isovalue 1000.5 --size 8x8 -o out.png"];
    is_as_stored("warning", &session(&sandbox, &lines));
}

#[test]
fn transfer_functions_listed() {
    is_as_stored("tf-list", &session(&Sandbox::new(), &["tf list"]));
}

#[test]
fn errors() {
    let sandbox = with_ovol();
    let ovol = sandbox.read("ball.ovol");
    sandbox.write("short.ovol", &ovol[..ovol.len() - 100]);
    let mut damaged = ovol;
    let last = damaged.len() - 1;
    damaged[last] ^= 0xff;
    sandbox.write("damaged.ovol", &damaged);
    let nrrd = ball_nrrd();
    sandbox.write("short.nrrd", &nrrd[..nrrd.len() - 100]);
    sandbox.write("text.txt", b"no volume");
    let lines = [
        "render ball.ovol",
        "render ball.ovol -o out.png --shiny",
        "render ball.ovol -o out.png --size 0x16",
        "render ball.ovol -o out.png --isovalue nan",
        "render ball.ovol -o out.png --isovalue 100 --fov 30 --ortho-height 4",
        "render ball.ovol -o out.jpg",
        "render gone.ovol -o out.png",
        "info short.ovol",
        "check damaged.ovol",
        "build short.nrrd -o out.ovol",
        "info text.txt",
    ];
    is_as_stored("errors", &session(&sandbox, &lines));
}
