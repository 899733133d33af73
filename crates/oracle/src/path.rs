//! A ray cut into segments, one for each cell that it crosses with positive length.

use crate::OracleRay;

/// The part of a ray in the domain, in index space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Path {
    origin: [f64; 3],
    direction: [f64; 3],
    /// Cells along each axis, at least one.
    cells: [u32; 3],
    t_start: f64,
    t_end: f64,
}

/// A stretch of a ray in one cell, `t0 < t1`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Segment {
    pub(crate) cell: [u32; 3],
    pub(crate) t0: f64,
    pub(crate) t1: f64,
}

impl Path {
    /// Clips a ray to the domain of a lattice and to its own `t_min..=t_max`.
    ///
    /// `None` if nothing of positive length remains, if there are no cells, or if the ray is not one.
    pub(crate) fn new(dims: [u32; 3], ray: &OracleRay) -> Option<Self> {
        let origin = ray.origin.map(f64::from);
        let direction = ray.direction.map(f64::from);
        let finite = origin.iter().chain(&direction).all(|c| c.is_finite());
        let bounded = !ray.t_min.is_nan() && !ray.t_max.is_nan();
        if !finite || !bounded || direction == [0.0; 3] || dims.iter().any(|&n| n < 2) {
            return None;
        }
        let cells = dims.map(|n| n - 1);
        let (t_start, t_end) = (f64::from(ray.t_min), f64::from(ray.t_max));
        let mut path = Self { origin, direction, cells, t_start, t_end };
        for axis in 0..3 {
            let (first, last) = (0, cells[axis]);
            if direction[axis] == 0.0 {
                if origin[axis] < f64::from(first) || origin[axis] > f64::from(last) {
                    return None;
                }
                continue;
            }
            let (near, far) = if direction[axis] > 0.0 { (first, last) } else { (last, first) };
            path.t_start = path.t_start.max(path.plane(axis, near));
            path.t_end = path.t_end.min(path.plane(axis, far));
        }
        (path.t_start < path.t_end).then_some(path)
    }

    /// The length of the direction: voxels per unit of `t`.
    pub(crate) fn speed(&self) -> f64 {
        self.direction.iter().map(|d| d * d).sum::<f64>().sqrt()
    }

    /// The parameter at which the ray meets lattice plane `k` of an axis that it is not parallel to.
    ///
    /// The quotient is rounded once, the difference too unless it is exact, which it is for all but
    /// origins next to zero.
    #[inline]
    fn plane(&self, axis: usize, k: u32) -> f64 {
        (f64::from(k) - self.origin[axis]) / self.direction[axis]
    }

    /// The cell-local point at `t`, in `[0,1]³`; exactly 0 or 1 on the cell's faces.
    pub(crate) fn local(&self, cell: [u32; 3], t: f64) -> [f64; 3] {
        std::array::from_fn(|axis| {
            let (low, high) = (cell[axis], cell[axis] + 1);
            let d = self.direction[axis];
            let from_cell = self.origin[axis] - f64::from(low);
            if d == 0.0 {
                return from_cell.clamp(0.0, 1.0);
            }
            let (t_low, t_high) = (self.plane(axis, low), self.plane(axis, high));
            let before_low = if d > 0.0 { t <= t_low } else { t >= t_low };
            let after_high = if d > 0.0 { t >= t_high } else { t <= t_high };
            match (before_low, after_high) {
                (true, _) => 0.0,
                (_, true) => 1.0,
                _ => (from_cell + t * d).clamp(0.0, 1.0),
            }
        })
    }

