//! `isoray tf`: pictures of transfer functions, and files and flags that are none.

use crate::files::{RAW_FLAGS, ball, ball_nrrd, floats, with_ovol};
use crate::sandbox::Sandbox;

const TOML: &str = include_str!("../../../../fixtures/transfer/tooth.toml");
const JSON: &str = include_str!("../../../../fixtures/transfer/cool-to-warm.json");

/// A sandbox with both files and the ball.
fn sandbox() -> Sandbox {
    let sandbox = Sandbox::with("ball.nrrd", &ball_nrrd());
    sandbox.write("a.toml", TOML.as_bytes());
    sandbox.write("a.json", JSON.as_bytes());
    sandbox
}

#[test]
fn colour_maps_are_listed() {
    let list = Sandbox::new().succeeds("tf list");
    assert!(list.starts_with("viridis\n") && list.lines().count() >= 20, "{list}");
}

#[test]
fn previews() {
    let sandbox = sandbox();
    let values = |line: &str| {
        let line = format!("tf preview {line} --size 300x200 -o out.png");
        let printed = sandbox.succeeds(&line);
        let picture = image::load_from_memory(&sandbox.read("out.png")).unwrap().into_rgb8();
        assert_eq!(picture.dimensions(), (300, 200), "{line}");
        let colored =
            picture.pixels().filter(|p| p.0.iter().max().unwrap() - p.0.iter().min().unwrap() > 40).count();
        assert!(colored > 1500, "{line}: {colored}");
        assert!(printed.starts_with("out.png: 300 x 200 pixels, "), "{printed}");
        printed.split_once("values ").unwrap().1.split_once(',').unwrap().0.to_owned()
    };
    assert_eq!(values("a.toml"), "420 to 1300");
    assert_eq!(values("--tf a.toml --tf-range -5:7"), "-5 to 7");
    assert_eq!(values("a.json"), "0 to 1");
    assert_eq!(values("a.json --volume ball.nrrd"), "0 to 225");
    assert_eq!(values("a.json --volume ball.nrrd --tf-range 1:100 --log"), "1 to 100");
    assert_eq!(values(""), "0 to 1");
    assert_eq!(values("--colormap RdBu --tf-range -1:1"), "-1 to 1");
    sandbox.write("ball.raw", &ball());
    assert_eq!(values(&format!("a.json --volume ball.raw {RAW_FLAGS}")), "0 to 225");
    assert_eq!(sandbox.names(), ["a.json", "a.toml", "ball.nrrd", "ball.raw", "out.png"]);
}

#[test]
fn proposals_need_no_flag() {
    let sandbox = with_ovol();
    let preview = |line: &str| sandbox.succeeds(&format!("tf preview {line} -o out.png"));
    let plain = preview("--volume ball.ovol");
    let picture = sandbox.read("out.png");
    assert_eq!(preview("--volume ball.nrrd"), plain);
    assert_eq!(sandbox.read("out.png"), picture, "the same volume");
    let densest = |text: &str| text.rsplit_once(' ').unwrap().1.trim().parse::<f32>().unwrap();
    assert_eq!(densest(&preview("--volume ball.ovol --extinction-scale 2")), 2.0 * densest(&plain));
    // Neither one value nor a threshold near zero is an error.
    for (name, change) in [("one.nrrd", 7.0), ("zero.nrrd", 0.0)] {
        sandbox.write(name, &floats(|samples| samples.fill(change)));
        assert!(preview(&format!("--volume {name}")).contains("1 control points"));
    }
}

