//! `isoray render --volume`: pictures, and flags and files that are none.

use crate::files::{ball_nrrd, floats, with_ovol};
use crate::pictures::{TOOTH, read_exr};
use crate::sandbox::Sandbox;

const TOML: &str = include_str!("../../../../fixtures/transfer/tooth-inside.toml");
const JSON: &str = include_str!("../../../../fixtures/transfer/cool-to-warm.json");

/// What is shown of the ball: its middle, all red.
const RED: &str = "[[points]]\nvalue = 120\ncolor = '#ff0000'\nextinction = 0\n[[points]]\nvalue = 200\ncolor = '#ff0000'\nextinction = 0.8\n";

/// A sandbox with the ball and transfer functions.
fn sandbox() -> Sandbox {
    let sandbox = Sandbox::with("ball.nrrd", &ball_nrrd());
    sandbox.write("red.toml", RED.as_bytes());
    sandbox.write("a.json", JSON.as_bytes());
    sandbox
}

#[test]
fn without_a_transfer_function_one_is_proposed() {
    let sandbox = with_ovol();
    let text = sandbox.succeeds("render ball.ovol --volume --size 40x30 -o out.png");
    let lines: Vec<&str> = text.lines().collect();
    assert!(lines[0].starts_with("transfer function viridis, proposed from the histogram: clear up to "));
    assert!(lines[0].contains("--tf") && lines[1].starts_with("gradient scale "), "{text}");
    assert_eq!(lines[2..], ["out.png: 40 x 30 pixels, volume, bounded:0.00196"]);
    let image = image::open(sandbox.path("out.png")).unwrap().into_rgb8();
    let [corner, centre] = [*image.get_pixel(0, 0), *image.get_pixel(20, 15)].map(|p| p.0);
    assert_eq!(corner, [48, 48, 56], "the background alone");
    let colorful = centre.iter().max().unwrap() - centre.iter().min().unwrap();
    assert!(centre[1] > 100 && colorful > 60, "{centre:?}");
    let text =
        sandbox.succeeds("render ball.nrrd --volume --colormap warm --shading none --size 8x8 -o out.png");
    assert!(text.starts_with("transfer function warm, ") && !text.contains("gradient scale"), "{text}");
    assert_eq!(sandbox.names(), ["ball.nrrd", "ball.ovol", "out.png"]);
}

#[test]
fn transfer_functions_from_files() {
    let sandbox = sandbox();
    let picture = |flags: &str| {
        let line = format!("render ball.nrrd --volume --size 40x30 {flags} -o out.png");
        assert!(!sandbox.succeeds(&line).contains("proposed from the histogram"));
        image::open(sandbox.path("out.png")).unwrap().into_rgba8()
    };
    let image = picture("--tf red.toml --transparent --shading none");
    assert_eq!(image.get_pixel(0, 0)[3], 0);
    let centre = image.get_pixel(20, 15).0;
    assert!(centre[..3] == [255, 0, 0] && (200..=255).contains(&centre[3]), "{centre:?}");
    let clearer = picture("--tf red.toml --transparent --extinction-scale 0.2").get_pixel(20, 15).0;
    assert!(clearer[3] < 200 && clearer[3] > 20, "{clearer:?}");
    assert_ne!(picture("--tf a.json"), picture("--tf a.json --tf-range 100:200"));
}

#[test]
fn light_and_its_scale_matter() {
    let sandbox = sandbox();
    let picture = |flags: &str| {
        sandbox.succeeds(&format!("render ball.nrrd --volume --tf red.toml --size 30x30 {flags} -o out.png"));
        sandbox.read("out.png")
    };
    let pictures = [
        "--shading none",
        "",
        "--shading specular",
        "--gradient-scale 100",
        "--light -50,0,0",
        "--light -50,0,0 --shading specular",
    ]
    .map(picture);
    for (n, a) in pictures.iter().enumerate() {
        assert!(pictures[..n].iter().all(|b| a != b), "{n}");
    }
    assert_eq!(picture("--shading diffuse --light headlight"), pictures[1]);
    // At the centre itself no direction leads to it.
    assert_eq!(picture("--light 5.5,4.5,5"), pictures[1]);
}

#[test]
fn exr_has_linear_colour_alone() {
    let sandbox = sandbox();
    // Orthographic along z, past and through the ball.
    let camera = "--eye 5.5,4.5,-20 --look-at 5.5,4.5,5 --up 0,1,0 --ortho-height 9";
    let line = "render ball.nrrd --volume --tf red.toml --shading none --size 27x18";
    sandbox.succeeds(&format!("{line} {camera} --scheme bounded:1e-6 -o out.exr"));
    let (width, height, channels) = read_exr(&sandbox.path("out.exr"));
    assert_eq!((width, height), (27, 18));
    assert_eq!(channels.keys().collect::<Vec<_>>(), ["A", "B", "G", "R"]);
    for n in 0..width * height {
        let [r, g, b, a] = ["R", "G", "B", "A"].map(|name| channels[name][n]);
        assert!((r - a).abs() <= 2e-6 && g == 0.0 && b == 0.0, "premultiplied: {r} {g} {b} {a}");
    }
    // Less than 2 away from the middle there is nothing to see.
    assert!(channels["A"][0] == 0.0 && channels["A"][9 * 27 + 13] > 0.5);
}

