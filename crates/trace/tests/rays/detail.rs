//! Levels of detail: one continuous field, whichever ray comes by.

use std::ops::ControlFlow;

use glam::{DAffine3, DVec3};
use isoray_build::{FileOptions, build_with};
use isoray_cell::Cubic;
use isoray_grid::{DenseVolume, Dims, Scalar};
use isoray_octree::lod::{
    BLOCK_EDGE, BLOCK_SAMPLES, Detail, DetailRequest, DetailView, DistanceMeasure, PixelWidth,
};
use isoray_octree::{Coarse, OctreeVolume};
use isoray_oracle::{SplitMix64, adversarial_lattice, adversarial_ray};
use isoray_trace::{Candidate, DetailTracer, FirstHit, Hit, HitPolicy, Ray, Trace, Tracer};

fn volume<T: Scalar>(dims: [u32; 3], samples: &[T], coarse: Coarse) -> OctreeVolume<T> {
    let mut source = DenseVolume::new(Dims::new(dims).unwrap(), samples).unwrap();
    let options = FileOptions { coarse, ..FileOptions::default() };
    build_with(&mut source, &options, |_| {}).unwrap()
}

/// A volume of some size, an eye in or near it, and pixels so wide that levels change from block to block.
struct Case<T: Scalar> {
    volume: OctreeVolume<T>,
    detail: Detail,
    isovalue: f32,
    random: SplitMix64,
}

fn case<T: Scalar>(seed: u64, convert: impl Fn(f32) -> T) -> Case<T> {
    let mut random = SplitMix64::new(seed);
    let dims = [(); 3].map(|()| 2 + random.below(70));
    let samples: Vec<T> = match random.below(3) {
        0 => adversarial_lattice(dims, seed).into_iter().map(&convert).collect(),
        1 => (0..dims.iter().product::<u32>()).map(|_| convert(random.below(256) as f32)).collect(),
        _ => {
            let along = [(); 3].map(|()| random.range(0.05, 0.8));
            let at = |n: u32| {
                let p = [n % dims[0], n / dims[0] % dims[1], n / dims[0] / dims[1]];
                (0..3).map(|a| (along[a] * f64::from(p[a])).sin()).sum::<f64>()
            };
            (0..dims.iter().product::<u32>()).map(|n| convert((128.0 + 40.0 * at(n)) as f32)).collect()
        }
    };
    let coarse = [Coarse::Injected, Coarse::Filtered, Coarse::Mean][random.below(3) as usize];
    let volume = volume(dims, &samples, coarse);
    let eye = dims.map(|n| random.range(-1.0, 2.0) * f64::from(n));
    let edges = DVec3::from_array([(); 3].map(|()| random.range(0.5, 2.0)));
    let place = DAffine3::from_scale(edges);
    let measure = match random.below(3) {
        0 => DistanceMeasure::Slices(DVec3::from_array([(); 3].map(|()| random.range(-1.0, 1.0)))),
        _ => DistanceMeasure::True,
    };
    let pixel = match random.below(8) {
        0 => PixelWidth::Constant(random.range(0.1, 10.0)),
        _ => PixelWidth::PerDistance(1.0, place.transform_point3(DVec3::from_array(eye))),
    };
    let blend = if random.coin() { 0.0 } else { random.unit() };
    let ratio = random.range(-6.0, 0.0).exp2();
    let detail = Detail::new(volume.meta().dims, &place, &DetailRequest { pixel, ratio, measure, blend });
    let isovalue = [128.0, 100.5, convert(100.0).to_f32()][random.below(3) as usize];
    Case { volume, detail, isovalue, random }
}

/// All leaf blocks: level and corner on its lattice.
fn blocks(detail: &Detail) -> Vec<(u32, [u32; 3])> {
    let cells = detail.dims().axes().map(|n| n - 1);
    let mut blocks = std::collections::BTreeSet::new();
    for z in (0..cells[2]).step_by(4) {
        for y in (0..cells[1]).step_by(4) {
            for x in (0..cells[0]).step_by(4) {
                let level = detail.level([x, y, z]);
                blocks.insert((level, [x, y, z].map(|c| c >> (level + 2) << 2)));
            }
        }
    }
    blocks.into_iter().collect()
}

