//! Emission and absorption along many rays at once: down the octree together, each block made ready once for all.

use isoray_grid::Scalar;
use isoray_octree::{CAP_EDGE, NODE_LEVEL, Node, OctreeView, Path};
use isoray_preint::{Integrate, Lighting, Radiance, Visibility};
use wide::f64x4;

use crate::brick::{Bricks, SAMPLES};
use crate::descent::{ALL_BORDERS, ALL_OCTANTS, octants_at};
use crate::place::Place;
use crate::ray::{ClippedRay, Ray};
use crate::ray_group::{Integral, RayGroup};
use crate::ray_lanes::GROUP;
use crate::region::Region;
use crate::shown::Shown;
use crate::volume::VolumeTracer;
use crate::work::Counters;

/// Voxels between neighbouring rays, where they enter, up to which they go together. On heptane, bonsai, engine and mixing they take 0.80 to 1.00 of the time
/// at some 0.1 to 0.2 voxels, 0.96 to 1.02 at 0.3, 1.00 to 1.01 at 0.5 and 1.09 to 1.35 beyond.
const WIDEST: f64 = 0.3;

/// As many groups as a set of them has bits.
const MOST_RAYS: usize = GROUP * u32::BITS as usize;

impl<'a, T: Scalar> VolumeTracer<'a, T> {
    /// As [`integrate`](Self::integrate), along up to 256 rays: the same, bit for bit. Ray by ray, `lighting` tells what it is lit by, if it may meet anything,
    /// and `take` is told what it gathers, both with its number.
    ///
    /// Rays that are close to each other go together; neighbours in the list gain most.
    ///
    /// # Panics
    /// If there are more rays.
    pub fn integrate_all(
        &mut self,
        rays: &[Ray],
        world_per_t: f64,
        scheme: &impl Integrate,
        lighting: impl Fn(usize) -> Option<Lighting>,
        counters: &mut impl Counters,
        mut take: impl FnMut(usize, Radiance),
    ) {
        assert!(rays.len() <= MOST_RAYS, "no more than {MOST_RAYS} rays");
        let Some(region) = self.region else {
            return (0..rays.len()).for_each(|n| take(n, Radiance::default()));
        };
        if are_apart(rays, &region) {
            for (n, ray) in rays.iter().enumerate() {
                let seen = ClippedRay::new(ray, &region)
                    .map(|ray| self.along(&ray, world_per_t, scheme, lighting(n).as_ref(), counters));
                take(n, seen.unwrap_or_default());
            }
            return;
        }
        let mut groups = std::mem::take(&mut self.groups);
        groups.resize_with(rays.len().div_ceil(GROUP), RayGroup::default);
        for (n, group) in groups.iter_mut().enumerate() {
            group.take(|lane| {
                let n = n * GROUP + lane;
                Some((ClippedRay::new(rays.get(n)?, &region)?, lighting(n)))
            });
        }
        let integral = Integral { world_per_t, scheme };
        self.sweep(&mut groups, &integral, counters);
        for n in 0..rays.len() {
            take(n, groups[n / GROUP].finish(n % GROUP, &integral));
        }
        self.groups = groups;
    }

    /// Takes rays through all that is visible.
    fn sweep(
        &mut self,
        groups: &mut [RayGroup],
        integral: &Integral<'_, impl Integrate>,
        counters: &mut impl Counters,
    ) {
        // Once for each way to face; nearly always there is one.
        let facings = groups.iter().fold(0, |facings, group| facings | group.facings());
        for backward in bits(facings) {
            groups.iter_mut().for_each(|group| group.turn_to(backward as u32));
            let mut sweep = Sweep {
                view: self.view,
                shown: &self.shown,
                visible: &self.visible,
                bricks: &mut self.bricks,
                path: &mut self.path,
                groups,
                backward: backward as u32,
                integral,
                counters,
            };
            sweep.all();
        }
    }
}

/// Whether neighbouring rays are so far apart where the first of them enters that it is better to follow each alone.
fn are_apart(rays: &[Ray], region: &Region) -> bool {
    let square = |pair: &[Ray]| {
        ClippedRay::new(&pair[0], region).map(|ray| pair[0].square_apart(&pair[1], ray.t_begin))
    };
    rays.windows(2).find_map(square).is_none_or(|square| square > WIDEST * WIDEST)
}

