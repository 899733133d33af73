//! Lattices full of ties, steps and outliers.

use super::SplitMix64;

/// The kinds of adversarial lattices.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum LatticeKind {
    /// One value everywhere.
    Constant,
    /// Two values in turn along every axis: each cell is a saddle with many surfaces.
    Checker,
    /// Random integers 0 to 4: plateaus of every shape.
    FewValued,
    /// A few random waves: what data look like.
    Smooth,
    /// Small random values and one of 1e30.
    HugeSample,
    /// Random integers 0 to 255.
    Bytes,
    /// As `FewValued`, one sample in sixteen NaN or infinite.
    NonFinite,
}

impl LatticeKind {
    /// All kinds, in the order in which seeds cycle through them.
    pub const ALL: [Self; 7] = [
        Self::Constant,
        Self::Checker,
        Self::FewValued,
        Self::Smooth,
        Self::HugeSample,
        Self::Bytes,
        Self::NonFinite,
    ];

    /// The samples of a lattice of this kind, x fastest.
    pub fn generate(self, dims: [u32; 3], seed: u64) -> Vec<f32> {
        const FEW: u32 = 5;
        let mut rng = SplitMix64::new(seed);
        let rng = &mut rng;
        let small = |rng: &mut SplitMix64| rng.below(FEW) as f32;
        let count: usize = dims.iter().map(|&n| n as usize).product();
        match self {
            Self::Constant => vec![small(rng); count],
            Self::Checker => {
                let values = [small(rng), small(rng)];
                points(dims).map(|p| values[(p.iter().sum::<u32>() % 2) as usize]).collect()
            }
            Self::FewValued => (0..count).map(|_| small(rng)).collect(),
            Self::Smooth => smooth(dims, rng),
            Self::HugeSample => {
                const HUGE: f32 = 1e30;
                let mut samples: Vec<f32> = (0..count).map(|_| rng.range(-1.0, 1.0) as f32).collect();
                let at = rng.below(u32::try_from(count).unwrap_or(u32::MAX)) as usize;
                if let Some(sample) = samples.get_mut(at) {
                    *sample = if rng.coin() { HUGE } else { -HUGE };
                }
                samples
            }
            Self::Bytes => (0..count).map(|_| f32::from(rng.next_u64() as u8)).collect(),
            Self::NonFinite => {
                const ODDS: u32 = 16;
                const OUTLIERS: [f32; 3] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
                let sample = |_| match rng.below(ODDS) {
                    0 => OUTLIERS[rng.below(3) as usize],
                    _ => small(rng),
                };
                (0..count).map(sample).collect()
            }
        }
    }
}

/// Sums of waves with wavelengths from four voxels up.
fn smooth(dims: [u32; 3], rng: &mut SplitMix64) -> Vec<f32> {
    const WAVES: usize = 4;
    let limit = std::f64::consts::FRAC_PI_2;
    let waves: [[f64; 4]; WAVES] = std::array::from_fn(|_| {
        let phase = rng.range(0.0, std::f64::consts::TAU);
        [rng.range(-limit, limit), rng.range(-limit, limit), rng.range(-limit, limit), phase]
    });
    let value = |p: [u32; 3]| -> f64 {
        let [x, y, z] = p.map(f64::from);
        waves.iter().map(|w| (w[0] * x + w[1] * y + w[2] * z + w[3]).sin()).sum()
    };
    points(dims).map(|p| value(p) as f32).collect()
}

/// The points of a lattice, x fastest.
fn points([nx, ny, nz]: [u32; 3]) -> impl Iterator<Item = [u32; 3]> {
    (0..nz).flat_map(move |z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])))
}

/// A lattice of the kind that `seed` comes to in the cycle of [`LatticeKind::ALL`], x fastest.
pub fn adversarial_lattice(dims: [u32; 3], seed: u64) -> Vec<f32> {
    LatticeKind::ALL[(seed % LatticeKind::ALL.len() as u64) as usize].generate(dims, seed)
}

/// An isovalue for some samples: one of them, one a unit in the last place beside it, or the middle
/// between two of them. Always finite.
pub fn adversarial_isovalue(samples: &[f32], seed: u64) -> f32 {
    /// Tries to draw a finite sample.
    const DRAWS: u32 = 64;
    let mut rng = SplitMix64::new(seed);
    let mut draw = || {
        let n = u32::try_from(samples.len()).unwrap_or(u32::MAX);
        (0..DRAWS)
            .filter_map(|_| samples.get(rng.below(n) as usize).copied())
            .find(|s| s.is_finite())
            .unwrap_or(0.0)
    };
    let (a, b) = (draw(), draw());
    match rng.below(4) {
        0 => a,
        1 => a.next_up().min(f32::MAX),
        2 => a.next_down().max(f32::MIN),
        _ => 0.5 * a + 0.5 * b,
    }
}
