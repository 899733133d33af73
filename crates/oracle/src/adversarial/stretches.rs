//! Stretches through cells on which integrators usually fail.

use super::{SplitMix64, adversarial_case};
use crate::OracleStretch;

/// The kinds of adversarial stretches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum StretchKind {
    /// A cell and a stretch of an [`adversarial_case`], magnitudes limited to 10¹⁵.
    Case,
    /// One value at all corners.
    Constant,
    /// A large value, a unit in the last place more or less at some corners.
    NearlyConstant,
    /// A cubic with two extrema between the ends, along a diagonal.
    TwoExtrema,
    /// Small integers, or bytes.
    Integers,
    /// Random values around a random mean: what data look like.
    Plain,
}

impl StretchKind {
    /// All kinds, in the order in which seeds cycle through them.
    pub const ALL: [Self; 6] =
        [Self::Case, Self::Constant, Self::NearlyConstant, Self::TwoExtrema, Self::Integers, Self::Plain];

    /// A stretch of this kind: corners, entry and exit are `f32` numbers, its length is 0, 10⁻⁶, 1 or 100.
    pub fn generate(self, seed: u64) -> OracleStretch {
        const LIMIT: f32 = 1e15;
        const LENGTHS: [f64; 8] = [0.0, 1e-6, 1.0, 1.0, 1.0, 1.0, 100.0, 100.0];
        const LARGE: [f32; 4] = [30000.0, 1.0, -1e7, 65535.0];
        let mut rng = SplitMix64::new(seed ^ 0x5eed);
        let rng = &mut rng;
        let case = adversarial_case(seed);
        let length = LENGTHS[rng.below(8) as usize];
        let (mut entry, mut exit) = (case.entry, case.exit);
        let corners: [f32; 8] = match self {
            Self::Case => case.samples.map(|s| s.clamp(-LIMIT, LIMIT)),
            Self::Constant => [rng.range(-4.0, 4.0).round() as f32; 8],
            Self::NearlyConstant => {
                let value = LARGE[rng.below(4) as usize];
                let values = [value.next_down(), value, value.next_up()];
                std::array::from_fn(|_| values[rng.below(3) as usize])
            }
            Self::TwoExtrema => {
                let [up, down] = [(); 2].map(|()| 10_f64.powf(rng.range(-0.5, 1.5)));
                let by_count = [0.0, up, -down, rng.range(-1.0, 1.0)];
                (entry, exit) = ([0.0; 3], [1.0; 3]);
                std::array::from_fn(|c: usize| by_count[c.count_ones() as usize] as f32)
            }
            Self::Integers => {
                let count = [2, 5, 256][rng.below(3) as usize];
                std::array::from_fn(|_| rng.below(count) as f32)
            }
            Self::Plain => {
                let mean = rng.range(-100.0, 100.0);
                std::array::from_fn(|_| (mean + rng.range(-1.0, 1.0)) as f32)
            }
        };
        let [entry, exit] = [entry, exit].map(|end| end.map(f64::from));
        OracleStretch { corners: corners.map(f64::from), entry, exit, length }
    }
}

/// A stretch of the kind that `seed` comes to in the cycle of [`StretchKind::ALL`].
///
/// Its length is not that of the way from entry to exit, as if the cell had any size.
pub fn adversarial_stretch(seed: u64) -> OracleStretch {
    StretchKind::ALL[(seed % StretchKind::ALL.len() as u64) as usize].generate(seed)
}
