//! Time to find samples in an octree, and those beside them: by the methods of several papers, and by the project's.

mod common;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use isoray_benches::hashing::Method;
use isoray_benches::kernels::{Points, on_this_thread};

const METHODS: [(&str, Method); 3] = [
    ("top-down, by centres", Method::TopDown),
    ("Frisken-Perry 2002", Method::FriskenPerry),
    ("Knoll 2006", Method::Knoll2006),
];

fn points(criterion: &mut Criterion) {
    on_this_thread();
    let points = Points::generate();
    let [located, stepped] = points.expected().map(|answer| answer.checked());

    let mut group = criterion.benchmark_group("point location");
    group.throughput(Throughput::Elements(Points::COUNT as u64));
    assert_eq!(points.locate(), located);
    group.bench_function("isoray", |bencher| bencher.iter(|| points.locate()));
    for (name, method) in METHODS {
        assert_eq!(points.locate_by(method), located, "{name}");
        group.bench_function(name, |bencher| bencher.iter(|| points.locate_by(method)));
    }
    group.finish();

    let mut group = criterion.benchmark_group("neighbour steps");
    group.throughput(Throughput::Elements(points.steps()));
    assert_eq!(points.step(), stepped);
    group.bench_function("isoray", |bencher| bencher.iter(|| points.step()));
    for (name, method) in METHODS {
        assert_eq!(points.step_by(method), stepped, "{name}");
        group.bench_function(name, |bencher| bencher.iter(|| points.step_by(method)));
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = common::config();
    targets = points
}
criterion_main!(benches);
