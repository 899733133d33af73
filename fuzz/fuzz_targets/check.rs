//! What must hold of every cell, shared by the fuzz target and the test that runs its corpus.

use isoray_cell::root::{
    BernsteinItp, BernsteinNewton, BernsteinSeries, FirstRoot, HermiteNewton, Neubauer, Schwarze, SplitNewton,
};
use isoray_cell::{Cubic, EXCURSION_UNITS, MAGNITUDES, Mask, ROOT_STEP, Real, Segment, relative};
use isoray_oracle::CellCase;
use wide::f32x8;

/// Eight samples, the isovalue, entry and exit, each an `f32` in little-endian order. Ends are brought into the cell, as every caller
/// must; what is not a number stays so.
pub(crate) fn case(bytes: &[u8]) -> Option<CellCase> {
    let (words, _) = bytes.as_chunks::<4>();
    let words: &[[u8; 4]; 15] = words.first_chunk()?;
    let number = |n: usize| f32::from_le_bytes(words[n]);
    let local = |n: usize| number(n).clamp(0.0, 1.0);
    Some(CellCase {
        samples: std::array::from_fn(number),
        isovalue: number(8),
        entry: std::array::from_fn(|a| local(9 + a)),
        exit: std::array::from_fn(|a| local(12 + a)),
    })
}

/// Panics if an intersector does what it must not.
pub(crate) fn check(case: &CellCase) {
    let corners = relative(&case.samples, case.isovalue);
    let segment = Segment { entry: case.entry, exit: case.exit };
    let found = BernsteinSeries::first_root(&corners, &segment).get();
    let others = [
        BernsteinNewton::first_root(&corners, &segment).get(),
        BernsteinItp::first_root(&corners, &segment).get(),
        HermiteNewton::first_root(&corners, &segment).get(),
        SplitNewton::first_root(&corners, &segment).get(),
        Neubauer::first_root(&corners, &segment).get(),
        Schwarze::first_root(&corners, &segment).get(),
        found,
    ];
    assert!(others.iter().flatten().all(|s| (0.0..=1.0).contains(s)), "{others:?} in {case:?}");

    let splat = |x: f32| f32x8::splat(x);
    let lanes = Segment { entry: segment.entry.map(splat), exit: segment.exit.map(splat) };
    let root = BernsteinSeries::first_root(&corners.map(splat), &lanes);
    let lane = (root.found.bits() & 1 == 1).then(|| root.s.lane(0));
    assert_eq!(lane.map(f32::to_bits), found.map(f32::to_bits), "lanes and scalar in {case:?}");

    let cubic = Cubic::along(&corners, &segment);
    if !cubic.0.iter().all(|b| b.is_finite()) {
        return;
    }
    assert_eq!(cubic.roots().first().copied(), found, "all roots and the first in {case:?}");
    let differ = cubic.starts_inside() != cubic.ends_inside();
    assert_eq!(cubic.roots().len() % 2 == 1, differ, "parity in {case:?}");
    if MAGNITUDES.contains(&case.magnitude()) {
        let verdict = case.judge(found, EXCURSION_UNITS, 2.0 * ROOT_STEP);
        assert!(!verdict.is_violation(), "{verdict:?}: {found:?} in {case:?}");
    }
}
