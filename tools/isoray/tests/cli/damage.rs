//! Damaged `.ovol` files.

use crate::files::with_ovol;

/// Length of header and section table of `ball.ovol`: caps and two levels of nodes.
const BODY: usize = 2304 + 3 * 32;

#[test]
fn a_damaged_header_is_refused_by_every_command() {
    let sandbox = with_ovol();
    let sound = sandbox.read("ball.ovol");
    for at in (0..BODY).step_by(61).chain([8, 12, 16, 28, 128, 152, 164, 2304, 2312, BODY - 1]) {
        let mut bytes = sound.clone();
        bytes[at] ^= 0xff;
        sandbox.write("bad.ovol", &bytes);
        for line in ["info bad.ovol", "check bad.ovol", "render bad.ovol --isovalue 9 -o out.png"] {
            sandbox.fails(1, line, &["error: bad.ovol: "]);
        }
    }
}

#[test]
fn a_truncated_or_padded_file_is_refused_by_every_command() {
    let sandbox = with_ovol();
    let sound = sandbox.read("ball.ovol");
    let padded = [sound.as_slice(), &[0]].concat();
    let cut = [1, 7, 8, 100, 2303, 2304, BODY, sound.len() / 2 + BODY / 2, sound.len() - 1];
    for bytes in cut.iter().map(|&n| &sound[..n]).chain([padded.as_slice()]) {
        sandbox.write("bad.ovol", bytes);
        for line in ["info bad.ovol", "check bad.ovol", "render bad.ovol --isovalue 9 -o out.png"] {
            sandbox.fails(1, line, &["error: bad.ovol: "]);
        }
    }
}

#[test]
fn a_damaged_body_is_refused_by_check_and_survived_by_render() {
    let sandbox = with_ovol();
    let sound = sandbox.read("ball.ovol");
    assert!(sound.len() > BODY + 1000);
    for at in (BODY..sound.len()).step_by(53).chain([sound.len() - 5, sound.len() - 1]) {
        let mut bytes = sound.clone();
        bytes[at] ^= 0xff;
        sandbox.write("bad.ovol", &bytes);
        sandbox.fails(1, "check bad.ovol", &["error: bad.ovol: damaged"]);
        let outcome =
            sandbox.line("render bad.ovol --isovalue 100 --size 16x16 --normals central -o out.png");
        assert!([0, 1].contains(&outcome.code), "byte {at}: {outcome:?}");
        assert_eq!(outcome.code == 0, sandbox.names().contains(&"out.png".to_owned()), "byte {at}");
        if outcome.code == 0 {
            std::fs::remove_file(sandbox.path("out.png")).unwrap();
        }
    }
}

#[test]
fn a_body_of_noise_is_survived() {
    let sandbox = with_ovol();
    let mut bytes = sandbox.read("ball.ovol");
    let mut state = 1_u32;
    for byte in &mut bytes[BODY..] {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        *byte = (state >> 24) as u8;
    }
    sandbox.write("bad.ovol", &bytes);
    sandbox.fails(1, "check bad.ovol", &["bad.ovol: damaged"]);
    for isovalue in [1, 60, 128, 255] {
        let line = format!("render bad.ovol --isovalue {isovalue} --size 32x32 --stats -o out.exr");
        assert!([0, 1].contains(&sandbox.line(&line).code));
    }
}
