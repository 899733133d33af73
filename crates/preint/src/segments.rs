//! Stretches of a ray in cells, gathered for lanes, and what has been accumulated along the ray.

use isoray_cell::Real;
use wide::f32x16;

/// Segments that are integrated at a time.
pub const LANES: usize = 16;

/// Consecutive stretches of one ray in cells, front to back, a lane each.
#[derive(Clone, Debug)]
pub struct Segments {
    corners: [[f32; LANES]; 8],
    entry: [[f32; LANES]; 3],
    exit: [[f32; LANES]; 3],
    length: [f32; LANES],
    /// What gradients in the cell are to be multiplied by.
    slope: [f32; LANES],
    count: usize,
}

/// Stretches, a lane each.
#[derive(Debug)]
pub struct LanesMut<'s> {
    /// The cells' finite corner values, x fastest.
    pub corners: &'s mut [[f32; LANES]; 8],
    /// Where the ray enters, cell-local.
    pub entry: &'s mut [[f32; LANES]; 3],
    /// Where it leaves.
    pub exit: &'s mut [[f32; LANES]; 3],
    /// The distance between the two in world units.
    pub length: &'s mut [f32; LANES],
    /// Of a cell whose edges are `1/slope` long in index space, by which gradients are multiplied; a power of two.
    pub slope: &'s mut [f32; LANES],
}

impl Default for Segments {
    fn default() -> Self {
        let zero = [0.0; LANES];
        Self {
            corners: [zero; 8],
            entry: [zero; 3],
            exit: [zero; 3],
            length: zero,
            slope: [1.0; LANES],
            count: 0,
        }
    }
}

impl Segments {
    /// Adds a stretch: the cell's finite corner values, x fastest; where the ray enters and leaves, cell-local; and the distance between the
    /// two in world units. Must not be called when [full](Self::is_full).
    #[inline(always)]
    pub fn push(&mut self, corners: &[f32; 8], entry: [f32; 3], exit: [f32; 3], length: f32) {
        let n = self.count % LANES;
        self.slope[n] = 1.0;
        for (lanes, corner) in self.corners.iter_mut().zip(corners) {
            lanes[n] = *corner;
        }
        for a in 0..3 {
            self.entry[a][n] = entry[a];
            self.exit[a][n] = exit[a];
        }
        self.length[n] = length;
        self.count = n + 1;
    }

    /// Replaces all by `count` stretches, at most [`LANES`], to be written here. What other lanes hold does not matter.
    #[inline(always)]
    pub fn lanes_mut(&mut self, count: usize) -> LanesMut<'_> {
        self.count = count.min(LANES);
        let Self { corners, entry, exit, length, slope, .. } = self;
        LanesMut { corners, entry, exit, length, slope }
    }

    /// Adds a stretch along which the field is constant.
    #[inline(always)]
    pub fn push_constant(&mut self, value: f32, length: f32) {
        self.push(&[value; 8], [0.0; 3], [0.0; 3], length);
    }

    /// Whether there is no room for another.
    #[inline(always)]
    pub fn is_full(&self) -> bool {
        self.count == LANES
    }

    /// Number of stretches.
    #[inline(always)]
    pub fn count(&self) -> usize {
        self.count
    }

    /// Removes all.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// The value at the first corner of each cell.
    #[inline(always)]
    pub(crate) fn reference(&self) -> f32x16 {
        f32x16::new(self.corners[0])
    }

    /// The value at the first corner of cell `n`.
    #[inline(always)]
    pub(crate) fn reference_of(&self, n: usize) -> f64 {
        self.corners[0][n].into()
    }

    #[inline(always)]
    pub(crate) fn lengths(&self) -> f32x16 {
        f32x16::new(self.length)
    }

    #[inline(always)]
    pub(crate) fn length_of(&self, n: usize) -> f64 {
        self.length[n].into()
    }

    /// What gradients are to be multiplied by.
    #[inline(always)]
    pub(crate) fn slopes(&self) -> f32x16 {
        f32x16::new(self.slope)
    }

    /// That of segment `n`.
    pub(crate) fn slope_of(&self, n: usize) -> f64 {
        self.slope[n].into()
    }

    /// Corner values less the first one's.
    #[inline(always)]
    pub(crate) fn relative(&self) -> [f32x16; 8] {
        self.corners.map(|c| f32x16::new(c) - self.reference())
    }

    /// Where the rays enter and leave.
    #[inline(always)]
    pub(crate) fn ends(&self) -> isoray_cell::Segment<f32x16> {
        isoray_cell::Segment { entry: self.entry.map(f32x16::new), exit: self.exit.map(f32x16::new) }
    }

    /// Segment `n` alone, in double precision: corners less the first one's, and ends.
    pub(crate) fn alone(&self, n: usize) -> ([f64; 8], isoray_cell::Segment<f64>) {
        let reference = self.reference_of(n);
        let at = |ends: &[[f32; LANES]; 3]| std::array::from_fn(|a| f64::from(ends[a][n]));
        let corners = std::array::from_fn(|c| f64::from(self.corners[c][n]) - reference);
        (corners, isoray_cell::Segment { entry: at(&self.entry), exit: at(&self.exit) })
    }

    /// Least and greatest corner value of each cell.
    #[inline(always)]
    pub(crate) fn ranges(&self) -> [f32x16; 2] {
        let corners = self.corners.map(f32x16::new);
        let least = corners.into_iter().reduce(Real::min).unwrap_or(f32x16::ZERO);
        let greatest = corners.into_iter().reduce(Real::max).unwrap_or(f32x16::ZERO);
        [least, greatest]
    }
}

/// What a ray has gathered so far, front to back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Radiance {
    /// Linear RGB, premultiplied.
    pub color: [f64; 3],
    /// Share of what lies behind that still comes through.
    pub transmittance: f64,
    /// Bound of the error so far, of any channel: of a scheme that has one.
    pub error: f64,
    /// What lies behind cannot matter any more.
    pub is_done: bool,
    /// Number of pieces integrated.
    pub pieces: u32,
}

impl Default for Radiance {
    fn default() -> Self {
        Self { color: [0.0; 3], transmittance: 1.0, error: 0.0, is_done: false, pieces: 0 }
    }
}

impl Radiance {
    /// Opacity so far.
    pub fn alpha(&self) -> f64 {
        1.0 - self.transmittance
    }

    /// Puts a piece of the given opacity and colour (not premultiplied) behind what there is.
    #[inline(always)]
    pub(crate) fn add(&mut self, alpha: f64, color: [f64; 3]) {
        let weight = self.transmittance * alpha;
        for (sum, c) in self.color.iter_mut().zip(color) {
            *sum += weight * c;
        }
        self.transmittance -= weight;
        self.pieces += 1;
    }

    /// Likewise, of a colour that is premultiplied.
    #[inline(always)]
    pub(crate) fn add_premultiplied(&mut self, alpha: f64, color: [f32; 3]) {
        for (sum, c) in self.color.iter_mut().zip(color) {
            *sum += self.transmittance * f64::from(c);
        }
        self.transmittance -= self.transmittance * alpha;
        self.pieces += 1;
    }
}
