//! Looks of isosurfaces, and what is cut away.

use crate::files::{SIZE, ball, nrrd, with_ovol};
use crate::pictures::read_exr;
use crate::sandbox::Sandbox;

/// From below along z, onto the middle of the ball.
const CAMERA: &str = "--eye 5.5,4.5,-20 --look-at 5.5,4.5,5 --up 0,1,0 --ortho-height 9 --size 27x27";

/// The middle pixel of a picture: red, green, blue, alpha and depth.
fn middle(sandbox: &Sandbox, flags: &str) -> [f32; 5] {
    let outcome = sandbox.line(&format!("render ball.ovol {CAMERA} {flags} -o out.exr"));
    assert!(outcome.code == 0 && outcome.stderr.is_empty(), "{flags}: {outcome:?}");
    let (width, height, channels) = read_exr(&sandbox.path("out.exr"));
    ["R", "G", "B", "A", "Z"].map(|name| channels[name][height / 2 * width + width / 2])
}

#[test]
fn several_surfaces_with_colours_and_opacities() {
    let sandbox = with_ovol();
    let outer = middle(&sandbox, "--isovalue 100:#ff0000");
    assert!(outer[0] > 0.9 && outer[1] == 0.0 && outer[3] == 1.0, "{outer:?}");
    // Through the outer one, whichever comes first in the line.
    for flags in
        ["--isovalue 100:1,0,0:0.25 --isovalue 200:0,1,0", "--isovalue 200:0,1,0 --isovalue 100:1,0,0:0.25"]
    {
        let [r, g, b, a, z] = middle(&sandbox, flags);
        assert!((0.2..0.26).contains(&r) && (0.7..0.76).contains(&g) && b == 0.0, "{flags}: {r}, {g}, {b}");
        assert_eq!((a, z), (1.0, outer[4]), "depth is that of the first");
    }
    // Translucent alone: through its front and its back.
    let [.., a, _] = middle(&sandbox, "--isovalue 100::0.5");
    assert!((a - 0.75).abs() < 1e-6, "{a}");
    let told =
        sandbox.succeeds(&format!("render ball.ovol {CAMERA} --isovalue 100 --isovalue 200 -o out.png"));
    assert!(told.contains("isovalues 100, 200"), "{told}");
}

#[test]
fn levels_of_detail() {
    let sandbox = with_ovol();
    let [x, y, z] = SIZE.map(|n| 4 * n);
    sandbox.succeeds(&format!("synth sphere --size {x},{y},{z} --type u8 -o large.nrrd"));
    let picture = |flags: &str| {
        let command = format!("render large.nrrd --isovalue 128 --size 45x33 {flags} -o out.exr");
        let outcome = sandbox.line(&command);
        assert!(outcome.code == 0 && outcome.stderr.is_empty(), "{flags}: {outcome:?}");
        std::fs::read(sandbox.path("out.exr")).unwrap()
    };
    let exact = picture("");
    assert!(picture("--lod 0") == exact && picture("--lod 0.001") == exact, "nothing is that coarse");
    let coarse = picture("--lod 4 --traversal single");
    assert!(coarse != exact);
    for flags in ["", "--traversal masked", "--traversal coherent", "--packet 16"] {
        assert!(picture(&format!("--lod 4 {flags}")) == coarse, "{flags}");
    }
    assert!(picture("--lod 4 --lod-colors") != coarse);
    // Along a diagonal, one pixel is as far as another along no axis.
    let near = "--lod 4 --eye 50,50,60 --look-at 20,18,20";
    let hard = picture(near);
    for flags in ["--lod-blend 1", "--lod-distance slices"] {
        assert!(picture(&format!("{near} {flags}")) != hard, "{flags}");
    }
    // What hides the light behind the ball's edge is far enough away to be coarse.
    let lamp = "--light 100,90,80 --shadows --ao 4";
    let shadowed = picture(lamp);
    assert!(picture(&format!("{lamp} --shadow-lod 0")) == shadowed);
    let far = picture(&format!("{lamp} --shadow-lod 8"));
    assert!(far != shadowed && far == picture(&format!("{lamp} --shadow-lod 8 --traversal single")));
    picture(&format!("{lamp} --lod 4 --shadow-lod 8"));
    picture("--lod 4 --normals central --shadows --ao 4 --light 100,90,80 --clip-plane 1,0,0,12 --cap");
    let refused = [
        ("--lod -1", "--lod"),
        ("--lod-blend 0.5", "--lod-blend: expected --lod RATIO beside it"),
        ("--lod-distance true", "--lod-distance: expected --lod RATIO beside it"),
        ("--lod-colors", "--lod-colors: expected --lod RATIO beside it"),
        ("--shadow-lod 2", "--shadow-lod: expected --shadows or --ao beside it"),
        (
            "--ao 4 --lod 4 --shadow-lod 2",
            "--shadow-lod: expected 0 or more than the ratio of --lod, 4, found 2",
        ),
        ("--ao 4 --isovalue 90 --isovalue 100 --shadow-lod 2", "--shadow-lod: expected one opaque surface"),
        (
            "--ao 4 --shadow-lod 2 --structure grid",
            "--shadow-lod: expected --structure octree or auto, found grid",
        ),
        ("--shadow-lod 1 --volume", "--shadow-lod: expected an isosurface to render, found --volume"),
        ("--lod 1 --structure grid", "--lod: expected --structure octree or auto, found grid"),
        ("--lod 1 --volume", "--lod: expected an isosurface to render, found --volume"),
    ];
    for (flags, part) in refused {
        sandbox.fails(2, &format!("render ball.ovol {flags} -o refused.png"), &[part]);
    }
    sandbox.succeeds("build large.nrrd --no-lod -o without.ovol");
    sandbox.fails(
        1,
        "render without.ovol --isovalue 128 --lod 4 -o refused.png",
        &["without.ovol: expected coarse samples for --lod, found a volume that was built without"],
    );
    assert!(!sandbox.path("refused.png").exists());
}