#[test]
fn a_real_scan_is_the_same_on_any_number_of_threads() {
    let sandbox = Sandbox::new();
    sandbox.write("tooth.toml", TOML.as_bytes());
    for name in ["out.png", "out.exr"] {
        let picture = |threads: &str| {
            let flags = ["--volume", "--tf", "tooth.toml", "--shading", "specular", "--size", "60x50"];
            let outcome = sandbox.run(["render", TOOTH].into_iter().chain(flags).chain([
                "--threads",
                threads,
                "-o",
                name,
            ]));
            assert_eq!((outcome.code, outcome.stderr.as_str()), (0, ""));
            sandbox.read(name)
        };
        assert!(picture("1") == picture("3"), "{name}");
    }
}

#[test]
fn schemes_agree() {
    let sandbox = sandbox();
    let line = "render ball.nrrd --volume --tf red.toml --size 24x24";
    let alpha = |scheme: &str| {
        let text = sandbox.succeeds(&format!("{line} --scheme {scheme} -o out.exr"));
        let scheme = scheme.split(' ').next().unwrap();
        assert!(text.ends_with(&format!("out.exr: 24 x 24 pixels, volume, {scheme}\n")), "{text}");
        read_exr(&sandbox.path("out.exr")).2.remove("A").unwrap()
    };
    let expected = alpha("bounded:0.000001");
    for (scheme, tolerance) in [
        ("bounded:0.001", 0.001),
        ("bounded:0.001 --structure grid", 0.001),
        ("adaptive --terminate 0", 0.01),
        ("adaptive", 0.01),
        ("fixed:64 --terminate 0", 0.001),
        ("fixed:1", 0.1),
    ] {
        let found = alpha(scheme);
        let worst = expected.iter().zip(&found).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(worst <= tolerance, "{scheme}: {worst}");
    }
}

#[test]
fn statistics_have_the_documented_keys() {
    let sandbox = sandbox();
    let line = "render ball.nrrd --volume --tf red.toml --size 20x10 --repeat 2 --threads 2 -o out.png";
    sandbox.succeeds(&format!("{line} --stats s.json"));
    let json: serde_json::Value = serde_json::from_slice(&sandbox.read("s.json")).unwrap();
    for key in ["open_s", "build_s", "render_s", "write_s", "mrays_per_s", "nodes_per_ray", "lookups_per_ray"]
    {
        assert!(json[key].is_number(), "{key} in {json}");
    }
    let number = |key: &str| json[key].as_f64().unwrap();
    assert_eq!((number("rays"), number("repeat"), number("raw_bytes")), (200.0, 2.0, 1320.0));
    assert!(
        (10.0..150.0).contains(&number("lit_rays")) && number("ended_rays") <= number("lit_rays"),
        "{json}"
    );
    assert!(number("pieces_per_ray") > 0.1 && number("cells_per_ray") > 0.1, "{json}");
    assert!(number("largest_error_bound") > 0.0 && number("largest_error_bound") <= 0.00196, "{json}");
    assert!(json["scheme"] == "bounded:0.00196" && json["isovalues"].is_null(), "{json}");
    let text = sandbox.succeeds(&format!("{line} --stats"));
    for word in
        ["render", "lit, ", "ended", "scheme", "error", "pieces/ray", "Mrays/s", "cells/ray", "structure"]
    {
        assert!(text.contains(word), "no {word} in {text}");
    }
}

#[test]
fn flags_that_do_not_fit_together() {
    // The files are missing: flags are looked at first.
    let sandbox = Sandbox::new();
    for flag in [
        "--tf a.toml",
        "--colormap gray",
        "--tf-range 1:2",
        "--log",
        "--extinction-scale 2",
        "--shading none",
        "--gradient-scale 2",
        "--scheme adaptive",
        "--terminate 0.1",
    ] {
        let name = flag.split(' ').next().unwrap();
        let part = format!("{name}: expected --volume beside it, found an isosurface to render");
        sandbox.fails(2, &format!("render gone.nrrd {flag} -o out.png"), &[&part]);
    }
    let cases = [
        ("--isovalue 5", "--isovalue: expected an isosurface to render, found --volume"),
        ("--normals central", "--normals: expected an isosurface to render, found --volume"),
        ("--traversal single", "--traversal: expected an isosurface to render, found --volume"),
        ("--shading none --light 1,2,3", "--light: expected --shading diffuse or specular, found none"),
        ("--shading none --gradient-scale 2", "--gradient-scale: expected --shading diffuse or specular"),
        ("--terminate 0.1", "--terminate: expected --scheme adaptive or fixed:N, found bounded:0.00196"),
        ("--terminate 0.1 --scheme bounded:0.1", "found bounded:0.1, where the bound decides"),
        ("--tf a.toml --colormap gray", "cannot be used with"),
        ("--colormap jet", "--colormap: expected a colour map, one of viridis"),
        ("--log --tf-range -1:4", "--log: expected positive values"),
        ("--size 0x0", "0x0"),
        ("--fov 180", "field of view of 180 degrees"),
    ];
    for (flags, part) in cases {
        sandbox.fails(2, &format!("render gone.nrrd --volume {flags} -o out.png"), &[part]);
    }
}