#[test]
fn all_cells_at_a_sample_see_one_value() {
    let (mut mixes, mut interpolated) = (0, 0);
    for seed in 0..80 {
        let Case { volume, detail, .. } = case(seed, |s| s as u8);
        let octree = volume.view();
        let view = DetailView::new(&octree, volume.meta().coarse, detail);
        let last = octree.dims().axes().map(|n| n - 1);
        let blocks = blocks(view.detail());
        mixes += usize::from(blocks.iter().any(|b| b.0 != blocks[0].0));
        for (level, corner) in blocks {
            let block = view.block_alone(level, corner);
            for n in 0..BLOCK_SAMPLES {
                let index = [n % BLOCK_EDGE, n / BLOCK_EDGE % BLOCK_EDGE, n / BLOCK_EDGE / BLOCK_EDGE];
                let p = [0, 1, 2].map(|a| (corner[a] + index[a] as u32) << level);
                if (0..3).any(|a| p[a] > last[a]) {
                    continue;
                }
                let expected = view.vertex(p);
                let found = block.samples[n];
                let is_same = expected.to_bits() == found.to_bits() || (expected.is_nan() && found.is_nan());
                assert!(is_same, "seed {seed}, level {level}, {p:?}: {found} for {expected}");
                interpolated += usize::from(found.fract() != 0.0);
            }
        }
    }
    println!("{mixes} mixes of levels, {interpolated} values between others");
    assert!(mixes > 30 && interpolated > 1000);
}

/// What a policy is told.
#[derive(Clone, Copy, Debug)]
enum Event {
    Candidate(Candidate),
    Jump(Hit),
}

#[derive(Default)]
struct Record(Vec<Event>);

impl HitPolicy for Record {
    fn candidate(&mut self, candidate: &Candidate) -> ControlFlow<()> {
        self.0.push(Event::Candidate(*candidate));
        ControlFlow::Continue(())
    }

    fn jump(&mut self, hit: &Hit) -> ControlFlow<()> {
        self.0.push(Event::Jump(*hit));
        ControlFlow::Continue(())
    }
}

/// A ray from anywhere to anywhere, or from the eye.
fn ray(detail: &Detail, random: &mut SplitMix64, seed: u64) -> Ray {
    let dims = detail.dims().axes();
    if random.coin() {
        let r = adversarial_ray(dims, seed);
        return Ray { origin: r.origin, direction: r.direction, t_min: r.t_min, t_max: r.t_max };
    }
    let origin = detail.eye().map(|c| c as f32);
    // Samples are aimed at too: edges and vertices of blocks.
    let to: [f64; 3] = match random.below(3) {
        0 => dims.map(|n| f64::from(random.below(n))),
        _ => dims.map(|n| random.range(0.0, f64::from(n - 1))),
    };
    let direction = std::array::from_fn(|a| (to[a] - f64::from(origin[a])) as f32);
    Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY }
}

/// Cells with their states, along all of the ray: no side is changed between two of them without a jump. The numbers of candidates and of jumps.
fn check_states(events: &[Event], told: &str) -> [usize; 2] {
    let mut side: Option<bool> = None;
    let mut end = f64::NEG_INFINITY;
    let mut count = [0, 0];
    for event in events {
        match event {
            Event::Candidate(candidate) => {
                let cubic = Cubic::along(&candidate.corners, &candidate.segment);
                assert!(candidate.interval[0] >= end, "{told}: {candidate:?} begins before {end}");
                assert!(side.is_none_or(|side| side == cubic.starts_inside()), "{told}: {candidate:?}");
                (side, end) = (Some(cubic.ends_inside()), candidate.interval[1]);
                count[0] += 1;
            }
            Event::Jump(hit) => {
                assert!(side.is_none_or(|side| side != hit.is_entering), "{told}: {hit:?}");
                side = Some(hit.is_entering);
                count[1] += 1;
            }
        }
    }
    count
}

#[test]
fn no_side_is_changed_between_cells_without_a_hit() {
    let (mut rays, mut cells, mut jumps) = (0, 0, 0);
    for seed in 0..150 {
        let Case { volume, detail, isovalue, mut random } = case(seed, |s| s as u8);
        let octree = volume.view();
        let view = DetailView::new(&octree, volume.meta().coarse, detail);
        let mut tracer = DetailTracer::new(&view);
        for n in 0..100 {
            let ray = ray(view.detail(), &mut random, 1000 * seed + n);
            let mut record = Record::default();
            tracer.trace(&ray, isovalue, &mut record, &mut ());
            let [some, jumped] = check_states(&record.0, &format!("seed {seed}, {ray:?}"));
            rays += 1;
            cells += some;
            jumps += jumped;
            let mut first = FirstHit::default();
            tracer.trace(&ray, isovalue, &mut first, &mut ());
            let expected = record.0.iter().find_map(|event| match event {
                Event::Candidate(candidate) => candidate.first_hit(),
                Event::Jump(hit) => Some(*hit),
            });
            assert_eq!(first.0, expected);
        }
    }
    println!("{rays} rays, {cells} cells, {jumps} jumps");
    assert!(cells > 10_000);
}

