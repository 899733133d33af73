//! Rays through every structure and with every policy against the oracle: first and all crossings, several surfaces, shadows.

use std::ops::ControlFlow;

use anyhow::Result;
use isoray_grid::{BrickSizes, BrickedVolume, DenseVolume, GridVolume, Scalar};
use isoray_oracle::{DenseLattice, OracleRay, SplitMix64, judge_all};
use isoray_trace::{CountHits, Crossing, GridTracer, Hit, Ray, Trace, Tracer};
use rayon::prelude::*;

use super::verify::lattice;
use crate::catalog::{Dense, DenseVisitor, Entry, Place};
use crate::for_oracle;

/// Titles of the columns.
pub(crate) const HEADER: &str = "rays, all crossings and shadows                      rays compared crossings  wrong | shadows compared occluded  wrong | unlike in grids over array  bricks  octree";

/// Rays that one thread follows with one tracer.
const RAYS: usize = 1024;

/// The least sine of the angle between a surface and the shadow rays from it that are compared.
const STEEP: f64 = 0.2;

/// All views of one volume.
pub(crate) struct Rays<'a> {
    pub(crate) entry: &'a Entry,
    pub(crate) size: u32,
}

/// What a structure says of a ray.
#[derive(Debug, PartialEq)]
struct Answer {
    hit: Option<Hit>,
    any: bool,
    count: u32,
    /// Of all of the volume's isovalues, in order.
    crossings: Vec<Crossing>,
    /// Whether something lies between the hit and the light.
    is_occluded: bool,
}

/// Against the oracle.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    compared: u64,
    crossings: u64,
    wrong: u64,
    shadows: u64,
    occluded: u64,
    wrong_shadows: u64,
}

impl Tally {
    fn join(self, other: Self) -> Self {
        Self {
            compared: self.compared + other.compared,
            crossings: self.crossings + other.crossings,
            wrong: self.wrong + other.wrong,
            shadows: self.shadows + other.shadows,
            occluded: self.occluded + other.occluded,
            wrong_shadows: self.wrong_shadows + other.wrong_shadows,
        }
    }
}

impl DenseVisitor for Rays<'_> {
    type Output = Result<Vec<String>>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        let octree = volume.octree()?;
        let view = octree.view();
        let mut dense = DenseVolume::new(volume.dims, &volume.samples)?;
        let bricked = BrickedVolume::new(&mut dense, BrickSizes { brick: 4, macrobrick: 3 })?;
        let of_array = GridVolume::new(dense);
        let of_bricks = GridVolume::new(&bricked);
        let of_octree = GridVolume::new(&view);
        let lattice = lattice(volume);
        let world_to_index = volume.index_to_world.inverse();
        let isovalues = &self.entry.isovalues;
        let mut failures = Vec::new();
        for place in Place::ALL {
            let camera = volume.camera(place, self.size)?;
            let pixels = (0..self.size).flat_map(|y| (0..self.size).map(move |x| [x, y]));
            let rays: Vec<Lit> = pixels
                .map(|[x, y]| {
                    Lit::new(camera.index_ray(&world_to_index, x, y), u64::from(y) << 32 | u64::from(x))
                })
                .collect();
            let expected = answers(|| Tracer::new(&view), &rays, isovalues);
            let unlike = |found: Vec<Answer>| found.iter().zip(&expected).filter(|(a, b)| a != b).count();
            let unlike = [
                unlike(answers(|| GridTracer::new(&of_array), &rays, isovalues)),
                unlike(answers(|| GridTracer::new(&of_bricks), &rays, isovalues)),
                unlike(answers(|| GridTracer::new(&of_octree), &rays, isovalues)),
            ];
            let tally = rays
                .par_iter()
                .zip(&expected)
                .map(|(ray, answer)| against_oracle(&lattice, ray, answer, isovalues[0]))
                .reduce(Tally::default, Tally::join);
            let name = format!("{} at {}, {}", self.entry.name, isovalues[0], place.name());
            let Tally { compared, crossings, wrong, shadows, occluded, wrong_shadows } = tally;
            println!(
                "{name:<48} {:>8} {compared:>8} {crossings:>9} {wrong:>6} | {shadows:>16} {occluded:>8} {wrong_shadows:>6} | {:>26} {:>7} {:>7}",
                rays.len(),
                unlike[0],
                unlike[1],
                unlike[2]
            );
            let checks = [("all crossings", wrong), ("shadow rays", wrong_shadows)];
            failures.extend(
                checks
                    .iter()
                    .filter(|c| c.1 > 0)
                    .map(|(what, n)| format!("{name}: {n} rays, {what} unlike the oracle's")),
            );
            let grids = ["the array", "bricks", "the octree"].into_iter().zip(unlike);
            failures.extend(
                grids
                    .filter(|g| g.1 > 0)
                    .map(|(of, n)| format!("{name}: {n} rays, the grid over {of} unlike the octree")),
            );
        }
        Ok(failures)
    }
}

