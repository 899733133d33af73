//! Time series: pictures of their steps.

use std::path::Path;

use crate::sandbox::Sandbox;
use crate::series::{built, step};

const SIZE: &str = "--size 24x20";

#[test]
fn one_step() {
    let sandbox = built();
    let picture = |line: &str| {
        let text = sandbox.succeeds(&format!("render {line} {SIZE} --isovalue 100 -o out.png"));
        (text, sandbox.read("out.png"))
    };
    let (text, last) = picture("s.ovol.d --step 2");
    assert_eq!(text, "out.png: step 2, 24 x 20 pixels, isovalue 100\n");
    assert!(last == picture("s.ovol.d/s10.ovol").1);
    assert!(last != picture("s.ovol.d --step 0").1);
    sandbox.succeeds(&format!("render s.ovol.d --step 1 {SIZE} --isovalue 100 -o %03d.exr"));
    assert!(sandbox.names().contains(&"001.exr".to_owned()));
    // Of a series of one step, that one; any other file may be called what it likes.
    sandbox.write("a.raw", &step(10));
    sandbox.succeeds("build a.raw --dims 12,10,11 --type u8 -o a.ovol.d");
    assert!(picture("a.ovol.d").1 == last);
    sandbox.succeeds(&format!("render s.ovol.d/s1.ovol {SIZE} --isovalue 100 -o a%d.png"));
    assert!(sandbox.names().contains(&"a%d.png".to_owned()));
}

#[test]
fn many_steps_look_alike() {
    let sandbox = built();
    let text = sandbox.succeeds(&format!("render s.ovol.d --steps 0:2:2 {SIZE} -o f_%02d.png"));
    let lines: Vec<&str> = text.lines().collect();
    assert!(lines.len() == 3 && lines[0].starts_with("isovalue "), "{text}");
    let isovalue = lines[0].split([' ', ',']).nth(1).unwrap();
    for (line, n) in lines[1..].iter().zip([0, 2]) {
        assert_eq!(*line, format!("f_{n:02}.png: step {n}, 24 x 20 pixels, isovalue {isovalue}"));
    }
    for (n, name) in [(0, "s1"), (2, "s10")] {
        let line = format!("render s.ovol.d/{name}.ovol --isovalue {isovalue} {SIZE} -o one.png");
        sandbox.succeeds(&line);
        assert!(sandbox.read("one.png") == sandbox.read(&format!("f_{n:02}.png")), "{n}");
    }
    assert_eq!(sandbox.names().iter().filter(|name| name.starts_with("f_")).count(), 2);
}

#[test]
fn volumes_share_what_is_proposed_for_the_first() {
    let sandbox = built();
    let text = sandbox.succeeds(&format!("render s.ovol.d --volume --steps : {SIZE} -o v%d.exr"));
    let said = |what: &str| text.lines().filter(|line| line.starts_with(what)).count();
    assert_eq!((said("transfer function "), said("gradient scale "), said("v")), (1, 1, 3), "{text}");
    let alone = |name: &str| {
        sandbox.succeeds(&format!("render s.ovol.d/{name}.ovol --volume {SIZE} -o one.exr"));
        sandbox.read("one.exr")
    };
    assert!(sandbox.read("v0.exr") == alone("s1"), "the first one is as it would be alone");
    assert!(sandbox.read("v2.exr") != alone("s10"), "the others are not, or they would flicker");
}

#[test]
fn statistics_tell_of_every_step() {
    let sandbox = built();
    let line = format!("render s.ovol.d --steps 1: {SIZE} --isovalue 100 -o f%d.png --stats");
    let json: serde_json::Value = {
        sandbox.succeeds(&format!("{line} s.json"));
        serde_json::from_slice(&sandbox.read("s.json")).unwrap()
    };
    let steps: Vec<_> = json.as_array().unwrap().iter().map(|s| s["step"].as_u64().unwrap()).collect();
    assert_eq!(steps, [1, 2]);
    assert!(json[0]["hits"].as_u64() > json[1]["hits"].as_u64(), "{json}");
    let text = sandbox.succeeds(&line);
    assert_eq!(text.lines().filter(|line| line.starts_with("throughput")).count(), 2, "{text}");
    sandbox.succeeds(&format!("render s.ovol.d --step 0 {SIZE} --isovalue 100 -o f.png --stats s.json"));
    let json: serde_json::Value = serde_json::from_slice(&sandbox.read("s.json")).unwrap();
    assert_eq!(json["isovalues"], serde_json::json!([100.0]));
}

