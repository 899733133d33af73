//! Patches that do not make a mesh.

use glam::DAffine3;
use isoray_amr::{Centering, Mesh, MeshError, MeshOptions, Patch, Patches};

fn patch(level: u32, low: [i32; 3], cells: [u32; 3]) -> Patch {
    let count: u32 = cells.iter().product();
    Patch { level, low, cells, values: vec![1.0; count as usize].into() }
}

fn refusal(patches: Vec<Patch>) -> MeshError {
    let patches = Patches {
        centering: Centering::Cells,
        ratios: vec![2, 4],
        index_to_world: DAffine3::IDENTITY,
        domain: ([0; 3], [4; 3]),
        patches,
    };
    Mesh::new(&patches, MeshOptions::default()).unwrap_err()
}

#[test]
fn what_is_wrong_is_named() {
    let all = || patch(0, [0; 3], [4; 3]);
    let cases = [
        (refusal(vec![all(), patch(3, [0; 3], [2; 3])]), "patch 1: expected a level below 3, found 3"),
        (
            refusal(vec![all(), patch(1, [0; 3], [2, 0, 2])]),
            "patch 1 of level 1: expected cells along each axis, found 2x0x2",
        ),
        (
            refusal(vec![Patch { values: vec![0.0; 63].into(), ..all() }]),
            "patch 0 of level 0: expected 64 values, found 63",
        ),
        (
            refusal(vec![all(), patch(1, [6, 0, 0], [4, 2, 2])]),
            "patch 1 of level 1: expected cells of the domain, (0, 0, 0) to (7, 7, 7), found (6, 0, 0) to (9, 1, 1)",
        ),
        (
            refusal(vec![all(), Patch { values: vec![2.0; 8].into(), ..patch(0, [2; 3], [2; 3]) }]),
            "patches 0 and 1 of level 0: expected the same values where they overlap, found 1 and 2 at (2, 2, 2)",
        ),
        (
            refusal(vec![all(), patch(1, [1, 0, 0], [2, 2, 2])]),
            "patch 1 of level 1: expected to cover whole cells of level 0, found that it cuts (0, 0, 0)",
        ),
        (
            refusal(vec![patch(0, [0; 3], [4, 4, 3])]),
            "expected patches all over the domain, found none over the cells (0, 0, 24) to (31, 31, 31) of level 2",
        ),
    ];
    for (error, text) in cases {
        assert_eq!(error.to_string(), text);
    }
}
