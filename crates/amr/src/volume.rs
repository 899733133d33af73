//! Emission and absorption along rays through a mesh.

use std::ops::ControlFlow;

use isoray_cell::Segment;
use isoray_preint::{Integrate, Lighting, Radiance, Segments, Visibility};
use isoray_trace::parts::{self, ClippedRay, Gather, Region};
use isoray_trace::{Counters, Ray};

use crate::cuboid::Cuboid;
use crate::hybrid::Split;
use crate::mesh::Mesh;
use crate::range::range;
use crate::samples::fill;
use crate::stretches::Stretches;
use crate::tree::Node;
use crate::visit::{BrickAt, Corners, CubeAt, Visit};
use crate::walk::Walk;

/// Integrates emission and absorption along rays through one mesh. Make one per thread and keep it.
///
/// Rays are integrated cell by cell, in order; boxes, bricks and cells whose values the transfer function hides are passed by.
#[derive(Clone, Debug)]
pub struct MeshVolumeTracer<'m> {
    mesh: &'m Mesh,
    visible: Visibility,
    /// By node.
    shown: Vec<bool>,
    /// What holds all blocks that are shown.
    region: Option<Region>,
    walk: Walk,
    stretches: Stretches<'m>,
    segments: Segments,
}

impl<'m> MeshVolumeTracer<'m> {
    /// A tracer of what is `visible` of a mesh.
    pub fn new(mesh: &'m Mesh, visible: &Visibility) -> Self {
        let shown: Vec<bool> = mesh.ranges.iter().map(|&[low, high]| visible.is_visible(low, high)).collect();
        Self {
            mesh,
            visible: visible.clone(),
            region: region(mesh, &shown),
            shown,
            walk: Walk::new(mesh),
            stretches: Stretches::new(),
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
        self.gather(ray, world_per_t, scheme, lighting, &mut Alike, counters)
    }

    /// Likewise, but `colors` has the colour of cells, or parts of cells, with the edge `1 << exponent`, by the exponent, and again: linear RGB, up to 1, at least one.
    /// All that the scheme itself shows must be [white](isoray_preint::TransferFunction::in_white).
    pub fn integrate_levels(
        &mut self,
        ray: &Ray,
        world_per_t: f64,
        (scheme, colors): (&impl Integrate, &[[f32; 3]]),
        lighting: Option<&Lighting>,
        counters: &mut impl Counters,
    ) -> Radiance {
        let mut levels = ByLevel { colors, exponent: 0, white: [0.0; 3], color: [0.0; 3] };
        let radiance = self.gather(ray, world_per_t, scheme, lighting, &mut levels, counters);
        levels.add(radiance.color);
        Radiance { color: levels.color, ..radiance }
    }

    fn gather<I: Integrate>(
        &mut self,
        ray: &Ray,
        world_per_t: f64,
        scheme: &I,
        lighting: Option<&Lighting>,
        levels: &mut impl Levels,
        counters: &mut impl Counters,
    ) -> Radiance {
        let Some(region) = &self.region else { return Radiance::default() };
        let Some(ray) = &ClippedRay::of(ray, region) else { return Radiance::default() };
        self.stretches.clear();
        let mut integral = Integral {
            visible: &self.visible,
            shown: &self.shown,
            stretches: &mut self.stretches,
            gather: Gather::new(ray, world_per_t, scheme, lighting, &mut self.segments),
            levels,
        };
        if self.walk.follow(self.mesh, ray, &mut integral, counters).is_continue() {
            let _ = integral.flush();
        }
        integral.gather.finish()
    }
}

/// What comes of a cell's size.
trait Levels {
    /// Before a cell with the edge `1 << exponent`: whether it matters that it is not as large as those before.
    fn differs(&self, exponent: u32) -> bool;

    /// Goes on with such cells, `white` having been gathered before them.
    fn turn_to(&mut self, exponent: u32, white: [f64; 3]);
}

/// Nothing.
struct Alike;

impl Levels for Alike {
    #[inline(always)]
    fn differs(&self, _: u32) -> bool {
        false
    }

    #[inline(always)]
    fn turn_to(&mut self, _: u32, _: [f64; 3]) {}
}

/// A colour, by which the white that is gathered there is multiplied.
struct ByLevel<'c> {
    colors: &'c [[f32; 3]],
    /// Of the cells at hand.
    exponent: u32,
    /// What had been gathered when the ray came to the first of them, white and coloured.
    white: [f64; 3],
    color: [f64; 3],
}

