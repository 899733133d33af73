//! Octrees written as unstructured hexahedra, as Gerris does: every leaf is a cell, and values are at its corners.
//!
//! Coordinates are rounded, so the octree is found in integers: the edge `h` of the smallest cells comes from that of the
//! largest, halved, and from the extent of all, which must be a multiple; points are then counted in `h` from the
//! lowest corner. The cells of one size are a lattice through the corner of any of the largest.

use std::path::Path;

use glam::DAffine3;
use isoray_amr::{Centering, Patch, Values};

use super::{AmrField, AmrLevel, IndexBox, MOST_LEVELS, Outline, component_names, patch};
use crate::error::ReadError;
use crate::layout::axis_aligned;
use crate::sample::Losses;
use crate::vtk::unstructured::{self, Precision, Unstructured};
use crate::vtk::{Array, MARKS, Place};

/// Name of the format.
const FORMAT: &str = "legacy VTK hexahedra";
/// Most a point may be off its place, in edges of the smallest cells; at one half, the place would be a guess.
const MOST_OFF: f64 = 0.25;

/// The leaves of an octree, and the arrays.
#[derive(Clone, Debug)]
pub(super) struct Hexahedra {
    leaves: Vec<Leaf>,
    /// For each field, the array and the component of it.
    fields: Vec<(Array, usize)>,
}

#[derive(Clone, Debug)]
struct Leaf {
    level: usize,
    cell: IndexBox,
    /// The points at its corners, x fastest.
    corners: [u32; 8],
}

impl Hexahedra {
    /// Reads points and cells of `path`.
    pub(super) fn open(path: &Path) -> Result<(Outline, Self), ReadError> {
        let Unstructured { points, cells, arrays, precision } = unstructured::read(path)?;
        let octree = Octree::new(path, &points, &cells, precision)?;
        let leaves = octree.leaves(path, &points, &cells)?;
        let mut counts = vec![0; octree.depth + 1];
        leaves.iter().for_each(|leaf| counts[leaf.level] += 1);
        let level = |(number, &cells): (usize, &u64)| {
            let ratio = (number < octree.depth).then_some(2);
            AmrLevel { ratio, boxes: cells as usize, cells }
        };
        let levels = counts.iter().enumerate().map(level).collect();
        let (mut fields, mut components) = (Vec::new(), Vec::new());
        for array in arrays.into_iter().filter(|a| !MARKS.contains(&a.name.as_str())) {
            let centering = if array.place == Place::Points { Centering::Vertices } else { Centering::Cells };
            for (name, component) in component_names(&array.name, array.components) {
                fields.push(AmrField { name, centering, active: array.active });
                components.push((array.clone(), component));
            }
        }
        let (domain, index_to_world) = octree.place(path)?;
        let outline = Outline { format: FORMAT, fields, levels, domain, index_to_world };
        Ok((outline, Self { leaves, fields: components }))
    }

    /// Reads field `chosen` of `path`.
    pub(super) fn read(
        &self,
        path: &Path,
        chosen: usize,
        losses: &mut Losses,
    ) -> Result<Vec<Patch>, ReadError> {
        let (array, component) = &self.fields[chosen];
        let values = unstructured::values(path, array, *component, losses)?;
        let (all, count): (Vec<f32>, usize) = match array.place {
            Place::Points => {
                (self.leaves.iter().flat_map(|leaf| leaf.corners.map(|p| values[p as usize])).collect(), 8)
            }
            Place::Cells => ((0..self.leaves.len()).map(|number| values[number]).collect(), 1),
        };
        let of_leaves = Values::parts(all, std::iter::repeat(count));
        let patches = self.leaves.iter().zip(of_leaves);
        Ok(patches.map(|(leaf, values)| patch(leaf.level, &leaf.cell, values)).collect())
    }
}

/// Where the leaves of all sizes can be.
#[derive(Clone, Debug)]
struct Octree {
    /// Lowest corner of all cells in the world.
    low: [f64; 3],
    /// Edges of the smallest cells along all cells.
    size: [i64; 3],
    /// Edge of the smallest cells in the world.
    edge: f64,
    /// Levels below that of the largest cells.
    depth: usize,
    /// A corner of a cell of level 0, at or below `low` and closer to it than that cell's edge, in smallest edges from
    /// `low`.
    anchor: [i64; 3],
    /// How far a point may be off its place, in edges of the smallest cells.
    most_off: f64,
}

