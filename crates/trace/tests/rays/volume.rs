//! Volume integration against the float64 reference, on small adversarial volumes, rays and transfer functions.

use isoray_build::build;
use isoray_grid::{DenseVolume, Dims, GridVolume, Scalar};
use isoray_octree::OctreeVolume;
use isoray_oracle::{DenseLattice, OracleRadiance, OracleRay, OracleShading, RayKind, SplitMix64};
use isoray_oracle::{
    TransferPoint, TransferPoints, adversarial_lattice, adversarial_transfer, integrate_ray,
};
use isoray_preint::{Bounded, ControlPoint, Lighting, Radiance, TransferFunction, Visibility};
use isoray_trace::{DenseVolumeTracer, Ray, VolumeTracer, Work};
use rayon::prelude::*;

/// Bounds of the error that are asked for.
const EPSILONS: [f64; 2] = [1e-3, 1e-5];

/// How far control points are moved to see whether a pixel hangs on a rounding error: units of `2⁻²⁴` of the largest sample, as for
/// isosurfaces (DESIGN section 4, 'Grazing').
const JITTER_UNITS: f64 = 8.0;

fn volume<T: Scalar>(dims: [u32; 3], samples: &[T]) -> OctreeVolume<T> {
    let mut source = DenseVolume::new(Dims::new(dims).unwrap(), samples).unwrap();
    build(&mut source, glam::DAffine3::IDENTITY, |_| {}).unwrap()
}

fn grid<T: Scalar>(dims: [u32; 3], samples: &[T]) -> GridVolume<DenseVolume<'_, T>> {
    GridVolume::new(DenseVolume::new(Dims::new(dims).unwrap(), samples).unwrap())
}

fn ray(r: &OracleRay) -> Ray {
    Ray { origin: r.origin, direction: r.direction, t_min: r.t_min, t_max: r.t_max }
}

/// Slopes up to which [`Bounded`] is checked: single precision has to hold them, which it does not between neighbouring subnormal numbers.
const STEEPEST: f64 = 1e30;

/// `None` if a number or a slope is too large.
fn function(points: &TransferPoints) -> Option<TransferFunction> {
    let is_too_steep = |pair: &[TransferPoint]| {
        let width = pair[1].value - pair[0].value;
        width > 0.0 && pair[0].extinction.max(pair[1].extinction).max(1.0) / width > STEEPEST
    };
    if points.0.windows(2).any(is_too_steep) {
        return None;
    }
    let point = |p: &TransferPoint| ControlPoint {
        value: p.value as f32,
        color: p.color.map(|c| c as f32),
        extinction: p.extinction as f32,
    };
    TransferFunction::new(points.0.iter().map(point).collect()).ok()
}

/// Sees everything.
fn everything() -> Visibility {
    let opaque = ControlPoint { value: 0.0, color: [1.0; 3], extinction: 1.0 };
    Visibility::new(&TransferFunction::new(vec![opaque]).unwrap())
}

/// The largest difference of a channel.
fn difference(found: &Radiance, expected: &OracleRadiance) -> f64 {
    let channels = (0..3).map(|n| (found.color[n] - expected.color[n]).abs());
    channels.fold((found.alpha() - expected.alpha()).abs(), f64::max)
}

fn between(a: &Radiance, b: &Radiance) -> f64 {
    (0..3).fold((a.transmittance - b.transmittance).abs(), |m, n| m.max((a.color[n] - b.color[n]).abs()))
}

/// Whether all samples of a region of 8³ that the octree could merge have the same bits.
fn has_leaf<T: Scalar>(dims: [u32; 3], samples: &[T]) -> bool {
    const EDGE: u32 = 8;
    let dims = Dims::new(dims).unwrap();
    let [bx, by, bz] = dims.axes().map(|n| n.div_ceil(EDGE));
    (0..bx * by * bz).any(|n| {
        let low = [n % bx, n / bx % by, n / (bx * by)].map(|b| b * EDGE);
        let first = samples[dims.linear(low)];
        let along = |a: usize| low[a]..dims.axes()[a].min(low[a] + EDGE);
        along(2).all(|z| along(1).all(|y| along(0).all(|x| samples[dims.linear([x, y, z])].same_bits(first))))
    })
}

#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    rays: u32,
    lit: u32,
    /// Left out, because the answer hangs on rounding errors.
    doubtful: u32,
    /// Cases in which the two tracers must agree bit for bit.
    equal: u32,
    /// Cells integrated of those that are met.
    cells: u64,
    met: u64,
    /// The largest error as a share of ε.
    worst: f64,
}

