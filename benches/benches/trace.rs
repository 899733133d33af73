//! Time of one frame on one thread: the project's first hits and gradients against those of the 2006 paper.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use isoray_benches::knoll2006::PaperOctree;
use isoray_benches::views::View;
use isoray_benches::volumes::marschner_lobb;
use isoray_build::build;
use isoray_grid::{DenseVolume, Dims};
use isoray_trace::{Ray, Tracer};

const EDGE: u32 = 128;
const PIXELS: u32 = 256;
const ISOVALUE: f32 = 127.5;

fn frames(criterion: &mut Criterion) {
    let dims = Dims::new([EDGE; 3]).unwrap();
    let samples = marschner_lobb(EDGE as usize);
    let paper = PaperOctree::build(dims, &samples);
    let volume =
        build(&mut DenseVolume::new(dims, &samples).unwrap(), glam::DAffine3::IDENTITY, |_| {}).unwrap();
    let octree = volume.view();
    for (name, view) in
        [("far", View::far(dims, PIXELS, PIXELS)), ("close", View::close(dims, PIXELS, PIXELS))]
    {
        let mut group = criterion.benchmark_group(format!("marschner_lobb_{EDGE}_{name}"));
        group.throughput(Throughput::Elements(view.directions.len() as u64)).sample_size(20);
        group.bench_function("isoray", |bencher| {
            let mut tracer = Tracer::new(&octree);
            bencher.iter(|| {
                for &direction in &view.directions {
                    let ray = Ray { origin: view.origin, direction, t_min: 0.0, t_max: f32::INFINITY };
                    black_box(tracer.first_hit(&ray, ISOVALUE).map(|hit| (hit.t, hit.gradient())));
                }
            });
        });
        group.bench_function("knoll2006", |bencher| {
            bencher.iter(|| {
                for &direction in &view.directions {
                    black_box(paper.first_hit(view.origin, direction, ISOVALUE));
                }
            });
        });
        group.finish();
    }
}

criterion_group!(benches, frames);
criterion_main!(benches);
