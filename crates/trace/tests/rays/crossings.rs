//! All crossings of several isosurfaces, and rays that start on one, against the float64 reference.

use std::ops::ControlFlow;

use isoray_build::build;
use isoray_cell::{Cubic, VALUE_ERROR_UNITS};
use isoray_grid::{DenseVolume, Dims, Scalar};
use isoray_octree::OctreeVolume;
use isoray_oracle::{
    DenseLattice, OracleRay, RayKind, SplitMix64, adversarial_isovalue, adversarial_lattice, error_in_ulps,
    judge_all,
};
use isoray_trace::{Candidate, CountHits, Crossing, DepartingRay, Hit, HitPolicy, Ray, Trace, Tracer};

fn volume<T: Scalar>(dims: [u32; 3], samples: &[T]) -> OctreeVolume<T> {
    let mut source = DenseVolume::new(Dims::new(dims).unwrap(), samples).unwrap();
    build(&mut source, glam::DAffine3::IDENTITY, |_| {}).unwrap()
}

fn ray(r: &OracleRay) -> Ray {
    Ray { origin: r.origin, direction: r.direction, t_min: r.t_min, t_max: r.t_max }
}

/// All crossings, in the order in which they come.
fn collected(
    follow: impl FnOnce(&mut dyn FnMut(&Crossing) -> ControlFlow<()>) -> ControlFlow<()>,
) -> Vec<Crossing> {
    let mut found = Vec::new();
    let end = follow(&mut |crossing| {
        found.push(*crossing);
        ControlFlow::Continue(())
    });
    assert!(end.is_continue());
    found
}

fn crossings<T: Scalar>(tracer: &mut Tracer<'_, T>, ray: &Ray, isovalues: &[f32]) -> Vec<Crossing> {
    collected(|mut visit| tracer.crossings(ray, isovalues, &mut visit, &mut ()))
}

fn departing<T: Scalar>(tracer: &mut Tracer<'_, T>, ray: &DepartingRay, isovalue: f32) -> Vec<Crossing> {
    collected(|mut visit| tracer.departing_crossings(ray, &[isovalue], &mut visit, &mut ()))
}

/// Whether there is a cell on the ray's way along which the field is so close to the isovalue that either answer is right.
struct Undecided(bool);

impl HitPolicy for Undecided {
    fn candidate(&mut self, c: &Candidate) -> ControlFlow<()> {
        let largest = c.corners.iter().fold(0f32, |m, &x| m.max(x.abs()));
        let bound = VALUE_ERROR_UNITS * f32::EPSILON / 2.0 * largest;
        self.0 |= Cubic::along(&c.corners, &c.segment).0.iter().all(|b| b.abs() <= bound);
        ControlFlow::Continue(())
    }

