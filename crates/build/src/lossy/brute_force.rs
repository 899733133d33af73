//! The bound on displacements against the oracle: every sample takes an extreme or any value that it may, independently of its neighbours,
//! which is far worse than what consolidation does.

#[path = "../../tests/builds/lossy/displacement.rs"]
mod displacement;

use isoray_grid::Scalar;
use isoray_oracle::{DenseLattice, LatticeKind, RayKind, SplitMix64, adversarial_isovalue, all_hits};

use super::limits::Window;
use super::loss::{Isovalues, Loss, SurfaceTolerance};
use super::rules::Rules;
use super::values::sample;

/// What has been checked.
#[derive(Debug, Default)]
struct Tally {
    hits: u32,
    changed: u32,
    /// Hits that are farther than a quarter of the bound.
    far: u32,
}

/// A volume whose samples take any values that they may.
fn perturbed<T: Scalar>(dims: [u32; 3], samples: &[f32], loss: &Loss, random: &mut SplitMix64) -> Vec<f32> {
    loss.check().unwrap();
    let rules = Rules::new::<T>(loss);
    let mut window = Window::default();
    (window.size, window.samples) = (dims.map(|n| n as usize), samples.to_vec());
    let mut limits = vec![f64::INFINITY; samples.len()];
    rules.surfaces.iter().for_each(|surfaces| window.limit(surfaces, &mut limits));
    let change = |(&s, &limit): (&f32, &f64)| {
        let allowed = rules.allowed(s, limit);
        if allowed.is_empty() {
            return s;
        }
        assert!(allowed.contains(s), "{s} is not in {allowed:?}");
        let between = allowed.low + random.unit() as f32 * (allowed.high - allowed.low);
        let new = match random.below(4) {
            0 => allowed.low,
            1 => allowed.high,
            2 if allowed.contains(between) => sample::<T>(between.floor().max(allowed.low)).to_f32(),
            _ => s,
        };
        // A bounded one: rays cannot tell numbers of 10³⁸.
        new.clamp(s - 1e4, s + 1e4)
    };
    samples.iter().zip(&limits).map(change).collect()
}

/// What fills a volume.
#[derive(Clone, Copy, Debug)]
enum Content {
    /// A slope with noise on it, so that cells are monotone along some axes and not along others.
    Slope,
    Adversarial(LatticeKind),
}

impl Content {
    const ALL: [Self; 8] = [
        Self::Slope,
        Self::Adversarial(LatticeKind::Smooth),
        Self::Slope,
        Self::Adversarial(LatticeKind::FewValued),
        Self::Slope,
        Self::Adversarial(LatticeKind::NonFinite),
        Self::Slope,
        Self::Adversarial(LatticeKind::Checker),
    ];

    /// Samples between -100 and 100 or so, whole if `is_whole`.
    fn generate(self, dims: [u32; 3], seed: u64, is_whole: bool) -> Vec<f32> {
        let random = &mut SplitMix64::new(seed);
        let samples = match self {
            Self::Slope => {
                let steepness = random.range(1.0, 12.0);
                let slope: [f64; 3] = std::array::from_fn(|_| random.range(-steepness, steepness));
                let noise = steepness * random.range(0.0, 0.6);
                let lattice = DenseLattice::from_fn(dims, |p| {
                    let ramp: f64 =
                        (0..3).map(|a| slope[a] * (f64::from(p[a]) - f64::from(dims[a]) / 2.0)).sum();
                    (ramp + random.range(-noise, noise)) as f32
                });
                lattice.samples().to_vec()
            }
            Self::Adversarial(LatticeKind::Smooth) => {
                LatticeKind::Smooth.generate(dims, seed).into_iter().map(|s| s * 25.0).collect()
            }
            Self::Adversarial(kind) => kind.generate(dims, seed),
        };
        let round = |s: f32| match is_whole {
            true if s.is_finite() => s.round().clamp(-128.0, 127.0),
            true => 0.0,
            false => s,
        };
        samples.into_iter().map(round).collect()
    }
}

fn check<T: Scalar>(seeds: std::ops::Range<u64>) -> Tally {
    let mut tally = Tally::default();
    for seed in seeds {
        let random = &mut SplitMix64::new(seed);
        let dims: [u32; 3] = std::array::from_fn(|_| 2 + random.below(9));
        let kind = Content::ALL[seed as usize % Content::ALL.len()];
        let samples = kind.generate(dims, seed, T::TYPE != isoray_grid::ScalarType::F32);
        let mut isovalues: Vec<f32> = (0..3).map(|n| adversarial_isovalue(&samples, seed * 3 + n)).collect();
        isovalues.sort_by(f32::total_cmp);
        let displacement = [0.0, 0.03, 0.3, 1.0, 5.0][random.below(5) as usize];
        let (list, range) =
            (Isovalues::List(isovalues.clone()), Isovalues::Range([isovalues[0], isovalues[2]]));
        for isovalues_of in [list, range] {
            let between = random.range(isovalues[0].into(), isovalues[2].into()) as f32;
            let surface = SurfaceTolerance { displacement, isovalues: isovalues_of };
            let mut tried = isovalues.clone();
            if matches!(surface.isovalues, Isovalues::Range(_)) {
                tried.push(between.clamp(isovalues[0], isovalues[2]));
            }
            let loss = Loss { surface: Some(surface), ..Loss::default() };
            let changed = perturbed::<T>(dims, &samples, &loss, random);
            tally.changed += samples.iter().zip(&changed).filter(|(a, b)| a != b).count() as u32;
            let what = format!("seed {seed}, {kind:?} {dims:?}, {loss:?}");
            compare(dims, &samples, &changed, &tried, displacement.min(1.0), &what, &mut tally);
        }
    }
    tally
}

/// Every hit of rays with either surface has the other one within the displacement.
fn compare(
    dims: [u32; 3],
    a: &[f32],
    b: &[f32],
    isovalues: &[f32],
    reach: f64,
    what: &str,
    tally: &mut Tally,
) {
    let [a, b] = [a, b].map(|s| DenseLattice::from_vec(dims, s.to_vec()).unwrap());
    for &v in isovalues {
        let v = f64::from(v);
        for (n, kind) in RayKind::ALL.into_iter().enumerate() {
            let ray = kind.generate(dims, n as u64 + tally.hits as u64);
            for (on, other) in [(&a, &b), (&b, &a)] {
                for hit in all_hits(on, &ray, v) {
                    assert!(
                        displacement::is_near(&hit, on, other, v, reach),
                        "{what}: isovalue {v}, {ray:?}, {hit:?}"
                    );
                    tally.hits += 1;
                    tally.far += u32::from(!displacement::is_near(&hit, on, other, v, reach / 4.0));
                }
            }
        }
    }
}

fn report(name: &str, tally: &Tally) {
    println!("{name}: {tally:?}");
    assert!(
        tally.hits > 2000 && tally.changed > 2000 && tally.far > 10,
        "{name}: too little to mean anything: {tally:?}"
    );
}

#[test]
fn surfaces_of_f32_volumes_keep_within_the_displacement() {
    report("f32", &check::<f32>(0..600));
}

#[test]
fn surfaces_of_i8_volumes_keep_within_the_displacement() {
    report("i8", &check::<i8>(1000..1600));
}

#[test]
fn surfaces_of_i16_volumes_keep_within_the_displacement() {
    report("i16", &check::<i16>(2000..2600));
}
