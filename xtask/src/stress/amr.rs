//! Adaptive meshes: the same field from all sides of a point, linear fields, ranges, and rays that lose no change of side.

use std::ops::Range;

use anyhow::{Result, bail};
use glam::DAffine3;
use isoray_amr::{Centering, Mesh, MeshOptions, MeshTracer, OctreeLeaf, Patches};
use isoray_oracle::{
    AmrCells, AmrKind, OracleRay, SplitMix64, adversarial_averages, adversarial_corners,
    adversarial_isovalue, adversarial_ray,
};
use isoray_trace::{Ray, Trace};
use serde::{Deserialize, Serialize};

use super::shard;
use super::traverse::Sides;

/// Meshes whose domain is covered: what is not has no field.
const KINDS: [AmrKind; 6] = [
    AmrKind::Uniform,
    AmrKind::SingleOct,
    AmrKind::Balanced,
    AmrKind::Unbalanced,
    AmrKind::RatioFour,
    AmrKind::MixedRatios,
];

/// Points, and rays, that are tried with one mesh.
const PER_MESH: u64 = 512;

/// Roundings between two computations of one value, in units of 2⁻²³ of the largest: of a vertex, of three middles that hang on each other for each of up to five levels, and of
/// the interpolant.
const ROUNDINGS: f64 = 16.0;

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct Tally {
    meshes: u64,
    points: u64,
    /// Of which some cells that meet do not agree.
    torn: u64,
    /// At which a linear field is another.
    bent: u64,
    /// At which the field is outside of the range by which rays pass by.
    outside: u64,
    rays: u64,
    cells: u64,
    crossings: u64,
    /// Crossings at faces.
    jumps: u64,
    slips: u64,
    offending: shard::Offending,
}

impl shard::Tally for Tally {
    fn merge(&mut self, other: Self) {
        self.meshes += other.meshes;
        self.points += other.points;
        self.torn += other.torn;
        self.bent += other.bent;
        self.outside += other.outside;
        self.rays += other.rays;
        self.cells += other.cells;
        self.crossings += other.crossings;
        self.jumps += other.jumps;
        self.slips += other.slips;
        self.offending.merge(other.offending);
    }
}

pub(crate) fn run(args: &shard::Args) -> Result<()> {
    let tally = args.run("amr", |inputs| block(inputs, args.seed))?;
    let Tally { meshes, points, torn, bent, outside, rays, cells, crossings, jumps, slips, offending } =
        &tally;
    println!(
        "{meshes} meshes, {points} points on faces, edges and vertices: {torn} torn, {bent} bent, {outside} outside of ranges; \
         {rays} rays, {cells} cells, {crossings} crossings, {jumps} at faces alone: {slips} slips"
    );
    match tally.failures() {
        0 => Ok(()),
        n => bail!("{n} failures; offending inputs:\n{offending}"),
    }
}

/// As [`run`], a few of them: `count` points and as many rays.
pub(super) fn few(count: u64, seed: u64) -> shard::Outcome {
    let tally = shard::few(count, PER_MESH, |inputs| block(inputs, seed));
    shard::Outcome {
        cases: tally.points + tally.rays,
        doubtful: None,
        failures: tally.failures(),
        offending: tally.offending,
    }
}

fn block(inputs: Range<u64>, seed: u64) -> Tally {
    let mut tally = Tally::default();
    for first in inputs.clone().step_by(PER_MESH as usize) {
        tally.try_mesh(seed << 40 | first, inputs.end.min(first + PER_MESH) - first);
    }
    tally
}

impl Tally {
    fn failures(&self) -> u64 {
        self.torn + self.bent + self.outside + self.slips
    }

    fn try_mesh(&mut self, seed: u64, count: u64) {
        let (kind, is_of_cells) = kind_of(seed);
        let shape = kind.generate(seed);
        let noise = match is_of_cells {
            true => mesh(&adversarial_averages(&shape, seed), Centering::Cells, |&v| vec![v as f32]),
            false => mesh(&adversarial_corners(&shape, seed), Centering::Vertices, |v| {
                v.map(|v| v as f32).to_vec()
            }),
        };
        let linear = linear_mesh(&shape, is_of_cells);
        self.meshes += 1;
        let what = format!("{kind:?}, seed {seed}");
        let mut random = SplitMix64::new(seed);
        for _ in 0..count {
            self.try_point(&noise, linear.as_ref(), &mut random, &what);
        }
        let values: Vec<f32> =
            (0..64).filter_map(|_| noise.value(point(&noise, &mut random), 0)).map(|v| v as f32).collect();
        let mut tracer = MeshTracer::new(&noise);
        for n in 0..count {
            let isovalue = adversarial_isovalue(&values, seed + n % 4);
            let OracleRay { origin, direction, t_min, t_max } =
                adversarial_ray(noise.dims().axes(), seed ^ n << 20);
            let ray = Ray { origin, direction, t_min, t_max };
            let mut sides = Sides::default();
            tracer.trace(&ray, isovalue, &mut sides, &mut ());
            self.rays += 1;
            self.cells += sides.cells;
            self.crossings += sides.crossings;
            self.jumps += sides.jumps;
            self.slips += sides.slips;
            if sides.slips > 0 {
                self.offending.keep(&format!("{what}, isovalue {isovalue}"), &ray);
            }
        }
    }

