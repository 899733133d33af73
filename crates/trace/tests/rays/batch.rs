//! Batches of rays: the same answers as one by one, on any number of threads.

use isoray_build::build;
use isoray_grid::{DenseVolume, Dims};
use isoray_oracle::{RayKind, SplitMix64};
use isoray_trace::{Ray, Tracer, any_hits, first_hits};

#[test]
fn batches_answer_as_single_rays_do() {
    let dims = [45, 38, 51];
    let mut random = SplitMix64::new(2);
    let samples: Vec<i16> = (0..dims.iter().product()).map(|_| random.below(1000) as i16 - 500).collect();
    let mut array = DenseVolume::new(Dims::new(dims).unwrap(), &samples).unwrap();
    let volume = build(&mut array, glam::DAffine3::IDENTITY, |_| {}).unwrap();
    let view = volume.view();
    let rays: Vec<Ray> = (0..3001)
        .map(|n| RayKind::ALL[n as usize % RayKind::ALL.len()].generate(dims, n))
        .map(|r| Ray { origin: r.origin, direction: r.direction, t_min: r.t_min, t_max: r.t_max })
        .collect();
    let mut tracer = Tracer::new(&view);
    let expected: Vec<_> = rays.iter().map(|ray| tracer.first_hit(ray, 100.5)).collect();
    assert!(expected.iter().flatten().count() > 300);
    for threads in [1, 2, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut hits = vec![None; rays.len()];
        let mut any = vec![false; rays.len()];
        pool.install(|| {
            first_hits(|| Tracer::new(&view), &rays, 100.5, &mut hits);
            any_hits(|| Tracer::new(&view), &rays, 100.5, &mut any);
        });
        assert_eq!(hits, expected, "{threads} threads");
        assert!(any.iter().zip(&expected).all(|(any, hit)| *any == hit.is_some()), "{threads} threads");
    }
}