#[test]
fn values_that_cannot_be_read_name_their_flag() {
    let sandbox = Sandbox::new();
    for (flags, part) in [
        ("--scheme bounded:1e-7", "from 2e-7 to 0.5 after bounded:, found '1e-7'"),
        ("--scheme bounded:0.6", "found '0.6'"),
        ("--scheme bounded", "bounded:EPS"),
        ("--scheme fixed:0", "a whole number from 1 to 10000 after fixed:, found '0'"),
        ("--scheme fixed:10001", "found '10001'"),
        ("--scheme exact", "found 'exact'"),
        ("--terminate 1", "from 0 to less than 1, found '1'"),
        ("--terminate -0.5", "found '-0.5'"),
        ("--gradient-scale 0", "from 1e-30 to 1e30, found '0'"),
        ("--gradient-scale -3", "found '-3'"),
        ("--shading phong", "specular"),
        ("--extinction-scale 0", "above 0, found '0'"),
    ] {
        let flag = flags.split(' ').next().unwrap();
        sandbox.fails(2, &format!("render gone.nrrd --volume {flags} -o out.png"), &[flag, part]);
    }
}

#[test]
fn wrong_transfer_functions_leave_no_picture() {
    let sandbox = sandbox();
    sandbox.write("b.toml", b"[[points]]\nvalue = 1\ncolor = '#102030'\nextinction = -2\n");
    for (flags, part) in [
        ("--tf b.toml", "b.toml:4:14: points[0].extinction: expected an extinction of at least 0"),
        ("--tf gone.toml", "gone.toml: cannot open"),
        ("--tf ball.nrrd", "ball.nrrd"),
        ("--tf red.toml --extinction-scale 1e38", "--extinction-scale"),
    ] {
        sandbox.fails(1, &format!("render ball.nrrd --volume {flags} -o out.png"), &[part]);
    }
    sandbox.write("tf.png", RED.as_bytes());
    sandbox.fails(1, "render ball.nrrd --volume --tf tf.png -o tf.png", &["tf.png: is an input"]);
    sandbox.fails(
        1,
        "render ball.nrrd --volume --tf red.toml --stats red.toml -o out.png",
        &["red.toml: is an input"],
    );
}

#[test]
fn nothing_to_see_is_a_warning() {
    let sandbox = sandbox();
    sandbox.write("nan.nrrd", &floats(|samples| samples.fill(f32::NAN)));
    for (line, part) in [
        ("ball.nrrd --tf red.toml --tf-range 300:400", "no value from 0 to 225 has an extinction"),
        ("nan.nrrd", "no sample is finite"),
    ] {
        let outcome = sandbox.line(&format!("render {line} --volume --size 8x8 -o out.png"));
        assert_eq!(outcome.code, 0, "{outcome:?}");
        assert!(outcome.stderr.contains(&format!("warning: nothing to see: {part}")), "{outcome:?}");
        let image = image::open(sandbox.path("out.png")).unwrap().into_rgb8();
        assert!(image.pixels().all(|p| p == image.get_pixel(0, 0)));
    }
    // A volume of one value is a haze.
    sandbox.write("one.nrrd", &floats(|samples| samples.fill(7.0)));
    let text = sandbox.succeeds("render one.nrrd --volume --size 8x8 -o out.png");
    assert!(text.contains("of one extinction"), "{text}");
    let image = image::open(sandbox.path("out.png")).unwrap().into_rgb8();
    assert_ne!(image.get_pixel(4, 4), image.get_pixel(0, 0));
}

#[test]
fn help_explains_it() {
    let sandbox = Sandbox::new();
    let help = sandbox.succeeds("render --help");
    let words = [
        "--volume",
        "--tf ",
        "--scheme",
        "bounded:EPS",
        "--terminate",
        "--shading",
        "diffuse",
        "--gradient-scale",
    ];
    for word in words {
        assert!(help.contains(word), "no {word} in {help}");
    }
    assert!(sandbox.succeeds("").contains("--volume"), "what to try next");
}
