//! Progress bars, for what takes longer than a second and only on a terminal.

use std::fmt;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

/// How long something may take without a bar.
const PATIENCE: Duration = Duration::from_secs(1);

/// A bar that shows itself once [`PATIENCE`] is over; never when stderr is not a terminal.
pub(crate) struct Progress {
    what: &'static str,
    template: &'static str,
    begin: Instant,
    bar: Option<ProgressBar>,
}

impl Progress {
    pub(crate) fn new(what: &'static str) -> Self {
        Self::with_template(what, "{msg} [{bar:40}] {percent}% {elapsed}, {eta} left")
    }

    /// A bar that counts voxels and tells how many there are a second.
    pub(crate) fn of_voxels(what: &'static str) -> Self {
        Self::with_template(what, "{msg} [{bar:40}] {percent}% {rate} {elapsed}, {eta} left")
    }

    fn with_template(what: &'static str, template: &'static str) -> Self {
        Self { what, template, begin: Instant::now(), bar: None }
    }

    /// `done` of `total` are done.
    pub(crate) fn update(&mut self, done: u64, total: u64) {
        if self.bar.is_none() && self.begin.elapsed() > PATIENCE {
            let bar = ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::stderr());
            if let Ok(style) = ProgressStyle::with_template(self.template) {
                let rate = |state: &ProgressState, out: &mut dyn fmt::Write| {
                    // A bar that cannot be written is no reason to stop.
                    let _ = write!(out, "{:.0} million voxels/s", state.per_sec() / 1e6);
                };
                bar.set_style(style.with_key("rate", rate).progress_chars("=> "));
            }
            bar.set_message(self.what);
            self.bar = Some(bar);
        }
        if let Some(bar) = &self.bar {
            bar.set_position(done);
        }
    }
}

impl Progress {
    /// A share of all is done, 1 being the end.
    pub(crate) fn update_share(&mut self, share: f64) {
        /// Steps of the bar: finer than anyone sees.
        const STEPS: f64 = 1000.0;
        self.update((share * STEPS) as u64, STEPS as u64);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