#[test]
fn every_traversal_makes_the_same_picture() {
    let sandbox = with_ovol();
    let picture = |flags: &str| {
        let command = format!("render ball.ovol --isovalue 100 --size 45x33 {flags} -o out.exr");
        sandbox.succeeds(&command);
        std::fs::read(sandbox.path("out.exr")).unwrap()
    };
    let expected = picture("--traversal single");
    for flags in [
        "",
        "--traversal masked",
        "--traversal masked --packet 2",
        "--traversal coherent",
        "--packet 16",
        "--structure grid",
    ] {
        assert!(picture(flags) == expected, "{flags}");
    }
    let refused = [
        ("--packet 1", "--packet"),
        ("--packet 17", "--packet"),
        (
            "--packet 4 --traversal single",
            "--packet: expected --traversal auto, masked or coherent beside it",
        ),
        ("--traversal masked --structure grid", "--traversal masked: expected --structure octree or auto"),
        (
            "--traversal coherent --structure grid",
            "--traversal coherent: expected --structure octree or auto",
        ),
    ];
    for (flags, part) in refused {
        sandbox.fails(2, &format!("render ball.ovol --isovalue 100 {flags} -o out.png"), &[part]);
    }
}

#[test]
fn lights_shadows_sky_and_highlights() {
    let sandbox = with_ovol();
    let of = |flags: &str| middle(&sandbox, &format!("--isovalue 100 {flags}"))[1];
    let lit = of("");
    let (front, back) = (of("--light dir:0,0,-1"), of("--light dir:0,0,1 --shadows"));
    assert!((front - lit).abs() < 0.01 && back < 0.15 * lit, "{front}, {back}, {lit}");
    // Two lights share.
    let both = of("--light headlight --light dir:0,0,1");
    assert!(both < lit && both > 0.5 * lit, "{both}");
    assert!(of("--specular 0.5:8") > lit + 0.3);
    let sky = of("--ao 16");
    assert!((sky - lit).abs() < 0.02, "the ball hides no sky from itself: {sky}, {lit}");
}

#[test]
fn colours_by_another_field() {
    let sandbox = with_ovol();
    // A second field that rises along z, and a third one of colours: red on the lower half along z, green above.
    let [nx, ny, nz] = SIZE;
    let rising: Vec<u8> = (0..nx * ny * nz).map(|n| (n / (nx * ny)) as u8 * 10).collect();
    sandbox.write("rising.nrrd", &nrrd("12 10 11", "uint8", "raw", &rising));
    let rgb: Vec<u8> =
        (0..nx * ny * nz).flat_map(|n| if n / (nx * ny) < 6 { [255, 0, 0] } else { [0, 255, 0] }).collect();
    let header = "NRRD0004\ntype: uint8\ndimension: 4\nsizes: 3 12 10 11\nkinds: vector domain domain domain\nencoding: raw\n\n";
    sandbox.write("rgb.nrrd", &[header.as_bytes(), &rgb].concat());
    let of = |flags: &str| middle(&sandbox, &format!("--isovalue 100 {flags}"));
    let [r, g, b, ..] = of("--color-by rgb.nrrd");
    assert!(r > 0.9 && g == 0.0 && b == 0.0, "{r}, {g}, {b}");
    // The front of the ball lies at z = 0.7: value 7 of 0 to 100.
    let low = of("--color-by rising.nrrd --color-map gray");
    let high = of("--color-by rising.nrrd --color-map gray --color-range 100:0");
    assert!((low[0] - high[0]).abs() > 0.5, "{low:?}, {high:?}");
    sandbox.succeeds("build rising.nrrd -o rising.ovol");
    assert_eq!(of("--color-by rising.ovol --color-map gray"), low);
    let told =
        sandbox.line(&format!("render ball.ovol {CAMERA} --isovalue 100 --color-by rising.ovol -o out.png"));
    assert!(told.stdout.contains("colours from 0 to 100"), "{told:?}");

    sandbox.write("small.nrrd", &nrrd("4 4 4", "uint8", "raw", &[7; 64]));
    let line = |flags: &str| format!("render ball.ovol --isovalue 100 {flags} -o other.png");
    sandbox.fails(
        2,
        &line("--color-by small.nrrd"),
        &["small.nrrd", "expected 12x10x11", "ball.ovol", "found 4x4x4"],
    );
    sandbox.fails(1, &line("--color-by gone.nrrd"), &["gone.nrrd"]);
    sandbox.fails(2, &line("--color-by rgb.nrrd --color-map gray"), &["--color-map", "red, green and blue"]);
}

