//! What is wrong but no reason to stop: exit code 0, the picture is written, one warning says it.

use crate::files::{ball, floats, nrrd};
use crate::sandbox::Sandbox;

/// The warnings of a render that must write its picture all the same.
fn warned(sandbox: &Sandbox, line: &str) -> String {
    let outcome = sandbox.line(&format!("render {line} --size 8x8 -o out.png"));
    assert_eq!(outcome.code, 0, "{line}: {outcome:?}");
    assert!(outcome.stderr.lines().all(|l| l.starts_with("warning: ")), "{outcome:?}");
    assert!(sandbox.names().contains(&"out.png".to_owned()));
    std::fs::remove_file(sandbox.path("out.png")).unwrap();
    outcome.stderr
}

#[test]
fn samples_that_are_not_finite_are_counted() {
    let bytes = floats(|s| {
        s[0] = f32::NAN;
        s[5] = f32::INFINITY;
        s[63] = f32::NEG_INFINITY;
    });
    let sandbox = Sandbox::with("a.nrrd", &bytes);
    let line = "warning: a.nrrd: 3 of 64 samples are NaN or infinite; the cells that touch them are empty\n";
    assert_eq!(warned(&sandbox, "a.nrrd --isovalue 30.5"), line);
    let outcome = sandbox.line("build a.nrrd -o a.ovol");
    assert_eq!((outcome.code, outcome.stderr.as_str()), (0, line));
    assert!(warned(&sandbox, "a.ovol --isovalue 30.5").contains("a.ovol: 3 of 64 samples"));
    assert!(sandbox.line("info a.ovol").stdout.contains("3 samples"));
}

#[test]
fn no_finite_sample_at_all() {
    let sandbox = Sandbox::with("a.nrrd", &floats(|s| s.fill(f32::NAN)));
    let stderr = warned(&sandbox, "a.nrrd --isovalue 1");
    assert!(stderr.contains("64 of 64") && stderr.contains("no sample is finite"), "{stderr}");
    assert!(warned(&sandbox, "a.nrrd").contains("no sample is finite"));
}

#[test]
fn isovalue_outside_the_range() {
    let sandbox = Sandbox::with("a.nrrd", &floats(|_| ()));
    for isovalue in ["63.01", "1e9", "-300", "0"] {
        let stderr = warned(&sandbox, &format!("a.nrrd --isovalue {isovalue}"));
        assert!(stderr.contains("the values range from 0 to 63"), "{isovalue}: {stderr}");
    }
    for isovalue in ["63", "0.001", "12"] {
        assert_eq!(warned(&sandbox, &format!("a.nrrd --isovalue {isovalue}")), "");
    }
    sandbox.write("b.nrrd", &floats(|s| s.fill(5.0)));
    assert!(warned(&sandbox, "b.nrrd").contains("the values range from 5 to 5"), "no isovalue to propose");
}

#[test]
fn data_longer_than_the_header_says() {
    let body = [ball().as_slice(), &[1, 2, 3]].concat();
    let sandbox = Sandbox::with("a.nrrd", &nrrd("12 10 11", "uint8", "raw", &body));
    let expected = "warning: a.nrrd: 3 bytes after the last sample are ignored\n";
    assert_eq!(warned(&sandbox, "a.nrrd --isovalue 100"), expected);
    sandbox.write("a.raw", &body);
    let stderr = warned(&sandbox, "a.raw --dims 12,10,11 --type u8 --isovalue 100");
    assert_eq!(stderr, expected.replace("nrrd", "raw"));
}

#[test]
fn volumes_without_cells() {
    let sandbox = Sandbox::with("a.raw", &ball());
    for dims in ["1,1,1320", "1320,1,1", "12,110,1", "1,1,1"] {
        let stderr = warned(&sandbox, &format!("a.raw --dims {dims} --type u8 --isovalue 100"));
        assert!(stderr.contains("no cells"), "{dims}: {stderr}");
    }
}
