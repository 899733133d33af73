//! Volume rays through octrees whose nodes hold anything at all: they end, in bounds.

use isoray_build::build;
use isoray_grid::{DenseVolume, Dims, Scalar};
use isoray_octree::{NODE_LEVEL, OctreeVolume, Parts};
use isoray_oracle::{RayKind, SplitMix64};
use isoray_preint::{Bounded, ControlPoint, TransferFunction, Visibility};
use isoray_trace::{Ray, VolumeTracer, Work};

fn damaged<T: Scalar>(
    dims: [u32; 3],
    random: &mut SplitMix64,
    any: impl Fn(&mut SplitMix64) -> T,
) -> OctreeVolume<T> {
    let dims = Dims::new(dims).unwrap();
    // Regions of one value beside noise.
    let sample = |n: usize| match n / 64 % 3 {
        0 => T::default(),
        _ => any(random),
    };
    let samples: Vec<T> = (0..dims.samples()).map(sample).collect();
    let mut source = DenseVolume::new(dims, &samples).unwrap();
    let sound = build(&mut source, glam::DAffine3::IDENTITY, |_| {}).unwrap();
    let view = sound.view();
    let mut levels: Vec<_> =
        (NODE_LEVEL..=view.root_level()).map(|level| view.nodes(level).to_vec()).collect();
    let mut caps = view.caps().to_vec();
    let (odds, is_near) = (1 + random.below(4), random.coin());
    for node in levels.iter_mut().flatten() {
        if random.below(odds) > 0 {
            continue;
        }
        let link = random.next_u64() as u32;
        node.first = if is_near { link % 8 } else { link }.into();
        node.mask = random.next_u64() as u8;
        // Ranges that show everything, or any.
        if random.coin() {
            (node.mins, node.maxs) = ([T::LOWEST.into(); 8], [T::HIGHEST.into(); 8]);
        } else {
            node.mins = std::array::from_fn(|_| any(random).into());
            node.maxs = std::array::from_fn(|_| any(random).into());
        }
        node.values = std::array::from_fn(|_| any(random).into());
    }
    match random.below(3) {
        0 => caps.truncate(random.below(caps.len() as u32 + 1) as usize),
        _ => caps.iter_mut().for_each(|byte| *byte = random.next_u64() as u8),
    }
    if random.below(8) == 0 {
        levels[random.below(2) as usize].clear();
    }
    OctreeVolume::from_parts(sound.meta().clone(), Parts { levels, caps })
}

fn survive<T: Scalar>(any: impl Fn(&mut SplitMix64) -> T) {
    let point = |value, extinction| ControlPoint { value, color: [1.0; 3], extinction };
    let gaps = [point(-20.0, 0.0), point(10.0, 0.01), point(20.0, 0.0), point(90.0, 0.0), point(91.0, 1e-4)];
    let transfer = TransferFunction::new(gaps.to_vec()).unwrap();
    let scheme = Bounded::new(&transfer, 1e-3, 1.0);
    let mut cells = 0;
    for seed in 0..60 {
        let mut random = SplitMix64::new(seed);
        let dims = [(); 3].map(|()| 9 + random.below(40));
        let volume = damaged(dims, &mut random, &any);
        let view = volume.view();
        let mut tracer = VolumeTracer::new(&view, &Visibility::new(&transfer));
        for (kind, n) in RayKind::ALL.into_iter().flat_map(|kind| (0..6).map(move |n| (kind, n))) {
            let r = kind.generate(dims, seed * 100 + n);
            let ray = Ray { origin: r.origin, direction: r.direction, t_min: r.t_min, t_max: r.t_max };
            let mut work = Work::default();
            let found = tracer.integrate(&ray, 1.0, &scheme, None, &mut work);
            assert!((0.0..=1.0).contains(&found.transmittance), "seed {seed}, {kind:?} {n}: {found:?}");
            // However links lead, a ray meets a cell but once.
            assert!(
                work.cells <= dims.iter().map(|&n| u64::from(n)).sum(),
                "seed {seed}, {kind:?} {n}: {work:?}"
            );
            cells += work.cells;
        }
    }
    assert!(cells > 1000, "only {cells}");
}

#[test]
fn rays_survive_damaged_bytes() {
    survive(|random| random.next_u64() as u8);
}

#[test]
fn rays_survive_damaged_words() {
    survive(|random| random.next_u64() as i16);
}

#[test]
fn rays_survive_damaged_numbers() {
    // Every pattern of bits: NaN, infinities, subnormal numbers.
    survive(|random| match random.below(3) {
        0 => f32::from_bits(random.next_u64() as u32),
        _ => random.range(-30.0, 120.0) as f32,
    });
}
