//! Ray-cell pairs to time and to judge first-root finders on.

use std::ops::ControlFlow;

use isoray_cell::{Cubic, Real, Segment, relative};
use isoray_grid::Scalar;
use isoray_oracle::SplitMix64;
use isoray_trace::{Candidate, Hit, HitPolicy, Ray, Tracer};

use crate::views::View;

/// What a first-root finder is given: corner values less the isovalue, and a stretch of a ray.
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    /// Corner values relative to the isovalue, x fastest.
    pub corners: [f32; 8],
    /// The stretch, cell-local.
    pub segment: Segment,
}

/// What has to be done for a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scenario {
    /// All Bernstein coefficients lie on one side.
    Rejected,
    /// They do not, but there is no root.
    NoRoot,
    /// A root in the first half of the stretch.
    Early,
    /// One in the second.
    Late,
}

impl Scenario {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Rejected, Self::NoRoot, Self::Early, Self::Late];

    /// That of a pair.
    pub fn of(pair: &Pair) -> Self {
        let cubic = Cubic::along(&pair.corners, &pair.segment);
        let inside = cubic.0.iter().filter(|&&b| b >= 0.0).count();
        match cubic.first_root().get() {
            Some(s) if s < 0.5 => Self::Early,
            Some(_) => Self::Late,
            None if inside % 4 == 0 => Self::Rejected,
            None => Self::NoRoot,
        }
    }
}

/// Collects the cells whose corners lie on both sides, up to the hit.
struct Collect<'p>(&'p mut Vec<Pair>);

impl HitPolicy for Collect<'_> {
    fn candidate(&mut self, candidate: &Candidate) -> ControlFlow<()> {
        self.0.push(Pair { corners: candidate.corners, segment: candidate.segment });
        if candidate.first_hit().is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    fn jump(&mut self, _: &Hit) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// The pairs that single rays of a view meet, in their order, up to `count`.
pub fn met_by_rays<T: Scalar>(
    tracer: &mut Tracer<'_, T>,
    view: &View,
    isovalue: f32,
    count: usize,
) -> Vec<Pair> {
    let mut pairs = Vec::new();
    for &direction in &view.directions {
        let ray = Ray { origin: view.origin, direction, t_min: 0.0, t_max: f32::INFINITY };
        tracer.trace(&ray, isovalue, &mut Collect(&mut pairs), &mut ());
        if pairs.len() >= count {
            break;
        }
    }
    pairs.truncate(count);
    pairs
}

/// Random corners of both signs, and stretches from face to face.
pub fn random(count: usize, seed: u64) -> Vec<Pair> {
    let mut rng = SplitMix64::new(seed);
    let mut pairs = Vec::with_capacity(count);
    while pairs.len() < count {
        let corners: [f32; 8] = std::array::from_fn(|_| rng.range(-1.0, 1.0) as f32);
        let mut end = |side: f32| {
            let mut p: [f32; 3] = std::array::from_fn(|_| rng.unit() as f32);
            p[rng.below(3) as usize] = side;
            p
        };
        let segment = Segment { entry: end(0.0), exit: end(1.0) };
        if corners.iter().any(|&c| c < 0.0) && corners.iter().any(|&c| c >= 0.0) {
            pairs.push(Pair { corners, segment });
        }
    }
    pairs
}

/// The pairs that have an extremum inside, with the isovalue moved to within 10⁻⁶ to 10⁻² of its value, relative to the largest
/// corner: on one side the ray just misses the surface, on the other it just enters it and leaves.
pub fn grazing(pairs: &[Pair], seed: u64) -> Vec<Pair> {
    let mut rng = SplitMix64::new(seed);
    let shifted = |pair: &Pair| {
        let [entry, exit] = [pair.segment.entry, pair.segment.exit].map(|p| p.map(f64::from));
        let cubic = Cubic::along(&pair.corners.map(f64::from), &Segment { entry, exit });
        // Most have none, which their coefficients tell sooner.
        let [b0, b1, b2, b3] = cubic.0;
        if [b1 - b0, b2 - b1, b3 - b2].windows(2).all(|slopes| slopes[0] * slopes[1] > 0.0) {
            return None;
        }
        // Where the slope changes sign, by sampling.
        const SAMPLES: u32 = 256;
        let at = |n: u32| cubic.at(f64::from(n) / f64::from(SAMPLES));
        let n = (1..SAMPLES).find(|&n| (at(n) - at(n - 1)) * (at(n + 1) - at(n)) < 0.0)?;
        let largest = pair.corners.iter().fold(0.0, |m: f32, c| m.max(c.abs()));
        let off = rng.sign() * 10_f64.powf(rng.range(-6.0, -2.0)) * f64::from(largest);
        let corners = relative(&pair.corners, (at(n) + off) as f32);
        Some(Pair { corners, segment: pair.segment })
    };
    pairs.iter().filter_map(shifted).collect()
}

/// Pairs side by side in lanes; the last one fills lanes that are left.
pub fn pack<R: Real<Scalar = f32>>(pairs: &[Pair]) -> ([R; 8], Segment<R>) {
    let pair = |n: usize| &pairs[n.min(pairs.len() - 1)];
    let (entry, exit) = (R::gather(|n| pair(n).segment.entry), R::gather(|n| pair(n).segment.exit));
    (R::gather(|n| pair(n).corners), Segment { entry, exit })
}

/// All pairs in lanes; what is left over is dropped.
pub fn packed<R: Real<Scalar = f32>>(pairs: &[Pair]) -> Vec<([R; 8], Segment<R>)> {
    pairs.chunks_exact(R::LANES).map(pack).collect()
}
