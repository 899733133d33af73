//! The oracle against dense sampling along the ray, over every kind of adversarial ray and lattice.

use isoray_oracle::{
    CellKind, DenseLattice, Lattice, LatticeKind, OracleHit, OracleRay, RayKind, SplitMix64,
    adversarial_cell, adversarial_isovalue, all_hits, first_hit, judge,
};

const SAMPLES: u32 = 3000;

/// Where a ray is inside the open domain, by intervals; independent of the order of crossings.
fn clip(dims: [u32; 3], ray: &OracleRay) -> Option<(f64, f64)> {
    let (mut start, mut end) = (f64::from(ray.t_min), f64::from(ray.t_max));
    for (axis, n) in dims.into_iter().enumerate() {
        let (o, d) = (f64::from(ray.origin[axis]), f64::from(ray.direction[axis]));
        let last = f64::from(n - 1);
        if d == 0.0 {
            if o < 0.0 || o > last {
                return None;
            }
        } else {
            let (a, b) = ((0.0 - o) / d, (last - o) / d);
            start = start.max(a.min(b));
            end = end.min(a.max(b));
        }
    }
    (start < end).then_some((start, end))
}

/// The cell at a parameter, and the field minus the isovalue there: a weighted sum over its corners.
fn sample(l: &impl Lattice, ray: &OracleRay, v: f64, t: f64) -> Option<([u32; 3], f64)> {
    let dims = l.dims();
    let at = |axis: usize| f64::from(ray.origin[axis]) + t * f64::from(ray.direction[axis]);
    let cell: [u32; 3] = std::array::from_fn(|axis| (at(axis).floor() as u32).min(dims[axis] - 2));
    let mut sum = 0.0;
    for corner in 0..8_u32 {
        let bit = |axis: usize| corner >> axis & 1;
        let weight: f64 = (0..3)
            .map(|axis| {
                let x = at(axis) - f64::from(cell[axis]);
                if bit(axis) == 1 { x } else { 1.0 - x }
            })
            .product();
        let s = l.sample(std::array::from_fn(|axis| cell[axis] + bit(axis)));
        if !s.is_finite() {
            return None;
        }
        sum += weight * (s - v);
    }
    Some((cell, sum))
}

fn points([nx, ny, nz]: [u32; 3]) -> impl Iterator<Item = [u32; 3]> {
    (0..nz).flat_map(move |z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])))
}

/// Checks that between consecutive samples the number of hits is even if their states agree and odd if
/// they differ; samples too near the isovalue to have a state are left out, and so
/// are pairs from different cells if some cells are empty. Returns how many were not.
fn check_parity(l: &impl Lattice, ray: &OracleRay, v: f64, scale: f64, context: &str) -> u32 {
    let hits = all_hits(l, ray, v);
    assert_eq!(first_hit(l, ray, v), hits.first().copied(), "{context}");
    assert!(hits.windows(2).all(|w| w[0].t <= w[1].t), "{context}: {hits:?}");
    let Some((start, end)) = clip(l.dims(), ray) else {
        assert_eq!(hits, [], "{context}");
        return 0;
    };
    assert!(hits.iter().all(|h| h.t >= start && h.t <= end), "{context}: {hits:?}");
    let holes = points(l.dims()).any(|p| !l.sample(p).is_finite());
    if !holes {
        assert!(hits.windows(2).all(|w| w[0].entering != w[1].entering), "{context}: {hits:?}");
    }
    let mut previous: Option<(f64, [u32; 3], bool)> = None;
    let mut checked = 0;
    for k in 0..SAMPLES {
        let t = start + (end - start) * (f64::from(k) + 0.5) / f64::from(SAMPLES);
        let found = sample(l, ray, v, t).filter(|(_, s)| s.abs() > 1e-9 * scale);
        let Some((cell, value)) = found else { continue };
        let inside = value >= 0.0;
        if let Some((before, _, state)) = previous.filter(|(_, other, _)| !holes || *other == cell) {
            let between: Vec<&OracleHit> = hits.iter().filter(|h| h.t > before && h.t <= t).collect();
            assert_eq!(between.len() % 2 == 1, state != inside, "{context}: {before}..{t}, {hits:?}");
            if let Some(last) = between.last() {
                assert_eq!(last.entering, inside, "{context}");
            }
        }
        previous = Some((t, cell, inside));
        checked += 1;
    }
    checked
}

