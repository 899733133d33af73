//! Meshes that are coarser where that does.

use isoray_amr::{Centering, Mesh, MeshOptions, Patches};
use isoray_oracle::{AmrKind, SplitMix64, adversarial_averages, adversarial_corners};

use crate::continuity::assert_continuous;
use crate::linear::{assert_linear, linear};
use crate::meshes::{DOMAIN, KINDS, Kind, mesh, noise};
use crate::oracle;

const CENTERINGS: [Centering; 2] = [Centering::Vertices, Centering::Cells];

/// Boxes of more cells than those that patches are cut into.
const BROAD: Kind = Kind { ratios: &[2, 4], chance: 0.9, group: 8 };

/// Random patches and random octrees, by number, with values that agree nowhere.
fn all_meshes(centering: Centering, seed: u64) -> Vec<(String, Patches)> {
    let mut all = Vec::new();
    for kind in KINDS.into_iter().chain([BROAD]) {
        let patches = mesh(kind, centering, seed, |p, level| noise(p, level, seed));
        all.push((format!("{kind:?}, {centering:?}, {seed}"), patches));
    }
    for kind in AmrKind::ALL {
        let cells = kind.generate(seed);
        let patches = match centering {
            Centering::Vertices => {
                oracle::patches(&adversarial_corners(&cells, seed), centering, |corners| {
                    corners.map(|c| c as f32).to_vec()
                })
            }
            Centering::Cells => oracle::patches(&adversarial_averages(&cells, seed), centering, |&average| {
                vec![average as f32]
            }),
        };
        all.push((format!("{kind:?}, {centering:?}, {seed}"), patches));
    }
    all
}

fn edge(patches: &Patches, level: u32) -> f64 {
    patches.ratios[..level as usize].iter().map(|&r| 1.0 / f64::from(r)).product()
}

fn distance(eye: [f64; 3], [low, high]: [[f64; 3]; 2]) -> f64 {
    (0..3).map(|a| (low[a] - eye[a]).max(eye[a] - high[a]).max(0.0).powi(2)).sum::<f64>().sqrt()
}

/// What a distance leaves of patches: cells of an edge of up to `ratio` times theirs from an eye.
fn cut(patches: &Patches, eye: [f64; 3], ratio: f64) -> Patches {
    let is_fine_enough = |level, place| edge(patches, level) <= ratio * distance(eye, place);
    patches.clone().coarsened(is_fine_enough).unwrap()
}

/// The finest level at a point, in coordinates of level 0.
fn level_at(patches: &Patches, p: [f64; 3]) -> Option<u32> {
    let has = |level: u32, low: [i32; 3], cells: [u32; 3]| {
        let edge = edge(patches, level);
        (0..3).all(|a| {
            let along = p[a] / edge - f64::from(low[a]);
            along >= 0.0 && along < f64::from(cells[a])
        })
    };
    patches.patches.iter().filter(|patch| has(patch.level, patch.low, patch.cells)).map(|p| p.level).max()
}

#[test]
fn any_cut_makes_a_continuous_mesh() {
    for centering in CENTERINGS {
        for seed in 0..12 {
            for (what, patches) in all_meshes(centering, seed) {
                let whole = Mesh::new(&patches, MeshOptions::default()).unwrap();
                let mut random = SplitMix64::new(seed);
                let eye = patches.domain.1.map(|n| random.range(-1.0, 2.0) * f64::from(n));
                let ratio = random.range(0.0, 1.0);
                // By a distance, and by no order at all.
                let is_any = |level: u32, [low, _]: [[f64; 3]; 2]| noise(low, level, seed) > -0.5;
                for cut in [cut(&patches, eye, ratio), patches.clone().coarsened(is_any).unwrap()] {
                    let mesh = Mesh::new(&cut, MeshOptions::default());
                    let mesh = mesh.unwrap_or_else(|error| panic!("{error}: {what}"));
                    assert_eq!(mesh.dims(), whole.dims());
                    assert_eq!(mesh.index_to_world(), whole.index_to_world());
                    let cells = |mesh: &Mesh| mesh.size().leaves.iter().sum::<u64>();
                    assert!(cells(&mesh) <= cells(&whole), "{what}");
                    assert_continuous(&mesh, seed, 500, &what);
                }
            }
        }
    }
}