    fn jump(&mut self, _: &Hit) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// Every kind of ray against one kind of volume, for one to four isovalues. The numbers of rays and of crossings.
fn check<T: Scalar + Into<f64>>(seeds: std::ops::Range<u64>, convert: impl Fn(f32) -> T) -> [usize; 3] {
    let (mut rays, mut compared, mut number) = (0, 0, 0);
    for seed in seeds {
        let side = |n: u64| 2 + (seed.wrapping_mul(n) % 19) as u32;
        let dims = [side(7), side(11), side(13)];
        let samples: Vec<T> = adversarial_lattice(dims, seed).iter().map(|&s| convert(s)).collect();
        let widened: Vec<f32> = samples.iter().map(|s| s.to_f32()).collect();
        let count = 1 + seed % 4;
        let mut isovalues: Vec<f32> =
            (0..count).map(|n| adversarial_isovalue(&widened, seed * 17 + n)).collect();
        isovalues.dedup();
        let built = volume(dims, &samples);
        let lattice = DenseLattice::from_vec(dims, samples).unwrap();
        let view = built.view();
        let mut tracer = Tracer::new(&view);
        for kind in RayKind::ALL {
            for n in 0..12 {
                let oracle_ray = kind.generate(dims, seed.wrapping_mul(1000) + n);
                rays += 1;
                let verdicts = isovalues.iter().map(|&v| judge_all(&lattice, &oracle_ray, v));
                let verdicts: Vec<_> = verdicts.collect();
                let mut undecided = Undecided(false);
                for &v in &isovalues {
                    tracer.trace(&ray(&oracle_ray), v, &mut undecided, &mut ());
                }
                if undecided.0 || verdicts.iter().any(|verdict| verdict.grazing) {
                    continue;
                }
                let found = crossings(&mut tracer, &ray(&oracle_ray), &isovalues);
                let what = format!("{kind:?} seed {seed} ray {n} {dims:?} {isovalues:?}");
                assert!(found.is_sorted_by(|a, b| a.hit.t <= b.hit.t), "{what}: out of order");
                for (surface, verdict) in verdicts.iter().enumerate() {
                    let own: Vec<_> = found.iter().filter(|c| c.surface == surface).collect();
                    assert_eq!(own.len(), verdict.hits.len(), "{what}: surface {surface}, {own:?}");
                    let mut counted = CountHits::default();
                    tracer.trace(&ray(&oracle_ray), isovalues[surface], &mut counted, &mut ());
                    assert_eq!(counted.0 as usize, own.len(), "{what}");
                    for (crossing, hit) in own.iter().zip(&verdict.hits) {
                        let length: f64 =
                            oracle_ray.direction.iter().map(|&d| f64::from(d).powi(2)).sum::<f64>().sqrt();
                        let voxels = (f64::from(crossing.hit.t) - hit.t).abs() * length;
                        let is_close = voxels <= 1e-2 || error_in_ulps(crossing.hit.t, hit.t) <= 1.0;
                        assert!(is_close, "{what}: {voxels} voxels off: {crossing:?}, {hit:?}");
                        assert_eq!(crossing.hit.is_entering, hit.entering, "{what}");
                    }
                    number += own.len();
                }
                compared += 1;
            }
        }
    }
    [rays, compared, number]
}

#[test]
fn all_crossings_of_several_surfaces_agree_with_the_reference() {
    for (name, [rays, compared, crossings]) in [
        ("f32", check(0..60, |s| s)),
        ("u8", check(1000..1060, |s| s.clamp(0.0, 255.0) as u8)),
        ("i16", check(2000..2060, |s| (s * 100.0 - 50.0).clamp(-32768.0, 32767.0) as i16)),
    ] {
        println!("{name}: {compared} of {rays} rays compared, {crossings} crossings");
        assert!(compared * 3 > rays && crossings > rays / 2, "{name}: too few to mean anything");
    }
}

/// Values of a field at the points of a lattice.
fn sampled(dims: [u32; 3], field: impl Fn([f64; 3]) -> f64) -> Vec<f32> {
    let [nx, ny, nz] = dims;
    let points = (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])));
    points.map(|p| field(p.map(f64::from)) as f32).collect()
}

fn direction(random: &mut SplitMix64) -> [f64; 3] {
    loop {
        let d = [(); 3].map(|()| random.range(-1.0, 1.0));
        let length = d.iter().map(|c| c * c).sum::<f64>().sqrt();
        if (0.1..1.0).contains(&length) {
            return d.map(|c| c / length);
        }
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|n| a[n] * b[n]).sum()
}

/// Rays to points on a surface from all around.
fn onto<T: Scalar>(
    tracer: &mut Tracer<'_, T>,
    dims: [u32; 3],
    isovalue: f32,
    n: usize,
) -> Vec<(Ray, Crossing)> {
    let mut random = SplitMix64::new(9);
    let mut hits = Vec::new();
    while hits.len() < n {
        let target: [f64; 3] = std::array::from_fn(|a| random.range(0.0, f64::from(dims[a] - 1)));
        let d = direction(&mut random);
        let far = 3.0 * f64::from(dims[0].max(dims[1]).max(dims[2]).min(64));
        let ray = Ray {
            origin: std::array::from_fn(|a| (target[a] - far * d[a]) as f32),
            direction: d.map(|c| c as f32),
            t_min: 0.0,
            t_max: f32::INFINITY,
        };
        if let Some(hit) = tracer.first_hit(&ray, isovalue) {
            hits.push((ray, Crossing { surface: 0, hit }));
        }
    }
    hits
}

/// Sine of the angle by which surfaces of neighbouring cells of the body may differ.
const CREASES: f64 = 0.1;

