//! Time of first hits by single rays, packets and slabs, far and close, on one thread.

mod common;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use isoray_benches::kernels::{Rays, Viewing, on_this_thread};
use isoray_benches::views::View;
use isoray_packet::{Slicing, Traversal};

fn packets(criterion: &mut Criterion) {
    on_this_thread();
    let views: [(&str, Viewing); 2] = [("far", View::far), ("close", View::close)];
    for (name, viewing) in views {
        let rays = Rays::new(viewing);
        let single = rays.single().checked();
        let mut group = criterion.benchmark_group(format!("first hits, {name}"));
        group.throughput(Throughput::Elements(rays.count()));
        group.bench_function("single rays", |bencher| bencher.iter(|| rays.single()));
        for (name, traversal) in
            [("packets", Traversal::Masked), ("slabs", Traversal::Coherent(Slicing::default()))]
        {
            assert_eq!(rays.packets(traversal), single, "{name} find the hits of single rays, bit for bit");
            group.bench_function(name, |bencher| bencher.iter(|| rays.packets(traversal)));
        }
        group.finish();
    }
}

criterion_group! {
    name = benches;
    config = common::config();
    targets = packets
}
criterion_main!(benches);