#[test]
fn cells_are_as_fine_as_is_wanted() {
    let mut coarser = 0;
    for centering in CENTERINGS {
        for seed in 0..12 {
            for (what, patches) in all_meshes(centering, seed) {
                let mut random = SplitMix64::new(seed);
                let (low, cells) = patches.domain;
                let point = |random: &mut SplitMix64, margin: f64| -> [f64; 3] {
                    std::array::from_fn(|a| {
                        f64::from(low[a]) + random.range(-margin, 1.0 + margin) * f64::from(cells[a])
                    })
                };
                let eye = point(&mut random, 0.5);
                let ratio = random.range(0.05, 0.5);
                let cut = cut(&patches, eye, ratio);
                for _ in 0..200 {
                    let p = point(&mut random, 0.0);
                    let [before, after] = [&patches, &cut].map(|of| level_at(of, p).unwrap());
                    assert!(after <= before, "{what}");
                    coarser += u32::from(after < before);
                    let is_enough = edge(&patches, after) <= ratio * distance(eye, [p, p]);
                    assert!(after == before || is_enough, "level {after} for {before} at {p:?}: {what}");
                }
            }
        }
    }
    assert!(coarser > 5000, "{coarser}");
}

#[test]
fn nothing_or_everything_is_left_out() {
    for centering in CENTERINGS {
        for seed in 0..6 {
            for (what, patches) in all_meshes(centering, seed) {
                let same = patches.clone().coarsened(|_, _| false).unwrap();
                // Values that are not finite are equal to none.
                assert!(format!("{same:?}") == format!("{patches:?}"), "{what}");
                let coarsest = patches.clone().coarsened(|_, _| true).unwrap();
                assert!(coarsest.patches.iter().all(|patch| patch.level == 0), "{what}");
            }
        }
    }
}

#[test]
fn linear_fields_stay_exact() {
    for kind in KINDS.into_iter().chain([BROAD]) {
        for centering in CENTERINGS {
            for seed in 0..6 {
                let patches = mesh(kind, centering, seed, |p, _| linear(p) as f32);
                for n in 1..4u32 {
                    let cut = cut(&patches, [-3.0, -1.0, 2.0], 0.1 * f64::from(n));
                    assert_linear(
                        &Mesh::new(&cut, MeshOptions::default()).unwrap(),
                        seed,
                        &format!("{kind:?}"),
                    );
                }
            }
        }
    }
}

#[test]
fn octrees_are_merged_into_parents() {
    for kind in [AmrKind::Balanced, AmrKind::Unbalanced, AmrKind::MixedRatios] {
        for centering in CENTERINGS {
            for seed in 0..6 {
                let cells = kind.generate(seed);
                let values =
                    cells.map(|leaf| samples(leaf.low.map(f64::from), f64::from(leaf.edge), centering));
                let patches = oracle::patches(&values, centering, Vec::clone);
                let coarsest = patches.coarsened(|_, _| true).unwrap();
                let edge = coarsest.index_to_world.matrix3.x_axis.x;
                for patch in &coarsest.patches {
                    assert_eq!(patch.cells, [1; 3]);
                    // The values at vertices are those that they had; a mean of a linear field is that in the middle.
                    let expected = samples(patch.low.map(|c| f64::from(c) * edge), edge, centering);
                    for (found, expected) in patch.values.iter().zip(expected) {
                        let error = (found - expected).abs();
                        assert!(
                            error <= 128.0 * f32::EPSILON,
                            "{found} for {expected}: {kind:?}, {centering:?}"
                        );
                    }
                }
            }
        }
    }
}

/// What a linear field has in a cell or at its vertices.
fn samples(low: [f64; 3], edge: f64, centering: Centering) -> Vec<f32> {
    let at = |shift: [f64; 3]| linear(std::array::from_fn(|a| low[a] + shift[a] * edge)) as f32;
    match centering {
        Centering::Cells => vec![at([0.5; 3])],
        Centering::Vertices => (0..8).map(|n| at(std::array::from_fn(|a| f64::from(n >> a & 1)))).collect(),
    }
}

#[test]
fn cells_that_are_not_finite_are_no_cover() {
    let kind = Kind { ratios: &[2], chance: 0.5, group: 2 };
    for centering in CENTERINGS {
        // As a code that leaves out what finer levels have.
        let mut patches = mesh(kind, centering, 7, |p, _| linear(p) as f32);
        assert_eq!(patches.patches[0].cells, DOMAIN.1);
        let count = patches.patches[0].values.len();
        patches.patches[0].values = vec![f32::NAN; count].into();
        let fine = patches.patches.len();
        let cut = patches.coarsened(|_, _| true).unwrap();
        assert_eq!(cut.patches.len(), fine);
    }
}