impl Tally {
    fn join(self, other: Self) -> Self {
        Self {
            rays: self.rays + other.rays,
            lit: self.lit + other.lit,
            doubtful: self.doubtful + other.doubtful,
            equal: self.equal + other.equal,
            cells: self.cells + other.cells,
            met: self.met + other.met,
            worst: self.worst.max(other.worst),
        }
    }
}

/// What one volume is seen with.
struct Case<T: Scalar> {
    name: String,
    samples: Vec<T>,
    octree: OctreeVolume<T>,
    lattice: DenseLattice<T>,
    points: TransferPoints,
    transfer: TransferFunction,
    shading: Option<(OracleShading, Lighting)>,
    /// By how much a value may be off.
    jitter: f64,
    /// A bound of the shading.
    brightest: f32,
}

impl<T: Scalar + Into<f64>> Case<T> {
    /// `None` if the seed's transfer function has numbers or slopes that are too large.
    fn new(seed: u64, convert: impl Fn(f32) -> T) -> Option<Self> {
        let side = |n: u64| 2 + (seed.wrapping_mul(n) % 19) as u32;
        let dims = [side(7), side(11), side(13)];
        let samples: Vec<T> = adversarial_lattice(dims, seed).iter().map(|&s| convert(s)).collect();
        let finite = || samples.iter().filter(|s| s.is_finite()).map(|s| s.to_f32());
        let range = [finite().fold(f32::INFINITY, f32::min), finite().fold(f32::NEG_INFINITY, f32::max)];
        let points = adversarial_transfer(seed / 7, range.map(|v| if v.is_finite() { v } else { 0.0 }));
        let transfer = function(&points)?;
        let steepest = range[1] - range[0];
        let shading = (seed.is_multiple_of(3) && steepest > 0.0 && steepest < 1e6).then(|| shading(steepest));
        Some(Self {
            name: format!("seed {seed}, {dims:?}"),
            octree: volume(dims, &samples),
            lattice: DenseLattice::from_vec(dims, samples.clone()).unwrap(),
            samples,
            points,
            transfer,
            brightest: shading.map_or(1.0, |(_, lighting)| lighting.brightest(steepest)),
            shading,
            jitter: JITTER_UNITS * 2f64.powi(-24) * f64::from(range[0].abs().max(range[1].abs())),
        })
    }

    /// The truth, and whether it is none because moving the control points by a rounding error changes it.
    fn truth(&self, ray: &OracleRay, world_per_t: f64) -> (OracleRadiance, f64) {
        let shading = self.shading.as_ref().map(|(oracle, _)| oracle);
        let moved = |by: f64| {
            let point = |p: &TransferPoint| TransferPoint { value: p.value + by, ..*p };
            let points = TransferPoints(self.points.0.iter().map(point).collect());
            integrate_ray(&self.lattice, ray, world_per_t, &points, shading)
        };
        let truth = moved(0.0);
        let apart = |other: OracleRadiance| {
            (0..3).fold((truth.alpha() - other.alpha()).abs(), |m, n| {
                m.max((truth.color[n] - other.color[n]).abs())
            })
        };
        (truth, apart(moved(self.jitter)).max(apart(moved(-self.jitter))))
    }

    fn check(&self, seed: u64, rays: u64) -> Tally {
        let dims = self.octree.meta().dims.axes();
        let view = self.octree.view();
        let grid = grid(dims, &self.samples);
        let visible = Visibility::new(&self.transfer);
        let mut octree = VolumeTracer::new(&view, &visible);
        let mut dense = DenseVolumeTracer::new(&grid, &visible);
        let mut all_octree = VolumeTracer::new(&view, &everything());
        let mut all_dense = DenseVolumeTracer::new(&grid, &everything());
        let must_equal = !has_leaf(dims, &self.samples);
        let schemes = EPSILONS.map(|epsilon| Bounded::new(&self.transfer, epsilon, self.brightest));
        let lighting = self.shading.as_ref().map(|(_, lighting)| lighting);
        let mut tally = Tally::default();
        for (kind, n) in RayKind::ALL.into_iter().flat_map(|kind| (0..rays).map(move |n| (kind, n))) {
            let oracle_ray = kind.generate(dims, seed.wrapping_mul(1000) + n);
            let world_per_t = [1.0, 0.3, 7.0][(seed + n) as usize % 3];
            let (truth, doubt) = self.truth(&oracle_ray, world_per_t);
            tally.rays += 1;
            tally.lit += u32::from(truth.optical_depth > 0.0);
            for scheme in &schemes {
                let what = format!("{}, {kind:?} {n}, {oracle_ray:?}", self.name);
                let ray = ray(&oracle_ray);
                let [mut culled, mut met] = [Work::default(); 2];
                let a = octree.integrate(&ray, world_per_t, scheme, lighting, &mut ());
                let b = dense.integrate(&ray, world_per_t, scheme, lighting, &mut culled);
                let c = all_octree.integrate(&ray, world_per_t, scheme, lighting, &mut ());
                let d = all_dense.integrate(&ray, world_per_t, scheme, lighting, &mut met);
                tally.cells += culled.cells;
                tally.met += met.cells;
                if must_equal {
                    tally.equal += 1;
                    assert_eq!((a, c), (b, d), "{what}");
                }
                let epsilon = scheme.epsilon();
                if doubt > epsilon / 16.0 {
                    tally.doubtful += 1;
                    continue;
                }
                for (found, which) in [(a, "octree"), (b, "dense"), (c, "octree, all"), (d, "dense, all")] {
                    let error = difference(&found, &truth) / epsilon;
                    assert!(error <= 1.0, "{which}: {error} of {epsilon}, {what}\n{found:?}\n{truth:?}");
                    assert!(found.error <= epsilon, "{which}: {found:?}, {what}");
                    tally.worst = tally.worst.max(error);
                }
                let by_culling = between(&a, &c).max(between(&b, &d));
                assert!(by_culling <= epsilon, "culling: {by_culling} of {epsilon}, {what}");
            }
        }
        tally
    }
}

