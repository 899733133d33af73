//! Time of each first-root finder on each scenario, one pair at a time and in lanes: cells of the bundled scan, and random ones.

use std::hint::black_box;
use std::path::Path;

use criterion::{
    BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main, measurement::WallTime,
};
use isoray_benches::cells::{Pair, Scenario, grazing, met_by_rays, packed, random};
use isoray_benches::views::View;
use isoray_build::build;
use isoray_cell::Real;
use isoray_cell::root::{
    BernsteinItp, BernsteinNewton, BernsteinSeries, FirstRoot, HermiteNewton, Neubauer, Schwarze, SplitNewton,
};
use isoray_io::{Dataset, OpenOptions};
use isoray_trace::Tracer;
use wide::{f32x4, f32x8, f32x16};

const PAIRS: usize = 4096;
const ISOVALUE: f32 = 600.0;

fn lanes<F: FirstRoot, R: Real<Scalar = f32>>(group: &mut BenchmarkGroup<'_, WallTime>, pairs: &[Pair]) {
    let packed = packed::<R>(pairs);
    group.bench_function(format!("{}, {} lanes", F::NAME, R::LANES), |bencher| {
        bencher.iter(|| {
            for (corners, segment) in &packed {
                black_box(F::first_root(corners, segment));
            }
        });
    });
}

fn method<F: FirstRoot>(group: &mut BenchmarkGroup<'_, WallTime>, pairs: &[Pair]) {
    lanes::<F, f32>(group, pairs);
    lanes::<F, f32x4>(group, pairs);
    lanes::<F, f32x8>(group, pairs);
    lanes::<F, f32x16>(group, pairs);
}

fn set(criterion: &mut Criterion, name: &str, pairs: &[Pair]) {
    let mut group = criterion.benchmark_group(name);
    group.throughput(Throughput::Elements(pairs.len() as u64)).sample_size(10);
    method::<BernsteinSeries>(&mut group, pairs);
    method::<BernsteinNewton>(&mut group, pairs);
    method::<BernsteinItp>(&mut group, pairs);
    method::<HermiteNewton>(&mut group, pairs);
    method::<SplitNewton>(&mut group, pairs);
    method::<Neubauer>(&mut group, pairs);
    method::<Schwarze>(&mut group, pairs);
    group.finish();
}

/// `PAIRS` of them, repeated if there are fewer.
fn of_scenario(pairs: &[Pair], scenario: Scenario) -> Vec<Pair> {
    let some: Vec<Pair> = pairs.iter().copied().filter(|p| Scenario::of(p) == scenario).collect();
    assert!(!some.is_empty(), "no pair is {scenario:?}");
    some.into_iter().cycle().take(PAIRS).collect()
}

fn methods(criterion: &mut Criterion) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures/tooth/tooth.nrrd");
    let scan = Dataset::open(&file, &OpenOptions::default()).unwrap();
    let volume = build(&mut scan.slabs::<u16>().unwrap(), scan.index_to_world(), |_| {}).unwrap();
    let octree = volume.view();
    let view = View::close(scan.dims(), 256, 256);
    let met = met_by_rays(&mut Tracer::new(&octree), &view, ISOVALUE, 20 * PAIRS);
    let random = random(20 * PAIRS, 1);
    for (name, pairs) in [("tooth", &met), ("random", &random)] {
        for scenario in Scenario::ALL {
            set(criterion, &format!("{name}, {scenario:?}"), &of_scenario(pairs, scenario));
        }
        let grazing = grazing(pairs, 2).into_iter().take(PAIRS).collect::<Vec<_>>();
        set(criterion, &format!("{name}, grazing"), &grazing);
    }
}

criterion_group!(benches, methods);
criterion_main!(benches);
