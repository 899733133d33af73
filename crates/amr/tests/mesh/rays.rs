//! Rays through meshes, against the oracle's on the finest lattice.

use std::ops::ControlFlow;

use isoray_amr::{Centering, Mesh, MeshOptions, MeshTracer, MeshVolumeTracer};
use isoray_cell::{Cubic, VALUE_ERROR_UNITS};
use isoray_oracle::{
    AmrKind, DenseLattice, OracleRay, OracleShading, RayKind, TransferPoints, adversarial_corners,
    adversarial_isovalue, adversarial_transfer, integrate_ray, judge,
};
use isoray_preint::{Bounded, ControlPoint, Lighting, TransferFunction, Visibility};
use isoray_trace::{Candidate, CountHits, Hit, HitPolicy, Ray, Trace};

use crate::oracle::patches;

/// What has no gaps, which the oracle's lattice does not tell from what is around them.
const KINDS: [AmrKind; 6] = [
    AmrKind::Uniform,
    AmrKind::SingleOct,
    AmrKind::Balanced,
    AmrKind::Unbalanced,
    AmrKind::RatioFour,
    AmrKind::MixedRatios,
];

/// A mesh, and its field on the finest lattice.
fn mesh(kind: AmrKind, seed: u64) -> (Mesh, DenseLattice<f64>) {
    let cells = adversarial_corners(&kind.generate(seed), seed);
    let patches = patches(&cells, Centering::Vertices, |corners| corners.map(|c| c as f32).to_vec());
    let mesh = Mesh::new(&patches, MeshOptions::default()).unwrap();
    let [nx, ny, nz] = mesh.dims().axes();
    let mut values = Vec::new();
    for z in 0..nz {
        for y in 0..ny {
            for x in 0..nx {
                let p = [x, y, z].map(f64::from);
                values.push((0..8).find_map(|octant| mesh.value(p, octant)).unwrap());
            }
        }
    }
    let lattice = DenseLattice::from_vec([nx, ny, nz], values).unwrap();
    (mesh, lattice)
}

pub(crate) fn ray(r: &OracleRay) -> Ray {
    Ray { origin: r.origin, direction: r.direction, t_min: r.t_min, t_max: r.t_max }
}

/// Keeps the cell of the first hit, or that it was at a face.
#[derive(Default)]
struct HitCell(Option<Candidate>, bool);