#[test]
fn flags_that_make_no_sense() {
    let sandbox = built();
    for (line, part) in [
        (
            "s.ovol.d -o a.png",
            "s.ovol.d: a series of 3 steps: expected --step N, from 0 to 2, or --steps A:B",
        ),
        ("s.ovol.d --step 3 -o a.png", "--step: expected steps from 0 to 2"),
        (
            "s.ovol.d --steps 1:3 -o a%d.png",
            "--steps: expected steps from 0 to 2, the last in s.ovol.d, found 3",
        ),
        ("s.ovol.d --steps 7: -o a%d.png", "found 7"),
        ("s.ovol.d --steps 0:2 -o a.png", "--output a.png: expected a name with a place for the number"),
        ("s.ovol.d --steps 0:2 -o a%d%d.png", "like frame_%04d.png"),
        ("s.ovol.d --steps 2:0 -o a%d.png", "two steps in ascending order, found '2:0'"),
        ("s.ovol.d --steps 0:2:0 -o a%d.png", "'--steps <A:B[:S]>'"),
        ("s.ovol.d --steps 0:2 --step 1 -o a%d.png", "cannot be used with"),
        ("s.ovol.d --step -1 -o a.png", "-1"),
        ("s.ovol.d --step 1 --dims 1,2,3 -o a.png", "a series needs no flags that describe an input"),
        ("s.ovol.d --steps 0:2 -o a%d.jpg", ".png or .exr"),
        ("s.ovol.d --steps 0:2 -o a%d.png --stats a1.png", "a1.png: given as the picture and as the --stats"),
        (
            "s1.raw --step 1 -o a.png",
            "--step: expected a series, a folder ending in .ovol.d or one of plotfiles, found s1.raw",
        ),
        ("s1.raw --steps 0:1 -o a%d.png", "--steps: expected a series"),
    ] {
        sandbox.fails(2, &format!("render {line}"), &[part]);
    }
    sandbox.fails(1, "render s.ovol.d --steps 0:1 -o gone/a%d.png", &["there is no folder gone"]);
    sandbox.fails(
        1,
        "render s.ovol.d --step 0 -o a.png --stats s.ovol.d/s1.ovol",
        &["s1.ovol: is an input and would be overwritten"],
    );
    sandbox.fails(1, "render gone.ovol.d --step 0 -o a.png", &["gone.ovol.d: cannot be read as a folder"]);
}

#[test]
fn simulations_load() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/series");
    if !folder.is_dir() {
        return println!("SKIPPED: there is no {}", folder.display());
    }
    let sandbox = Sandbox::new();
    for (name, count, isovalues, bounds) in
        [("fingers", 10, [20, 60], "64x64x64 f32"), ("isabel", 6, [25, 40], "125x125x25 f32")]
    {
        let pattern = folder.join(name).join(format!("{name}_*.vti"));
        let outcome = sandbox.run(["build", pattern.to_str().unwrap(), "-o", &format!("{name}.ovol.d")]);
        assert!(outcome.code == 0 && outcome.stdout.contains(bounds), "{outcome:?}");
        let text = sandbox.succeeds(&format!("check {name}.ovol.d"));
        assert!(text.contains(&format!("{name}.ovol.d: sound: {count} steps of {bounds} samples")), "{text}");
        for isovalue in isovalues {
            let (last, output) = (count - 1, format!("{name}_{isovalue}_%d.png"));
            let line = format!("render {name}.ovol.d --isovalue {isovalue} --size 48x48 -o {output}");
            sandbox.succeeds(&format!("{line} --steps 0:{last}:{last} --stats s.json"));
            let json: serde_json::Value = serde_json::from_slice(&sandbox.read("s.json")).unwrap();
            assert!((0..2).all(|n| json[n]["hits"].as_u64() >= Some(10)), "{name} at {isovalue}: {json}");
        }
    }
}
