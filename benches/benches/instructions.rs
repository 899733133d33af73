//! Instructions of each kernel, counted by valgrind, each in a process of its own and on one thread: a count repeats where a time does not. `cargo xtask instructions` runs it.
//!
//! What is made before is not counted, nor is what is freed after.

#![allow(missing_docs, reason = "gungraun's macros make public items")]

use std::hint::black_box;

use gungraun::{Callgrind, LibraryBenchmarkConfig, library_benchmark, library_benchmark_group, main};
use isoray_benches::kernels::{
    Answer, Building, Clumps, Points, Rays, Roots, Stretches, Viewing, VolumeRays, adaptive, bounded, fixed,
    on_this_thread, table,
};
use isoray_benches::views::View;
use isoray_benches::volumes::{marschner_lobb, turbulence};
use isoray_packet::{Slicing, Traversal};
use isoray_preint::{Bounded, Integrate};
use wide::f32x16;

/// Half a step of eight bits.
const EPSILON: f64 = 1.0 / 510.0;

/// What is made before stays until the process ends, so that nothing is freed while instructions are counted.
fn kept<W>(make: impl FnOnce() -> W) -> &'static W {
    on_this_thread();
    Box::leak(Box::new(make()))
}

fn is_found(answer: Answer) {
    answer.checked();
}

fn roots<R: isoray_cell::Real<Scalar = f32>>() -> &'static Roots<R> {
    kept(Roots::generate)
}

#[library_benchmark(teardown = is_found)]
#[bench::random(roots())]
fn first_roots_one_by_one(roots: &'static Roots<f32>) -> Answer {
    black_box(roots).find()
}

#[library_benchmark(teardown = is_found)]
#[bench::random(roots())]
fn first_roots_in_lanes(roots: &'static Roots<f32x16>) -> Answer {
    black_box(roots).find()
}

fn rays(viewing: Viewing) -> &'static Rays {
    kept(|| Rays::new(viewing))
}

#[library_benchmark(setup = rays, teardown = is_found)]
#[bench::far(View::far)]
#[bench::close(View::close)]
fn single_rays(rays: &'static Rays) -> Answer {
    black_box(rays).single()
}

#[library_benchmark(setup = rays, teardown = is_found)]
#[bench::far(View::far)]
#[bench::close(View::close)]
fn packets(rays: &'static Rays) -> Answer {
    black_box(rays).packets(Traversal::Masked)
}

#[library_benchmark(setup = rays, teardown = is_found)]
#[bench::far(View::far)]
#[bench::close(View::close)]
fn slabs(rays: &'static Rays) -> Answer {
    black_box(rays).packets(Traversal::Coherent(Slicing::default()))
}

fn building(generate: fn(usize) -> Vec<u8>) -> &'static Building {
    kept(|| Building::new(generate))
}

#[library_benchmark(setup = building, teardown = is_found)]
#[bench::marschner_lobb(marschner_lobb)]
#[bench::turbulence(turbulence)]
fn octree_making(building: &'static Building) -> Answer {
    black_box(building).build()
}

type Scheme = Box<dyn Integrate>;

fn stretches(scheme: Scheme) -> &'static (Stretches, Scheme) {
    kept(|| (Stretches::generate(), scheme))
}

#[library_benchmark(setup = stretches, teardown = is_found)]
#[bench::bounded(Box::new(bounded(EPSILON)))]
#[bench::adaptive(Box::new(adaptive()))]
#[bench::fixed_4(Box::new(fixed(4)))]
#[bench::adaptive_table(Box::new(table()))]
fn segment_integration(work: &'static (Stretches, Scheme)) -> Answer {
    let (stretches, scheme) = black_box(work);
    stretches.integrate(scheme)
}

fn volume_rays(viewing: Viewing) -> &'static (VolumeRays, Bounded) {
    kept(|| (VolumeRays::new(viewing), bounded(EPSILON)))
}

#[library_benchmark(setup = volume_rays, teardown = is_found)]
#[bench::far(View::far)]
#[bench::close(View::close)]
fn volume_rays_octree(work: &'static (VolumeRays, Bounded)) -> Answer {
    let (rays, scheme) = black_box(work);
    rays.octree(scheme)
}

fn clumps() -> &'static (Clumps, Bounded) {
    kept(|| {
        let clumps = Clumps::generate();
        let scheme = clumps.scheme();
        (clumps, scheme)
    })
}

#[library_benchmark(teardown = is_found)]
#[bench::clumps(clumps())]
fn mesh_making((clumps, _): &'static (Clumps, Bounded)) -> Answer {
    black_box(clumps).make()
}

#[library_benchmark(teardown = is_found)]
#[bench::clumps(clumps())]
fn mesh_surface((clumps, _): &'static (Clumps, Bounded)) -> Answer {
    black_box(clumps).surface()
}

#[library_benchmark(teardown = is_found)]
#[bench::clumps(clumps())]
fn mesh_volume((clumps, scheme): &'static (Clumps, Bounded)) -> Answer {
    black_box(clumps).volume(scheme)
}

fn points() -> &'static Points {
    kept(Points::generate)
}

#[library_benchmark(teardown = is_found)]
#[bench::random(points())]
fn point_location(points: &'static Points) -> Answer {
    black_box(points).locate()
}

#[library_benchmark(teardown = is_found)]
#[bench::random(points())]
fn neighbor_steps(points: &'static Points) -> Answer {
    black_box(points).step()
}

library_benchmark_group!(
    name = kernels,
    benchmarks = [
        first_roots_one_by_one,
        first_roots_in_lanes,
        single_rays,
        packets,
        slabs,
        octree_making,
        segment_integration,
        volume_rays_octree,
        mesh_making,
        mesh_surface,
        mesh_volume,
        point_location,
        neighbor_steps,
    ]
);

// Caches are not simulated: counts of their misses would be those of no machine at hand, and take as long again.
main!(
    config = LibraryBenchmarkConfig::default().tool(Callgrind::with_args(["--cache-sim=no"])),
    library_benchmark_groups = kernels
);
