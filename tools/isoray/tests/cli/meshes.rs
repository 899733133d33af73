//! Adaptive meshes.

use std::fmt::Write;
use std::fs::{create_dir_all, remove_file};

use crate::pictures::read_exr;
use crate::sandbox::Sandbox;

/// Cells of level 0 along each axis, and the box of level 1.
const CELLS: i32 = 8;
const FINE: [i32; 2] = [4, 11];

/// A folder with a plotfile.
fn plotfile() -> Sandbox {
    let sandbox = Sandbox::new();
    write_plotfile(&sandbox, "plt");
    sandbox
}

/// A plotfile of two levels: how far cells are from the centre, and the same doubled.
fn write_plotfile(sandbox: &Sandbox, folder: &str) {
    let boxed = |[low, high]: [i32; 2]| format!("(({low},{low},{low}) ({high},{high},{high}) (0,0,0))");
    let last = [CELLS - 1, 2 * CELLS - 1];
    let mut header = String::from("HyperCLaw-V1.1\n2\nr\nd\n3\n0\n1\n0 0 0\n8 8 8\n2\n");
    writeln!(header, "{} {}\n0 0\n1 1 1\n0.5 0.5 0.5\n0\n0", boxed([0, last[0]]), boxed([0, last[1]]))
        .unwrap();
    for (level, [low, high]) in [[0, last[0]], FINE].into_iter().enumerate() {
        let edge = 0.5f64.powi(level as i32);
        writeln!(header, "{level} 1 0\n0").unwrap();
        for _ in 0..3 {
            writeln!(header, "{} {}", f64::from(low) * edge, f64::from(high + 1) * edge).unwrap();
        }
        writeln!(header, "Level_{level}/Cell").unwrap();
        create_dir_all(sandbox.path(&format!("{folder}/Level_{level}"))).unwrap();
        let at = |n: i32| (f64::from(n) + 0.5) * edge - 4.0;
        let mut values = Vec::new();
        for scale in [1.0, 2.0] {
            for z in low..=high {
                for y in low..=high {
                    for x in low..=high {
                        let r = scale * (at(x).powi(2) + at(y).powi(2) + at(z).powi(2)).sqrt();
                        // No digit is lost when it is read.
                        values.extend_from_slice(&f64::from(r as f32).to_le_bytes());
                    }
                }
            }
        }
        let place = boxed([low, high]);
        let fab = format!("FAB ((8, (64 11 52 0 1 12 0 1023)),(8, (8 7 6 5 4 3 2 1))){place} 2\n");
        sandbox.write(&format!("{folder}/Level_{level}/Cell_D_00000"), &[fab.as_bytes(), &values].concat());
        let list =
            format!("1\n1\n2\n0\n(1 0\n{place}\n)\n1\nFabOnDisk: Cell_D_00000 0\n\n1,2\n0,0,\n\n1,2\n9,9,\n");
        sandbox.write(&format!("{folder}/Level_{level}/Cell_H"), list.as_bytes());
    }
    sandbox.write(&format!("{folder}/Header"), header.as_bytes());
}

#[test]
fn info_lists_levels_and_fields() {
    let sandbox = plotfile();
    let text = sandbox.succeeds("info plt");
    for part in
        ["AMReX plotfile", "8 x 8 x 8", "512  2", "field        r, at cells", "field        d, at cells"]
    {
        assert!(text.contains(part), "no '{part}' in {text}");
    }
    let json: serde_json::Value =
        serde_json::from_str(&sandbox.succeeds("info plt --field d --json")).unwrap();
    assert_eq!(json["levels"][1]["cells"], 512);
    assert_eq!(json["fields"].as_array().unwrap().len(), 1);
    // A cell of the finer level by the centre.
    let least = json["fields"][0]["range"][0].as_f64().unwrap();
    assert!((least - 2.0 * 0.1875f64.sqrt()).abs() < 1e-6, "{least}");
}

#[test]
fn surfaces_are_where_they_should_be() {
    let sandbox = plotfile();
    let camera = "--eye 4,4,-20 --look-at 4,4,4 --up 0,1,0 --ortho-height 9";
    for (isovalue, normals) in [(1.5, "forward"), (3.0, "central")] {
        let line = format!(
            "render plt --field r --isovalue {isovalue} --normals {normals} {camera} --size 19x19 -o out.exr"
        );
        assert!(sandbox.succeeds(&line).contains("out.exr"));
        let (_, _, channels) = read_exr(&sandbox.path("out.exr"));
        let at = |name: &str| channels[name][9 * 19 + 9];
        // A ball around the centre; means of averages are off by what the field is curved.
        assert!((at("Z") - (24.0 - isovalue)).abs() < 0.15, "{} of {isovalue}", at("Z"));
        // Towards larger values, away from the centre; forward normals are those of a cell beside the axis.
        assert!(at("N.Z") < -0.95, "{}", at("N.Z"));
        let hits = channels["Z"].iter().filter(|z| z.is_finite()).count() as f32;
        let expected = std::f32::consts::PI * isovalue * isovalue * (19.0f32 / 9.0).powi(2);
        assert!((hits / expected - 1.0).abs() < 0.1, "{hits} for {expected}");
    }
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let sandbox = plotfile();
    for what in [
        "--isovalue 2 --light 20,30,-40 --shadows --ao 4",
        "--volume --shading specular",
        "--isovalue 1 --isovalue 2:1,0.5,0:0.5",
    ] {
        for threads in [1, 2] {
            let line =
                format!("render plt --field d {what} --size 40x40 --threads {threads} -o {threads}.exr");
            assert_eq!(sandbox.line(&line).code, 0, "{what}");
        }
        assert_eq!(sandbox.read("1.exr"), sandbox.read("2.exr"), "{what}");
    }
}

