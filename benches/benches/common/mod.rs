//! What the benchmarks of kernels have in common.

use std::time::Duration;

use criterion::Criterion;

/// Two and a half seconds for each kernel: these are small, and a file of them takes less than half a minute.
pub(crate) fn config() -> Criterion {
    Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(2))
}
