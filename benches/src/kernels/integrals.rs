//! Emission and absorption along stretches in cells.

use isoray_oracle::SplitMix64;
use isoray_preint::{
    Bounded, Cuts, Integrate, LANES, LinearPieces, Linearised, PreintegrationTable, Radiance, Segments,
    TableAxes,
};

use super::{Answer, dims, transfer};
use crate::cells::random;
use crate::volumes::marschner_lobb;

/// The longest stretch in a cell, its diagonal, in units of index space; and one next to which others are not told apart.
const LENGTHS: [f32; 2] = [1e-3, 1.733];
/// What is left of the light behind when rays end, in schemes without a bound.
const TERMINATE: f64 = 1e-3;

/// Random stretches in random cells of the Marschner-Lobb signal, sixteen together as if they were of one ray.
#[derive(Clone, Debug)]
pub struct Stretches {
    rays: Vec<Segments>,
}

impl Stretches {
    /// How many.
    pub const COUNT: usize = 1 << 12;

    /// Always the same.
    pub fn generate() -> Self {
        let (dims, samples) = (dims(), marschner_lobb(super::EDGE));
        let mut rng = SplitMix64::new(2);
        let mut cell = || {
            let low: [u32; 3] = dims.axes().map(|n| rng.below(n - 1));
            let corner = |n: u32| std::array::from_fn(|a| low[a] + (n >> a & 1));
            std::array::from_fn(|n| f32::from(samples[dims.linear(corner(n as u32))]))
        };
        // The corners of the pairs are of no use here: values have to be close to each other, as they are in volumes.
        let pairs = random(Self::COUNT, 3);
        let ray = |pairs: &[crate::cells::Pair]| {
            let mut segments = Segments::default();
            for pair in pairs {
                let [entry, exit] = [pair.segment.entry, pair.segment.exit];
                let square: f32 = (0..3).map(|a| (exit[a] - entry[a]).powi(2)).sum();
                segments.push(&cell(), entry, exit, square.sqrt());
            }
            segments
        };
        Self { rays: pairs.chunks_exact(LANES).map(ray).collect() }
    }

    /// What each ray shows by a scheme.
    #[inline(never)]
    pub fn integrate(&self, scheme: &impl Integrate) -> Answer {
        Answer::of_radiances(self.rays.iter().map(|segments| {
            let mut radiance = Radiance::default();
            scheme.integrate(segments, None, &mut radiance);
            radiance
        }))
    }

    /// By how much the answers of two schemes can differ if both keep every channel within these bounds, and find the same rays.
    pub fn bound(epsilons: [f64; 2]) -> f64 {
        4.0 * (epsilons[0] + epsilons[1]) * (Self::COUNT / LANES) as f64
    }
}

/// With every channel of a pixel off by at most `epsilon`.
pub fn bounded(epsilon: f64) -> Bounded {
    Bounded::new(&transfer(), epsilon, 1.0)
}

/// Cut at extrema, into pieces that are linear in the value.
pub fn adaptive() -> Linearised<LinearPieces> {
    let cuts = Cuts::Adaptive { inflection: false, shading: false };
    Linearised { cuts, pieces: LinearPieces::new(&transfer()), terminate: TERMINATE }
}

/// Cut into so many pieces of equal length.
pub fn fixed(pieces: u32) -> Linearised<LinearPieces> {
    Linearised { cuts: Cuts::Fixed(pieces), pieces: LinearPieces::new(&transfer()), terminate: TERMINATE }
}

/// As [`adaptive`], by a table of 128² values and 16 lengths.
pub fn table() -> Linearised<PreintegrationTable<f32>> {
    let [least_length, greatest_length] = LENGTHS;
    let axes = TableAxes { values: 128, lengths: 16, range: [0.0, 255.0], least_length, greatest_length };
    let pieces = PreintegrationTable::new(&transfer(), axes).expect("its axes have some extent");
    Linearised { cuts: adaptive().cuts, pieces, terminate: TERMINATE }
}
