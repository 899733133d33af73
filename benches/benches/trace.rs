//! Time of one frame on one thread: the project's first hits and gradients against those of the 2006 paper.

mod common;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use isoray_benches::kernels::{Rays, Viewing, on_this_thread};
use isoray_benches::views::View;

/// By how much the paper's hits may differ from ours in number, and their depths in sum, relative to ours: its root finder misses some and misplaces others, 2 % of them or less in
/// `tests/paper.rs`.
const UNLIKE: f64 = 0.05;

fn frames(criterion: &mut Criterion) {
    on_this_thread();
    let paper = Rays::paper();
    let views: [(&str, Viewing); 2] = [("far", View::far), ("close", View::close)];
    for (name, viewing) in views {
        let rays = Rays::new(viewing);
        let ours = rays.with_gradients().checked();
        assert_eq!(ours, rays.single(), "{name}: with gradients the hits are the same, bit for bit");
        let theirs = rays.by_paper(&paper).checked();
        let difference = [theirs.found as f64 / ours.found as f64, theirs.sum / ours.sum].map(|of| of - 1.0);
        assert!(difference.iter().all(|by| by.abs() <= UNLIKE), "{name}: {theirs:?}, ours {ours:?}");
        let mut group = criterion.benchmark_group(format!("marschner_lobb_{}_{name}", Rays::EDGE));
        group.throughput(Throughput::Elements(rays.count()));
        group.bench_function("isoray", |bencher| bencher.iter(|| rays.with_gradients()));
        group.bench_function("knoll2006", |bencher| bencher.iter(|| rays.by_paper(&paper)));
        group.finish();
    }
}

criterion_group! {
    name = benches;
    config = common::config();
    targets = frames
}
criterion_main!(benches);