/// All leaf cells that the ray passes through, found plane by plane of the finest lattice: level, corner on its lattice, where it is left, and samples.
fn passed<T: Scalar>(view: &DetailView<'_, T>, ray: &Ray) -> Vec<(u32, [u32; 3], f64, [f32; 8])> {
    let last = view.volume().dims().axes().map(|n| f64::from(n - 1));
    let (o, d) = (ray.origin.map(f64::from), ray.direction.map(f64::from));
    let (mut begin, mut end) = (f64::from(ray.t_min), f64::from(ray.t_max));
    let mut crossed = Vec::new();
    for a in 0..3 {
        if d[a] == 0.0 {
            if o[a] < 0.0 || o[a] > last[a] {
                return Vec::new();
            }
            continue;
        }
        let at = |k: f64| (k - o[a]) / d[a];
        begin = begin.max(at(0.0).min(at(last[a])));
        end = end.min(at(0.0).max(at(last[a])));
        crossed.extend((0..=last[a] as u32).map(|k| at(k.into())));
    }
    crossed.retain(|&t| t > begin && t < end);
    crossed.extend([begin, end]);
    crossed.sort_by(f64::total_cmp);
    crossed.dedup();
    let mut cells: Vec<(u32, [u32; 3], f64, [f32; 8])> = Vec::new();
    for pair in crossed.windows(2).filter(|_| begin < end) {
        let middle = 0.5 * (pair[0] + pair[1]);
        let finest = std::array::from_fn(|a| (o[a] + middle * d[a]).floor().clamp(0.0, last[a] - 1.0) as u32);
        let level = view.detail().level(finest);
        let cell = finest.map(|c| c >> level);
        if let Some(same) = cells.last_mut().filter(|same| (same.0, same.1) == (level, cell)) {
            same.2 = pair[1];
            continue;
        }
        let block = view.block_alone(level, cell.map(|c| c & !3));
        let at = |n: usize| {
            let index = [0, 1, 2].map(|a| (cell[a] as usize & 3) + (n >> a & 1));
            block.samples[index[0] + BLOCK_EDGE * (index[1] + BLOCK_EDGE * index[2])]
        };
        cells.push((level, cell, pair[1], std::array::from_fn(at)));
    }
    cells
}

#[test]
fn where_rounding_decides_the_face_between_levels_is_hit() {
    let (mut faces, mut jumps) = (0, 0);
    for seed in 500..580 {
        let Case { volume, detail, mut random, .. } = case(seed, |s| {
            // Empty cells begin anew.
            if s.is_finite() { 0.37 * s } else { 0.0 }
        });
        let octree = volume.view();
        let view = DetailView::new(&octree, volume.meta().coarse, detail);
        let mut tracer = DetailTracer::new(&view);
        for n in 0..60 {
            let ray = ray(view.detail(), &mut random, 1000 * seed + n);
            for pair in passed(&view, &ray).windows(2) {
                let (level, cell, t, corners) = pair[0];
                if level == pair[1].0 {
                    continue;
                }
                // The isovalue is what one side sees where the ray leaves it.
                let width = f64::from(1u32 << level);
                let local = std::array::from_fn(|a| {
                    let at = f64::from(ray.origin[a]) + t * f64::from(ray.direction[a]);
                    (at / width - f64::from(cell[a])).clamp(0.0, 1.0) as f32
                });
                let isovalue = isoray_cell::trilinear(&corners, local);
                if !isovalue.is_finite() || !corners.iter().all(|c| c.is_finite()) {
                    continue;
                }
                let mut record = Record::default();
                tracer.trace(&ray, isovalue, &mut record, &mut ());
                jumps += check_states(&record.0, &format!("seed {seed}, {ray:?}, {isovalue}"))[1];
                faces += 1;
                let mut first = FirstHit::default();
                tracer.trace(&ray, isovalue, &mut first, &mut ());
                let is_hit = record.0.iter().any(|event| match event {
                    Event::Candidate(candidate) => candidate.first_hit().is_some(),
                    Event::Jump(_) => true,
                });
                assert_eq!(first.0.is_some(), is_hit);
            }
        }
    }
    println!("{faces} faces, {jumps} jumps");
    assert!(jumps > 50, "only {jumps} jumps at {faces} faces");
}

