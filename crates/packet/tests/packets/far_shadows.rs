//! Shadows through coarser levels of detail.

use std::ops::ControlFlow;

use glam::{DAffine3, DVec3};
use isoray_build::build;
use isoray_grid::{DenseVolume, Dims};
use isoray_octree::lod::{Detail, DetailRequest, DetailView, DistanceMeasure, PixelWidth};
use isoray_octree::{Coarse, OctreeVolume};
use isoray_oracle::SplitMix64;
use isoray_packet::{FarShadows, PacketTracer, TracePackets, Traversal};
use isoray_trace::{DetailTracer, Hit, Ray, Trace};

const EDGE: u32 = 96;

fn volume(at: impl Fn(DVec3) -> f64) -> OctreeVolume<f32> {
    let sample = |n: u32| {
        let p = [n % EDGE, n / EDGE % EDGE, n / EDGE.pow(2)].map(f64::from);
        at(DVec3::from_array(p)) as f32
    };
    let samples: Vec<f32> = (0..EDGE.pow(3)).map(sample).collect();
    let mut source = DenseVolume::new(Dims::new([EDGE; 3]).unwrap(), &samples).unwrap();
    build(&mut source, DAffine3::IDENTITY, |_| {}).unwrap()
}

/// Cells of a coarse level everywhere, or coarser ones the farther from a corner of the domain.
fn detail(dims: Dims, level: Option<u32>) -> Detail {
    let (pixel, ratio) = match level {
        Some(level) => (PixelWidth::Constant(1.0), f64::from(1u32 << level)),
        None => (PixelWidth::PerDistance(1.0, DVec3::ZERO), 0.08),
    };
    let request = DetailRequest { pixel, ratio, measure: DistanceMeasure::True, blend: 0.0 };
    Detail::new(dims, &DAffine3::IDENTITY, &request)
}

/// What rays along z hit from above and below.
fn hits(tracer: &mut PacketTracer<'_, f32>, isovalue: f32) -> Vec<Hit> {
    let ray = |n: u32| {
        let [x, y] = [n % 64, n / 64].map(|c| 1.0 + 1.47 * c as f32);
        let [origin, towards] = if n.is_multiple_of(2) { [-10.0, 1.0] } else { [EDGE as f32 + 10.0, -1.0] };
        Ray { origin: [x, y, origin], direction: [0.01, 0.02, towards], t_min: 0.0, t_max: f32::INFINITY }
    };
    (0..64 * 64).filter_map(|n| tracer.first_hit(&ray(n), isovalue)).collect()
}

#[test]
fn a_light_is_hidden_where_a_ray_comes_to_the_other_side_of_a_coarse_surface() {
    let waves = volume(|p| (0.31 * p.x).sin() + (0.24 * p.y).sin() + (0.28 * p.z + 0.05 * p.x).cos());
    let octree = waves.view();
    let mut random = SplitMix64::new(3);
    let (mut tested, mut hidden, mut exact) = (0, 0, 0);
    for round in 0..24 {
        let isovalue = random.range(-0.6, 0.6) as f32;
        let level = [None, Some(1), Some(2)][round % 3];
        let view = DetailView::new(&octree, Coarse::Injected, detail(octree.dims(), level));
        let mut far = FarShadows::new(PacketTracer::new(&octree), &view);
        let mut ordered = DetailTracer::new(&view);
        let light = [(); 3].map(|()| random.range(-1.0, 1.0) as f32);
        let rays: Vec<_> = hits(&mut PacketTracer::new(&octree), isovalue)
            .iter()
            .map(|hit| {
                let own = [(); 3].map(|()| random.range(-1.0, 1.0) as f32);
                let direction = if round % 4 < 2 { light } else { own };
                let t_max = if random.coin() { f32::INFINITY } else { random.range(0.0, 60.0) as f32 };
                hit.departing_ray(direction, t_max, !hit.is_entering)
            })
            .collect();
        for (n, rays) in rays.chunks(64).enumerate() {
            let mut found = vec![true; rays.len()];
            far.occluded_all(rays, isovalue, crate::traversals::one_of(n), &mut found, &mut ());
            for (ray, &found) in rays.iter().zip(&found) {
                let cell = ray.origin().map(|c| (c as u32).min(EDGE - 2));
                let level = view.detail().level(cell);
                let expected = match level {
                    0 => {
                        exact += 1;
                        PacketTracer::new(&octree).occluded(ray, isovalue, &mut ())
                    }
                    _ => {
                        let speed = ray.direction.iter().map(|&d| f64::from(d).powi(2)).sum::<f64>().sqrt();
                        let begin = (f64::from(1u32 << level) / speed) as f32;
                        let from_there = Ray { t_min: begin, ..ray.rounded() };
                        let mut comes_over = false;
                        let _ = ordered.crossings(
                            &from_there,
                            &[isovalue],
                            &mut |crossing| {
                                comes_over |= crossing.hit.is_entering != ray.into_inside;
                                ControlFlow::Continue(())
                            },
                            &mut (),
                        );
                        comes_over
                    }
                };
                assert_eq!(found, expected, "round {round}: {ray:?}, isovalue {isovalue}, level {level}");
                assert_eq!(found, far.occluded(ray, isovalue, &mut ()), "alone: {ray:?}");
                tested += 1;
                hidden += usize::from(found);
            }
        }
    }
    println!("{tested} rays, {hidden} of them hidden, {exact} traced at the finest level");
    assert!(tested > 20_000 && hidden > tested / 5 && hidden < 4 * tested / 5 && exact > 500);
}