/// Lit from a corner, for gradients of about `steepest`.
fn shading(steepest: f32) -> (OracleShading, Lighting) {
    let lighting = Lighting {
        ambient: 0.2,
        diffuse: 0.5,
        specular: 0.3,
        exponent: 10.0,
        light: [0.8, -0.5, 0.3].map(|c: f32| c / steepest),
        half: [0.1, -0.9, 0.4].map(|c: f32| c / steepest),
    };
    let oracle = OracleShading {
        ambient: lighting.ambient.into(),
        diffuse: lighting.diffuse.into(),
        specular: lighting.specular.into(),
        exponent: lighting.exponent.into(),
        light: lighting.light.map(f64::from),
        half: lighting.half.map(f64::from),
    };
    (oracle, lighting)
}

fn check<T: Scalar + Into<f64>>(name: &str, seeds: std::ops::Range<u64>, convert: impl Fn(f32) -> T + Sync) {
    let per_seed =
        |seed| Case::new(seed, &convert).map_or(Tally::default(), |case: Case<T>| case.check(seed, 4));
    let tally = seeds.into_par_iter().map(per_seed).reduce(Tally::default, Tally::join);
    println!("{name}: {tally:?}");
    assert!(tally.lit * 4 > tally.rays, "{name}: too little to see: {tally:?}");
    assert!(tally.doubtful * 4 < tally.rays, "{name}: too much in doubt: {tally:?}");
    assert!(tally.equal > 0 && tally.cells * 10 < tally.met * 9, "{name}: nothing is culled: {tally:?}");
}

#[test]
fn f32_volumes_agree_with_the_reference() {
    check("f32", 0..98, |s| s);
}

#[test]
fn u8_volumes_agree_with_the_reference() {
    check("u8", 1000..1098, |s| s.clamp(0.0, 255.0) as u8);
}

#[test]
fn i16_volumes_agree_with_the_reference() {
    check("i16", 2000..2098, |s| (s * 100.0 - 50.0).clamp(-32768.0, 32767.0) as i16);
}

