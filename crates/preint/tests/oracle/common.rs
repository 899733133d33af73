//! A pixel, and what the oracle says about it.

use isoray_oracle::{
    OracleRadiance, OracleShading, OracleStretch, SplitMix64, TransferPoint, TransferPoints,
    integrate_stretch,
};
use isoray_preint::{Bounded, ControlPoint, Integrate, Lighting, Radiance, Segments, TransferFunction};

/// A stretch of a ray in a cell.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stretch {
    pub(crate) corners: [f32; 8],
    pub(crate) entry: [f32; 3],
    pub(crate) exit: [f32; 3],
    pub(crate) length: f32,
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
    pub(crate) fn exact(&self) -> OracleStretch {
        OracleStretch {
            corners: self.corners.map(f64::from),
            entry: self.entry.map(f64::from),
            exit: self.exit.map(f64::from),
            length: self.length.into(),
        }
    }
}

/// Control points as the oracle takes them.
pub(crate) fn points(points: &[ControlPoint]) -> TransferPoints {
    let point = |p: &ControlPoint| TransferPoint {
        value: p.value.into(),
        color: p.color.map(f64::from),
        extinction: p.extinction.into(),
    };
    TransferPoints(points.iter().map(point).collect())
}

/// Shading as the oracle takes it.
pub(crate) fn shading(lighting: &Lighting) -> OracleShading {
    OracleShading {
        ambient: lighting.ambient.into(),
        diffuse: lighting.diffuse.into(),
        specular: lighting.specular.into(),
        exponent: lighting.exponent.into(),
        light: lighting.light.map(f64::from),
        half: lighting.half.map(f64::from),
    }
}

/// Least and greatest.
pub(crate) fn range(corners: &[f32; 8]) -> [f32; 2] {
    corners.iter().fold([f32::INFINITY, f32::NEG_INFINITY], |[a, b], &s| [a.min(s), b.max(s)])
}

/// A bound of the slope along any axis.
pub(crate) fn steepest(stretches: &[Stretch]) -> f32 {
    let width = |s: &Stretch| {
        let [low, high] = range(&s.corners);
        (high - low).next_up()
    };
    stretches.iter().map(width).fold(0.0, f32::max)
}

/// A light and a highlight; the factor is of the order of 1 where the field is steep.
pub(crate) fn lighting(rng: &mut SplitMix64, steepest: f32) -> Lighting {
    let mut direction =
        || std::array::from_fn(|_| (rng.range(-2.0, 2.0) / f64::from(steepest.max(1e-25))) as f32);
    let [light, half] = [direction(), direction()];
    let exponent = [1.0, 1.5, 2.0, 10.5, 50.0][rng.below(5) as usize];
    let specular = [0.0, 0.5][rng.below(2) as usize];
    Lighting { ambient: 0.2, diffuse: 0.7, specular, exponent, light, half }
}

/// Control points of the oracle's, whose numbers are all of single precision.
pub(crate) fn from_oracle(points: &TransferPoints) -> Vec<ControlPoint> {
    let point = |p: &TransferPoint| ControlPoint {
        value: p.value as f32,
        color: p.color.map(|c| c as f32),
        extinction: p.extinction as f32,
    };
    points.0.iter().map(point).collect()
}

/// Consecutive stretches, and how they are integrated: `batch` of them at a time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pixel<'a> {
    pub(crate) points: &'a [ControlPoint],
    pub(crate) epsilon: f64,
    pub(crate) lighting: Option<Lighting>,
    pub(crate) stretches: &'a [Stretch],
    pub(crate) batch: usize,
}

impl Pixel<'_> {
    pub(crate) fn integrate(&self) -> Radiance {
        let lit = self.lighting.map_or(1.0, |l| l.brightest(steepest(self.stretches)));
        let transfer = TransferFunction::new(self.points.to_vec()).expect("points are in order");
        let scheme = Bounded::new(&transfer, self.epsilon, lit);
        let mut radiance = Radiance::default();
        for stretches in self.stretches.chunks(self.batch) {
            let mut segments = Segments::default();
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

    pub(crate) fn exact(&self) -> OracleRadiance {
        self.exact_moved(0.0)
    }

    /// With control points moved by `moved` times the largest value of each cell.
    fn exact_moved(&self, moved: f64) -> OracleRadiance {
        let shading = self.lighting.as_ref().map(shading);
        let one = |stretch: &Stretch| {
            let largest = stretch.corners.iter().fold(0.0, |m: f32, s| m.max(s.abs()));
            let mut points = points(self.points);
            points.0.iter_mut().for_each(|p| p.value += moved * f64::from(largest));
            integrate_stretch(&stretch.exact(), &points, shading.as_ref())
        };
        self.stretches.iter().map(one).fold(OracleRadiance::default(), |seen, one| seen.over(&one))
    }

    /// Of any channel.
    pub(crate) fn error(&self, seen: &Radiance) -> f64 {
        difference(&self.exact(), seen.color, seen.alpha())
    }

    /// Whether 16 roundings of double precision change the exact answer by a tenth of ε.
    pub(crate) fn is_undecided(&self) -> bool {
        let exact = self.exact();
        let moves = (0..12).flat_map(|n| [-1.0, 1.0].map(|s| s * 16.0 * f64::EPSILON * 8_f64.powi(-n)));
        let changed = moves.map(|moved| self.exact_moved(moved));
        changed.into_iter().any(|c| difference(&exact, c.color, c.alpha()) > 0.1 * self.epsilon)
    }
}

fn difference(exact: &OracleRadiance, color: [f64; 3], alpha: f64) -> f64 {
    (0..3).fold((exact.alpha() - alpha).abs(), |m, n| m.max((exact.color[n] - color[n]).abs()))
}
