//! Packets through levels of detail against single rays, bit for bit.

use glam::{DAffine3, DVec3};
use isoray_build::{FileOptions, build_with};
use isoray_grid::{DenseVolume, Dims};
use isoray_octree::Coarse;
use isoray_octree::lod::{Detail, DetailRequest, DetailView, DistanceMeasure, PixelWidth};
use isoray_oracle::{SplitMix64, adversarial_ray};
use isoray_packet::{DetailPacketTracer, TracePackets, Traversal};
use isoray_trace::{Hit, Ray};

fn bits(hit: &Hit) -> ([u32; 12], [u32; 4], bool) {
    let [x, y, z] = hit.local;
    let mut numbers = [0; 12];
    for (bits, number) in numbers.iter_mut().zip([hit.t, x, y, z].into_iter().chain(hit.corners)) {
        *bits = number.to_bits();
    }
    let [i, j, k] = hit.cell;
    (numbers, [hit.level, i, j, k], hit.is_entering)
}

#[test]
fn packets_hit_what_single_rays_hit() {
    let (mut hits, mut coarse_hits, mut occluded, mut told) = (0, 0, 0, 0);
    for seed in 0..150 {
        let mut random = SplitMix64::new(seed);
        let dims = [(); 3].map(|()| 2 + random.below(80));
        let along = [(); 3].map(|()| random.range(0.05, 0.6));
        let noise = random.range(0.0, 30.0);
        let samples: Vec<f32> = (0..dims.iter().product::<u32>())
            .map(|n| {
                let p = [n % dims[0], n / dims[0] % dims[1], n / dims[0] / dims[1]];
                let waves: f64 = (0..3).map(|a| (along[a] * f64::from(p[a])).sin()).sum();
                match random.below(2000) {
                    0 => f32::NAN,
                    _ => (40.0 * waves + random.range(0.0, noise)) as f32,
                }
            })
            .collect();
        let coarse = [Coarse::Injected, Coarse::Filtered][random.below(2) as usize];
        let mut source = DenseVolume::new(Dims::new(dims).unwrap(), &samples).unwrap();
        let options = FileOptions { coarse, ..FileOptions::default() };
        let volume = build_with(&mut source, &options, |_| {}).unwrap();
        let octree = volume.view();
        let eye: [f64; 3] = dims.map(|n| random.range(-1.5, 2.5) * f64::from(n));
        let pixel = match random.below(5) {
            0 => PixelWidth::Constant(random.range(0.5, 6.0)),
            _ => PixelWidth::PerDistance(1.0, DVec3::from_array(eye)),
        };
        let (ratio, blend) =
            (random.range(-6.0, -1.0).exp2(), if random.coin() { 0.0 } else { random.unit() });
        let request = DetailRequest { pixel, ratio, measure: DistanceMeasure::True, blend };
        let view =
            DetailView::new(&octree, coarse, Detail::new(octree.dims(), &DAffine3::IDENTITY, &request));
        let (mut packets, mut single) = (DetailPacketTracer::new(&view), DetailPacketTracer::new(&view));
        for n in 0..10 {
            let target = dims.map(|n| random.range(0.0, f64::from(n - 1)));
            let width = random.range(-9.0, 0.0).exp2();
            let across = [(); 2].map(|()| [(); 3].map(|()| random.range(-1.0, 1.0)));
            let mut rays: Vec<Ray> = (0..1 + random.below(90))
                .map(|n| {
                    let [u, v] = [n % 8, n / 8].map(|c| width * 8.0 * (f64::from(c) - 3.5));
                    let to = |a: usize| target[a] - eye[a] + u * across[0][a] + v * across[1][a];
                    let origin = eye.map(|c| c as f32);
                    Ray {
                        origin,
                        direction: [0, 1, 2].map(|a| to(a) as f32),
                        t_min: 0.0,
                        t_max: f32::INFINITY,
                    }
                })
                .collect();
            if n == 9 {
                // One that comes from elsewhere.
                let other = adversarial_ray(dims, seed);
                rays[0] = Ray { origin: other.origin, direction: other.direction, ..rays[0] };
            }
            let isovalue = random.range(-40.0, 60.0) as f32;
            let mut found = [vec![None; rays.len()], vec![None; rays.len()]];
            let traversal = crate::traversals::one_of(n);
            packets.first_hits(&rays, isovalue, traversal, &mut found[0], &mut ());
            single.first_hits(&rays, isovalue, Traversal::Single, &mut found[1], &mut ());
            for (n, ray) in rays.iter().enumerate() {
                let [packet, alone] = [&found[0][n], &found[1][n]].map(|hit| hit.as_ref().map(bits));
                assert_eq!(packet, alone, "seed {seed}, ray {n}: {ray:?}, isovalue {isovalue}");
            }
            hits += found[0].iter().flatten().count();
            if let Some(hull) = crate::traversals::hull(&rays) {
                let may_hit = packets.may_hit(&hull, isovalue, &mut ());
                assert!(may_hit || found[0].iter().all(Option::is_none), "seed {seed}: {hull:?}");
                told += usize::from(!may_hit);
            }
            let of_these: Vec<Hit> = found[0].iter().flatten().copied().collect();
            occluded += crate::shadows::compare(&mut packets, &mut single, &of_these, isovalue, &mut random);
            coarse_hits += found[0].iter().flatten().filter(|hit| hit.level > 0).count();
        }
    }
    println!(
        "{hits} hits, {coarse_hits} of them at coarse levels; {occluded} of {} rays from there are occluded",
        3 * hits
    );
    println!("{told} packets that hit nothing were told by their hulls");
    assert!(hits > 10_000 && coarse_hits > 5000 && told > 30);
    assert!(occluded > hits / 2 && occluded < 3 * hits - hits / 2);
}