/// With leaves large and small beside noise, culled and not, the two tracers differ by what each may be off; and nothing is left behind in
/// one from ray to ray.
#[test]
fn octree_and_dense_tracer_agree_on_large_leaves() {
    let dims = [67, 43, 38];
    for seed in 0..6 {
        let mut random = SplitMix64::new(seed);
        // Regions of 16³ samples, some of noise and some of one value.
        let lattice = (0..dims[2]).flat_map(|z| {
            (0..dims[1]).flat_map(move |y| (0..dims[0]).map(move |x| x / 16 + y / 16 * 3 + z / 16 * 5))
        });
        let samples: Vec<u8> = lattice
            .map(|region| if region % 3 == 0 { random.below(256) as u8 } else { (region * 37 % 256) as u8 })
            .collect();
        let (octree, grid) = (volume(dims, &samples), grid(dims, &samples));
        let view = octree.view();
        // Three shells with nothing between them.
        let extinction = [3.0, 0.1, 1e-3][seed as usize % 3];
        let point =
            |value: u32, extinction| ControlPoint { value: value as f32, color: [0.9, 0.5, 0.1], extinction };
        let shell = |v| [point(v, 0.0), point(v + 12, extinction), point(v + 25, 0.0)];
        let transfer = TransferFunction::new([20, 90, 180].into_iter().flat_map(shell).collect()).unwrap();
        let visible = Visibility::new(&transfer);
        let scheme = Bounded::new(&transfer, 1e-4, 1.0);
        let mut octree = VolumeTracer::new(&view, &visible);
        let mut dense = DenseVolumeTracer::new(&grid, &visible);
        let mut lit = 0;
        for (kind, n) in RayKind::ALL.into_iter().flat_map(|kind| (0..60).map(move |n| (kind, n))) {
            let ray = ray(&kind.generate(dims, seed * 1000 + n));
            let [mut a_work, mut b_work] = [Work::default(); 2];
            let a = octree.integrate(&ray, 0.5, &scheme, None, &mut a_work);
            let b = dense.integrate(&ray, 0.5, &scheme, None, &mut b_work);
            let apart = between(&a, &b);
            assert!(apart <= 2.0 * scheme.epsilon(), "{apart}: {kind:?} seed {seed} ray {n}\n{a:?}\n{b:?}");
            assert_eq!(
                b,
                DenseVolumeTracer::new(&grid, &visible).integrate(&ray, 0.5, &scheme, None, &mut ())
            );
            assert_eq!(a, VolumeTracer::new(&view, &visible).integrate(&ray, 0.5, &scheme, None, &mut ()));
            assert!(a.is_done != b.is_done || a_work.cells <= b_work.cells, "{kind:?} seed {seed} ray {n}");
            lit += u32::from(b.pieces > 0);
        }
        println!("seed {seed}: {lit} lit");
        assert!(lit > 200, "seed {seed}: too little to see: {lit}");
    }
}

/// Volumes of one layer have no cells, and what is no ray meets none.
#[test]
fn where_there_is_nothing_nothing_is_gathered() {
    let opaque =
        TransferFunction::new(vec![ControlPoint { value: 0.0, color: [1.0; 3], extinction: 1.0 }]).unwrap();
    let scheme = Bounded::new(&opaque, 1e-3, 1.0);
    let along =
        Ray { origin: [-1.0, 0.0, 0.5], direction: [1.0, 0.0, 0.0], t_min: 0.0, t_max: f32::INFINITY };
    let rays = [
        along,
        Ray { direction: [0.0; 3], ..along },
        Ray { direction: [f32::NAN, 0.0, 0.0], ..along },
        Ray { origin: [f32::INFINITY, 0.0, 0.0], ..along },
        Ray { t_min: 3.0, t_max: 3.0, ..along },
        Ray { t_max: f32::NAN, ..along },
    ];
    for (dims, is_empty) in [([9, 1, 9], true), ([1, 1, 1], true), ([2, 2, 2], false), ([300, 2, 2], false)] {
        let samples = vec![7i16; dims.iter().product::<u32>() as usize];
        let grid = grid(dims, &samples);
        let mut tracer = DenseVolumeTracer::new(&grid, &everything());
        for (n, ray) in rays.iter().enumerate() {
            let found = tracer.integrate(ray, 1.0, &scheme, None, &mut ());
            assert_eq!(found == Radiance::default(), is_empty || n > 0, "{dims:?}, {ray:?}: {found:?}");
        }
    }
}

/// A length along the ray counts as many world units as the caller says.
#[test]
fn optical_depth_is_by_world_length() {
    let dims = [20, 6, 9];
    let samples = vec![3.0f32; 20 * 6 * 9];
    let (octree, grid) = (volume(dims, &samples), grid(dims, &samples));
    let half =
        TransferFunction::new(vec![ControlPoint { value: 0.0, color: [0.25; 3], extinction: 0.5 }]).unwrap();
    let scheme = Bounded::new(&half, 1e-6, 1.0);
    let ray = Ray { origin: [-1.0, 2.0, 4.25], direction: [2.0, 0.0, 0.0], t_min: 0.0, t_max: f32::INFINITY };
    for world_per_t in [0.1_f64, 0.25, 1.0] {
        let expected = 1.0 - (-0.5 * 9.5 * world_per_t).exp();
        let a = VolumeTracer::new(&octree.view(), &everything()).integrate(
            &ray,
            world_per_t,
            &scheme,
            None,
            &mut (),
        );
        let b =
            DenseVolumeTracer::new(&grid, &everything()).integrate(&ray, world_per_t, &scheme, None, &mut ());
        for found in [a, b] {
            assert!((found.alpha() - expected).abs() < 1e-6, "{found:?}, expected {expected}");
            assert!((found.color[1] - 0.25 * expected).abs() < 1e-6, "{found:?}");
        }
        // The octree's whole way is one leaf's inside, but for the cells at the upper border of the root's octants.
        assert!(a.pieces < b.pieces && b.pieces == 19, "{} and {}", a.pieces, b.pieces);
    }
}
