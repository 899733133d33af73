//! Emission and absorption along a ray through a dense volume.

use std::ops::ControlFlow;

use std::borrow::Cow;

use isoray_grid::{Branching, DenseVolume, GridVolume, MacrocellLevel, Macrocells, Scalar};
use isoray_preint::{Integrate, Lighting, Radiance, Segments, Visibility};
use wide::f64x4;

use crate::brick::{Bricks, SAMPLES};
use crate::corner::Corner;
use crate::gather::Gather;
use crate::grid_steps::{CORNER_STRIDES, Cubes, GridSteps};
use crate::place::Place;
use crate::ray::{ClippedRay, Ray};
use crate::region::Region;
use crate::shown::Shown;
use crate::steps::Cube;
use crate::work::Counters;

/// Integrates emission and absorption along rays through one dense volume.
///
/// The counterpart of [`VolumeTracer`](crate::VolumeTracer) for arrays: it meets the same cells on the same stretches of the ray, bit for
/// bit, so that results differ only where the octree passes through the inside of a scalar leaf in one step, and then by no more than the
/// scheme's errors. Macrocells whose values the transfer function hides are passed by. Make one per thread and keep it.
#[derive(Clone, Debug)]
pub struct DenseVolumeTracer<'a, T: Scalar> {
    samples: DenseVolume<'a, T>,
    /// Of four parts along an edge at every level.
    macrocells: Cow<'a, Macrocells<T>>,
    visible: Visibility,
    shown: Shown<T>,
    /// `None`: there are no cells.
    region: Option<Region>,
    bricks: Bricks,
    segments: Segments,
}

impl<'a, T: Scalar> DenseVolumeTracer<'a, T> {
    /// A tracer of what is `visible` of `volume`.
    ///
    /// Macrocells of other than four parts along an edge are not made use of: it then finds its own.
    pub fn new<'v: 'a>(volume: &'a GridVolume<DenseVolume<'v, T>>, visible: &Visibility) -> Self {
        let mut edges = (1..).map(|level| PARTS.checked_pow(level));
        let is_of_four = volume.macrocells().levels().iter().all(|l| edges.next() == Some(Some(l.edge())));
        let macrocells = match is_of_four {
            true => Cow::Borrowed(volume.macrocells()),
            false => Cow::Owned(Macrocells::new(volume.samples(), &Branching::default())),
        };
        Self {
            samples: *volume.samples(),
            macrocells,
            visible: visible.clone(),
            shown: Shown::new(visible),
            region: Region::whole(volume.samples().dims()),
            bricks: Bricks::new(),
            segments: Segments::default(),
        }
    }

    /// What `scheme` gathers along the ray, front to back, a unit of whose parameter is `world_per_t` long in the world.
    ///
    /// A ray with a component that is not finite, or without direction, gathers nothing.
    pub fn integrate(
        &mut self,
        ray: &Ray,
        world_per_t: f64,
        scheme: &impl Integrate,
        lighting: Option<&Lighting>,
        counters: &mut impl Counters,
    ) -> Radiance {
        let Some(region) = &self.region else { return Radiance::default() };
        let Some(ray) = &ClippedRay::new(ray, region) else { return Radiance::default() };
        let levels = self.macrocells.levels();
        let [nx, ny, _] = self.samples.dims().axes().map(|n| n as usize);
        let mut search = DenseIntegral {
            samples: self.samples,
            strides: [nx, nx * ny],
            levels,
            visible: &self.visible,
            shown: &self.shown,
            bricks: &mut self.bricks,
            gather: Gather::new(ray, world_per_t, scheme, lighting, &mut self.segments),
        };
        // If it breaks, nothing is left to gather.
        let _ = search.all(counters);
        search.gather.finish()
    }
}

/// Parts of a macrocell along an edge.
const PARTS: u32 = 4;

/// A block of cells on the ray's way.
struct Macrocell {
    /// Its low corner, in units of its parts.
    corner: [u32; 3],
    center: f64x4,
    /// Where the ray is in it.
    t: f64,
    t_end: f64,
}

