//! Verifying a series.

use std::path::Path;
use std::time::Instant;

use anyhow::{Result, bail};
use isoray_octree::Series;

use super::steps;
use crate::output::to_stdout;
use crate::progress::Progress;

/// Verifies every step completely; prints a line for each, and fails if one of them is damaged or does not fit.
pub(crate) fn check(path: &Path) -> Result<()> {
    let begin = Instant::now();
    let series = Series::open(path)?;
    let mut damaged = Vec::new();
    for (n, file) in series.files().iter().enumerate() {
        let verified = series.step(n).and_then(|volume| {
            let mut bar = Progress::new("checking");
            Ok(volume.verify_with_progress(file, &mut |share| bar.update_share(share))?)
        });
        let name = series.name(n);
        match verified {
            Ok(()) => to_stdout(|out| writeln!(out, "step {n}: {name}: sound"))?,
            Err(e) => {
                to_stdout(|out| writeln!(out, "step {n}: {name}: NOT sound"))?;
                damaged.push(e);
            }
        }
    }
    let all = steps(series.len());
    if let Some(first) = damaged.first() {
        let which = if damaged.len() == 1 { "" } else { ", the first" };
        bail!("{}: {} of {all} not sound{which}: {first}", path.display(), damaged.len());
    }
    let shape = series.shape();
    to_stdout(|out| {
        writeln!(
            out,
            "{}: sound: {all} of {} {} samples, every checksum and node verified in {:.2} s",
            path.display(),
            shape.dims,
            shape.scalar,
            begin.elapsed().as_secs_f64()
        )
    })
}
