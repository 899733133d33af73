//! What a traversal found, played back: what is left of the time when the cells are known, or the answer is.

use std::hint::black_box;
use std::ops::ControlFlow;

use isoray_benches::views::View;
use isoray_trace::{Candidate, FirstHit, Hit, HitPolicy, Trace};

/// What a frame came to: by this a timed run is known to have found what it should.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Found {
    pub(crate) hits: u64,
    /// Sum of the bits of where on the rays they are: the same in whatever order rays are traced, and exact.
    depths: u64,
}

impl Found {
    /// One more hit, at `t`.
    #[inline(always)]
    pub(crate) fn add(&mut self, t: f32) {
        self.hits += 1;
        self.depths += u64::from(t.to_bits());
    }
}

/// The cells that rays intersected, up to that of the first hit and with it, packed, in order.
#[derive(Debug, Default)]
pub(crate) struct Recorded {
    candidates: Vec<Candidate>,
    /// Of each ray, where its cells end.
    ends: Vec<usize>,
}

/// Records the cells on the way to the first hit.
struct Recording<'a> {
    candidates: &'a mut Vec<Candidate>,
    first: FirstHit,
}

impl HitPolicy for Recording<'_> {
    fn candidate(&mut self, candidate: &Candidate) -> ControlFlow<()> {
        self.candidates.push(*candidate);
        self.first.candidate(candidate)
    }

    fn jump(&mut self, _: &Hit) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// Ends in the cell that is known to be hit, without intersecting any.
struct KnownCells<'a>(&'a [Candidate]);

impl HitPolicy for KnownCells<'_> {
    #[inline(always)]
    fn candidate(&mut self, candidate: &Candidate) -> ControlFlow<()> {
        black_box(candidate.corners);
        let Some((_, rest)) = self.0.split_first() else { return ControlFlow::Continue(()) };
        self.0 = rest;
        // Rays that miss go on behind their last cell, as they did.
        if rest.is_empty() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    fn jump(&mut self, _: &Hit) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// Lambert's law for a headlight.
pub(crate) fn lambert(gradient: [f32; 3], direction: [f32; 3]) -> f32 {
    let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    dot(gradient, direction).abs() / dot(gradient, gradient).sqrt().max(f32::MIN_POSITIVE)
}

/// What a frame does with each hit: shades it, or only keeps it.
#[inline(always)]
pub(crate) fn finish<const SHADED: bool>(t: f32, gradient: impl FnOnce() -> [f32; 3], direction: [f32; 3]) {
    match SHADED {
        true => _ = black_box(lambert(gradient(), direction)),
        false => _ = black_box(t),
    }
}

impl Recorded {
    pub(crate) fn new(tracer: &mut impl Trace, view: &View, isovalue: f32) -> Self {
        let mut recorded = Self::default();
        for &direction in &view.directions {
            let mut recording =
                Recording { candidates: &mut recorded.candidates, first: FirstHit::default() };
            tracer.trace(&view.ray(direction), isovalue, &mut recording, &mut ());
            recorded.ends.push(recorded.candidates.len());
        }
        recorded
    }

    fn per_ray(&self) -> impl Iterator<Item = &[Candidate]> {
        let begins = std::iter::once(&0).chain(&self.ends);
        begins.zip(&self.ends).map(|(&begin, &end)| &self.candidates[begin..end])
    }

    /// The intersection floor: only the cells that must be intersected, and then the same shading.
    #[inline(never)]
    pub(crate) fn intersect(&self, view: &View) -> Found {
        let mut found = Found::default();
        for (cells, &direction) in self.per_ray().zip(&view.directions) {
            if let Some(hit) = cells.iter().find_map(Candidate::first_hit) {
                found.add(hit.t);
                finish::<true>(hit.t, || hit.gradient(), direction);
            }
        }
        found
    }

    /// Only the traversal, up to the cells that are known to be hit, and with fetching the samples of all that are to be intersected. What comes out is of the rays that met all
    /// of their cells: these hit where they are known to.
    #[inline(never)]
    pub(crate) fn traverse(
        &self,
        tracer: &mut impl Trace,
        view: &View,
        isovalue: f32,
        hits: &[Option<Hit>],
    ) -> Found {
        let mut found = Found::default();
        for ((cells, &direction), hit) in self.per_ray().zip(&view.directions).zip(hits) {
            let mut known = KnownCells(if hit.is_some() { cells } else { &[] });
            tracer.trace(&view.ray(direction), isovalue, &mut known, &mut ());
            if let Some(hit) = hit
                && known.0.is_empty()
            {
                found.add(hit.t);
            }
        }
        found
    }
}