#[test]
fn flags_that_make_no_sense() {
    // The files are missing: flags are looked at first.
    let sandbox = Sandbox::new();
    let cases = [
        ("--colormap jet", "--colormap: expected a colour map, one of viridis, inferno, "),
        ("--tf-range 5", "two numbers separated by a colon"),
        ("--tf-range 5:4", "found '5:4'"),
        ("--tf-range -1:nan", "found '-1:nan'"),
        (
            "--tf-range -1:4 --log",
            "--log: expected positive values to map by their logarithm, found the range -1 to 4",
        ),
        ("--extinction-scale 0", "expected a finite number above 0, found '0'"),
        ("--extinction-scale -2", "found '-2'"),
        ("--extinction-scale inf", "found 'inf'"),
        ("--size 119x400", "--size: expected 120 to 8192 pixels a side, found 119x400"),
        ("--size 9000x400", "found 9000x400"),
        ("--tf b.toml", "cannot be used with"),
        ("--colormap gray", "cannot be used with"),
        ("--dims 4,4,4 --type u8", "--volume VOLUME is missing"),
        ("--shiny", "--shiny"),
    ];
    for (flags, part) in cases {
        let file = if part.starts_with("--colormap:") { "" } else { "gone.toml" };
        sandbox.fails(2, &format!("tf preview {file} {flags} -o out.png"), &[part]);
    }
    sandbox.fails(2, "tf preview gone.toml", &["--output"]);
    sandbox.fails(
        2,
        "tf preview gone.toml -o out.jpg",
        &["--output out.jpg: expected a name that ends in .png"],
    );
    sandbox.fails(2, "tf preview --tf a --colormap gray -o out.png", &["cannot be used with"]);
    sandbox.fails(2, "tf paint", &["paint"]);
}

#[test]
fn flags_that_make_no_sense_for_this_volume() {
    let sandbox = Sandbox::with("a.nrrd", &floats(|samples| samples.iter_mut().for_each(|s| *s -= 90.0)));
    let line = "tf preview --volume a.nrrd --log -o out.png";
    sandbox.fails(2, line, &["--log: expected positive values", "choose one with --tf-range"]);
    sandbox.write("huge.nrrd", &floats(|samples| samples[5] = 3e38));
    sandbox.fails(1, "tf preview --volume huge.nrrd -o out.png", &["choose --tf-range", "caused by", "1e30"]);
}

#[test]
fn wrong_files_are_told_in_one_line() {
    let sandbox = sandbox();
    sandbox.write("b.toml", b"[[points]]\nvalue = 1\ncolor = '#102030'\nextinction = -2\n");
    sandbox.write("b.json", br#"[{"RGBPoints": [0.5, 0, 0, 0, 0.25, 0, 0, 0]}]"#);
    sandbox.write("c.json", b"[\n{]");
    sandbox.write("none", b"");
    sandbox.write("bytes", &[0xff; 99]);
    let cases = [
        ("gone.toml", "gone.toml: cannot open"),
        ("b.toml", "b.toml:4:14: points[0].extinction: expected an extinction of at least 0"),
        (
            "b.json",
            "b.json: RGBPoints[4]: expected a value of at least 0.5, that of the point before, found 0.25",
        ),
        ("c.json", "c.json:2:2: expected a ParaView preset in JSON"),
        ("none", "none: expected a transfer function, found an empty file"),
        ("bytes", "bytes: expected a transfer function as text"),
        ("ball.nrrd", "ball.nrrd"),
        (
            "a.json --log",
            "a.json: expected positive values to map by their logarithm, found the range 0 to 1",
        ),
        ("a.toml --extinction-scale 1e38", "--extinction-scale"),
        ("a.toml --volume gone.nrrd", "gone.nrrd: cannot be opened"),
    ];
    for (words, part) in cases {
        sandbox.fails(1, &format!("tf preview {words} -o out.png"), &[part]);
    }
}

#[test]
fn outputs_that_cannot_be_written() {
    let sandbox = sandbox();
    sandbox.fails(1, "tf preview a.toml -o missing/out.png", &["there is no folder missing"]);
    sandbox.write("tf.png", TOML.as_bytes());
    sandbox.fails(1, "tf preview tf.png -o tf.png", &["tf.png: is an input"]);
    sandbox.fails(1, "tf preview --tf tf.png -o tf.png", &["tf.png: is an input"]);
}

#[test]
fn help_explains_it() {
    let sandbox = Sandbox::new();
    assert!(sandbox.succeeds("--help").contains("transfer functions"));
    let help = sandbox.succeeds("tf preview --help");
    for word in ["ParaView", "--tf-range", "-100:400", "--log", "--extinction-scale", "histogram", "tf list"]
    {
        assert!(help.contains(word), "no {word} in {help}");
    }
}
