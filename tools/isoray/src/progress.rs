//! Progress bars, for what takes longer than a second and only on a terminal.

use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// How long something may take without a bar.
const PATIENCE: Duration = Duration::from_secs(1);

/// A bar that shows itself once [`PATIENCE`] is over; never when stderr is not a terminal.
pub(crate) struct Progress {
    what: &'static str,
    begin: Instant,
    bar: Option<ProgressBar>,
}

impl Progress {
    pub(crate) fn new(what: &'static str) -> Self {
        Self { what, begin: Instant::now(), bar: None }
    }

    /// `done` of `total` are done.
    pub(crate) fn update(&mut self, done: u64, total: u64) {
        if self.bar.is_none() && self.begin.elapsed() > PATIENCE {
            let bar = ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::stderr());
            let style = ProgressStyle::with_template("{msg} [{bar:40}] {percent}% {elapsed}, {eta} left");
            if let Ok(style) = style {
                bar.set_style(style.progress_chars("=> "));
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
