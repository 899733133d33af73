//! Ray traversal (section 4.3, appendix C).

use isoray_cell::fma;
use isoray_grid::{Scalar, ScalarType, Threshold};

use super::cell::{Stretch, first_root, gradient};
use super::{LEAF, MAX_DEPTH, OctCap, PaperHit, PaperOctree, child_cell};

/// Stands in for smaller direction components, so that reciprocals stay finite.
const LEAST_DIRECTION: f32 = 1e-20;

/// The bit of an axis in an octant.
const AXIS_TABLE: [usize; 3] = [4, 2, 1];

/// Bits of an octant.
const AXIS_BITS: u32 = 3;

/// A ray in octree space, where samples have integer coordinates.
struct Ray {
    origin: [f32; 3],
    direction: [f32; 3],
    reciprocal: [f32; 3],
    /// The octant that the ray meets first.
    first: usize,
}

impl Ray {
    #[inline(always)]
    fn new(origin: [f32; 3], direction: [f32; 3]) -> Self {
        let direction =
            direction.map(|d| if d.abs() < LEAST_DIRECTION { LEAST_DIRECTION.copysign(d) } else { d });
        let first = (0..3).map(|a| if direction[a] < 0.0 { AXIS_TABLE[a] } else { 0 }).sum();
        Self { origin, direction, reciprocal: direction.map(|d| 1.0 / d), first }
    }

    /// Where the ray crosses the plane `k` of `axis`; one expression for all planes, so that all depths
    /// agree.
    #[inline(always)]
    fn crossing(&self, axis: usize, k: i32) -> f32 {
        (k as f32 - self.origin[axis]) * self.reciprocal[axis]
    }

    #[inline(always)]
    fn mid_planes(&self, cell: [i32; 3], bit: i32) -> [f32; 3] {
        std::array::from_fn(|a| self.crossing(a, cell[a] | bit))
    }
}

/// Calls `visit` for the octants of a region, in the order of a ray that crosses their mid-planes at
/// `planes`, with its stretch in each, until that returns true: the crossings are sorted, and each one
/// toggles the bit of its axis.
#[inline(always)]
fn march(
    first: usize,
    planes: [f32; 3],
    t_enter: f32,
    t_exit: f32,
    mut visit: impl FnMut(usize, f32, f32) -> bool,
) -> bool {
    let mut child = first;
    // Floats that are not negative sort like their bits; the axis goes along below them.
    let mut axis_isects: [u64; 3] = std::array::from_fn(|a| {
        let is_behind = planes[a] <= t_enter;
        child ^= if is_behind { AXIS_TABLE[a] } else { 0 };
        let key = u64::from(planes[a].to_bits()) << AXIS_BITS | AXIS_TABLE[a] as u64;
        if is_behind { u64::MAX } else { key }
    });
    for (a, b) in [(0, 1), (1, 2), (0, 1)] {
        let (p, q) = (axis_isects[a], axis_isects[b]);
        (axis_isects[a], axis_isects[b]) = (p.min(q), p.max(q));
    }
    let last = u64::from(t_exit.to_bits()) << AXIS_BITS;
    let mut t = t_enter;
    for key in axis_isects {
        if key >= last {
            break;
        }
        let plane = f32::from_bits((key >> AXIS_BITS) as u32);
        if visit(child, t, plane) {
            return true;
        }
        t = plane;
        child ^= key as usize & ((1 << AXIS_BITS) - 1);
    }
    visit(child, t, t_exit)
}

/// One ray's traversal; with `ARRAY`, samples come from there.
struct Walk<'a, T, const ARRAY: bool> {
    tree: &'a PaperOctree<T>,
    /// Empty without `ARRAY`.
    array: &'a [T],
    ray: Ray,
    isovalue: f32,
    /// The isovalue as the least sample value inside.
    threshold: T,
    /// The node entered at each depth.
    parent_trace: [u32; MAX_DEPTH],
    hit: Option<PaperHit>,
}