/// The search for what is visible.
struct DenseIntegral<'s, T, I> {
    samples: DenseVolume<'s, T>,
    /// Distance of neighbours along y and z in `samples`.
    strides: [usize; 2],
    levels: &'s [MacrocellLevel<T>],
    visible: &'s Visibility,
    shown: &'s Shown<T>,
    bricks: &'s mut Bricks,
    gather: Gather<'s, I>,
}

impl<T: Scalar, I: Integrate> DenseIntegral<'_, T, I> {
    /// Passes through the visible macrocells of the highest level.
    fn all(&mut self, counters: &mut impl Counters) -> ControlFlow<()> {
        let Some((top, parts)) = self.levels.iter().enumerate().next_back() else {
            return ControlFlow::Continue(());
        };
        let ray = self.gather.ray;
        let edge = f64::from(parts.edge());
        let cubes = Cubes::new(ray, edge, 1.0 / edge);
        let strides = &CORNER_STRIDES[ray.backward as usize & 7];
        let [nx, ny, nz] = parts.blocks();
        let last = f64x4::new([nx - 1, ny - 1, nz - 1, 1].map(f64::from));
        let mut steps = GridSteps::at(ray, &cubes, [f64x4::ZERO, last], ray.t_begin, |at| Corner::new(at).0);
        let [nx, ny] = [nx, ny].map(|n| n as usize);
        let mut t = ray.t_begin;
        loop {
            let leaves = steps.leaves();
            let t_end = if leaves < ray.t_end { leaves } else { ray.t_end };
            let at = Corner(steps.index()).coordinates();
            let [x, y, z] = at.map(|c| c as usize);
            let range = parts.ranges().get(x + nx * (y + ny * z));
            if range.is_some_and(|range| self.shown.meets(range)) {
                counters.node();
                let place = Macrocell {
                    corner: at.map(|c| c * PARTS),
                    center: steps.cube() * f64x4::splat(edge) + f64x4::splat(edge / 2.0),
                    t,
                    t_end,
                };
                self.macrocell(top, place, counters)?;
            }
            if t_end >= ray.t_end {
                return ControlFlow::Continue(());
            }
            steps.cross(ray, &cubes, strides, t_end);
            t = t_end;
        }
    }

    /// Passes through a macrocell of `level`: through the visible ones among its parts, or through its cells.
    fn macrocell(&mut self, level: usize, place: Macrocell, counters: &mut impl Counters) -> ControlFlow<()> {
        let Some((below, parts)) = level.checked_sub(1).and_then(|n| Some((n, self.levels.get(n)?))) else {
            return self.cells(place, counters);
        };
        let ray = self.gather.ray;
        let step = ray.step * f64x4::splat((1u64 << (2 * level)) as f64);
        let cube = Cube { center: place.center, mid: ray.crossings(place.center), step };
        let [nx, ny, _] = parts.blocks().map(|n| n as usize);
        cube.walk(ray, [place.t, place.t_end], |steps, offset, [t, t_end]| {
            let at: [u32; 3] = std::array::from_fn(|a| place.corner[a] + (offset >> (2 * a) & 3));
            let [x, y, z] = at.map(|c| c as usize);
            let is_shown =
                parts.ranges().get(x + nx * (y + ny * z)).is_some_and(|range| self.shown.meets(range));
            if !is_shown {
                return ControlFlow::Continue(());
            }
            counters.node();
            let corner = at.map(|c| c * PARTS);
            self.macrocell(below, Macrocell { corner, center: steps.center(step), t, t_end }, counters)
        })
    }

    /// Passes through the cells of a macrocell of the lowest level, a block.
    #[inline(never)]
    fn cells(&mut self, place: Macrocell, counters: &mut impl Counters) -> ControlFlow<()> {
        let brick = self.bricks.of(Place::around(place.center).key(), |brick| {
            counters.lookups(SAMPLES as u32);
            let low = self.samples.dims().linear(place.corner);
            brick.fill_from_array(self.samples.samples(), low, self.strides, self.visible);
        });
        let ray = self.gather.ray;
        let block = Cube { center: place.center, mid: ray.crossings(place.center), step: ray.step };
        self.gather.block(brick, block, [place.t, place.t_end], counters)
    }
}
