//! Hits, and what a traversal does about them.

use std::ops::ControlFlow;

use isoray_cell::{Cubic, Segment};
use isoray_grid::Dims;

use crate::ray::DepartingRay;

/// A crossing of the isosurface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Where on the ray.
    pub t: f32,
    /// Level of detail: the cell is `2^level` voxels wide.
    pub level: u32,
    /// Low corner of the cell.
    pub cell: [u32; 3],
    /// Position in the cell, cell-local.
    pub local: [f32; 3],
    /// The cell's corner values less the isovalue, x fastest.
    pub corners: [f32; 8],
    /// The ray passes from outside (below the isovalue) to inside.
    pub is_entering: bool,
}

impl Hit {
    /// Gradient of the cell's own interpolant, per unit of index space (*forward* normals).
    pub fn gradient(&self) -> [f32; 3] {
        let width = (1u64 << self.level) as f32;
        isoray_cell::gradient(&self.corners, self.local).map(|g| g / width)
    }

    /// Whether a direction, in index space, leads behind the surface or along it, seen from where the ray came from: light from there cannot reach the side that the viewer sees.
    #[inline]
    pub fn faces_away(&self, direction: [f32; 3]) -> bool {
        let slope: f32 = self.gradient().iter().zip(direction).map(|(g, d)| g * d).sum();
        slope == 0.0 || (slope < 0.0) != self.is_entering
    }

    /// Where it is, in index space.
    pub fn position(&self) -> [f64; 3] {
        let width = (1u64 << self.level) as f64;
        std::array::from_fn(|a| f64::from(self.cell[a]) + f64::from(self.local[a]) * width)
    }

    /// The cell of the finest lattice, of a volume of these dimensions, in which it is, and where in it.
    pub fn in_finest(&self, dims: Dims) -> ([u32; 3], [f32; 3]) {
        if self.level == 0 {
            return (self.cell, self.local);
        }
        let position = self.position();
        let cell = std::array::from_fn(|a| (position[a] as u32).min(dims.axes()[a].saturating_sub(2)));
        (cell, std::array::from_fn(|a| (position[a] - f64::from(cell[a])).clamp(0.0, 1.0) as f32))
    }

    /// One that was found on the lattice of a level of detail.
    pub fn on_level(self, level: u32) -> Self {
        Self { level, cell: self.cell.map(|c| c << level), ..self }
    }

    /// A ray that starts here, on the first of the surfaces, and is expected to leave it to the inside or to the outside. A viewer who sees
    /// the ray that hit enter is outside.
    pub fn departing_ray(&self, direction: [f32; 3], t_max: f32, into_inside: bool) -> DepartingRay {
        DepartingRay::new(self.cell, self.local, self.level, direction, t_max, into_inside)
    }
}

/// A ray's stretch in a cell whose corners lie on both sides of the isovalue.
#[derive(Clone, Copy, Debug)]
pub struct Candidate {
    /// Level of detail: the cell is `2^level` voxels wide.
    pub level: u32,
    /// Low corner of the cell.
    pub cell: [u32; 3],
    /// Corner values less the isovalue, x fastest.
    pub corners: [f32; 8],
    /// The stretch, cell-local.
    pub segment: Segment,
    /// Where it begins and ends on the ray.
    pub interval: [f64; 2],
}

impl Candidate {
    /// The first crossing on the stretch.
    #[inline(always)]
    pub fn first_hit(&self) -> Option<Hit> {
        let cubic = Cubic::along(&self.corners, &self.segment);
        let root = cubic.first_root().get()?;
        let [begin, end] = self.interval;
        Some(Hit {
            t: (begin + f64::from(root) * (end - begin)) as f32,
            level: self.level,
            cell: self.cell,
            local: self.segment.at(root),
            corners: self.corners,
            is_entering: !cubic.starts_inside(),
        })
    }
}

/// What to do with the cells that a ray may hit, in order along the ray.
pub trait HitPolicy {
    /// Takes the next candidate; `Break` ends the traversal.
    fn candidate(&mut self, candidate: &Candidate) -> ControlFlow<()>;

    /// Takes a crossing at the face between two cells, which cannot be but where levels of detail meet.
    fn jump(&mut self, hit: &Hit) -> ControlFlow<()>;
}

/// Stops at the first hit and keeps it.
#[derive(Clone, Copy, Debug, Default)]
pub struct FirstHit(pub Option<Hit>);

impl HitPolicy for FirstHit {
    #[inline(always)]
    fn candidate(&mut self, candidate: &Candidate) -> ControlFlow<()> {
        self.0 = candidate.first_hit();
        if self.0.is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    fn jump(&mut self, hit: &Hit) -> ControlFlow<()> {
        self.0 = Some(*hit);
        ControlFlow::Break(())
    }
}

/// Stops at the first hit and keeps only that there was one (shadow rays).
#[derive(Clone, Copy, Debug, Default)]
pub struct AnyHit(pub bool);

impl HitPolicy for AnyHit {
    #[inline(always)]
    fn candidate(&mut self, candidate: &Candidate) -> ControlFlow<()> {
        self.0 = Cubic::along(&candidate.corners, &candidate.segment).first_root().found;
        if self.0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    fn jump(&mut self, _: &Hit) -> ControlFlow<()> {
        self.0 = true;
        ControlFlow::Break(())
    }
}

/// Counts all crossings up to the end of the ray.
#[derive(Clone, Copy, Debug, Default)]
pub struct CountHits(pub u32);

impl HitPolicy for CountHits {
    #[inline(always)]
    fn candidate(&mut self, candidate: &Candidate) -> ControlFlow<()> {
        self.0 += Cubic::along(&candidate.corners, &candidate.segment).roots().len() as u32;
        ControlFlow::Continue(())
    }

    fn jump(&mut self, _: &Hit) -> ControlFlow<()> {
        self.0 += 1;
        ControlFlow::Continue(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_surface_faces_where_the_ray_came_from() {
        let corners = [-0.5, 0.5, -0.5, 0.5, -0.5, 0.5, -0.5, 0.5];
        let entering = Hit { t: 1.0, level: 0, cell: [0; 3], local: [0.5; 3], corners, is_entering: true };
        let leaving = Hit { is_entering: false, ..entering };
        for (direction, expected) in [
            ([-1.0, 0.3, 0.0], [false, true]),
            ([0.1, 0.0, 2.0], [true, false]),
            ([0.0, 1.0, 0.0], [true, true]),
        ] {
            assert_eq!([entering, leaving].map(|hit| hit.faces_away(direction)), expected);
        }
    }
}