#[test]
fn a_convex_body_shadows_its_far_side_and_nothing_else() {
    // An ellipsoid, in the middle and at the far end of a long volume, where coordinates are coarse.
    for (dims, centre) in [([40; 3], [19.3, 20.1, 18.7]), ([40, 40, 60_000], [19.3, 20.1, 59_970.4])] {
        let field = |p: [f64; 3]| {
            let r: f64 = (0..3).map(|a| ((p[a] - centre[a]) / [14.0, 11.0, 9.0][a]).powi(2)).sum();
            1.0 - r.sqrt()
        };
        let samples = sampled(dims, |p| if p[2] < centre[2] - 20.0 { -1.0 } else { field(p).max(-1.0) });
        let built = volume(dims, &samples);
        let view = built.view();
        let mut tracer = Tracer::new(&view);
        let mut random = SplitMix64::new(3);
        let (mut lit, mut dark, mut near_grazing) = (0, 0, 0);
        for (_, Crossing { hit, .. }) in onto(&mut tracer, dims, 0.013, 3000) {
            // Not from inside the body.
            if !hit.is_entering {
                continue;
            }
            let to_light = direction(&mut random);
            let shadow = hit.departing_ray(to_light.map(|c| c as f32), f32::INFINITY, false);
            let is_occluded = tracer.occluded(&shadow, 0.013, &mut ());
            assert_eq!(
                !departing(&mut tracer, &shadow, 0.013).is_empty(),
                is_occluded,
                "{hit:?} to {to_light:?}"
            );
            // The body is convex but for the creases between its cells: only what faces away is dark.
            let gradient = hit.gradient().map(f64::from);
            let slope = dot(gradient, to_light) / dot(gradient, gradient).sqrt();
            if slope.abs() < CREASES {
                near_grazing += 1;
                continue;
            }
            assert_eq!(is_occluded, slope > 0.0, "slope {slope}: {hit:?} to {to_light:?}");
            (lit, dark) = (lit + usize::from(!is_occluded), dark + usize::from(is_occluded));
        }
        println!("{dims:?}: {lit} lit, {dark} dark, {near_grazing} left out");
        assert!(lit > 1000 && dark > 1000 && near_grazing < 500);
    }
}

/// Large beside the roundings of coordinates to 32, small beside a cell.
const OFF: f32 = 3e-5;

#[test]
fn rays_from_wild_surfaces_agree_with_the_reference() {
    let dims = [32; 3];
    let gyroid = |p: [f64; 3]| {
        let [x, y, z] = p.map(|c| c * 0.55);
        x.sin() * y.cos() + y.sin() * z.cos() + z.sin() * x.cos()
    };
    let shell =
        |p: [f64; 3]| 0.9 - (p.map(|c| c - 15.4).iter().map(|c| c * c).sum::<f64>().sqrt() - 10.0).abs();
    let noise = std::cell::RefCell::new(SplitMix64::new(4));
    let fields: [(&str, Vec<f32>, f32); 3] = [
        ("gyroid", sampled(dims, gyroid), 0.31),
        ("thin shell", sampled(dims, shell), 0.0),
        ("noise", sampled(dims, |_| f64::from(noise.borrow_mut().below(200))), 99.5),
    ];
    for (name, samples, isovalue) in fields {
        let built = volume(dims, &samples);
        let lattice = DenseLattice::from_vec(dims, samples).unwrap();
        let view = built.view();
        let mut tracer = Tracer::new(&view);
        let mut random = SplitMix64::new(8);
        let (mut occluded, mut compared, mut left_out) = (0, 0, 0);
        for (ray, Crossing { hit, .. }) in onto(&mut tracer, dims, isovalue, 3000) {
            let to_light = direction(&mut random);
            let into_inside = !hit.is_entering;
            let shadow = hit.departing_ray(to_light.map(|c| c as f32), f32::INFINITY, into_inside);
            let found = tracer.occluded(&shadow, isovalue, &mut ());
            assert_eq!(!departing(&mut tracer, &shadow, isovalue).is_empty(), found);
            // The reference starts off the surface, on a side that its slope tells, still in the same cell.
            let off = OracleRay {
                origin: hit.position().map(|c| c as f32),
                direction: to_light.map(|c| c as f32),
                t_min: OFF,
                t_max: 1e6,
            };
            let verdict = judge_all(&lattice, &off, isovalue);
            let gradient = hit.gradient().map(f64::from);
            let slope = dot(gradient, to_light);
            let stays = (0..3).all(|a| {
                let on = f64::from(hit.local[a]) + 2.0 * f64::from(OFF) * to_light[a];
                (0.0..=1.0).contains(&on)
            });
            if verdict.grazing || !stays || slope.abs() < 0.2 * dot(gradient, gradient).sqrt() {
                left_out += 1;
                continue;
            }
            let expected = (slope > 0.0) != into_inside || !verdict.hits.is_empty();
            assert_eq!(found, expected, "{name}: {ray:?}, {hit:?}, {to_light:?}");
            compared += 1;
            occluded += usize::from(found);
        }
        println!("{name}: {compared} compared, {occluded} of them occluded, {left_out} left out");
        assert!(compared > 2000 && occluded > 500 && occluded < compared);
    }
}
