//! Time to make an adaptive mesh of patches in memory, and of rays through it, on one thread.

mod common;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use isoray_benches::kernels::{Clumps, on_this_thread};

fn meshes(criterion: &mut Criterion) {
    on_this_thread();
    let clumps = Clumps::generate();
    let scheme = clumps.scheme();
    let [surface_rays, volume_rays] = clumps.rays();
    assert_eq!(clumps.make().checked().found, clumps.leaves(), "the mesh is the same again");
    clumps.surface().checked();
    clumps.volume(&scheme).checked();
    let mut group = criterion.benchmark_group("adaptive mesh");
    group.throughput(Throughput::Elements(clumps.leaves()));
    group.bench_function("making", |bencher| bencher.iter(|| clumps.make()));
    group.throughput(Throughput::Elements(surface_rays));
    group.bench_function("surface", |bencher| bencher.iter(|| clumps.surface()));
    group.throughput(Throughput::Elements(volume_rays));
    group.bench_function("volume", |bencher| bencher.iter(|| clumps.volume(&scheme)));
    group.finish();
}

criterion_group! {
    name = benches;
    config = common::config();
    targets = meshes
}
criterion_main!(benches);
