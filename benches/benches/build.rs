//! Time to make octree volumes of samples in memory, on one thread: of a volume that nowhere is constant, and of one that partly is.

mod common;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use isoray_benches::kernels::{Building, on_this_thread};
use isoray_benches::volumes::{marschner_lobb, turbulence};

fn building(criterion: &mut Criterion) {
    on_this_thread();
    let mut group = criterion.benchmark_group("octree, making");
    let dense = Building::new(marschner_lobb);
    let partly_constant = Building::new(turbulence);
    let [most, least] = [&dense, &partly_constant].map(|samples| samples.build().checked());
    assert!(least.found < most.found, "what is constant takes less room");
    for (name, samples) in [("Marschner-Lobb", &dense), ("turbulence", &partly_constant)] {
        group.throughput(Throughput::Elements(samples.count()));
        group.bench_function(name, |bencher| bencher.iter(|| samples.build()));
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = common::config();
    targets = building
}
criterion_main!(benches);