/// Lowest and highest coordinates of the corners of a cell.
fn bounds(points: &[[f64; 3]], cell: &[u32; 8]) -> [[f64; 2]; 3] {
    let mut bounds = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
    for &point in cell {
        for (bound, x) in bounds.iter_mut().zip(points[point as usize]) {
            *bound = [bound[0].min(x), bound[1].max(x)];
        }
    }
    bounds
}

impl Octree {
    fn new(
        path: &Path,
        points: &[[f64; 3]],
        cells: &[[u32; 8]],
        precision: Precision,
    ) -> Result<Self, ReadError> {
        if cells.is_empty() {
            return Err(ReadError::mesh(path, "CELLS", "at least one cell", "none"));
        }
        let mut all = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
        for cell in cells {
            for (all, one) in all.iter_mut().zip(bounds(points, cell)) {
                *all = [all[0].min(one[0]), all[1].max(one[1])];
            }
        }
        let rounding = rounding(precision) * all.iter().flatten().fold(0.0, |most: f64, x| most.max(x.abs()));
        let [mut smallest, mut largest] = [f64::INFINITY, 0f64];
        let mut first_largest = 0;
        for (number, cell) in cells.iter().enumerate() {
            let edge = cube(path, number, bounds(points, cell), rounding)?;
            smallest = smallest.min(edge);
            if edge > largest {
                (largest, first_largest) = (edge, number);
            }
        }
        let depth = (largest / smallest).log2().round();
        if depth >= MOST_LEVELS as f64 {
            let found = format!("edges from {smallest} to {largest}");
            return Err(ReadError::mesh(path, "cells", "fewer than 30 levels", found));
        }
        let (lengths, longest) = longest(all);
        let edge = largest / depth.exp2();
        let edge = longest / (longest / edge).round();
        let size = lengths.map(|l| (l / edge).round());
        if !size.iter().all(|&n| n < f64::from(1 << 30)) {
            let found = format!("{size:?}");
            return Err(ReadError::mesh(
                path,
                "cells",
                "fewer than 2^30 of the smallest along each axis",
                found,
            ));
        }
        // A point, the lowest one, and `edge` times their distance are each off by so much; and f64's own rounding.
        let most_off = (4.0 * rounding / edge + f64::EPSILON * longest / edge).min(MOST_OFF);
        let (low, size, depth) = (all.map(|[low, _]| low), size.map(|n| n as i64), depth as usize);
        let mut octree = Self { low, size, edge, depth, anchor: [0; 3], most_off };
        let [corner, _] = octree.corners(path, first_largest, points, &cells[first_largest])?;
        octree.anchor = corner.map(|c| match c.rem_euclid(1 << depth) {
            0 => 0,
            above => above - (1 << depth),
        });
        Ok(octree)
    }

    /// Lowest and highest corner of a cell in smallest edges from `low`.
    fn corners(
        &self,
        path: &Path,
        number: usize,
        points: &[[f64; 3]],
        cell: &[u32; 8],
    ) -> Result<[[i64; 3]; 2], ReadError> {
        let (mut low, mut high) = ([i64::MAX; 3], [i64::MIN; 3]);
        for &point in cell {
            let place = self.lattice_point(path, number, points[point as usize])?;
            low = [0, 1, 2].map(|i| low[i].min(place[i]));
            high = [0, 1, 2].map(|i| high[i].max(place[i]));
        }
        Ok([low, high])
    }

    /// The place of a point in smallest edges from `low`.
    fn lattice_point(&self, path: &Path, cell: usize, point: [f64; 3]) -> Result<[i64; 3], ReadError> {
        let exact = [0, 1, 2].map(|i| (point[i] - self.low[i]) / self.edge);
        if (0..3).all(|i| (exact[i] - exact[i].round()).abs() <= self.most_off) {
            return Ok(exact.map(|x| x.round() as i64));
        }
        let expected = format!("corners at multiples of {} from {:?}", self.edge, self.low);
        Err(ReadError::mesh(path, format!("cell {cell}"), expected, format!("{point:?}")))
    }

    fn leaves(&self, path: &Path, points: &[[f64; 3]], cells: &[[u32; 8]]) -> Result<Vec<Leaf>, ReadError> {
        cells.iter().enumerate().map(|(number, cell)| self.leaf(path, points, number, cell)).collect()
    }