/// A ray, and the direction of length 1 in which the light is from what it hits.
struct Lit {
    ray: Ray,
    to_light: [f32; 3],
}

impl Lit {
    fn new(ray: Ray, seed: u64) -> Self {
        let mut random = SplitMix64::new(seed);
        let to_light = [(); 3].map(|()| random.sign() * random.range(0.1, 1.0));
        let length = to_light.iter().map(|d| d * d).sum::<f64>().sqrt();
        Self { ray, to_light: to_light.map(|d| (d / length) as f32) }
    }
}

fn answers<T: Trace>(tracer: impl Fn() -> T + Sync, rays: &[Lit], isovalues: &[f32]) -> Vec<Answer> {
    let of_chunk = |chunk: &[Lit]| {
        let mut tracer = tracer();
        chunk.iter().map(|lit| answer(&mut tracer, lit, isovalues)).collect::<Vec<_>>()
    };
    rays.par_chunks(RAYS).flat_map_iter(of_chunk).collect()
}

fn answer(tracer: &mut impl Trace, Lit { ray, to_light }: &Lit, isovalues: &[f32]) -> Answer {
    let isovalue = isovalues[0];
    let hit = tracer.first_hit(ray, isovalue);
    let mut count = CountHits::default();
    tracer.trace(ray, isovalue, &mut count, &mut ());
    let mut crossings = Vec::new();
    let _ = tracer.crossings(
        ray,
        isovalues,
        &mut |crossing| {
            crossings.push(*crossing);
            ControlFlow::Continue(())
        },
        &mut (),
    );
    let is_occluded = hit.is_some_and(|hit| {
        let shadow = hit.departing_ray(*to_light, f32::INFINITY, !hit.is_entering);
        tracer.occluded(&shadow, isovalue, &mut ())
    });
    Answer { hit, any: tracer.any_hit(ray, isovalue), count: count.0, crossings, is_occluded }
}

/// Compares what is said of a ray and of the shadow ray from its hit, unless they graze.
fn against_oracle<T: Scalar + Into<f64>>(
    lattice: &DenseLattice<T>,
    Lit { ray, to_light }: &Lit,
    answer: &Answer,
    isovalue: f32,
) -> Tally {
    let mut tally = Tally::default();
    let verdict = judge_all(lattice, &for_oracle::ray(ray), isovalue);
    if !verdict.grazing {
        let expected = verdict.hits.len();
        let of_several = answer.crossings.iter().filter(|c| c.surface == 0).count();
        let counts = [answer.count as usize, of_several];
        let is_right = counts == [expected; 2] && [answer.any, answer.hit.is_some()] == [expected > 0; 2];
        tally = Tally { compared: 1, crossings: expected as u64, wrong: (!is_right).into(), ..tally };
    }
    let Some(hit) = answer.hit else { return tally };
    // The reference starts a little off the surface, on a side that the slope tells, still in the same cell. Rounding its coordinates to 32 bits
    // moves the start by up to half an ulp along each axis; so far off, that is an eighth of its distance from the surface.
    let largest = hit.position().iter().fold(1f64, |m, &c| m.max(c)) as f32;
    let off = (8.0 / STEEP * 3f64.sqrt() / 2.0) as f32 * (largest.next_up() - largest);
    let origin = hit.position().map(|c| c as f32);
    let shadow = OracleRay { origin, direction: *to_light, t_min: off, t_max: f32::INFINITY };
    let verdict = judge_all(lattice, &shadow, isovalue);
    let dot = |a: [f32; 3], b: [f32; 3]| (0..3).map(|n| f64::from(a[n]) * f64::from(b[n])).sum::<f64>();
    let gradient = hit.gradient();
    let slope = dot(gradient, *to_light) / dot(gradient, gradient).sqrt();
    let stays = hit.local.iter().zip(to_light).all(|(x, d)| (0.0..=1.0).contains(&(x + 2.0 * off * d)));
    // A crossing next to the start may belong to either side of it.
    let is_clear = verdict.hits.first().is_none_or(|hit| hit.t > f64::from(4.0 * off));
    if verdict.grazing || !stays || !is_clear || slope.abs() < STEEP || !is_smooth(&hit) {
        return tally;
    }
    let into_inside = !hit.is_entering;
    let expected = (slope > 0.0) != into_inside || !verdict.hits.is_empty();
    let is_wrong = answer.is_occluded != expected;
    Tally { shadows: 1, occluded: expected.into(), wrong_shadows: is_wrong.into(), ..tally }
}

/// Whether the field changes as the gradient tells over the distance that the reference starts off and many times that.
fn is_smooth(hit: &Hit) -> bool {
    let gradient = hit.gradient();
    let steepness = gradient.iter().map(|g| g * g).sum::<f32>().sqrt();
    let largest = hit.corners.iter().fold(0f32, |m, c| m.max(c.abs()));
    steepness > 1e-2 * largest
}