#[test]
fn every_mixed_cell_on_the_way_is_visited() {
    let (mut rays, mut number, mut unlike) = (0, 0, 0);
    for seed in 300..400 {
        let Case { volume, detail, isovalue, mut random } = case(seed, |s| s as u16);
        let octree = volume.view();
        let view = DetailView::new(&octree, volume.meta().coarse, detail);
        let mut tracer = DetailTracer::new(&view);
        for n in 0..20 {
            let ray = ray(view.detail(), &mut random, 1000 * seed + n);
            if ray.direction.iter().any(|d| *d != 0.0 && d.abs() < 1e-6) {
                // It is rounded to one parallel to an axis here.
                continue;
            }
            let mut record = Record::default();
            tracer.trace(&ray, isovalue, &mut record, &mut ());
            let found: Vec<_> = record
                .0
                .iter()
                .filter_map(|event| match event {
                    Event::Candidate(candidate) => Some((candidate.level, candidate.cell)),
                    Event::Jump(_) => None,
                })
                .collect();
            let mut expected: Vec<_> = passed(&view, &ray)
                .iter()
                .filter(|(_, _, _, corners)| {
                    let inside = corners.iter().filter(|&&s| s >= isovalue).count();
                    !matches!(inside, 0 | 8)
                })
                .map(|&(level, cell, ..)| (level, cell.map(|c| c << level)))
                .collect();
            expected.dedup();
            rays += 1;
            number += expected.len();
            // The middle of a very short stretch can be rounded into the next cell.
            unlike += usize::from(found != expected);
        }
    }
    println!("{rays} rays, {number} cells, {unlike} unlike");
    assert!(number > 4000 && unlike * 200 <= rays, "{unlike} of {rays} rays unlike");
}

/// A leaf that the border cuts has one range for all that it spans.
#[test]
fn nothing_beyond_the_border_is_drawn() {
    let mut beyond = 0;
    for seed in 0..60 {
        let Case { volume, detail, .. } = case::<u8>(seed, |s| s.clamp(0.0, 255.0) as u8);
        let octree = volume.view();
        let cells = octree.dims().axes().map(|n| n - 1);
        let view = DetailView::new(&octree, volume.meta().coarse, detail);
        for level in view.detail().levels() {
            let steps = |a: usize| (0..=cells[a]).step_by(16 << level);
            for (z, y) in steps(2).flat_map(|z| steps(1).map(move |y| (z, y))) {
                for x in steps(0) {
                    let parts = view.parts(level, [x, y, z], level + 2, u64::MAX);
                    for n in 0..64 {
                        let origin = [0, 1, 2].map(|a| [x, y, z][a] + ((n >> (2 * a) & 3) << (level + 2)));
                        if (0..3).all(|a| origin[a] < cells[a]) {
                            continue;
                        }
                        assert_eq!(parts >> n & 1, 0, "seed {seed}, level {level}: {origin:?}");
                        assert!(!view.state(level, origin.map(|c| c >> level))[0], "{origin:?}");
                        beyond += 1;
                    }
                }
            }
        }
    }
    assert!(beyond > 1000, "{beyond}");
}

#[test]
fn one_level_everywhere_is_a_volume_of_its_own() {
    let mut random = SplitMix64::new(5);
    for level in 1..4u32 {
        // Whole cells: the coarse lattice is that of a volume.
        let dims = [9, 13, 10].map(|n: u32| ((n - 1) << level) + 1);
        let samples: Vec<f32> =
            (0..dims.iter().product::<u32>()).map(|_| random.range(0.0, 1.0) as f32).collect();
        let fine = volume(dims, &samples, Coarse::Injected);
        let octree = fine.view();
        let coarse_dims = isoray_octree::coarse_dims(octree.dims(), level);
        let at = |n: u32| {
            let p = [
                n % coarse_dims[0],
                n / coarse_dims[0] % coarse_dims[1],
                n / coarse_dims[0] / coarse_dims[1],
            ];
            octree.sample(p.map(|c| c << level))
        };
        let coarse_samples: Vec<f32> = (0..coarse_dims.iter().product::<u32>()).map(at).collect();
        let coarse = volume(coarse_dims, &coarse_samples, Coarse::Injected);
        let width = f64::from(1u32 << level);
        let request = DetailRequest {
            pixel: PixelWidth::Constant(width),
            ratio: 1.0,
            measure: DistanceMeasure::True,
            blend: 0.0,
        };
        let detail = Detail::new(octree.dims(), &DAffine3::IDENTITY, &request);
        let expected_level = level.min(octree.root_level() - isoray_octree::NODE_LEVEL);
        assert_eq!(detail.levels(), expected_level..=expected_level);
        assert_eq!(expected_level, level);
        let view = DetailView::new(&octree, Coarse::Injected, detail);
        let mut tracer = DetailTracer::new(&view);
        let coarse_view = coarse.view();
        let mut expected_tracer = Tracer::new(&coarse_view);
        let mut hits = 0;
        for seed in 0..500 {
            let r = adversarial_ray(coarse_dims, seed);
            let small = Ray { origin: r.origin, direction: r.direction, t_min: r.t_min, t_max: r.t_max };
            let by = width as f32;
            let ray =
                Ray { origin: r.origin.map(|c| c * by), direction: r.direction.map(|c| c * by), ..small };
            let expected = expected_tracer.first_hit(&small, 0.5).map(|hit| hit.on_level(level));
            assert_eq!(tracer.first_hit(&ray, 0.5), expected, "{ray:?}");
            hits += usize::from(expected.is_some());
        }
        assert!(hits > 100);
    }
}