    /// The segments in order.
    pub(crate) fn segments(&self) -> Segments<'_> {
        let cell: [u32; 3] = std::array::from_fn(|axis| self.first_cell(axis));
        let next = std::array::from_fn(|axis| self.exit(axis, cell[axis]));
        Segments { path: self, cell, next, t: self.t_start, done: false }
    }

    /// The parameter at which the ray leaves a layer of cells; never, where it is parallel to it.
    #[inline]
    fn exit(&self, axis: usize, cell: u32) -> f64 {
        if self.direction[axis] == 0.0 {
            f64::INFINITY
        } else if self.direction[axis] > 0.0 {
            self.plane(axis, cell + 1)
        } else {
            self.plane(axis, cell)
        }
    }

    /// The layer of cells that the ray is in just after `t_start`.
    ///
    /// The floor of the position is only a guess, as it is rounded; the crossings decide.
    fn first_cell(&self, axis: usize) -> u32 {
        let last = self.cells[axis] - 1;
        let d = self.direction[axis];
        if d == 0.0 {
            return (self.origin[axis] as u32).min(last);
        }
        let mut cell = ((self.origin[axis] + self.t_start * d) as u32).min(last);
        let passed = |k| self.plane(axis, k) <= self.t_start;
        if d > 0.0 {
            while cell > 0 && !passed(cell) {
                cell -= 1;
            }
            while cell < last && passed(cell + 1) {
                cell += 1;
            }
        } else {
            while cell < last && !passed(cell + 1) {
                cell += 1;
            }
            while cell > 0 && passed(cell) {
                cell -= 1;
            }
        }
        cell
    }
}

/// Iterator over the segments of a path.
#[derive(Clone, Debug)]
pub(crate) struct Segments<'a> {
    path: &'a Path,
    cell: [u32; 3],
    /// Where the ray leaves the current cell along each axis.
    next: [f64; 3],
    t: f64,
    done: bool,
}

impl Segments<'_> {
    /// Steps over every plane met up to `t`; planes met together are stepped over together.
    #[inline]
    fn advance(&mut self, t: f64) {
        for axis in 0..3 {
            if self.next[axis] > t {
                continue;
            }
            let forward = self.path.direction[axis] > 0.0;
            let border = if forward { self.path.cells[axis] - 1 } else { 0 };
            if self.cell[axis] == border {
                self.done = true;
                return;
            }
            self.cell[axis] = if forward { self.cell[axis] + 1 } else { self.cell[axis] - 1 };
            self.next[axis] = self.path.exit(axis, self.cell[axis]);
        }
    }
}

impl Iterator for Segments<'_> {
    type Item = Segment;

    #[inline]
    fn next(&mut self) -> Option<Segment> {
        while !self.done {
            let (cell, t0) = (self.cell, self.t);
            let t1 = self.next[0].min(self.next[1]).min(self.next[2]).min(self.path.t_end);
            self.t = t1;
            self.done = t1 >= self.path.t_end;
            if !self.done {
                self.advance(t1);
            }
            if t1 > t0 {
                return Some(Segment { cell, t0, t1 });
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::adversarial_ray;

    const DIMS: [u32; 3] = [5, 7, 4];

    /// Asserts that segments tile the path and lie between the planes of their cells; their number.
    fn check(ray: &OracleRay) -> usize {
        let Some(path) = Path::new(DIMS, ray) else { return 0 };
        let mut t = path.t_start;
        for segment in path.segments() {
            assert!(segment.t0 == t && segment.t1 > t, "{ray:?} {segment:?}");
            t = segment.t1;
            for axis in (0..3).filter(|&axis| path.direction[axis] != 0.0) {
                let low = path.plane(axis, segment.cell[axis]);
                let high = path.plane(axis, segment.cell[axis] + 1);
                let (near, far) = (low.min(high), low.max(high));
                assert!(near <= segment.t0 && segment.t1 <= far, "{ray:?} {segment:?}");
            }
        }
        assert_eq!(t, path.t_end, "{ray:?}");
        path.segments().count()
    }

    #[test]
    fn segments_tile_the_path_and_lie_between_the_planes_of_their_cells() {
        let segments: usize = (0..20_000).map(|seed| check(&adversarial_ray(DIMS, seed))).sum();
        assert!(segments > 50_000, "only {segments}");
    }

    #[test]
    fn a_path_that_enters_at_an_edge_starts_in_the_cell_behind_it() {
        for k in 1..1000_u16 {
            // The planes x = 0 and y = 1, or x = 4 and y = 5, are met at one parameter, but the rounded
            // position there may lie on either side of the latter.
            let d = f32::from(k) / 777.0;
            let up = OracleRay { origin: [-5.0, -4.0, 0.5], direction: [d, d, 0.0], t_min: 0.0, t_max: 1e9 };
            let down = OracleRay { origin: [9.0, 10.0, 0.5], direction: [-d, -d, 0.0], ..up };
            assert_eq!((check(&up), check(&down)), (4, 4));
        }
    }
}