/// A scalar leaf being traversed.
struct ScalarLeaf<T> {
    value: T,
    /// Depth of the node that holds it.
    parent: usize,
    /// Its edge less one: the bits of a coordinate that lie inside it.
    inner: i32,
}

impl<T: Scalar> PaperOctree<T> {
    /// The first crossing of the isosurface of `isovalue` at `t ≥ 0`, of a ray in index space.
    #[inline]
    pub fn first_hit(&self, origin: [f32; 3], direction: [f32; 3], isovalue: f32) -> Option<PaperHit> {
        self.traverse::<false>(&[], origin, direction, isovalue)
    }

    /// The same with all samples from the uncompressed array, which the octree then is an acceleration structure for (section 5.2).
    #[inline]
    pub fn first_hit_in_array(
        &self,
        array: &[T],
        origin: [f32; 3],
        direction: [f32; 3],
        isovalue: f32,
    ) -> Option<PaperHit> {
        self.traverse::<true>(array, origin, direction, isovalue)
    }

    #[inline(always)]
    fn traverse<const ARRAY: bool>(
        &self,
        array: &[T],
        origin: [f32; 3],
        direction: [f32; 3],
        isovalue: f32,
    ) -> Option<PaperHit> {
        let Threshold::AtLeast(threshold) = T::threshold(isovalue) else { return None };
        let ray = Ray::new(origin, direction);
        let (mut t_enter, mut t_exit) = (0f32, f32::INFINITY);
        for (a, n) in self.dims.axes().into_iter().enumerate() {
            let (low, high) = (ray.crossing(a, 0), ray.crossing(a, n as i32 - 1));
            t_enter = t_enter.max(low.min(high));
            t_exit = t_exit.min(low.max(high));
        }
        // Also false for a ray that is not made of numbers.
        if t_enter < t_exit {
            let parent_trace = [0; MAX_DEPTH];
            let mut walk =
                Walk::<T, ARRAY> { tree: self, array, ray, isovalue, threshold, parent_trace, hit: None };
            walk.node(0, 0, [0; 3], t_enter, t_exit);
            walk.hit
        } else {
            None
        }
    }
}