#[test]
fn levels_have_colours() {
    let sandbox = plotfile();
    let picture = |flag: &str| {
        let camera = "--eye 4,4,-20 --look-at 4,4,4 --up 0,1,0 --ortho-height 9";
        sandbox.succeeds(&format!(
            "render plt --field r --isovalue 1.5 {camera} --size 19x19 {flag} -o out.exr"
        ));
        let (_, _, channels) = read_exr(&sandbox.path("out.exr"));
        ["R", "G", "B"].map(|name| channels[name][9 * 19 + 9])
    };
    assert_ne!(picture(""), picture("--show-levels"));
}

/// Of volumes, opacity is what it is without: to a rounding with schemes that do not look at colours, and within the bound with that which does.
#[test]
fn levels_of_volumes_have_colours_and_no_opacity() {
    let sandbox = plotfile();
    for (scheme, bound) in [("bounded:0.001", 0.001), ("adaptive", 1e-6), ("fixed:3", 1e-6)] {
        for shading in ["none", "specular"] {
            let picture = |flag: &str| {
                let line = format!(
                    "render plt --field r --volume --scheme {scheme} --shading {shading} --size 30x30 {flag} -o out.exr"
                );
                sandbox.succeeds(&line);
                read_exr(&sandbox.path("out.exr")).2
            };
            let [plain, levels] = ["", "--show-levels"].map(picture);
            let seen = plain["A"].iter().filter(|&&a| a > 0.1).count();
            assert!(seen > 200, "{scheme} {shading}: {seen}");
            for (a, b) in plain["A"].iter().zip(&levels["A"]) {
                assert!((a - b).abs() <= bound, "{scheme} {shading}: {a} {b}");
            }
            assert_ne!(plain["R"], levels["R"]);
        }
    }
    let line = "render plt --field r --volume --show-levels --colormap magma -o out.png";
    sandbox.fails(2, line, &["--show-levels", "--colormap"]);
}

#[test]
fn outlines_of_patches_change_pixels_where_they_are_and_only_colours() {
    let sandbox = plotfile();
    // A pixel is a quarter of a unit wide; the domain goes from 0 to 8, the patch of level 1 from 2 to 6, and the ball from 2.5 to 5.5.
    let camera = "--eye 4,4,-20 --look-at 4,4,4 --up 0,1,0 --ortho-height 10 --size 40x40";
    for what in ["--isovalue 1.5", "--volume"] {
        let picture = |flag: &str| {
            sandbox.succeeds(&format!("render plt --field r {what} {camera} {flag} -o out.exr"));
            read_exr(&sandbox.path("out.exr")).2
        };
        let [plain, lines] = ["", "--show-patches"].map(picture);
        let same = |name: &str, at: usize| plain[name][at].to_bits() == lines[name][at].to_bits();
        // Along the sides of a square through the middle of the picture, whose pixels go from one corner to the other.
        let is_on = |at: usize, [low, high]: [usize; 2]| {
            let (x, y) = (at % 40, at / 40);
            let near = |c: usize, side: usize| c + 1 == side || c == side;
            let inside = |c: usize| c + 1 >= low && c <= high;
            [low, high].iter().any(|&s| near(x, s) && inside(y) || near(y, s) && inside(x))
        };
        let squares = [[4, 36], [12, 28]];
        for at in 0..1600 {
            let is_outline = squares.iter().any(|&square| is_on(at, square));
            let is_changed = ["R", "G", "B", "A"].iter().any(|name| !same(name, at));
            assert_eq!(is_changed, is_outline, "{what}: {}, {}", at % 40, at / 40);
            assert!(["Z", "N.X", "N.Y", "N.Z"].iter().all(|name| what == "--volume" || same(name, at)));
        }
    }
    // From the centre, all around: all of a ball around the eye, which hides them; and no surface.
    for (isovalue, is_hidden) in [(1.5, true), (20.0, false)] {
        let picture = |flag: &str| {
            let inside = "--eye 4,4,4 --look-at 4,4,8 --up 0,1,0 --fov 100 --size 40x40";
            let line = format!("render plt --field r --isovalue {isovalue} {inside} {flag} -o out.exr");
            assert_eq!(sandbox.line(&line).code, 0);
            read_exr(&sandbox.path("out.exr")).2
        };
        let [plain, lines] = ["", "--show-patches"].map(picture);
        let changed = plain["A"].iter().zip(&lines["A"]).filter(|(a, b)| a != b).count();
        assert!(plain["A"].iter().all(|&a| a == f32::from(u8::from(is_hidden))));
        assert!(if is_hidden { plain["R"] == lines["R"] } else { changed > 100 }, "{changed}");
    }
}