impl ByLevel<'_> {
    /// Colours what has been gathered since, `white` being all.
    fn add(&mut self, white: [f64; 3]) {
        let color = self.colors[self.exponent as usize % self.colors.len()];
        for a in 0..3 {
            self.color[a] += f64::from(color[a]) * (white[a] - self.white[a]);
        }
        self.white = white;
    }
}

impl Levels for ByLevel<'_> {
    #[inline]
    fn differs(&self, exponent: u32) -> bool {
        exponent != self.exponent
    }

    fn turn_to(&mut self, exponent: u32, white: [f64; 3]) {
        self.add(white);
        self.exponent = exponent;
    }
}

/// The least box of all blocks that are shown; `None` if none is.
fn region(mesh: &Mesh, shown: &[bool]) -> Option<Region> {
    let nodes = mesh.skeleton.nodes.iter().zip(shown).filter(|(_, is_shown)| **is_shown);
    let places = nodes.filter_map(|(node, _)| match *node {
        Node::Leaf(block) => Some(mesh.skeleton.blocks[block as usize].place),
        Node::Split { .. } => None,
    });
    let all = places.reduce(|a, b| Cuboid {
        low: std::array::from_fn(|k| a.low[k].min(b.low[k])),
        high: std::array::from_fn(|k| a.high[k].max(b.high[k])),
    })?;
    Region::between(all.low, all.high, mesh.dims())
}

/// What is gathered on the way.
struct Integral<'s, 'm, I, L> {
    visible: &'s Visibility,
    shown: &'s [bool],
    /// Those that are not integrated yet.
    stretches: &'s mut Stretches<'m>,
    gather: Gather<'s, I>,
    levels: &'s mut L,
}

impl<I: Integrate, L: Levels> Integral<'_, '_, I, L> {
    #[inline(never)]
    fn flush(&mut self) -> ControlFlow<()> {
        let Self { stretches, gather, .. } = self;
        if stretches.is_empty() {
            return ControlFlow::Continue(());
        }
        let end = gather.batch(|segments, ray, world_per_t| stretches.write_to(segments, ray, world_per_t));
        stretches.clear();
        end
    }
}

impl<'m, I: Integrate, L: Levels> Visit<'m> for Integral<'_, 'm, I, L> {
    const PASSES: bool = false;

    #[inline(always)]
    fn wants_node(&self, node: u32) -> bool {
        self.shown[node as usize]
    }

    #[inline(always)]
    fn wants(&self, [low, high]: [f32; 2]) -> bool {
        self.visible.is_visible(low, high)
    }

    fn find(&self, brick: &mut parts::Brick, at: &BrickAt<'m>, counters: &mut impl Counters) -> u64 {
        let [low, high] = at.brick().range;
        if self.visible.ranges().iter().any(|range| range[0] <= low && high <= range[1]) {
            return at.brick().own;
        }
        counters.lookups(parts::SAMPLES as u32);
        let whole = at.brick().own & !at.brick().split;
        let splits = Split::of_brick(at);
        let shown = splits.filter(|(_, split)| {
            split.any(&at.mesh.bricks.splits, &|values| {
                range(values).is_none_or(|[low, high]| self.visible.is_visible(low, high))
            })
        });
        let split = shown.fold(0, |cells, (offset, _)| cells | 1u64 << offset);
        brick.fill_with(|samples| fill(samples, at), self.visible, whole);
        brick.shown() | split
    }

    #[inline(always)]
    fn passes(&mut self, _: [f32; 2]) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn passes_cell(&mut self, _: Option<f32>) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn cell(
        &mut self,
        corners: Corners<'m>,
        _: impl FnOnce() -> Segment,
        interval: [f64; 2],
        place: CubeAt,
    ) -> ControlFlow<()> {
        if self.levels.differs(place.exponent) {
            let end = self.flush();
            self.levels.turn_to(place.exponent, self.gather.radiance().color);
            end?;
        }
        self.stretches.push(corners, interval, place);
        if self.stretches.is_full() { self.flush() } else { ControlFlow::Continue(()) }
    }
}