impl HitPolicy for HitCell {
    fn candidate(&mut self, candidate: &Candidate) -> ControlFlow<()> {
        self.0 = candidate.first_hit().map(|_| *candidate);
        if self.0.is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    fn jump(&mut self, _: &Hit) -> ControlFlow<()> {
        self.1 = true;
        ControlFlow::Break(())
    }
}

/// Whether all of the stretch in which the hit is lies within the error bound of the isovalue, or the hit is at a face where rounding decides: either answer is right then.
fn is_undecided(tracer: &mut MeshTracer<'_>, ray: &Ray, isovalue: f32) -> bool {
    let mut policy = HitCell::default();
    tracer.trace(ray, isovalue, &mut policy, &mut ());
    let HitCell(cell, is_jump) = policy;
    is_jump
        || cell.is_some_and(|c| {
            let largest = c.corners.iter().fold(0f32, |m, &x| m.max(x.abs()));
            let bound = VALUE_ERROR_UNITS * f32::EPSILON / 2.0 * largest;
            Cubic::along(&c.corners, &c.segment).0.iter().all(|b| b.abs() <= bound)
        })
}

fn isovalue(mesh: &Mesh, seed: u64) -> f32 {
    let values: Vec<f32> = (0..200)
        .filter_map(|n| {
            let at =
                |a: usize| f64::from(mesh.dims().axes()[a] - 1) * ((n * [7, 11, 13][a]) % 17) as f64 / 16.0;
            mesh.value([at(0).round(), at(1).round(), at(2).round()], 7 & !((n % 8) as u32))
        })
        .map(|v| v as f32)
        .collect();
    adversarial_isovalue(&values, seed)
}

#[test]
fn first_hits_are_the_oracles() {
    let (mut rays, mut hits, mut doubtful) = (0, 0, 0);
    for kind in KINDS {
        for seed in 0..12 {
            let (mesh, lattice) = mesh(kind, seed);
            let isovalue = isovalue(&mesh, seed);
            let mut tracer = MeshTracer::new(&mesh);
            for ray_kind in RayKind::ALL {
                for n in 0..12 {
                    let of_oracle = ray_kind.generate(mesh.dims().axes(), seed.wrapping_mul(1000) + n);
                    let verdict = judge(&lattice, &of_oracle, isovalue);
                    rays += 1;
                    if verdict.grazing {
                        doubtful += 1;
                        continue;
                    }
                    let ray = ray(&of_oracle);
                    let found = tracer.first_hit(&ray, isovalue);
                    let length = ray.direction.iter().map(|d| f64::from(*d).powi(2)).sum::<f64>().sqrt();
                    let agrees = match (found, verdict.hit) {
                        (None, None) => true,
                        (Some(found), Some(expected)) => {
                            hits += 1;
                            let off = (f64::from(found.t) - expected.t).abs();
                            off * length <= 1e-2 || off <= f64::from(f32::EPSILON) * expected.t.abs()
                        }
                        _ => false,
                    };
                    if !agrees && is_undecided(&mut tracer, &ray, isovalue) {
                        doubtful += 1;
                        continue;
                    }
                    assert!(
                        agrees,
                        "{kind:?} {seed} {ray_kind:?} {n}: {found:?}, expected {:?}, isovalue {isovalue}",
                        verdict.hit
                    );
                }
            }
        }
    }
    assert!(hits > 2000 && doubtful * 10 < rays, "{hits} hits and {doubtful} doubtful of {rays} rays");
}

#[test]
fn no_change_of_side_falls_between_cells() {
    let (mut checked, mut crossings) = (0, 0);
    for kind in KINDS {
        for seed in 0..12 {
            let (mesh, lattice) = mesh(kind, seed);
            let isovalue = isovalue(&mesh, seed);
            let mut tracer = MeshTracer::new(&mesh);
            for ray_kind in RayKind::ALL {
                for n in 0..20 {
                    let of_oracle = ray_kind.generate(mesh.dims().axes(), seed.wrapping_mul(1000) + n);
                    let ray = ray(&of_oracle);
                    let Some(sides) = sides(&lattice, &of_oracle, isovalue) else { continue };
                    let mut count = CountHits::default();
                    tracer.trace(&ray, isovalue, &mut count, &mut ());
                    assert_eq!(
                        count.0 % 2 == 1,
                        sides[0] != sides[1],
                        "{} crossings: {kind:?} {seed} {ray_kind:?} {n}, isovalue {isovalue}",
                        count.0
                    );
                    checked += 1;
                    crossings += count.0;
                    let mut seen = 0;
                    let all = tracer.crossings(
                        &ray,
                        &[isovalue],
                        &mut |_| {
                            seen += 1;
                            ControlFlow::Continue(())
                        },
                        &mut (),
                    );
                    assert!(all.is_continue());
                    assert_eq!(seen, count.0, "{kind:?} {seed} {ray_kind:?} {n}");
                }
            }
        }
    }
    assert!(checked > 3000 && crossings > 3000, "{checked} rays, {crossings} crossings");
}

/// On which side of the surface the ray enters and leaves the domain, if it has a stretch there and both are told clearly.
fn sides(lattice: &DenseLattice<f64>, ray: &OracleRay, isovalue: f32) -> Option<[bool; 2]> {
    use isoray_oracle::Lattice;
    let high = lattice.dims().map(|n| f64::from(n - 1));
    let (mut begin, mut end) = (f64::from(ray.t_min), f64::from(ray.t_max));
    for a in 0..3 {
        let (o, d) = (f64::from(ray.origin[a]), f64::from(ray.direction[a]));
        if d == 0.0 {
            if o < 0.0 || o > high[a] {
                return None;
            }
            continue;
        }
        let planes = [-o / d, (high[a] - o) / d];
        begin = begin.max(planes[0].min(planes[1]));
        end = end.min(planes[0].max(planes[1]));
    }
    if !begin.is_finite() || !end.is_finite() || end - begin < 1e-3 * (1.0 + begin.abs()) {
        return None;
    }
    let side = |t: f64| {
        let p: [f64; 3] = std::array::from_fn(|a| {
            (f64::from(ray.origin[a]) + t * f64::from(ray.direction[a])).clamp(0.0, high[a])
        });
        let value = field(lattice, p);
        let off = value - f64::from(isovalue);
        (off.abs() > 1e-4 * (value.abs() + f64::from(isovalue.abs()) + 1e-3)).then_some(off >= 0.0)
    };
    Some([side(begin)?, side(end)?])
}

/// Trilinear.
fn field(lattice: &DenseLattice<f64>, p: [f64; 3]) -> f64 {
    use isoray_oracle::Lattice;
    let low: [u32; 3] = std::array::from_fn(|a| (p[a] as u32).min(lattice.dims()[a] - 2));
    let local: [f64; 3] = std::array::from_fn(|a| p[a] - f64::from(low[a]));
    (0..8)
        .map(|n| {
            let weight = |a: usize| if n >> a & 1 == 1 { local[a] } else { 1.0 - local[a] };
            let corner = std::array::from_fn(|a| low[a] + (n >> a & 1) as u32);
            weight(0) * weight(1) * weight(2) * lattice.sample(corner)
        })
        .sum()
}

pub(crate) fn function(points: &TransferPoints) -> Option<TransferFunction> {
    let is_too_steep = points.0.windows(2).any(|pair| {
        let width = pair[1].value - pair[0].value;
        width > 0.0 && pair[0].extinction.max(pair[1].extinction).max(1.0) / width > 1e30
    });
    if is_too_steep {
        return None;
    }
    let point = |p: &isoray_oracle::TransferPoint| ControlPoint {
        value: p.value as f32,
        color: p.color.map(|c| c as f32),
        extinction: p.extinction as f32,
    };
    TransferFunction::new(points.0.iter().map(point).collect()).ok()
}

/// Lit from a corner, for gradients of about `steepest`.
pub(crate) fn shading(steepest: f32) -> (OracleShading, Lighting) {
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

#[test]
fn bounds_of_integrals_hold() {
    const EPSILON: f64 = 1e-4;
    let (mut rays, mut lit, mut doubtful) = (0, 0, 0);
    for kind in KINDS {
        for seed in 0..12 {
            let (mesh, lattice) = mesh(kind, seed);
            let [low, high] = mesh.range().unwrap();
            let points = adversarial_transfer(seed, [low, high]);
            let Some(transfer) = function(&points) else { continue };
            let is_lit = seed % 2 == 1 && high > low && high - low < 1e6;
            let shaded = is_lit.then(|| shading(high - low));
            let (of_oracle, lighting) = shaded.as_ref().map(|(oracle, lighting)| (oracle, lighting)).unzip();
            let brightest = lighting.map_or(1.0, |lighting: &Lighting| lighting.brightest(high - low));
            let scheme = Bounded::new(&transfer, EPSILON, brightest);
            let mut tracer = MeshVolumeTracer::new(&mesh, &Visibility::new(&transfer));
            let jitter = 8.0 * 2f64.powi(-24) * f64::from(low.abs().max(high.abs()));
            for ray_kind in RayKind::ALL {
                for n in 0..4 {
                    let ray_of_oracle = ray_kind.generate(mesh.dims().axes(), seed.wrapping_mul(1000) + n);
                    let moved = |by: f64| {
                        let point = |p: &isoray_oracle::TransferPoint| isoray_oracle::TransferPoint {
                            value: p.value + by,
                            ..*p
                        };
                        let points = TransferPoints(points.0.iter().map(point).collect());
                        let seen = integrate_ray(&lattice, &ray_of_oracle, 0.3, &points, of_oracle);
                        [seen.color[0], seen.color[1], seen.color[2], seen.alpha()]
                    };
                    let apart =
                        |a: [f64; 4], b: [f64; 4]| (0..4).fold(0.0, |m: f64, n| m.max((a[n] - b[n]).abs()));
                    let truth = moved(0.0);
                    let found = tracer.integrate(&ray(&ray_of_oracle), 0.3, &scheme, lighting, &mut ());
                    rays += 1;
                    lit += u32::from(truth[3] > 0.0);
                    if apart(truth, moved(jitter)).max(apart(truth, moved(-jitter))) > EPSILON / 16.0 {
                        doubtful += 1;
                        continue;
                    }
                    let error = apart(truth, [found.color[0], found.color[1], found.color[2], found.alpha()]);
                    assert!(error <= EPSILON, "{error}: {kind:?} {seed} {ray_kind:?} {n}");
                    assert!(found.error <= EPSILON);
                }
            }
        }
    }
    assert!(lit * 4 > rays && doubtful * 4 < rays, "{lit} lit and {doubtful} doubtful of {rays}");
}
