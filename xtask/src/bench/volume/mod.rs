//! Volume rendering: time against error, and features that are missed. What skipping gains is in [`skipping`](super::skipping).

mod curves;
pub(super) mod schemes;
mod spikes;
mod write;

use std::path::Path;

use anyhow::Result;
use serde::Serialize;

use crate::catalog::Entry;

/// All that is measured.
#[derive(Debug, Default, Serialize)]
pub(crate) struct VolumeSuite {
    curves: Vec<curves::Curve>,
    spikes: Vec<spikes::SpikeRow>,
}

/// The volumes that schemes are compared on.
const VOLUMES: [&str; 4] = ["heptane", "CT head", "bonsai", "tooth"];

/// # Errors
/// A pixel of a bounded scheme that is off by more than its bound, a scheme that misses what it cannot miss, or one whose picture is of something else.
pub(crate) fn run(
    quick: bool,
    docs: bool,
    data: &Path,
    only: Option<&str>,
    repeat: usize,
) -> Result<VolumeSuite> {
    let entries = if quick { vec![Entry::fixture()] } else { Entry::all(&[], data) };
    let mut suite =
        VolumeSuite { spikes: spikes::count(if quick { 2_000 } else { 100_000 }), ..Default::default() };
    write::print_spikes(&suite.spikes);
    spikes::judge(&suite.spikes)?;
    for entry in Entry::chosen(entries, only, &VOLUMES) {
        for is_shaded in [false, true] {
            let curve = entry.visit(curves::Measure { entry: &entry, is_shaded, quick, repeat })??;
            write::print_curve(&curve);
            curves::judge(&curve)?;
            suite.curves.push(curve);
        }
    }
    if docs {
        write::documentation(&suite)?;
    }
    Ok(suite)
}