#[test]
fn levels_that_are_not_resolved_are_left_out() {
    let sandbox = plotfile();
    // A cell of level 0 is 19/9 pixels wide.
    let camera = "--eye 4,4,-20 --look-at 4,4,4 --up 0,1,0 --ortho-height 9 --size 19x19";
    for (what, name) in [("--isovalue 1.5", "Z"), ("--volume", "A")] {
        let picture = |lod: &str| {
            let line = format!("render plt --field r {what} {camera} {lod} --stats=stats.json -o out.exr");
            sandbox.succeeds(&line);
            let stats: serde_json::Value = serde_json::from_slice(&sandbox.read("stats.json")).unwrap();
            let (_, _, channels) = read_exr(&sandbox.path("out.exr"));
            (channels[name].clone(), stats["mesh_detail"].clone())
        };
        let (whole, none) = picture("");
        assert!(none.is_null());
        let (fine, kept) = picture("--lod 2.1");
        assert_eq!(fine, whole, "{what}");
        assert_eq!(kept, serde_json::json!({ "patches": [2, 2], "cells": [1024, 1024] }));
        let (coarse, left) = picture("--lod 2.2");
        assert_eq!(left, serde_json::json!({ "patches": [2, 1], "cells": [1024, 512] }));
        assert_ne!(coarse, whole, "{what}");
        let at = 9 * 19 + 9;
        assert!((coarse[at] - whole[at]).abs() < 0.25, "{what}: {} for {}", coarse[at], whole[at]);
    }
    let text =
        sandbox.succeeds(&format!("render plt --field r --isovalue 2 {camera} --lod 3 --stats -o out.png"));
    assert!(text.contains("50.0 % of 1024 left out; 1 patches for 2"), "{text}");
}

#[test]
fn steps_of_a_series_have_levels_of_detail() {
    let sandbox = Sandbox::new();
    for folder in ["run/plt1", "run/plt2"] {
        write_plotfile(&sandbox, folder);
    }
    let line = "render run --field r --volume --size 20x20 --lod 50 --steps 0:1 --stats=stats.json -o frame_%02d.png";
    sandbox.succeeds(line);
    let stats: serde_json::Value = serde_json::from_slice(&sandbox.read("stats.json")).unwrap();
    for step in [0, 1] {
        assert_eq!(stats[step]["mesh_detail"]["cells"], serde_json::json!([1024, 512]));
    }
    assert_eq!(sandbox.read("frame_00.png"), sandbox.read("frame_01.png"));
}

#[test]
fn a_folder_of_plotfiles_is_a_series() {
    let sandbox = Sandbox::new();
    for folder in ["run/plt10", "run/plt9"] {
        write_plotfile(&sandbox, folder);
    }
    let frames = |flag: &str| {
        let line =
            format!("render run --field r --isovalue 2 --size 20x20 --steps 0:1 {flag} -o frame_%02d.png");
        let text = sandbox.succeeds(&line);
        assert!(text.contains("frame_00.png: step 0") && text.contains("frame_01.png: step 1"), "{text}");
        assert_eq!(sandbox.read("frame_00.png"), sandbox.read("frame_01.png"));
        sandbox.read("frame_00.png")
    };
    assert_ne!(frames(""), frames("--show-patches"));
    sandbox.fails(2, "render run --field r --isovalue 2 -o out.png", &["a series of 2 steps"]);
}

#[test]
fn what_is_wrong_is_said_once() {
    let sandbox = plotfile();
    let fails = |code, line: &str, parts: &[&str]| sandbox.fails(code, line, parts);
    fails(1, "render plt --isovalue 1 -o out.png", &["plt", "r", "d"]);
    fails(1, "render plt --field q --isovalue 1 -o out.png", &["--field q", "r, d"]);
    for flag in ["--lod-blend 0.5", "--lod-distance true", "--lod-colors"] {
        let line = format!("render plt --field r --isovalue 1 --lod 2 {flag} -o out.png");
        fails(2, &line, &[flag.split(' ').next().unwrap(), "adaptive mesh"]);
    }
    fails(2, "render plt --field r --dims 8,8,8 --isovalue 1 -o out.png", &["--dims"]);
    sandbox.write("cube.raw", &[0; 27]);
    for flag in ["--show-levels", "--show-patches"] {
        for what in ["--isovalue 1", "--volume"] {
            let line = format!("render cube.raw --dims 3,3,3 --type u8 {what} {flag} -o out.png");
            fails(2, &line, &[flag, "adaptive mesh"]);
        }
    }
    fails(2, "build plt -o out.ovol", &["plt", "adaptive mesh"]);
    remove_file(sandbox.path("plt/Level_1/Cell_H")).unwrap();
    fails(1, "render plt --field r --isovalue 1 -o out.png", &["Level_1/Cell_H"]);
}