    fn leaf(
        &self,
        path: &Path,
        points: &[[f64; 3]],
        number: usize,
        cell: &[u32; 8],
    ) -> Result<Leaf, ReadError> {
        let wrong =
            |expected: &str, found: String| ReadError::mesh(path, format!("cell {number}"), expected, found);
        let [low, high] = self.corners(path, number, points, cell)?;
        let edges = [0, 1, 2].map(|i| high[i] - low[i]);
        let edge = edges[0];
        if edges != [edge; 3] || edge.count_ones() != 1 || edge > 1 << self.depth {
            let expected = "a cube whose edge is that of the largest cells, halved some times";
            return Err(wrong(expected, format!("{edges:?} times the smallest edge")));
        }
        // Gerris counts from the top along y and z: the corner of a point is told by where it is.
        let mut corners = [None; 8];
        for &point in cell {
            let place = self.lattice_point(path, number, points[point as usize])?;
            let at = (0..3).try_fold(0, |at, i| match place[i] {
                x if x == low[i] => Some(at),
                x if x == high[i] => Some(at | (1 << i)),
                _ => None,
            });
            if let Some(at) = at {
                corners[at] = Some(point);
            }
        }
        let [Some(a), Some(b), Some(c), Some(d), Some(e), Some(f), Some(g), Some(h)] = corners else {
            return Err(wrong("eight points at the corners of a cube", format!("points {cell:?}")));
        };
        let from_anchor = [0, 1, 2].map(|i| low[i] - self.anchor[i]);
        if from_anchor.iter().any(|x| x % edge != 0) {
            let expected = "a cell at a multiple of its edge from the corner of a cell of the largest size";
            return Err(wrong(
                expected,
                format!("{from_anchor:?} times the smallest edge, of which it has {edge}"),
            ));
        }
        let index = from_anchor.map(|x| x / edge);
        let level = self.depth - edge.trailing_zeros() as usize;
        let cell = IndexBox::new(index, index)
            .ok_or_else(|| wrong("fewer than 2^30 cells along each axis", format!("{index:?}")))?;
        Ok(Leaf { level, cell, corners: [a, b, c, d, e, f, g, h] })
    }

    /// The box of level 0, whose lowest cell is (0, 0, 0), and the map to the world.
    fn place(&self, path: &Path) -> Result<(IndexBox, DAffine3), ReadError> {
        let coarse = 1i64 << self.depth;
        let high = [0, 1, 2].map(|i| (self.size[i] - self.anchor[i]).div_euclid(coarse));
        let partly = [0, 1, 2].map(|i| (self.size[i] - self.anchor[i]).rem_euclid(coarse) > 0);
        let high = [0, 1, 2].map(|i| high[i] - i64::from(!partly[i]));
        let edge = self.edge * coarse as f64;
        let origin = [0, 1, 2].map(|i| self.low[i] + self.edge * self.anchor[i] as f64);
        let placed = IndexBox::new([0; 3], high).zip(axis_aligned([edge; 3], origin));
        placed.ok_or_else(|| ReadError::mesh(path, "cells", "finite coordinates", format!("{origin:?}")))
    }
}

/// How far coordinates may be off, relative to the largest.
fn rounding(precision: Precision) -> f64 {
    match precision {
        // Half a unit in the sixth digit, which is the last that C and C++ print by default: at most 5 in 10^6.
        Precision::Text => 5e-6,
        Precision::Float => f64::from(f32::EPSILON) / 2.0,
        Precision::Double => f64::EPSILON / 2.0,
    }
}

/// The edge of a cell, which must be a cube up to the rounding of its corners.
fn cube(path: &Path, number: usize, bounds: [[f64; 2]; 3], rounding: f64) -> Result<f64, ReadError> {
    let edges = bounds.map(|[low, high]| high - low);
    let edge = edges.iter().sum::<f64>() / 3.0;
    // Each edge lies between two rounded coordinates.
    let is_cube = edges.iter().all(|e| *e > 0.0 && (e - edge).abs() <= 4.0 * rounding + f64::EPSILON * edge);
    if is_cube && edge.is_finite() {
        return Ok(edge);
    }
    Err(ReadError::mesh(path, format!("cell {number}"), "an axis-aligned cube", format!("edges {edges:?}")))
}

/// The lengths of a box, and the longest.
fn longest(bounds: [[f64; 2]; 3]) -> ([f64; 3], f64) {
    let lengths = bounds.map(|[low, high]| high - low);
    (lengths, lengths.into_iter().fold(0.0, f64::max))
}