fn magnitude(samples: &[f32], v: f32) -> f64 {
    let finite = samples.iter().filter(|s| s.is_finite());
    finite.map(|&s| (f64::from(s) - f64::from(v)).abs()).fold(1e-30, f64::max)
}

#[test]
fn hits_are_the_changes_between_dense_samples() {
    let mut checked = 0_u64;
    let mut rng = SplitMix64::new(11);
    for lattice in LatticeKind::ALL {
        for kind in RayKind::ALL {
            for _ in 0..12 {
                let seed = rng.next_u64();
                let dims = std::array::from_fn(|_| 2 + rng.below(6));
                let samples = lattice.generate(dims, seed);
                let v = adversarial_isovalue(&samples, seed);
                let scale = magnitude(&samples, v);
                let ray = kind.generate(dims, seed);
                let volume = DenseLattice::from_vec(dims, samples).expect("as many as the dimensions say");
                let context = format!("{lattice:?} {kind:?} {dims:?} seed {seed} {ray:?} v {v}");
                checked += u64::from(check_parity(&volume, &ray, f64::from(v), scale, &context));
            }
        }
    }
    assert!(checked > 500_000, "only {checked} samples had a state");
}

#[test]
fn hits_of_single_cells_are_the_changes_between_dense_samples() {
    let mut checked = 0_u64;
    for seed in 0..2400_u64 {
        let corners = adversarial_cell(seed);
        let volume = DenseLattice::from_vec([2; 3], corners.to_vec()).expect("eight corners");
        let ray = RayKind::ALL[(seed / 8) as usize % RayKind::ALL.len()].generate([2; 3], seed);
        let scale = corners.iter().fold(1e-30, |m: f64, c| m.max(c.abs()));
        let kind = CellKind::ALL[(seed % 8) as usize];
        let context = format!("{kind:?} {corners:?} seed {seed} {ray:?}");
        checked += u64::from(check_parity(&volume, &ray, 0.0, scale, &context));
    }
    assert!(checked > 500_000, "only {checked} samples had a state");
}

#[test]
fn every_hit_lies_on_the_surface_and_on_the_ray() {
    let mut hits = 0;
    for seed in 0..6000_u64 {
        let dims = [6, 4, 5];
        let samples = LatticeKind::Smooth.generate(dims, seed / 16);
        let v = adversarial_isovalue(&samples, seed);
        let volume = DenseLattice::from_vec(dims, samples).expect("as many as the dimensions say");
        let ray = RayKind::ALL[(seed % 16) as usize].generate(dims, seed);
        let speed = ray.direction.iter().map(|&d| f64::from(d).powi(2)).sum::<f64>().sqrt();
        for hit in all_hits(&volume, &ray, f64::from(v)) {
            hits += 1;
            let (_, value) = sample(&volume, &ray, f64::from(v), hit.t).expect("finite samples");
            assert!(value.abs() < 1e-9, "{value} at {hit:?} of {ray:?}");
            for axis in 0..3 {
                let p = f64::from(ray.origin[axis]) + hit.t * f64::from(ray.direction[axis]);
                assert!((p - hit.position[axis]).abs() < 1e-11);
                let cell = f64::from(hit.cell[axis]);
                assert!(hit.position[axis] >= cell && hit.position[axis] <= cell + 1.0);
            }
            let along: f64 = (0..3).map(|a| hit.gradient[a] * f64::from(ray.direction[a])).sum();
            assert!(if hit.entering { along > -1e-6 * speed } else { along < 1e-6 * speed });
        }
    }
    assert!(hits > 3000, "only {hits}");
}

#[test]
fn generic_rays_of_smooth_data_seldom_graze() {
    let dims = [16; 3];
    let (mut hits, mut grazing) = (0, 0);
    for seed in 0..4000_u64 {
        let samples = LatticeKind::Smooth.generate(dims, seed / 100);
        let volume = DenseLattice::from_vec(dims, samples).expect("as many as the dimensions say");
        let verdict = judge(&volume, &RayKind::Random.generate(dims, seed), 0.3);
        hits += u32::from(verdict.hit.is_some());
        grazing += u32::from(verdict.grazing);
        assert!(verdict.hit.is_none() || verdict.tested > 0);
    }
    assert!(hits > 2000 && grazing < 8, "{hits} hits, {grazing} grazing");
}
