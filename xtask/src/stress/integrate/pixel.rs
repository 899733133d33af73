//! A pixel: consecutive segments of a ray, and what the oracle says about it.

use std::fmt;

use isoray_oracle::{OracleRadiance, OracleStretch, TransferPoints, integrate_stretch};
use isoray_preint::{Bounded, ControlPoint, Integrate, Lighting, Radiance, Segments};

use super::moved;
use crate::for_oracle;

/// A stretch of a ray in a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stretch {
    pub(super) corners: [f32; 8],
    pub(super) entry: [f32; 3],
    pub(super) exit: [f32; 3],
    pub(super) length: f32,
}

impl From<&OracleStretch> for Stretch {
    fn from(of: &OracleStretch) -> Self {
        Self {
            corners: of.corners.map(|s| s as f32),
            entry: of.entry.map(|x| x as f32),
            exit: of.exit.map(|x| x as f32),
            length: of.length as f32,
        }
    }
}

impl Stretch {
    /// Least and greatest corner value.
    pub(super) fn range(&self) -> [f32; 2] {
        self.corners.iter().fold([f32::INFINITY, f32::NEG_INFINITY], |[a, b], &s| [a.min(s), b.max(s)])
    }

    /// A bound of the slope along an axis.
    pub(super) fn steepest(&self) -> f32 {
        let along = |a: usize| {
            (0..8)
                .filter(move |c| c >> a & 1 == 0)
                .map(move |c| (f64::from(self.corners[c | 1 << a]) - f64::from(self.corners[c])).abs() as f32)
        };
        (0..3).flat_map(along).fold(0.0, f32::max).next_up()
    }

    /// For the oracle.
    pub(super) fn exact(&self) -> OracleStretch {
        OracleStretch {
            corners: self.corners.map(f64::from),
            entry: self.entry.map(f64::from),
            exit: self.exit.map(f64::from),
            length: self.length.into(),
        }
    }
}

/// Consecutive stretches, and how they are integrated.
#[derive(Clone, Copy)]
pub(super) struct Pixel<'a> {
    pub(super) points: &'a [ControlPoint],
    pub(super) epsilon: f64,
    pub(super) lit: f32,
    pub(super) lighting: Option<Lighting>,
    pub(super) stretches: &'a [Stretch],
    /// Stretches that are integrated at a time.
    pub(super) batch: usize,
}

/// As it pastes into a test.
impl fmt::Debug for Pixel<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { points, epsilon, lit, lighting, stretches, batch } = self;
        write!(
            f,
            "Pixel {{ points: &{points:?}, epsilon: {epsilon:?}, lit: {lit:?}, lighting: {lighting:?}, "
        )?;
        write!(f, "stretches: &{stretches:?}, batch: {batch} }}")
    }
}

impl Pixel<'_> {
    /// What `scheme` sees.
    pub(super) fn integrate(&self, scheme: &Bounded) -> Radiance {
        let mut radiance = Radiance::default();
        let mut segments = Segments::default();
        for stretches in self.stretches.chunks(self.batch) {
            segments.clear();
            for Stretch { corners, entry, exit, length } in stretches {
                segments.push(corners, *entry, *exit, *length);
            }
            scheme.integrate(&segments, self.lighting.as_ref(), &mut radiance);
            if radiance.is_done {
                break;
            }
        }
        radiance
    }

    /// About how many pieces the oracle cuts the stretches into, those that are shaded counted four times.
    pub(super) fn oracle_pieces(&self) -> usize {
        let each = |stretch: &Stretch| {
            let [low, high] = stretch.range();
            let below = |v: f32| self.points.partition_point(|p| p.value <= v);
            1 + below(high) - below(low)
        };
        let factor = if self.lighting.is_some() { 4 } else { 1 };
        factor * self.stretches.iter().map(each).sum::<usize>()
    }

    /// What the oracle sees, with control points moved by `by` times the largest value of each cell.
    pub(super) fn exact(&self, points: &TransferPoints, by: [f64; 2]) -> OracleRadiance {
        /// Behind it, `e^(−DARK)` of a color of 10⁶ is below 10⁻⁹.
        const DARK: f64 = 36.0;
        let shading = self.lighting.as_ref().map(for_oracle::shading);
        let mut seen = OracleRadiance::default();
        for stretch in self.stretches {
            let one = if by == [0.0; 2] {
                integrate_stretch(&stretch.exact(), points, shading.as_ref())
            } else {
                let largest = stretch.corners.iter().fold(0.0, |m: f32, s| m.max(s.abs()));
                integrate_stretch(&stretch.exact(), &moved(points, by, largest.into()), shading.as_ref())
            };
            seen = seen.over(&one);
            if seen.optical_depth > DARK {
                break;
            }
        }
        seen
    }
}

/// The largest difference of a channel.
pub(super) fn difference(a: ([f64; 3], f64), b: &OracleRadiance) -> f64 {
    (0..3).fold((a.1 - b.alpha()).abs(), |m, n| m.max((a.0[n] - b.color[n]).abs()))
}
