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
    sandbox.fails(2, "render plt --field r --volume --show-levels -o out.png", &["--show-levels"]);
}

#[test]
fn a_folder_of_plotfiles_is_a_series() {
    let sandbox = Sandbox::new();
    for folder in ["run/plt10", "run/plt9"] {
        write_plotfile(&sandbox, folder);
    }
    let line = "render run --field r --isovalue 2 --size 20x20 --steps 0:1 -o frame_%02d.png";
    let text = sandbox.succeeds(line);
    assert!(text.contains("frame_00.png: step 0") && text.contains("frame_01.png: step 1"), "{text}");
    assert_eq!(sandbox.read("frame_00.png"), sandbox.read("frame_01.png"));
    sandbox.fails(2, "render run --field r --isovalue 2 -o out.png", &["a series of 2 steps"]);
}

#[test]
fn what_is_wrong_is_said_once() {
    let sandbox = plotfile();
    let fails = |code, line: &str, parts: &[&str]| sandbox.fails(code, line, parts);
    fails(1, "render plt --isovalue 1 -o out.png", &["plt", "r", "d"]);
    fails(1, "render plt --field q --isovalue 1 -o out.png", &["--field q", "r, d"]);
    fails(2, "render plt --field r --isovalue 1 --lod 2 -o out.png", &["--lod", "adaptive mesh"]);
    fails(2, "render plt --field r --dims 8,8,8 --isovalue 1 -o out.png", &["--dims"]);
    fails(2, "build plt -o out.ovol", &["plt", "adaptive mesh"]);
    remove_file(sandbox.path("plt/Level_1/Cell_H")).unwrap();
    fails(1, "render plt --field r --isovalue 1 -o out.png", &["Level_1/Cell_H"]);
}