/// Two balls of one size, of which one hides the light from a part of the other. The field is the distance from the nearer one, whose second derivatives across the
/// distance are `1/R`: between samples `h` apart it is interpolated to within `2·h²/(8R)`, and so is the surface displaced, on which it has slope 1.
#[test]
fn a_ball_shadows_another_one_but_not_itself() {
    const RADIUS: f64 = 20.0;
    let centers = [DVec3::new(30.0, 48.0, 48.0), DVec3::new(72.0, 52.0, 50.0)];
    let balls = volume(|p| -centers.map(|c| p.distance(c)).into_iter().fold(f64::INFINITY, f64::min));
    let (octree, isovalue) = (balls.view(), -RADIUS as f32);
    let to_light = (centers[0] - centers[1]).normalize();
    for level in 1..=2 {
        let cell = f64::from(1u32 << level);
        let displacement = 2.0 * cell * cell / (8.0 * RADIUS);
        let view = DetailView::new(&octree, Coarse::Injected, detail(octree.dims(), Some(level)));
        let mut far = FarShadows::new(PacketTracer::new(&octree), &view);
        let mut tracer = PacketTracer::new(&octree);
        let (mut lit, mut dark, mut shadowed, mut differing) = (0, 0, 0, 0);
        for hit in hits(&mut tracer, isovalue) {
            let position = DVec3::from_array(hit.position());
            let nearer = centers.map(|c| position.distance(c));
            let ball = usize::from(nearer[1] < nearer[0]);
            let weight = (position - centers[ball]).normalize().dot(to_light);
            if weight <= 0.0 {
                continue;
            }
            let ray = hit.departing_ray(to_light.as_vec3().to_array(), f32::INFINITY, !hit.is_entering);
            let expected = tracer.occluded(&ray, isovalue, &mut ());
            let found = far.occluded(&ray, isovalue, &mut ());
            match (ball, found) {
                // The other ball is behind the light's side of this one.
                (0, false) => lit += 1,
                (0, true) => {
                    dark += 1;
                    assert!(weight < displacement / cell, "level {level}: {position} has weight {weight}");
                }
                _ => {
                    shadowed += usize::from(expected);
                    differing += usize::from(found != expected);
                }
            }
        }
        println!("level {level}: {lit} lit, {dark} dark; {shadowed} in the shadow, {differing} differ");
        assert!(lit > 200 && shadowed > 200 && differing * 8 < shadowed);
    }
    // The finest level is what it is without.
    let view = DetailView::new(&octree, Coarse::Injected, detail(octree.dims(), Some(0)));
    let mut far = FarShadows::new(PacketTracer::new(&octree), &view);
    let hits = hits(&mut PacketTracer::new(&octree), isovalue);
    let rays: Vec<_> = hits.iter().map(|h| h.departing_ray([0.3, 0.1, -0.8], 30.0, !h.is_entering)).collect();
    let [mut found, mut expected] = [(); 2].map(|()| vec![false; rays.len()]);
    far.occluded_all(&rays, isovalue, Traversal::Auto, &mut found, &mut ());
    PacketTracer::new(&octree).occluded_all(&rays, isovalue, Traversal::Single, &mut expected, &mut ());
    assert_eq!(found, expected);
}
