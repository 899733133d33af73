//! Volume integration along many rays at once against each ray alone.

use isoray_build::build;
use isoray_grid::{DenseVolume, Dims, Scalar};
use isoray_octree::OctreeVolume;
use isoray_oracle::{RayKind, SplitMix64, adversarial_lattice};
use isoray_preint::{
    Bounded, ControlPoint, Cuts, Integrate, Lighting, LinearPieces, Linearised, Radiance, TransferFunction,
    Visibility,
};
use isoray_trace::{Ray, VolumeTracer, Work};

fn volume<T: Scalar>(dims: [u32; 3], samples: &[T]) -> OctreeVolume<T> {
    let mut source = DenseVolume::new(Dims::new(dims).unwrap(), samples).unwrap();
    build(&mut source, glam::DAffine3::IDENTITY, |_| {}).unwrap()
}

/// Values from `low` to `high` with a gap in between, at which there is a step.
fn transfer([low, high]: [f32; 2], extinction: f32) -> TransferFunction {
    let at = |share: f32, color: [f32; 3], extinction| ControlPoint {
        value: low + share * (high - low),
        color,
        extinction,
    };
    let points = vec![
        at(0.1, [0.9, 0.5, 0.1], 0.0),
        at(0.3, [0.2, 0.5, 0.8], extinction),
        at(0.5, [0.1, 0.9, 0.4], 0.0),
        at(0.6, [1.0, 0.2, 0.4], 0.0),
        at(0.6, [1.0, 0.2, 0.4], 3.0 * extinction),
        at(0.9, [0.5, 0.6, 0.7], extinction),
    ];
    TransferFunction::new(points).unwrap()
}

/// Rays around one: close to it, most of them, to one side or several; some that run back, and some that are none.
fn bundle(kind: RayKind, dims: [u32; 3], seed: u64) -> Vec<Ray> {
    let mut random = SplitMix64::new(seed);
    let first = kind.generate(dims, seed);
    let first =
        Ray { origin: first.origin, direction: first.direction, t_min: first.t_min, t_max: first.t_max };
    let spacing = [0.0, 0.01, 0.15][random.below(3) as usize];
    let count = 1 + random.below(70);
    let mut rays: Vec<Ray> = (0..count)
        .map(|n| {
            let mut ray = first;
            let a = random.below(3) as usize;
            ray.origin[a] += spacing * random.range(-1.0, 1.0) as f32;
            if n > 1 {
                match random.below(12) {
                    0 => ray.direction[a] = -ray.direction[a],
                    1 => ray.direction[a] = 0.0,
                    2 => ray.direction = ray.direction.map(|d| d * random.range(0.97, 1.03) as f32),
                    3 => ray.t_max = ray.t_min + random.range(0.0, 30.0) as f32,
                    _ => {}
                }
            }
            ray
        })
        .collect();
    if random.below(8) == 0 {
        let n = random.below(count) as usize;
        rays[n].direction[random.below(3) as usize] = f32::NAN;
    }
    rays
}

/// Rays met, those that ended early, and the nodes of single rays and of all at once.
#[derive(Debug, Default)]
struct Tally {
    lit: u32,
    ended: u32,
    single: Work,
    together: Work,
}

/// Bit for bit; bounds of errors may be no numbers.
fn numbers(of: &Radiance) -> ([u64; 5], bool, u32) {
    let [r, g, b] = of.color;
    let error = if of.error.is_nan() { f64::NAN } else { of.error };
    ([r, g, b, of.transmittance, error].map(f64::to_bits), of.is_done, of.pieces)
}

