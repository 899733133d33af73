//! Rays through every structure and with every policy against the oracle: first and all crossings, several surfaces, shadows.

use std::ops::ControlFlow;

use anyhow::Result;
use isoray_grid::{BrickSizes, BrickedVolume, DenseVolume, GridVolume, Scalar};
use isoray_oracle::{DenseLattice, SplitMix64, judge_all};
use isoray_trace::{CountHits, Crossing, GridTracer, Hit, Ray, Trace, Tracer};
use rayon::prelude::*;

use super::selection::Selection;
use super::shadow::Departure;
use crate::catalog::{Dense, DenseVisitor, Entry, Place};
use crate::for_oracle;

/// Titles of the columns.
pub(crate) const HEADER: &str = "rays, all crossings and shadows                      rays compared crossings  wrong | shadows compared occluded  wrong | unlike in grids over array  bricks  octree";

/// Rays that one thread follows with one tracer.
const RAYS: usize = 1024;

/// All views of one volume.
pub(crate) struct Rays<'a> {
    pub(crate) entry: &'a Entry,
    pub(crate) selection: &'a Selection,
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
    /// The least number of a ray of which anything is wrong.
    first: Option<usize>,
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
            first: self.first.into_iter().chain(other.first).min(),
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
        let lattice = for_oracle::lattice(volume);
        let world_to_index = volume.index_to_world.inverse();
        let isovalues = &self.entry.isovalues;
        let mut failures = Vec::new();
        for place in Place::ALL {
            let name = format!("{} at {}, {}", self.entry.name, isovalues[0], place.name());
            if !self.selection.wants(&name) {
                continue;
            }
            let camera = volume.camera(place, self.size)?;
            let pixels = (0..self.size).flat_map(|y| (0..self.size).map(move |x| [x, y]));
            let rays: Vec<Lit> = pixels
                .map(|[x, y]| {
                    Lit::new(camera.index_ray(&world_to_index, x, y), u64::from(y) << 32 | u64::from(x))
                })
                .collect();
            let expected = answers(|| Tracer::new(&view), &rays, isovalues);
            let unlike = |found: Vec<Answer>| {
                let differing: Vec<usize> = (0..rays.len()).filter(|&n| found[n] != expected[n]).collect();
                (differing.len(), differing.first().copied())
            };
            let unlike = [
                unlike(answers(|| GridTracer::new(&of_array), &rays, isovalues)),
                unlike(answers(|| GridTracer::new(&of_bricks), &rays, isovalues)),
                unlike(answers(|| GridTracer::new(&of_octree), &rays, isovalues)),
            ];
            let tally = rays
                .par_iter()
                .zip(&expected)
                .enumerate()
                .map(|(n, (ray, answer))| {
                    let tally = against_oracle(&lattice, ray, answer, isovalues[0]);
                    Tally { first: (tally.wrong + tally.wrong_shadows > 0).then_some(n), ..tally }
                })
                .reduce(Tally::default, Tally::join);
            let Tally { compared, crossings, wrong, shadows, occluded, wrong_shadows, first } = tally;
            println!(
                "{name:<48} {:>8} {compared:>8} {crossings:>9} {wrong:>6} | {shadows:>16} {occluded:>8} {wrong_shadows:>6} | {:>26} {:>7} {:>7}",
                rays.len(),
                unlike[0].0,
                unlike[1].0,
                unlike[2].0
            );
            let at = |n: Option<usize>| {
                n.map_or_else(String::new, |n| {
                    format!(", the first in pixel {:?}", [n as u32 % self.size, n as u32 / self.size])
                })
            };
            let checks = [("all crossings", wrong), ("shadow rays", wrong_shadows)];
            failures.extend(
                checks
                    .iter()
                    .filter(|c| c.1 > 0)
                    .map(|(what, n)| format!("{name}: {n} rays, {what} unlike the oracle's{}", at(first))),
            );
            let grids = ["the array", "bricks", "the octree"].into_iter().zip(unlike);
            failures.extend(grids.filter(|(_, (n, _))| *n > 0).map(|(of, (n, first))| {
                format!("{name}: {n} rays, the grid over {of} unlike the octree{}", at(first))
            }));
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
    let departure = Departure {
        position: hit.position(),
        local: hit.local.map(f64::from),
        gradient: hit.gradient().map(f64::from),
        largest: hit.corners.iter().fold(0f32, |m, c| m.max(c.abs())).into(),
        to_light: *to_light,
        t_max: f32::INFINITY,
    };
    let Some(hits) = departure.hits(lattice, isovalue) else { return tally };
    let into_inside = !hit.is_entering;
    let expected = (departure.slope() > 0.0) != into_inside || !hits.is_empty();
    let is_wrong = answer.is_occluded != expected;
    Tally { shadows: 1, occluded: expected.into(), wrong_shadows: is_wrong.into(), ..tally }
}
