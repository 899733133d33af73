//! Fields that are linear.

use glam::DVec3;
use isoray_amr::{Border, Centering, Mesh, MeshOptions, SplitRule};
use isoray_oracle::SplitMix64;

use crate::meshes::{KINDS, mesh};

pub(crate) fn linear(p: [f64; 3]) -> f64 {
    0.25 + 0.5 * p[0] - 1.25 * p[1] + 0.75 * p[2]
}

#[test]
fn linear_fields_are_exact() {
    for kind in KINDS {
        for centering in [Centering::Vertices, Centering::Cells] {
            for seed in 0..8 {
                let patches = mesh(kind, centering, seed, |p, _| linear(p) as f32);
                for rule in [SplitRule::Homogeneity, SplitRule::SurfaceArea] {
                    let mesh = Mesh::new(&patches, MeshOptions { rule, ..MeshOptions::default() }).unwrap();
                    assert_linear(&mesh, seed, &format!("{kind:?}, {centering:?}, {seed}"));
                }
            }
        }
    }
}

pub(crate) fn assert_linear(mesh: &Mesh, seed: u64, what: &str) {
    let mut random = SplitMix64::new(seed);
    for _ in 0..300 {
        let high = mesh.dims().axes().map(|n| f64::from(n - 1));
        let p = high.map(|n| random.range(0.0, 1.0) * n);
        let found = mesh.value(p, 7).unwrap();
        let world = mesh.index_to_world().transform_point3(DVec3::from(p)).to_array();
        // Values up to 16, of 24 bits, some roundings each.
        let error = (found - linear(world)).abs();
        assert!(error < 16.0 * 8.0 * f64::from(f32::EPSILON), "{error} at {p:?}: {what}");
    }
}

#[test]
fn constants_stay_as_they_are() {
    for kind in KINDS {
        for centering in [Centering::Vertices, Centering::Cells] {
            for border in [Border::Linear, Border::Bounded] {
                let patches = mesh(kind, centering, 3, |_, _| 0.1);
                let mesh = Mesh::new(&patches, MeshOptions { border, ..MeshOptions::default() }).unwrap();
                assert_eq!(mesh.range(), Some([0.1; 2]), "{kind:?}, {centering:?}, {border:?}");
            }
        }
    }
}