    fn try_point(&mut self, noise: &Mesh, linear: Option<&Mesh>, random: &mut SplitMix64, what: &str) {
        let p = point(noise, random);
        let [low, high] = noise.range().unwrap_or_default().map(f64::from);
        let rounding = ROUNDINGS * f64::from(f32::EPSILON) * low.abs().max(high.abs());
        let values = |mesh: &Mesh| (0..8).filter_map(|octant| mesh.value(p, octant)).collect::<Vec<f64>>();
        let found = values(noise);
        let least = found.iter().copied().fold(f64::INFINITY, f64::min);
        let most = found.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        self.points += 1;
        let is_torn = most - least > rounding;
        let is_outside = (0..8).any(|octant| {
            let range = noise.range_around(p, octant).map(|range| range.map(f64::from));
            noise
                .value(p, octant)
                .zip(range)
                .is_some_and(|(value, [low, high])| value < low - rounding || value > high + rounding)
        });
        let is_bent = linear.is_some_and(|mesh| {
            values(mesh)
                .iter()
                .any(|value| (value - of_place(p)).abs() > ROUNDINGS * f64::from(f32::EPSILON) * LARGEST)
        });
        self.torn += u64::from(is_torn);
        self.outside += u64::from(is_outside);
        self.bent += u64::from(is_bent);
        if is_torn || is_outside || is_bent {
            self.offending.keep(what, &(p, &found));
        }
    }
}

/// The kind of the mesh with this seed, and whether its values are of cells: all kinds in turn with the one, and then with the other.
fn kind_of(seed: u64) -> (AmrKind, bool) {
    let kinds = KINDS.len() as u64;
    let n = seed / PER_MESH;
    (KINDS[(n % kinds) as usize], n / kinds % 2 == 1)
}

/// On one, two or three planes of the lattice.
fn point(mesh: &Mesh, random: &mut SplitMix64) -> [f64; 3] {
    let planes = 1 + random.below(7);
    std::array::from_fn(|a| {
        let at = random.range(0.0, 1.0) * f64::from(mesh.dims().axes()[a] - 1);
        if planes >> a & 1 == 1 { at.round() } else { at }
    })
}

/// A linear field, by place, and more than it is anywhere.
fn of_place([x, y, z]: [f64; 3]) -> f64 {
    1.0 + 0.5 * x - 0.25 * y + 0.125 * z
}
const LARGEST: f64 = 256.0;

/// The mesh with a linear field; averages are exact where there is another cell along each axis.
fn linear_mesh(shape: &AmrCells<()>, is_of_cells: bool) -> Option<Mesh> {
    let [least, largest] = [shape.edges().last()?, shape.edges().first()?];
    if is_of_cells && shape.dims().iter().any(|n| n / largest < 2) {
        return None;
    }
    let place = |p: [f64; 3]| of_place(p.map(|c| c / f64::from(*least))) as f32;
    let leaf = |of: &isoray_oracle::AmrLeaf<()>| OctreeLeaf {
        low: of.low,
        edge: of.edge,
        values: match is_of_cells {
            true => vec![place(of.centre())],
            false => (0..8).map(|n| place(of.corner(n).map(f64::from))).collect(),
        },
    };
    let centering = if is_of_cells { Centering::Cells } else { Centering::Vertices };
    let leaves = shape.leaves().iter().map(leaf);
    let patches = Patches::of_leaves(centering, DAffine3::IDENTITY, shape.dims(), leaves);
    Mesh::new(&patches, MeshOptions::default()).ok()
}

fn mesh<T>(cells: &AmrCells<T>, centering: Centering, values: impl Fn(&T) -> Vec<f32>) -> Mesh {
    let leaves =
        cells.leaves().iter().map(|of| OctreeLeaf { low: of.low, edge: of.edge, values: values(&of.value) });
    let patches = Patches::of_leaves(centering, DAffine3::IDENTITY, cells.dims(), leaves);
    Mesh::new(&patches, MeshOptions::default()).expect("the oracle's meshes cover their domain")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_has_either_values() {
        // As many as are tried in a short run of the benchmarks, with a seed in their place.
        let seen: Vec<_> = (0..24).map(|n| kind_of((2006 << 40) | (n * PER_MESH))).collect();
        let tried = |wanted| seen.iter().filter(|pair| **pair == wanted).count();
        for kind in KINDS {
            assert_eq!([false, true].map(|is_of_cells| tried((kind, is_of_cells))), [2, 2], "{kind:?}");
        }
    }
}
