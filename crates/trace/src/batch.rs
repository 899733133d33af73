//! Many rays at once.

use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use crate::hit::Hit;
use crate::ray::Ray;
use crate::trace::Trace;

/// Rays that a thread traces before it asks for more: enough to make up for asking, few enough to balance threads.
const CHUNK: usize = 256;

/// The first crossing of each ray with the isosurface of `isovalue`, on the threads of the current rayon pool, each with a tracer that
/// `tracer` makes once. The same for any number of threads. Rays that follow each other closely gain from being next to each other.
///
/// ```
/// use isoray_build::build;
/// use isoray_grid::{DenseVolume, Dims};
/// use isoray_trace::{Ray, Tracer, first_hits};
///
/// let samples: Vec<u8> = (0..4096).map(|n| (n % 16) as u8).collect(); // a ramp along x
/// let mut array = DenseVolume::new(Dims::new([16; 3])?, &samples)?;
/// let volume = build(&mut array, glam::DAffine3::IDENTITY, |_| {})?;
/// let ray = |y| Ray { origin: [-5.0, y, 3.0], direction: [1.0, 0.0, 0.0], t_min: 0.0, t_max: f32::INFINITY };
/// let rays: Vec<Ray> = (0..20).map(|y| ray(y as f32)).collect();
/// let mut hits = vec![None; rays.len()];
/// let view = volume.view();
/// first_hits(|| Tracer::new(&view), &rays, 9.5, &mut hits);
/// assert!(hits[..16].iter().all(|hit| hit.unwrap().t == 14.5) && hits[16..] == [None; 4]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// Unless there is room for one hit of each ray.
pub fn first_hits<T: Trace + Send>(
    tracer: impl Fn() -> T + Sync,
    rays: &[Ray],
    isovalue: f32,
    hits: &mut [Option<Hit>],
) {
    each(tracer, rays, hits, |tracer, ray| tracer.first_hit(ray, isovalue));
}

/// Whether each ray crosses the isosurface of `isovalue` at all; as [`first_hits`].
///
/// # Panics
/// Unless there is room for one answer to each ray.
pub fn any_hits<T: Trace + Send>(
    tracer: impl Fn() -> T + Sync,
    rays: &[Ray],
    isovalue: f32,
    hits: &mut [bool],
) {
    each(tracer, rays, hits, |tracer, ray| tracer.any_hit(ray, isovalue));
}

/// Answers all rays.
fn each<T: Send, A: Send>(
    tracer: impl Fn() -> T + Sync,
    rays: &[Ray],
    answers: &mut [A],
    answer: impl Fn(&mut T, &Ray) -> A + Sync,
) {
    assert_eq!(rays.len(), answers.len(), "one answer to each ray");
    // Those that no thread works with at the moment. Rayon's own `map_init` would make one for each of its jobs.
    let idle = Mutex::new(Vec::new());
    let idle = || idle.lock().unwrap_or_else(PoisonError::into_inner);
    let chunks = rays.par_chunks(CHUNK).zip(answers.par_chunks_mut(CHUNK));
    chunks.with_max_len(1).for_each(|(rays, answers)| {
        let unused = idle().pop();
        let mut tracer_at_hand = unused.unwrap_or_else(&tracer);
        for (ray, slot) in rays.iter().zip(answers) {
            *slot = answer(&mut tracer_at_hand, ray);
        }
        idle().push(tracer_at_hand);
    });
}