impl<T: Scalar, const ARRAY: bool> Walk<'_, T, ARRAY> {
    /// The corners of a cell, in octant order, from the array.
    #[inline(always)]
    fn array_corners(&self, cell: [i32; 3]) -> [T; 8] {
        let dims = self.tree.dims;
        let low = dims.linear(cell.map(|c| c as u32));
        let steps = [dims.axes()[0] as usize, dims.layer()];
        std::array::from_fn(|n| self.array[low + (n >> 2) + (n >> 1 & 1) * steps[0] + (n & 1) * steps[1]])
    }

    /// Interior node `index` of `depth`. True when the surface was hit, as for all the others.
    fn node(&mut self, depth: usize, index: u32, cell: [i32; 3], t_enter: f32, t_exit: f32) -> bool {
        let tree = self.tree;
        let node = &tree.nodes[depth][index as usize];
        self.parent_trace[depth] = index;
        let bit = tree.child_bit_depth[depth];
        march(self.ray.first, self.ray.mid_planes(cell, bit), t_enter, t_exit, |child, t, t_end| {
            if !(node.child_mins[child] < self.threshold && self.threshold <= node.child_maxs[child]) {
                return false;
            }
            let cell = child_cell(cell, child, bit);
            let offset = node.child_offset[child];
            if offset == LEAF {
                let leaf = ScalarLeaf { value: node.child_scalars[child], parent: depth, inner: bit - 1 };
                return self.scalar_leaf(&leaf, depth + 1, cell, t, t_end);
            }
            let index = node.child_start + offset as u32;
            if depth + 2 == tree.max_depth {
                self.cap(index, cell, t, t_end)
            } else {
                self.node(depth + 1, index, cell, t, t_end)
            }
        })
    }

    /// The part of a scalar leaf that is the region of `depth` at `cell`: down to single cells, as in a node,
    /// although nothing is stored of it.
    #[inline(never)]
    fn scalar_leaf(
        &mut self,
        leaf: &ScalarLeaf<T>,
        depth: usize,
        cell: [i32; 3],
        t_enter: f32,
        t_exit: f32,
    ) -> bool {
        let bit = self.tree.child_bit_depth[depth];
        march(self.ray.first, self.ray.mid_planes(cell, bit), t_enter, t_exit, |child, t, t_end| {
            let cell = child_cell(cell, child, bit);
            if bit > 1 {
                self.scalar_leaf(leaf, depth + 1, cell, t, t_end)
            } else {
                self.leaf_cell(leaf, cell, t, t_end)
            }
        })
    }

    /// A cell of a scalar leaf: at the leaf's upper faces its far corners lie beyond; the others hold no
    /// surface.
    fn leaf_cell(&mut self, leaf: &ScalarLeaf<T>, cell: [i32; 3], t: f32, t_end: f32) -> bool {
        let at_last = |a: usize| if cell[a] & leaf.inner == leaf.inner { AXIS_TABLE[a] } else { 0 };
        let beyond = at_last(0) | at_last(1) | at_last(2);
        if beyond == 0 {
            return false;
        }
        if ARRAY {
            return self.intersect(&self.array_corners(cell), cell, t, t_end);
        }
        let samples = std::array::from_fn(|direction| {
            if direction & beyond == 0 {
                leaf.value
            } else {
                self.tree.neighbor_find(cell, neighbor(cell, direction), leaf.parent, &self.parent_trace)
            }
        });
        self.intersect(&samples, cell, t, t_end)
    }

    /// Cap `index` at `cell`.
    #[inline(never)]
    fn cap(&mut self, index: u32, cell: [i32; 3], t_enter: f32, t_exit: f32) -> bool {
        let tree = self.tree;
        let cap: &OctCap<T> = &tree.caps[index as usize];
        let parent = tree.max_depth - 2;
        march(self.ray.first, self.ray.mid_planes(cell, 1), t_enter, t_exit, |child, t, t_end| {
            let cell = child_cell(cell, child, 1);
            if ARRAY {
                return self.intersect(&self.array_corners(cell), cell, t, t_end);
            }
            let samples = std::array::from_fn(|direction| {
                if child & direction == 0 {
                    cap[(child | direction) & 7]
                } else {
                    tree.neighbor_find(cell, neighbor(cell, direction), parent, &self.parent_trace)
                }
            });
            self.intersect(&samples, cell, t, t_end)
        })
    }

    /// The cell at `cell` with these corners (octant order): a test of its range, then the intersection.
    #[inline(always)]
    fn intersect(&mut self, samples: &[T; 8], cell: [i32; 3], t: f32, t_end: f32) -> bool {
        let inside = samples.iter().filter(|&&s| s >= self.threshold).count();
        if inside == 0
            || inside == 8
            || (T::TYPE == ScalarType::F32 && !samples.iter().all(|s| s.is_finite()))
        {
            return false;
        }
        self.intersect_surface(samples, cell, t, t_end)
    }

    #[inline(never)]
    fn intersect_surface(&mut self, samples: &[T; 8], cell: [i32; 3], t: f32, t_end: f32) -> bool {
        let corners = samples.map(|s| s.to_f32() - self.isovalue);
        let Ray { origin, direction, .. } = self.ray;
        let stretch = Stretch {
            entry: std::array::from_fn(|a| fma(direction[a], t, origin[a] - cell[a] as f32)),
            along: direction.map(|d| d * (t_end - t)),
        };
        let Some(s) = first_root(&corners, &stretch) else { return false };
        let local = std::array::from_fn(|a| fma(stretch.along[a], s, stretch.entry[a]));
        self.hit = Some(PaperHit { t: fma(t_end - t, s, t), gradient: gradient(&corners, local) });
        true
    }
}

/// The lattice point one step from `cell` along the axes of `direction`.
#[inline(always)]
fn neighbor(cell: [i32; 3], direction: usize) -> [i32; 3] {
    std::array::from_fn(|a| cell[a] + i32::from(direction & AXIS_TABLE[a] != 0))
}