#[test]
fn cuts_and_caps() {
    let sandbox = with_ovol();
    let of = |flags: &str| middle(&sandbox, &format!("--isovalue 100:1,0,0 {flags}"));
    let whole = of("");
    // From the other side of the cut the back of the ball is seen.
    let open = of("--clip-plane 0,0,1,5");
    assert!(open[4] > 27.0 && whole[4] < 22.0, "{open:?}, {whole:?}");
    let closed = of("--clip-plane 0,0,1,5 --cap");
    assert!((closed[4] - 25.0).abs() < 1e-5, "{closed:?}");
    assert_eq!(of("--clip-box 0,0,5,11,9,10 --cap")[4], closed[4]);
    assert_eq!(of("--clip-box -5,-5,-5,20,20,20"), whole);
    assert!(of("--clip-plane 1,0,0,8")[4].is_infinite());
    // Volumes, too.
    let volume = |flags: &str| {
        sandbox.line(&format!("render ball.ovol --volume --tf-range 0:250 {CAMERA} {flags} -o volume.exr"));
        let (width, height, channels) = read_exr(&sandbox.path("volume.exr"));
        channels["A"][height / 2 * width + width / 2]
    };
    let (all, half, none) = (volume(""), volume("--clip-plane 0,0,1,5"), volume("--clip-plane 1,0,0,8"));
    assert!(all > half && half > 0.0 && none == 0.0, "{all}, {half}, {none}");
    let gone = sandbox.line("render ball.ovol --isovalue 100 --clip-plane 0,0,1,50 -o out.png");
    assert!(gone.code == 0 && gone.stderr.contains("all of the volume is cut away"), "{gone:?}");
}

#[test]
fn the_structure_changes_nothing() {
    let sandbox = with_ovol();
    let picture = |structure: &str| {
        let flags = "--isovalue 100::0.4 --isovalue 180 --light dir:1,2,-3 --shadows --ao 3 --clip-plane 1,1,1,9 --cap";
        sandbox.succeeds(&format!("render ball.ovol {CAMERA} {flags} --structure {structure} -o out.exr"));
        sandbox.read("out.exr")
    };
    let octree = picture("octree");
    assert!(octree == picture("grid") && octree == picture("auto"));
}

#[test]
fn looks_that_make_no_sense() {
    let sandbox = Sandbox::new();
    for (flags, parts) in [
        ("--isovalue 1:pink", ["--isovalue", "#c08040"]),
        ("--isovalue 1:#fff:0", ["--isovalue", "#c08040"]),
        ("--isovalue 1::0", ["--isovalue", "above 0 and up to 1"]),
        ("--light dir:0,0,0", ["--light", "not zero"]),
        ("--light dir:1,2", ["--light", "three numbers"]),
        ("--specular 3", ["--specular", "from 0 to 1"]),
        ("--specular 0.3:0", ["--specular", "from 1 to 10000"]),
        ("--ao 0", ["--ao", "0"]),
        ("--clip-box 0,0,0,1,1", ["--clip-box", "six numbers"]),
        ("--clip-box 0,0,5,1,1,4", ["--clip-box", "six numbers"]),
        ("--clip-plane 0,0,0,4", ["--clip-plane", "not zero"]),
        ("--clip-plane 1,0,0", ["--clip-plane", "four numbers"]),
        ("--color-map jet", ["--color-map", "--color-by"]),
        ("--color-range 0:1", ["--color-range", "--color-by"]),
        ("--color-by x --color-range 1:1", ["--color-range", "two different numbers"]),
        ("--color-by x --color-map nothing", ["--color-map", "nothing"]),
        ("--cap", ["--cap", "--clip-box or --clip-plane"]),
        ("--shadows", ["--shadows", "--light"]),
        ("--shadows --light headlight", ["--shadows", "--light"]),
        ("--structure tree", ["--structure", "octree"]),
        ("--volume --shadows", ["--shadows", "found --volume"]),
        ("--volume --ao 3", ["--ao", "found --volume"]),
        ("--volume --specular 1", ["--specular", "found --volume"]),
        ("--volume --color-by x", ["--color-by", "found --volume"]),
        ("--volume --cap --clip-plane 1,0,0,0", ["--cap", "found --volume"]),
        ("--volume --light headlight --light 1,2,3", ["--light", "found 2"]),
    ] {
        sandbox.fails(2, &format!("render gone.nrrd {flags} -o out.png"), &parts);
    }
    let bright = ball().iter().filter(|&&s| s > 100).count();
    assert!(bright > 50, "the ball of these tests");
}