fn check<T: Scalar>(
    octree: &OctreeVolume<T>,
    transfer: &TransferFunction,
    scheme: &impl Integrate,
    seed: u64,
    tally: &mut Tally,
) {
    let (view, visible) = (octree.view(), Visibility::new(transfer));
    let [mut single, mut together] = [(); 2].map(|()| VolumeTracer::new(&view, &visible));
    let lit_by = |n: usize| {
        (seed.is_multiple_of(2) && !n.is_multiple_of(5)).then(|| Lighting {
            ambient: 0.5,
            diffuse: 0.4 + n as f32 / 100.0,
            specular: 0.1,
            exponent: 8.0,
            light: [0.01, 0.02, 0.005],
            half: [0.02, 0.01, 0.01],
        })
    };
    for (n, kind) in (0..4).flat_map(|n| RayKind::ALL.map(|kind| (n, kind))) {
        let rays = bundle(kind, octree.meta().dims.axes(), seed * 100 + n);
        let expected = rays
            .iter()
            .enumerate()
            .map(|(n, ray)| single.integrate(ray, 0.7, scheme, lit_by(n).as_ref(), &mut tally.single));
        let expected: Vec<Radiance> = expected.collect();
        let mut found = vec![None; rays.len()];
        together.integrate_all(&rays, 0.7, scheme, lit_by, &mut tally.together, |n, radiance| {
            assert_eq!(found[n].replace(radiance), None, "told once");
        });
        for (n, (found, expected)) in found.iter().zip(&expected).enumerate() {
            let found = found.as_ref().map(numbers);
            assert_eq!(found, Some(numbers(expected)), "seed {seed}, {kind:?}, ray {n}: {:?}", rays[n]);
            tally.lit += u32::from(expected.pieces > 0);
            tally.ended += u32::from(expected.is_done);
        }
    }
    assert_eq!(tally.single.cells, tally.together.cells, "seed {seed}");
}

fn check_all<T: Scalar>(samples: impl Fn(u64) -> ([u32; 3], Vec<T>)) {
    let mut tally = Tally::default();
    for seed in 0..60 {
        let (dims, samples) = samples(seed);
        let octree = volume(dims, &samples);
        let finite = || samples.iter().filter(|s| s.is_finite()).map(|s| s.to_f32());
        let range = [finite().fold(f32::INFINITY, f32::min), finite().fold(f32::NEG_INFINITY, f32::max)];
        if !(range[1] - range[0] > 1e-3 && range[1] - range[0] < 1e6) {
            continue;
        }
        let transfer = transfer(range, [0.01, 0.3, 20.0][seed as usize % 3]);
        match seed % 4 {
            0 => {
                let (cuts, pieces) = (Cuts::Fixed(2), LinearPieces::new(&transfer));
                let scheme = Linearised { cuts, pieces, terminate: 0.01 };
                check(&octree, &transfer, &scheme, seed, &mut tally);
            }
            _ => check(&octree, &transfer, &Bounded::new(&transfer, 1e-3, 1.5), seed, &mut tally),
        }
    }
    println!("{tally:?}");
    assert!(tally.lit > 2000 && tally.ended > 200, "{tally:?}");
    assert!(2 * tally.together.nodes < tally.single.nodes, "rays do go together: {tally:?}");
}

#[test]
fn small_volumes() {
    let of = |seed: u64| {
        let dims = [7, 11, 13].map(|n| 2 + (seed.wrapping_mul(n) % 19) as u32);
        (dims, adversarial_lattice(dims, seed))
    };
    check_all(of);
    check_all(|seed| {
        let (dims, samples) = of(seed);
        (dims, samples.into_iter().map(|s| s.clamp(0.0, 255.0) as u8).collect())
    });
}

#[test]
fn large_leaves() {
    let dims = [67, 43, 38];
    check_all(|seed| {
        let mut random = SplitMix64::new(seed);
        // Regions of 16³ samples, some of noise and some of one value.
        let regions = (0..dims[2]).flat_map(|z| {
            (0..dims[1]).flat_map(move |y| (0..dims[0]).map(move |x| x / 16 + y / 16 * 3 + z / 16 * 5))
        });
        let value = |region: u32| match region % 3 {
            0 => random.below(4000) as u16,
            _ => (region * 541 % 4000) as u16,
        };
        (dims, regions.map(value).collect())
    });
}