/// Rays on their way through the octree.
struct Sweep<'s, 'a, T: Scalar, I, C> {
    view: &'a OctreeView<'a, T>,
    shown: &'s Shown<T>,
    visible: &'s Visibility,
    bricks: &'s mut Bricks,
    path: &'s mut Path<'a, T>,
    groups: &'s mut [RayGroup],
    backward: u32,
    integral: &'s Integral<'s, I>,
    counters: &'s mut C,
}

/// A node, or a part of a scalar leaf.
#[derive(Clone, Copy)]
struct Cube<'a, T: Scalar> {
    level: u32,
    corner: [u32; 3],
    content: Content<'a, T>,
}

#[derive(Clone, Copy)]
enum Content<'a, T: Scalar> {
    Node(&'a Node<T::Stored>),
    /// With the upper faces of the leaf that this part of it reaches: only the cells there are not constant.
    Leaf {
        value: T,
        is_seen: bool,
        borders: u32,
    },
}

impl<'a, T: Scalar, I: Integrate, C: Counters> Sweep<'_, 'a, T, I, C> {
    /// Takes all groups through all that is visible.
    fn all(&mut self) {
        let Some(root) = self.view.root() else { return };
        let level = self.view.root_level();
        self.counters.node();
        self.path.enter_node(level, root);
        let groups = u32::MAX >> (u32::BITS - self.groups.len() as u32);
        self.cube(&Cube { level, corner: [0; 3], content: Content::Node(root) }, groups);
    }

    /// Takes `groups`, a bit each, through what is visible of a cube, in an order that suits all rays.
    fn cube(&mut self, cube: &Cube<'a, T>, groups: u32) {
        let active = match cube.content {
            Content::Node(node) => self.shown.children(node),
            Content::Leaf { is_seen: true, .. } => ALL_OCTANTS,
            Content::Leaf { borders, .. } => octants_at(borders),
        };
        if active == 0 {
            return;
        }
        let half = 1 << (cube.level - 1);
        let mut met = [0; 8];
        for n in bits(groups) {
            let children = self.groups[n].lanes().children(cube.corner, half, active);
            for (met, is_met) in met.iter_mut().zip(children) {
                *met |= u32::from(is_met) << n;
            }
        }
        for (n, groups) in (0..8).zip(met) {
            if groups != 0 {
                self.counters.node();
                self.child(cube, n ^ self.backward, groups);
            }
        }
    }

    #[inline(always)]
    fn child(&mut self, cube: &Cube<'a, T>, octant: u32, groups: u32) {
        let level = cube.level - 1;
        let edge = 1 << level;
        let corner = std::array::from_fn(|a| cube.corner[a] + (octant >> a & 1) * edge);
        let content = match cube.content {
            Content::Leaf { value, borders, .. } if borders & octant == 0 => {
                for n in bits(groups) {
                    self.groups[n].constant(value.to_f32(), corner, edge, self.integral);
                }
                return;
            }
            _ if cube.level == NODE_LEVEL => return self.block(cube, corner, octant, groups),
            Content::Leaf { value, is_seen, borders } => {
                Content::Leaf { value, is_seen, borders: borders & octant }
            }
            Content::Node(parent) if parent.is_stored(octant) => {
                let Some(node) = self.view.nodes(level).get(parent.child(octant)) else { return };
                self.path.enter_node(level, node);
                Content::Node(node)
            }
            Content::Node(parent) => {
                self.path.enter_leaf(level, parent, octant);
                let value = parent.value(octant);
                let is_seen = self.shown.has(value) && value.is_finite();
                Content::Leaf { value, is_seen, borders: ALL_BORDERS }
            }
        };
        self.cube(&Cube { level, corner, content }, groups);
    }

    #[inline(always)]
    fn block(&mut self, parent: &Cube<'a, T>, corner: [u32; 3], octant: u32, groups: u32) {
        let [x, y, z] = corner.map(|c| f64::from(c + CAP_EDGE / 2));
        let place = Place::around(f64x4::new([x, y, z, 0.0]));
        let brick = self.bricks.of(place.key(), |brick| {
            self.counters.lookups(SAMPLES as u32);
            let own = match parent.content {
                Content::Node(node) => self.view.block(node, parent.corner, octant),
                Content::Leaf { .. } => self.path.leaf_block(),
            };
            brick.fill(self.view, self.path, place, own, self.visible);
        });
        if brick.shown() != 0 {
            for n in bits(groups) {
                self.groups[n].block(brick, corner, self.integral, self.counters);
            }
        }
    }
}

/// The numbers of the bits that are set.
#[inline(always)]
pub(crate) fn bits(mut set: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let n = (set != 0).then(|| set.trailing_zeros() as usize)?;
        set &= set - 1;
        Some(n)
    })
}
