//! Flags: those that make no sense (exit code 2), and those that look as if.

use crate::files::{RAW_FLAGS, ball, ball_nrrd, floats, with_ovol};
use crate::sandbox::Sandbox;

#[test]
fn camera_and_size_that_make_no_sense() {
    // The volume is missing: flags are looked at first.
    let sandbox = Sandbox::new();
    let cases = [
        ("--size 0x0", "0x0"),
        ("--size 16x0", "16x0"),
        ("--size 100000x100000", "100000x100000"),
        ("--size 4294967295x4294967295", "at most"),
        ("--fov 0", "field of view of 0 degrees"),
        ("--fov 180", "field of view of 180 degrees"),
        ("--fov -20", "field of view of -20 degrees"),
        ("--fov nan", "field of view of NaN degrees"),
        ("--ortho-height 0", "orthographic height of 0"),
        ("--ortho-height -3", "orthographic height of -3"),
        ("--ortho-height inf", "orthographic height of inf"),
        ("--eye 1,2,3 --look-at 1,2,3", "eye and look-at point are the same"),
        ("--eye 1,2,3 --look-at 1,2,9", "parallel to the view direction"),
        ("--up 0,0,0", "up vector"),
        ("--eye 1,2,3 --look-at 9,2,3 --up -1,0,0", "parallel to the view direction"),
        ("--isovalue nan", "--isovalue NaN: expected a finite number"),
        ("--isovalue inf", "--isovalue inf: expected a finite number"),
        ("--isovalue=-inf", "--isovalue -inf: expected a finite number"),
        ("--isovalue 1e39", "expected a finite number"),
    ];
    for (flags, part) in cases {
        sandbox.fails(2, &format!("render gone.nrrd {flags} -o out.png"), &[part]);
    }
}

#[test]
fn camera_that_makes_no_sense_for_this_volume() {
    let sandbox = Sandbox::with("ball.nrrd", &ball_nrrd());
    let line = |flags| format!("render ball.nrrd --isovalue 100 --size 8x8 {flags} -o out.png");
    // The centre of the volume, at which the camera looks.
    sandbox.fails(2, &line("--eye 5.5,4.5,5"), &["eye and look-at point are the same"]);
    sandbox.fails(2, &line("--eye 5.5,4.5,50"), &["parallel to the view direction"]);
    // These are fine here, though not for a volume of one cell.
    sandbox.succeeds(&line("--eye 0.5,0.5,0.5"));
    sandbox.succeeds(&line("--eye 0.5,0.5,40"));
}

#[test]
fn values_that_cannot_be_read_name_their_flag() {
    let sandbox = Sandbox::new();
    let cases = [
        ("--eye 1,2", "three numbers"),
        ("--eye 1,2,x", "three numbers"),
        ("--look-at nan,0,0", "three numbers"),
        ("--up --fov", "three numbers"),
        ("--size 640", "1024x768"),
        ("--size 640x-3", "1024x768"),
        ("--light sun", "headlight"),
        ("--background 2,0,0", "from 0 to 1"),
        ("--background -1,0,0", "from 0 to 1"),
        ("--dims 4,4", "three whole numbers"),
        ("--dims -4,4,4", "three whole numbers"),
        ("--dims 4294967296,1,1", "three whole numbers"),
        ("--type u7", "u7"),
        ("--threads 0", "whole number from 1"),
        ("--threads many", "whole number from 1"),
        ("--repeat 0", "0"),
        ("--normals smooth", "central"),
        ("--endian middle", "little"),
        ("--isovalue bone", "bone"),
    ];
    for (flags, part) in cases {
        let flag = flags.split(' ').next().unwrap();
        sandbox.fails(2, &format!("render gone.nrrd {flags} -o out.png"), &[flag, part]);
    }
    sandbox.fails(2, "build gone.nrrd -o out.ovol --threads 0", &["--threads", "whole number from 1"]);
}

#[test]
fn flags_that_contradict_each_other() {
    let sandbox = with_ovol();
    sandbox.write("ball.raw", &ball());
    sandbox.fails(2, "render ball.nrrd --fov 30 --ortho-height 4 -o out.png", &["--fov", "--ortho-height"]);
    sandbox.fails(2, "render ball.raw --dims 12,10,11 -o out.png", &["--type TYPE is missing"]);
    sandbox.fails(2, "info ball.raw --type u8", &["--dims X,Y,Z is missing"]);
    sandbox.fails(2, "build ball.raw --skip 4 -o out.ovol", &["--dims X,Y,Z is missing"]);
    for command in ["info ball.ovol", "render ball.ovol -o out.png", "build ball.ovol -o out.ovol"] {
        for flags in [RAW_FLAGS, "--dims 2,2,2", "--endian big", "--skip 0", "--component 0"] {
            sandbox.fails(2, &format!("{command} {flags}"), &["ball.ovol: an octree volume needs no --dims"]);
        }
    }
}

#[test]
fn missing_and_unknown_words() {
    let sandbox = Sandbox::with("ball.nrrd", &ball_nrrd());
    sandbox.fails(2, "render ball.nrrd", &["--output"]);
    sandbox.fails(2, "build ball.nrrd", &["--output"]);
    sandbox.fails(2, "render -o out.png", &["FILE"]);
    sandbox.fails(2, "render ball.nrrd -o out.png --shiny", &["--shiny"]);
    sandbox.fails(2, "paint ball.nrrd", &["paint"]);
    for name in ["out", "out.jpg", "out.png.gz", ".png"] {
        let parts = [name, "expected a name that ends in .png or .exr"];
        sandbox.fails(2, &format!("render ball.nrrd -o {name}"), &parts);
    }
}

#[test]
fn negative_values() {
    let sandbox = Sandbox::with("a.nrrd", &floats(|samples| samples.iter_mut().for_each(|s| *s -= 331.5)));
    let line = "render a.nrrd --eye -10,5,3 --look-at -1,-2,-3 --up -0.5,0,1 --isovalue -300 \
                --light -5,-6,-7 --size 8x6 -o out.png";
    assert_eq!(sandbox.succeeds(line), "out.png: 8 x 6 pixels, isovalue -300\n");
    assert_eq!(sandbox.names(), ["a.nrrd", "out.png"]);
    sandbox.write("ball.raw", &ball());
    let info = sandbox.succeeds(&format!("info ball.raw {RAW_FLAGS} --spacing -1,1,2 --origin -4,-5,-6"));
    assert!(info.contains("-4, -5, -6") && info.contains("-1, 0, 0"), "{info}");
}

#[test]
fn help_explains_every_command() {
    let sandbox = Sandbox::new();
    let help = sandbox.succeeds("--help");
    assert!(["build", "info", "check", "render"].iter().all(|command| help.contains(command)), "{help}");
    let render = sandbox.succeeds("render --help");
    for word in ["--isovalue", "--ortho-height", "degrees", "headlight", "proposed", ".exr", "world"] {
        assert!(render.contains(word), "no {word} in {render}");
    }
    assert!(sandbox.succeeds("--version").starts_with("isoray "));
}
