//! Putting coarse samples into nodes.

use isoray_grid::{Dims, Scalar};
use rayon::prelude::*;

use super::average::coarsen;
use super::{Cube, TASK_LEVEL, is_averaged};
use crate::fidelity::Coarse;
use crate::geometry::{MAX_LEVELS, NODE_LEVEL, child_origin, root_level};
use crate::node::{Node, Range};
use crate::view::OctreeView;

/// Nodes, or subtrees, whose changes are collected before they are made.
const NODES_AT_ONCE: usize = 1 << 14;
const SUBTREES_AT_ONCE: usize = 32;

/// A node with its level and index.
type Changed<T> = (u32, usize, Node<<T as Scalar>::Stored>);

/// Makes the coarse samples in nodes those of `kind`, from the finest to the coarsest, and widens ranges to bound them; `levels` are all the nodes of a sound structure as
/// [`Parts::levels`](crate::Parts::levels) has them, whose values are the volume's own samples, and `caps` its caps. Nothing to be done for kinds other than [`Coarse::Mean`] and [`Coarse::Filtered`].
///
/// Takes memory for the places of an eighth of all nodes beside them. The result does not depend on the number of threads.
pub fn fill_coarse<T: Scalar>(dims: Dims, levels: &mut [Vec<Node<T::Stored>>], caps: &[u8], kind: Coarse) {
    let root = root_level(dims);
    if !is_averaged(kind) || levels.len() != (root - NODE_LEVEL + 1) as usize {
        return;
    }
    let parts = root.min(TASK_LEVEL);
    let places = places(&view::<T>(dims, levels, caps), parts);
    for some in places.chunks(SUBTREES_AT_ONCE) {
        let structure = view::<T>(dims, levels, caps);
        let change = |&(index, origin): &(usize, [u32; 3])| {
            let cube = Cube::new(&structure, origin, parts, kind);
            let mut changed = Vec::new();
            fill_finest(&structure, &cube, (parts, index, origin), &mut changed);
            changed
        };
        let changed: Vec<Vec<Changed<T>>> = some.par_iter().map(change).collect();
        changed.into_iter().for_each(|changed| store::<T>(levels, changed));
    }
    for level in NODE_LEVEL..root {
        // Ranges take in values of neighbours.
        each_node(dims, levels, caps, level + 1, |view: &OctreeView<'_, T>, node, origin| {
            let mask = node.mask;
            for octant in (0..8).filter(|octant| mask >> octant & 1 == 1) {
                let value: T = expected_value(view, level, child_origin(origin, level + 1, octant), kind);
                node.values[octant as usize] = value.into();
            }
        });
        each_node(dims, levels, caps, level + 1, |view: &OctreeView<'_, T>, node, origin| {
            for octant in 0..8 {
                let corner = child_origin(origin, level + 1, octant);
                let child = view.nodes(level).get(node.child(octant)).filter(|_| node.is_stored(octant));
                let known = match child {
                    Some(child) if level > NODE_LEVEL => {
                        (0..8).map(|n| child.range(n)).fold(Range::EMPTY, Range::union)
                    }
                    _ => node.range(octant as usize),
                };
                let range = widened(view, known, child.is_none(), level, corner, kind);
                node.mins[octant as usize] = range.min.into();
                node.maxs[octant as usize] = range.max.into();
            }
        });
    }
}

fn view<'a, T: Scalar>(dims: Dims, levels: &'a [Vec<Node<T::Stored>>], caps: &'a [u8]) -> OctreeView<'a, T> {
    let mut slices: [&[Node<T::Stored>]; MAX_LEVELS] = [&[]; MAX_LEVELS];
    for (slot, nodes) in slices.iter_mut().zip(levels) {
        *slot = nodes;
    }
    OctreeView { dims, root_level: root_level(dims), levels: slices, caps }
}

fn store<T: Scalar>(levels: &mut [Vec<Node<T::Stored>>], changed: Vec<Changed<T>>) {
    for (level, index, node) in changed {
        if let Some(slot) =
            levels.get_mut((level - NODE_LEVEL) as usize).and_then(|nodes| nodes.get_mut(index))
        {
            *slot = node;
        }
    }
}

