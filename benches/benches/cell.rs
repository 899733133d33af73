//! Time of each first-root finder on each scenario, one pair at a time and in lanes: cells of the bundled scan, and random ones.

use std::path::Path;

use criterion::{
    BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main, measurement::WallTime,
};
use isoray_benches::cells::{Pair, Scenario, grazing, met_by_rays, random};
use isoray_benches::kernels::{Answer, Roots, on_this_thread};
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
/// Share of a set's pairs by which a method may find more or fewer roots than the default. The closed form misses 1.4 % of those that graze, of all others fewer; and of pairs
/// that graze by so little that rounding decides, within `EXCURSION_UNITS`·2⁻²⁴ = 1.6·10⁻⁶, which are 5 of 100 of what [`grazing`] makes, either may be said.
const UNLIKE: f64 = 0.1;

fn lanes<F: FirstRoot, R: Real<Scalar = f32>>(
    group: &mut BenchmarkGroup<'_, WallTime>,
    pairs: &[Pair],
    alone: Answer,
) {
    let roots = Roots::<R>::of(pairs);
    let name = format!("{}, {} lanes", F::NAME, R::LANES);
    assert_eq!(roots.find_by::<F>(), alone, "{name}: expected what one finds, bit for bit");
    group.bench_function(name, |bencher| bencher.iter(|| roots.find_by::<F>()));
}

fn method<F: FirstRoot>(group: &mut BenchmarkGroup<'_, WallTime>, pairs: &[Pair], default: Answer) {
    let alone = Roots::<f32>::of(pairs).find_by::<F>();
    let difference = alone.found.abs_diff(default.found) as f64;
    assert!(difference <= UNLIKE * pairs.len() as f64, "{}: {alone:?}, the default {default:?}", F::NAME);
    // Roots lie between 0 and 1, each.
    assert!(alone.sum >= 0.0 && alone.sum <= alone.found as f64, "{}: {alone:?}", F::NAME);
    lanes::<F, f32>(group, pairs, alone);
    lanes::<F, f32x4>(group, pairs, alone);
    lanes::<F, f32x8>(group, pairs, alone);
    lanes::<F, f32x16>(group, pairs, alone);
}

/// Times all methods on pairs of which the default finds a root in so many, if that is known.
fn set(criterion: &mut Criterion, name: &str, pairs: &[Pair], expected: Option<usize>) {
    // In lanes of any number the same pairs.
    let pairs = &pairs[..pairs.len() / f32x16::LANES * f32x16::LANES];
    let default = Roots::<f32>::of(pairs).find();
    match expected {
        Some(expected) => assert_eq!(default.found, expected as u64, "{name}: roots of the default"),
        None => _ = default.checked(),
    }
    let mut group = criterion.benchmark_group(name);
    group.throughput(Throughput::Elements(pairs.len() as u64)).sample_size(10);
    method::<BernsteinSeries>(&mut group, pairs, default);
    method::<BernsteinNewton>(&mut group, pairs, default);
    method::<BernsteinItp>(&mut group, pairs, default);
    method::<HermiteNewton>(&mut group, pairs, default);
    method::<SplitNewton>(&mut group, pairs, default);
    method::<Neubauer>(&mut group, pairs, default);
    method::<Schwarze>(&mut group, pairs, default);
    group.finish();
}

/// `PAIRS` of them, repeated if there are fewer.
fn of_scenario(pairs: &[Pair], scenario: Scenario) -> Vec<Pair> {
    let some: Vec<Pair> = pairs.iter().copied().filter(|p| Scenario::of(p) == scenario).collect();
    assert!(!some.is_empty(), "no pair is {scenario:?}");
    some.into_iter().cycle().take(PAIRS).collect()
}

fn methods(criterion: &mut Criterion) {
    on_this_thread();
    // The cells of which instructions are counted.
    set(criterion, "random", &random(Roots::<f32>::CELLS, 1), None);
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fixtures/tooth/tooth.nrrd");
    let scan = Dataset::open(&file, &OpenOptions::default()).unwrap();
    let volume = build(&mut scan.slabs::<u16>().unwrap(), scan.index_to_world(), |_| {}).unwrap();
    let octree = volume.view();
    let view = View::close(scan.dims(), 256, 256);
    let met = met_by_rays(&mut Tracer::new(&octree), &view, ISOVALUE, 20 * PAIRS);
    let random = random(20 * PAIRS, 1);
    for (name, pairs) in [("tooth", &met), ("random", &random)] {
        for scenario in Scenario::ALL {
            let found = if matches!(scenario, Scenario::Early | Scenario::Late) { PAIRS } else { 0 };
            set(criterion, &format!("{name}, {scenario:?}"), &of_scenario(pairs, scenario), Some(found));
        }
        let grazing = grazing(pairs, 2).into_iter().take(PAIRS).collect::<Vec<_>>();
        set(criterion, &format!("{name}, grazing"), &grazing, None);
    }
}

criterion_group!(benches, methods);
criterion_main!(benches);
