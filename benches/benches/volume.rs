//! Time to integrate emission and absorption, on one thread: along stretches in cells, by several schemes, and along rays through an octree and an array.

mod common;

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};
use isoray_benches::kernels::{
    Stretches, Viewing, VolumeRays, adaptive, bounded, fixed, on_this_thread, table,
};
use isoray_benches::views::View;
use isoray_preint::Integrate;

/// Half a step of eight bits, and one next to which it is nothing.
const EPSILONS: [f64; 2] = [1.0 / 510.0, 1e-6];
/// Schemes without a bound, which answer the same question: by how much the sum over all rays may differ, relative to it.
const UNBOUNDED: f64 = 0.05;

fn stretches(criterion: &mut Criterion) {
    on_this_thread();
    let stretches = Stretches::generate();
    let exact = stretches.integrate(&bounded(EPSILONS[1])).checked();
    let mut group = criterion.benchmark_group("segment integration");
    group.throughput(Throughput::Elements(Stretches::COUNT as u64));
    let by_bound = Stretches::bound(EPSILONS);
    scheme(&mut group, "bounded 1/510", &stretches, &bounded(EPSILONS[0]), exact.sum, by_bound);
    let by_share = UNBOUNDED * exact.sum;
    scheme(&mut group, "adaptive", &stretches, &adaptive(), exact.sum, by_share);
    scheme(&mut group, "fixed 4", &stretches, &fixed(4), exact.sum, by_share);
    scheme(&mut group, "adaptive, table", &stretches, &table(), exact.sum, by_share);
    group.finish();
}

fn scheme(
    group: &mut BenchmarkGroup<'_, WallTime>,
    name: &str,
    stretches: &Stretches,
    scheme: &impl Integrate,
    exact: f64,
    bound: f64,
) {
    let found = stretches.integrate(scheme).checked().sum;
    assert!((found - exact).abs() <= bound, "{name}: {found}, expected {exact} within {bound}");
    group.bench_function(name, |bencher| bencher.iter(|| stretches.integrate(scheme)));
}

fn rays(criterion: &mut Criterion) {
    let views: [(&str, Viewing); 2] = [("far", View::far), ("close", View::close)];
    let scheme = bounded(EPSILONS[0]);
    for (name, viewing) in views {
        let rays = VolumeRays::new(viewing);
        let [octree, array] = [rays.octree(&scheme), rays.array(&scheme)].map(|answer| answer.checked().sum);
        // Both are within the bound of every channel of every ray.
        let bound = 2.0 * 4.0 * EPSILONS[0] * rays.count() as f64;
        assert!((octree - array).abs() <= bound, "{octree} in the octree, {array} in the array");
        let mut group = criterion.benchmark_group(format!("volume rays, {name}"));
        group.throughput(Throughput::Elements(rays.count()));
        group.bench_function("octree", |bencher| bencher.iter(|| rays.octree(&scheme)));
        group.bench_function("array", |bencher| bencher.iter(|| rays.array(&scheme)));
        group.finish();
    }
}

criterion_group! {
    name = benches;
    config = common::config();
    targets = stretches, rays
}
criterion_main!(benches);
