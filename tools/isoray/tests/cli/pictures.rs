//! Pictures: what is in them, and what they must not depend on.

use std::collections::BTreeMap;
use std::path::Path;

use exr::prelude::{FlatSamples, read_first_flat_layer_from_file};

use crate::files::{RAW_FLAGS, ball, ball_mha, ball_nii, with_ovol};
use crate::sandbox::Sandbox;

pub(crate) const TOOTH: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/tooth/tooth.nrrd");

/// Width, height and channels by name.
pub(crate) fn read_exr(path: &Path) -> (usize, usize, BTreeMap<String, Vec<f32>>) {
    let layer = read_first_flat_layer_from_file(path).unwrap().layer_data;
    let channels = layer.channel_data.list.into_iter().map(|channel| {
        let FlatSamples::F32(values) = channel.sample_data else { panic!("not 32-bit float") };
        (channel.name.to_string(), values)
    });
    (layer.size.width(), layer.size.height(), channels.collect())
}

#[test]
fn png_shows_the_surface_over_the_background() {
    let sandbox = with_ovol();
    sandbox.succeeds("render ball.nrrd --isovalue 100 --size 40x30 --background 1,0,0 -o out.png");
    let image = image::open(sandbox.path("out.png")).unwrap();
    assert_eq!(image.color(), image::ColorType::Rgb8);
    let image = image.into_rgb8();
    assert_eq!(image.dimensions(), (40, 30));
    let [corner, centre] = [*image.get_pixel(0, 0), *image.get_pixel(20, 15)].map(|p| p.0);
    assert_eq!(corner, [255, 0, 0]);
    // Facing the headlight: bright, and of no strong colour.
    assert!(centre[1] > 100 && centre[0].abs_diff(centre[1]) < 60, "{centre:?}");
}

#[test]
fn transparent_png_has_alpha() {
    let sandbox = with_ovol();
    sandbox.succeeds("render ball.ovol --isovalue 100 --size 40x30 --transparent -o out.png");
    let image = image::open(sandbox.path("out.png")).unwrap();
    assert_eq!(image.color(), image::ColorType::Rgba8);
    let image = image.into_rgba8();
    assert_eq!((image.get_pixel(0, 0)[3], image.get_pixel(20, 15)[3]), (0, 255));
}

#[test]
fn exr_has_colour_depth_and_normals() {
    let sandbox = with_ovol();
    // Orthographic from below along z, onto a ball around the centre.
    let camera = "--eye 5.5,4.5,-20 --look-at 5.5,4.5,5 --up 0,1,0 --ortho-height 9";
    sandbox.succeeds(&format!("render ball.nrrd --isovalue 110 {camera} --size 27x18 -o out.exr"));
    let (width, height, channels) = read_exr(&sandbox.path("out.exr"));
    assert_eq!((width, height), (27, 18));
    assert_eq!(channels.keys().collect::<Vec<_>>(), ["A", "B", "G", "N.X", "N.Y", "N.Z", "R", "Z"]);
    let mut hits = 0;
    for n in 0..width * height {
        let at = |name: &str| channels[name][n];
        let normal = [at("N.X"), at("N.Y"), at("N.Z")];
        let length = normal.iter().map(|c| c * c).sum::<f32>().sqrt();
        if at("Z").is_finite() {
            hits += 1;
            assert_eq!(at("A"), 1.0);
            assert!((20.0..=25.0).contains(&at("Z")), "{}", at("Z"));
            assert!((length - 1.0).abs() < 1e-5, "{normal:?}");
            // Toward larger values: into the ball, which is brightest in the middle.
            assert!(normal[2] > 0.0, "{normal:?}");
        } else {
            assert_eq!(at("Z"), f32::INFINITY);
            assert_eq!([at("R"), at("G"), at("B"), at("A"), length], [0.0; 5], "premultiplied");
        }
    }
    // A disc of radius 4 in 9 × 13.5 world units.
    let share = f64::from(hits) / (27.0 * 18.0);
    assert!((share - 16.0 * std::f64::consts::PI / (9.0 * 13.5)).abs() < 0.03, "{share}");
}

#[test]
fn every_way_to_the_same_samples_gives_the_same_picture() {
    let sandbox = with_ovol();
    sandbox.write("ball.raw", &ball());
    sandbox.write("ball.mha", &ball_mha());
    let picture = |input: &str, name: &str| {
        sandbox.succeeds(&format!("render {input} --isovalue 77.5 --normals central --size 33x21 -o {name}"));
        sandbox.read(name)
    };
    for name in ["out.png", "out.exr"] {
        let expected = picture("ball.nrrd", name);
        for input in ["ball.ovol", "ball.mha", &format!("ball.raw {RAW_FLAGS}")] {
            assert!(picture(input, name) == expected, "{input}");
        }
    }
    sandbox.write("ball.nii", &ball_nii());
    assert!(sandbox.succeeds("info ball.nii").contains("12 x 10 x 11"));
    sandbox.succeeds(&format!("build ball.raw {RAW_FLAGS} -o raw.ovol"));
    assert!(sandbox.read("raw.ovol") == sandbox.read("ball.ovol"));
}

