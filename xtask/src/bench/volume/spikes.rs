//! Thin features: on how many segments a scheme misses one.

use anyhow::{Result, ensure};
use isoray_oracle::{OracleStretch, SplitMix64, adversarial_cell, integrate_stretch};
use isoray_preint::{
    Bounded, ControlPoint, Cuts, Integrate, LinearPieces, Linearised, Radiance, Segments, TransferFunction,
};
use serde::Serialize;

use crate::for_oracle;

/// A scheme and what it misses.
#[derive(Debug, Serialize)]
pub(crate) struct SpikeRow {
    pub(crate) scheme: String,
    /// Segments that meet the spike.
    pub(crate) meeting: u64,
    /// Of these, those on which the scheme sees nothing of it.
    pub(crate) missed: u64,
    /// Segments that do not meet the spike, but on which the scheme sees some of it.
    pub(crate) invented: u64,
}

/// Width of a spike, of the range of a cell's values.
const WIDTH: f64 = 1e-3;

/// Opacity from which on a spike counts as seen by the oracle.
const SEEN: f64 = 1e-4;

/// Counts over random and adversarial cells, each with a spike somewhere in its range.
pub(crate) fn count(segments: u64) -> Vec<SpikeRow> {
    let adaptive = Cuts::Adaptive { inflection: false, shading: false };
    let linearised = |cuts| {
        move |tf: &TransferFunction| -> Box<dyn Integrate> {
            Box::new(Linearised { cuts, pieces: LinearPieces::new(tf), terminate: 0.0 })
        }
    };
    let bounded = |epsilon| {
        move |tf: &TransferFunction| -> Box<dyn Integrate> { Box::new(Bounded::new(tf, epsilon, 1.0)) }
    };
    vec![
        try_scheme("fixed 1", segments, linearised(Cuts::Fixed(1))),
        try_scheme("fixed 2", segments, linearised(Cuts::Fixed(2))),
        try_scheme("fixed 3", segments, linearised(Cuts::Fixed(3))),
        try_scheme("fixed 4", segments, linearised(Cuts::Fixed(4))),
        try_scheme("fixed 8", segments, linearised(Cuts::Fixed(8))),
        try_scheme("adaptive", segments, linearised(adaptive)),
        try_scheme("bounded 1/510", segments, bounded(1.0 / 510.0)),
        try_scheme("bounded 1e-4", segments, bounded(1e-4)),
    ]
}

/// # Errors
/// A spike that is missed by a scheme that cuts where it may be, or of which another sees nothing at all.
pub(crate) fn judge(rows: &[SpikeRow]) -> Result<()> {
    for SpikeRow { scheme, meeting, missed, .. } in rows {
        let most = if scheme.starts_with("fixed") { meeting.saturating_sub(1) } else { 0 };
        ensure!(
            *meeting > 0 && *missed <= most,
            "{scheme}: expected at most {most} missed of {meeting} spikes, found {missed}"
        );
    }
    Ok(())
}

fn try_scheme(
    name: &str,
    segments: u64,
    scheme: impl Fn(&TransferFunction) -> Box<dyn Integrate>,
) -> SpikeRow {
    let mut row = SpikeRow { scheme: name.to_owned(), meeting: 0, missed: 0, invented: 0 };
    for seed in 0..segments {
        let Some((stretch, transfer)) = case(seed) else { continue };
        let mut batch = Segments::default();
        let single = |v: [f64; 3]| v.map(|c| c as f32);
        batch.push(&stretch.corners.map(|c| c as f32), single(stretch.entry), single(stretch.exit), 1.0);
        let mut radiance = Radiance::default();
        scheme(&transfer).integrate(&batch, None, &mut radiance);
        let points = for_oracle::transfer(transfer.points());
        let exact = integrate_stretch(&stretch, &points, None).alpha();
        row.meeting += u64::from(exact > SEEN);
        row.missed += u64::from(exact > SEEN && radiance.alpha() == 0.0);
        row.invented += u64::from(exact == 0.0 && radiance.alpha() > SEEN);
    }
    row
}

/// A segment through a cell, and a spike in the range of its values.
fn case(seed: u64) -> Option<(OracleStretch, TransferFunction)> {
    let mut random = SplitMix64::new(seed);
    let corners =
        if random.coin() { std::array::from_fn(|_| random.range(-1.0, 1.0)) } else { adversarial_cell(seed) };
    let corners = corners.map(|c| f64::from(c as f32));
    let [low, high] = [f64::min, f64::max].map(|of| corners.into_iter().reduce(of).unwrap_or(0.0));
    let width = WIDTH * (high - low);
    // A spike that single precision can tell from its neighbours.
    if width <= low.abs().max(high.abs()) * 1e-6 || high - low > 1e20 {
        return None;
    }
    let at = random.range(low, high) as f32;
    let point = |value: f32, extinction: f32| ControlPoint { value, color: [1.0; 3], extinction };
    let half = (0.5 * width) as f32;
    let spike = vec![point(at - half, 0.0), point(at, 1e3), point(at + half, 0.0)];
    // From one face to another.
    let (axis, other) = (random.below(3) as usize, random.below(3) as usize);
    let mut end = |face: f64, axis: usize| {
        let mut p: [f64; 3] = std::array::from_fn(|_| f64::from(random.unit() as f32));
        p[axis] = face;
        p
    };
    let (entry, exit) = (end(0.0, axis), end(1.0, other));
    Some((OracleStretch { corners, entry, exit, length: 1.0 }, TransferFunction::new(spike).ok()?))
}
