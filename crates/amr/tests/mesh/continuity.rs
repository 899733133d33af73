//! Both sides of every face.

use isoray_amr::{Centering, Mesh, MeshOptions};
use isoray_oracle::SplitMix64;

use crate::meshes::{KINDS, mesh, noise};

#[test]
fn all_sides_of_a_point_agree() {
    for kind in KINDS {
        for centering in [Centering::Vertices, Centering::Cells] {
            for seed in 0..8 {
                let patches = mesh(kind, centering, seed, |p, level| noise(p, level, seed));
                let mesh = Mesh::new(&patches, MeshOptions::default()).unwrap();
                assert_continuous(&mesh, seed, 3000, &format!("{kind:?}, {centering:?}, {seed}"));
            }
        }
    }
}

/// At random points of planes of the lattice, one, two or three; within the range of all values.
pub(crate) fn assert_continuous(mesh: &Mesh, seed: u64, points: usize, what: &str) {
    let mut random = SplitMix64::new(seed);
    let [low, high] = mesh.range().unwrap_or_default().map(f64::from);
    for _ in 0..points {
        let kinds = 1 + random.below(3);
        let p: [f64; 3] = std::array::from_fn(|a| {
            let n = f64::from(mesh.dims().axes()[a] - 1);
            let at = random.range(0.0, 1.0) * n;
            if (a as u32) < kinds { at.round() } else { at }
        });
        let values: Vec<f64> = (0..8).filter_map(|octant| mesh.value(p, octant)).collect();
        let bounds = [f64::min, f64::max].map(|f| values.iter().copied().reduce(f));
        // Cells may be empty.
        let [Some(least), Some(most)] = bounds else { continue };
        let rounding = 8.0 * f64::from(f32::EPSILON) * low.abs().max(high.abs());
        assert!(most - least <= rounding, "{values:?} at {p:?}: {what}");
        assert!(least >= low - rounding && most <= high + rounding);
    }
}
