//! Cells whose cubic along a ray is hard to solve.

use super::SplitMix64;

/// The kinds of adversarial cells. Every corner value is an f32, and the hard isovalue is 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CellKind {
    /// Random values of both signs.
    Random,
    /// Small integers, zeros among them: plateaus and zeros on faces, edges and vertices.
    Integers,
    /// A plane, through a vertex half of the time: the cubic is linear, its higher coefficients noise.
    Plane,
    /// A product of one linear factor per axis: three planted roots, equal ones among them.
    Product,
    /// A bilinear saddle, whose isosurface crosses itself.
    Saddle,
    /// Magnitudes from 1e-30 to 1e30 beside each other.
    HugeRange,
    /// One corner on the other side by one unit in the last place.
    Barely,
    /// Zero, but for at most one corner.
    NearlyFlat,
}

impl CellKind {
    /// All kinds, in the order in which seeds cycle through them.
    pub const ALL: [Self; 8] = [
        Self::Random,
        Self::Integers,
        Self::Plane,
        Self::Product,
        Self::Saddle,
        Self::HugeRange,
        Self::Barely,
        Self::NearlyFlat,
    ];

    /// A cell of this kind; corner `c` lies at `x = c & 1`, `y = c >> 1 & 1`, `z = c >> 2`.
    pub fn generate(self, seed: u64) -> [f64; 8] {
        const EIGHTHS: u32 = 9;
        let mut rng = SplitMix64::new(seed);
        let rng = &mut rng;
        let fraction = |rng: &mut SplitMix64| f64::from(rng.below(EIGHTHS)) / 8.0;
        let cell: [f64; 8] = match self {
            Self::Random => std::array::from_fn(|_| rng.range(-1.0, 1.0)),
            Self::Integers => std::array::from_fn(|_| f64::from(rng.below(5)) - 2.0),
            Self::Plane => {
                let slope: [f64; 3] = std::array::from_fn(|_| rng.range(-1.0, 1.0));
                let at = |c: usize| (0..3).filter(|axis| c >> axis & 1 == 1).map(|axis| slope[axis]).sum();
                let corners: [f64; 8] = std::array::from_fn(at);
                let zero = if rng.coin() { corners[rng.below(8) as usize] } else { rng.range(-0.5, 0.5) };
                corners.map(|s| s - zero)
            }
            Self::Product => {
                let first = fraction(rng);
                let roots: [f64; 3] = std::array::from_fn(|_| if rng.coin() { first } else { fraction(rng) });
                let factor = |c: usize, axis: usize| (c >> axis & 1) as f64 - roots[axis];
                std::array::from_fn(|c| (0..3).map(|axis| factor(c, axis)).product())
            }
            Self::Saddle => {
                let along = rng.below(3) as usize;
                let tilt = if rng.coin() { 0.0 } else { rng.range(-1e-3, 1e-3) };
                std::array::from_fn(|c| {
                    let parity = (c & 7 & !(1 << along)).count_ones() % 2;
                    1.0 - 2.0 * f64::from(parity) + tilt * (c >> along & 1) as f64
                })
            }
            Self::HugeRange => std::array::from_fn(|_| rng.sign() * 10_f64.powf(rng.range(-30.0, 30.0))),
            Self::Barely => {
                let side = rng.sign();
                let odd = rng.below(8) as usize;
                let near = f64::from(f32::EPSILON) * f64::from(rng.below(2));
                let mut corners: [f64; 8] = std::array::from_fn(|_| side * rng.range(0.5, 1.0));
                corners[odd] = -side * near;
                corners
            }
            Self::NearlyFlat => {
                let mut corners = [0.0; 8];
                corners[rng.below(8) as usize] = f64::from(rng.below(3)) - 1.0;
                corners
            }
        };
        cell.map(|s| f64::from(s as f32))
    }
}

/// A cell of the kind that `seed` comes to in the cycle of [`CellKind::ALL`].
pub fn adversarial_cell(seed: u64) -> [f64; 8] {
    CellKind::ALL[(seed % CellKind::ALL.len() as u64) as usize].generate(seed)
}
