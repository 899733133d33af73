//! The field against the oracle's, which is computed another way.

use glam::DAffine3;
use isoray_amr::{Border, Centering, Mesh, MeshOptions, OctreeLeaf, Patches};
use isoray_oracle::{
    AmrCells, AmrKind, AmrLattice, SplitMix64, adversarial_averages, adversarial_corners, vertex_values,
};

/// One patch for each leaf, and one that is empty for each cell of the smallest size that none covers.
pub(crate) fn patches<T>(
    mesh: &AmrCells<T>,
    centering: Centering,
    values: impl Fn(&T) -> Vec<f32>,
) -> Patches {
    let least = *mesh.edges().last().unwrap();
    let leaf = |low, edge, values| OctreeLeaf { low, edge, values };
    let mut all: Vec<_> = mesh.leaves().iter().map(|of| leaf(of.low, of.edge, values(&of.value))).collect();
    let count = if centering == Centering::Cells { 1 } else { 8 };
    let [nx, ny, nz] = mesh.dims();
    for z in (0..nz).step_by(least as usize) {
        for y in (0..ny).step_by(least as usize) {
            for x in (0..nx).step_by(least as usize) {
                if mesh.find([x, y, z]).is_none() {
                    all.push(leaf([x, y, z], least, vec![f32::NAN; count]));
                }
            }
        }
    }
    Patches::of_leaves(centering, DAffine3::IDENTITY, mesh.dims(), all)
}

/// Everywhere: in the domain, on its border, on faces, edges and vertices.
fn compare(mesh: &Mesh, lattice: &AmrLattice, least: u32, seed: u64, what: &str) {
    let mut random = SplitMix64::new(seed);
    let range = mesh.range().unwrap_or_default();
    let rounding = 16.0 * f64::from(f32::EPSILON) * f64::from(range[0].abs().max(range[1].abs()));
    let mut compared = 0;
    for _ in 0..2000 {
        let kinds = random.below(4);
        let p: [f64; 3] = std::array::from_fn(|a| {
            let at = random.range(0.0, 1.0) * f64::from(mesh.dims().axes()[a] - 1);
            if (a as u32) < kinds { at.round() } else { at }
        });
        // The mesh counts in its own finest cells.
        let expected = lattice.value(p.map(|c| c * f64::from(least)));
        let found: Vec<f64> = (0..8).filter_map(|octant| mesh.value(p, octant)).collect();
        // On a face of an empty cell the oracle may look at that.
        for value in found.iter().filter(|_| expected.is_finite()) {
            assert!((value - expected).abs() <= rounding, "{value} for {expected} at {p:?}: {what}");
            compared += 1;
        }
        assert!(!found.is_empty() || !expected.is_finite(), "nothing for {expected} at {p:?}: {what}");
    }
    assert!(compared > 1000, "{compared}: {what}");
}

#[test]
fn fields_of_vertices_are_the_oracles() {
    for kind in AmrKind::ALL {
        for seed in 0..6 {
            let cells = adversarial_corners(&kind.generate(seed), seed);
            let least = *cells.edges().last().unwrap();
            let patches = patches(&cells, Centering::Vertices, |corners| corners.map(|c| c as f32).to_vec());
            let mesh = Mesh::new(&patches, MeshOptions::default()).unwrap();
            compare(&mesh, &AmrLattice::new(&cells), least, seed, &format!("{kind:?}, {seed}"));
        }
    }
}

#[test]
fn fields_of_averages_are_the_oracles() {
    for kind in AmrKind::ALL {
        for border in [Border::Linear, Border::Bounded] {
            for seed in 0..6 {
                let cells = adversarial_averages(&kind.generate(seed), seed);
                let least = *cells.edges().last().unwrap();
                let patches = patches(&cells, Centering::Cells, |&average| vec![average as f32]);
                let mesh = Mesh::new(&patches, MeshOptions { border, ..MeshOptions::default() }).unwrap();
                let rule = match border {
                    Border::Linear => isoray_oracle::Border::Linear,
                    Border::Bounded => isoray_oracle::Border::Bounded,
                };
                let lattice = AmrLattice::new(&vertex_values(&cells, rule));
                compare(&mesh, &lattice, least, seed, &format!("{kind:?}, {border:?}, {seed}"));
            }
        }
    }
}