/// Index and origin of all nodes of `level`.
fn places<T: Scalar>(view: &OctreeView<'_, T>, level: u32) -> Vec<(usize, [u32; 3])> {
    let mut places = vec![(0, [0; 3])];
    for above in (level + 1..=view.root_level()).rev() {
        let nodes = view.nodes(above);
        let children = places.into_iter().flat_map(|(index, origin)| {
            let node = nodes.get(index);
            node.into_iter().flat_map(move |node| {
                node.stored_before(8).map(move |n| (node.child(n), child_origin(origin, above, n)))
            })
        });
        places = children.collect();
    }
    places
}

/// Changes every node of `level`, knowing nothing of other changes.
fn each_node<T: Scalar>(
    dims: Dims,
    levels: &mut [Vec<Node<T::Stored>>],
    caps: &[u8],
    level: u32,
    change: impl Fn(&OctreeView<'_, T>, &mut Node<T::Stored>, [u32; 3]) + Sync,
) {
    let places = places(&view::<T>(dims, levels, caps), level);
    for some in places.chunks(NODES_AT_ONCE) {
        let structure = view::<T>(dims, levels, caps);
        let change = |&(index, origin): &(usize, [u32; 3])| {
            let mut node = *structure.nodes(level).get(index)?;
            change(&structure, &mut node, origin);
            Some((level, index, node))
        };
        let changed = some.par_iter().filter_map(change).collect();
        store::<T>(levels, changed);
    }
}

/// In the node given by level, index and origin, and those below it: the samples of level 2, and the ranges of regions of edge 8 as far as levels 1 and 2 matter.
fn fill_finest<T: Scalar>(
    view: &OctreeView<'_, T>,
    cube: &Cube<T>,
    (level, index, origin): (u32, usize, [u32; 3]),
    changed: &mut Vec<Changed<T>>,
) {
    let Some(&(mut node)) = view.nodes(level).get(index) else { return };
    for octant in 0..8 {
        let corner = child_origin(origin, level, octant);
        if level == NODE_LEVEL {
            if node.is_stored(octant) {
                node.values[octant as usize] = cube.quarter(corner).into();
            }
            continue;
        }
        if level - 1 == NODE_LEVEL && has_cells(view, corner) {
            let range = node.range(octant as usize).union(cube.range(corner));
            node.mins[octant as usize] = range.min.into();
            node.maxs[octant as usize] = range.max.into();
        }
        if node.is_stored(octant) {
            fill_finest(view, cube, (level - 1, node.child(octant), corner), changed);
        }
    }
    if level <= NODE_LEVEL + 1 {
        changed.push((level, index, node));
    }
}

/// Whether the region at `corner` has cells.
pub(crate) fn has_cells<T: Scalar>(view: &OctreeView<'_, T>, corner: [u32; 3]) -> bool {
    (0..3).all(|a| corner[a] + 1 < view.dims().axes()[a])
}

/// The coarse sample at the low corner of a stored region of `level` ≥ [`NODE_LEVEL`], from those of the next finer level.
pub(crate) fn expected_value<T: Scalar>(
    view: &OctreeView<'_, T>,
    level: u32,
    corner: [u32; 3],
    kind: Coarse,
) -> T {
    coarsen(view.dims(), kind, level, corner, |q| view.coarse(level - 1, q, kind))
}

/// `known`, the range of the cells of a region of `level` ≥ [`NODE_LEVEL`] and of what its stored children were widened by, widened by the coarse samples of
/// its own level, and for a scalar leaf by those of all levels; at level [`NODE_LEVEL`] `known` has those of finer levels already.
pub(crate) fn widened<T: Scalar>(
    view: &OctreeView<'_, T>,
    known: Range<T>,
    is_leaf: bool,
    level: u32,
    corner: [u32; 3],
    kind: Coarse,
) -> Range<T> {
    let mut range = known;
    if !has_cells(view, corner) {
        return range;
    }
    for octant in 0..8 {
        let p = std::array::from_fn(|a| corner[a] + ((octant >> a & 1) << level));
        if view.dims().contains(p) {
            range.include(view.coarse(level, p, kind));
        }
    }
    if is_leaf && level > NODE_LEVEL {
        view.include_faces(level, corner, kind, &mut range);
    }
    range
}
