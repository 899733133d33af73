//! Tracing allocates nothing.
#![allow(unsafe_code, reason = "an allocator that counts is the only way to see allocations")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::ops::ControlFlow;

use isoray_build::build;
use isoray_grid::{DenseVolume, Dims};
use isoray_oracle::{RayKind, SplitMix64};
use isoray_trace::{Ray, Trace, Tracer};

/// The system's, counting what this thread asks for.
struct Counting;

thread_local! {
    static ASKED: Cell<u64> = const { Cell::new(0) };
}

// SAFETY: every call is passed on to the system's allocator as it is.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let _ = ASKED.try_with(|asked| asked.set(asked.get() + 1));
        // SAFETY: as above.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as above.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn asked() -> u64 {
    ASKED.with(Cell::get)
}

#[test]
fn no_ray_allocates() {
    let dims = [40, 33, 29];
    let mut random = SplitMix64::new(1);
    let samples: Vec<u8> = (0..dims.iter().product()).map(|_| random.below(256) as u8).collect();
    let volume = build(
        &mut DenseVolume::new(Dims::new(dims).unwrap(), &samples).unwrap(),
        glam::DAffine3::IDENTITY,
        |_| {},
    )
    .unwrap();
    let view = volume.view();
    let mut tracer = Tracer::new(&view);
    let isovalues = [30.5, 128.0, 200.25];
    let trace = |tracer: &mut Tracer<'_, u8>, isovalues: &[f32], n: u64| {
        let ray = RayKind::ALL[n as usize % RayKind::ALL.len()].generate(dims, n);
        let ray = Ray { origin: ray.origin, direction: ray.direction, t_min: ray.t_min, t_max: ray.t_max };
        let mut count = 0;
        if let Some(hit) = tracer.first_hit(&ray, isovalues[0]) {
            let shadow = hit.departing_ray([0.3, 0.4, -0.7], f32::INFINITY, false);
            count += u32::from(tracer.occluded(&shadow, isovalues[0], &mut ()));
        }
        count += u32::from(tracer.any_hit(&ray, isovalues[0]));
        let _ = tracer.crossings(
            &ray,
            isovalues,
            &mut |_| {
                count += 1;
                ControlFlow::Continue(())
            },
            &mut (),
        );
        count
    };
    // A single isovalue first: it shares what is remembered. Then several, which need room for what they are, once.
    for isovalues in [&isovalues[..1], &isovalues] {
        let mut hits = (0..50).map(|n| trace(&mut tracer, isovalues, n)).sum::<u32>();
        if isovalues.len() > 1 {
            continue;
        }
        let before = asked();
        hits += (0..400).map(|n| trace(&mut tracer, isovalues, n)).sum::<u32>();
        assert_eq!(asked() - before, 0, "allocations for 400 rays");
        assert!(hits > 400, "only {hits} hits");
    }
    let rays: Vec<Ray> = (0..400)
        .map(|n| RayKind::ALL[n as usize % RayKind::ALL.len()].generate(dims, n))
        .map(|r| Ray { origin: r.origin, direction: r.direction, t_min: r.t_min, t_max: r.t_max })
        .collect();
    let mut count = 0;
    let before = asked();
    for ray in &rays {
        let _ = tracer.crossings(
            ray,
            &isovalues,
            &mut |_| {
                count += 1;
                ControlFlow::Continue(())
            },
            &mut (),
        );
    }
    assert_eq!(asked() - before, 0, "allocations for 400 rays and three surfaces");
    assert!(count > 400, "only {count} crossings");
}