#[test]
fn a_real_scan_is_the_same_built_or_not_on_any_number_of_threads() {
    let sandbox = Sandbox::new();
    let build = sandbox.run(["build", TOOTH, "-o", "tooth.ovol", "--threads", "2"]);
    assert_eq!((build.code, build.stderr.as_str()), (0, ""));
    assert!(build.stdout.contains("103x94x161 u16"), "{}", build.stdout);
    sandbox.succeeds("check tooth.ovol");
    for name in ["out.png", "out.exr"] {
        let picture = |input: &str, threads: &str| {
            let flags = ["--isovalue", "600", "--size", "100x80", "--threads", threads, "-o", name];
            let outcome = sandbox.run(["render", input].into_iter().chain(flags));
            assert_eq!((outcome.code, outcome.stderr.as_str()), (0, ""));
            sandbox.read(name)
        };
        let expected = picture("tooth.ovol", "1");
        assert!(picture("tooth.ovol", "2") == expected && picture("tooth.ovol", "3") == expected);
        assert!(picture(TOOTH, "2") == expected);
    }
    let image = image::open(sandbox.path("out.png")).unwrap().into_rgb8();
    let bright = image.pixels().filter(|p| p.0.iter().all(|&c| c > 100)).count();
    assert!((800..7900).contains(&bright), "{bright} pixels of tooth");
}

#[test]
fn statistics_have_the_documented_keys() {
    let sandbox = with_ovol();
    let line = "render ball.ovol --isovalue 100 --size 20x10 --repeat 3 --threads 2 -o out.png";
    sandbox.succeeds(&format!("{line} --stats s.json"));
    let json: serde_json::Value = serde_json::from_slice(&sandbox.read("s.json")).unwrap();
    let keys = [
        "open_s",
        "build_s",
        "render_s",
        "threads",
        "rays",
        "hits",
        "mrays_per_s",
        "nodes_per_ray",
        "lookups_per_ray",
        "cells_per_ray",
        "structure_bytes",
        "raw_bytes",
        "packets",
        "background_packets",
        "rays_alone",
        "shadow_rays",
        "spared_shadow_rays",
    ];
    assert!(keys.iter().all(|key| json[key].is_number()), "{json}");
    assert_eq!((&json["rays"], &json["threads"], &json["raw_bytes"]), (&200.into(), &2.into(), &1320.into()));
    let hits = json["hits"].as_u64().unwrap();
    assert!((10..100).contains(&hits), "{hits}");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let mode = |name| std::fs::metadata(sandbox.path(name)).unwrap().permissions().mode();
        assert_eq!([mode("s.json"), mode("out.png"), mode("ball.ovol")], [mode("ball.nrrd"); 3]);
    }
    let text = sandbox.succeeds(&format!("{line} --stats"));
    for word in
        ["open", "build", "render", "rays", "Mrays/s", "nodes/ray", "structure", "packets", "rays alone"]
    {
        assert!(text.contains(word), "no {word} in {text}");
    }
}

#[test]
fn without_an_isovalue_one_is_proposed() {
    let sandbox = with_ovol();
    let text = sandbox.succeeds("render ball.nrrd --size 16x16 -o out.png");
    assert!(text.starts_with("isovalue ") && text.contains("Otsu") && text.contains("--isovalue"), "{text}");
    let image = image::open(sandbox.path("out.png")).unwrap().into_rgb8();
    assert_ne!(image.get_pixel(8, 8), image.get_pixel(0, 0));
}

#[test]
fn without_arguments_the_bundled_scan_is_rendered() {
    let sandbox = Sandbox::new();
    let text = sandbox.succeeds("");
    assert_eq!(sandbox.names(), ["isoray.png"]);
    let image = image::open(sandbox.path("isoray.png")).unwrap().into_rgb8();
    assert_eq!(image.dimensions(), (800, 800));
    assert_ne!(image.get_pixel(400, 400), image.get_pixel(0, 0));
    assert!(text.contains(&*sandbox.path("isoray.png").canonicalize().unwrap().to_string_lossy()), "{text}");
    assert!(text.contains("isoray render"), "{text}");
}
