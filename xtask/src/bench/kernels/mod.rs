//! Short pieces of work, one for each part of the renderer: what two builds are compared by.
//!
//! Each is some ten milliseconds of one thread, and tells what it found, so that a build that is fast because it is wrong is noticed.

mod list;

use anyhow::{Context, Result, ensure};
use isoray_grid::Scalar;
use serde::{Deserialize, Serialize};

use super::timer::{interleave_all, median, quantile};
use crate::catalog::{Dense, DenseVisitor, Entry};
use list::Answer;

/// One kernel, on one thread.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct KernelRow {
    pub(crate) kernel: String,
    /// The median.
    pub(crate) ms: f64,
    /// Over that of [`REFERENCE`], which is no part of the renderer and stays as it is: another machine changes it least.
    pub(crate) times_reference: f64,
    /// Half the distance of the quartiles, as a share of the median.
    pub(crate) spread: f64,
    /// How much was found, and a sum over it.
    pub(crate) answer: Answer,
}

/// The kernel that others are related to, by its name in all builds.
pub(crate) const REFERENCE: &str = "reference";

/// Titles of the columns.
const HEADER: &str =
    "\nKernels, one thread: by these two builds are compared (--save-baseline, --baseline). Reference: the recursion of Knoll 2006 on its own nodes.
kernel                                 ms  × reference  spread % | found, and a sum over it";

pub(crate) fn run(repeat: usize) -> Result<Vec<KernelRow>> {
    println!("{HEADER}");
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().context("cannot start a thread")?;
    let rows = one.install(|| Entry::fixture().visit(Kernels { repeat }))??;
    for KernelRow { kernel, ms, times_reference, spread, answer: [count, sum] } in &rows {
        println!(
            "{kernel:<32} {ms:>8.2} {times_reference:>12.3} {:>9.1} | {count:>8} {sum:.8e}",
            100.0 * spread
        );
    }
    Ok(rows)
}

/// All of them, on the bundled volume and a generated mesh.
struct Kernels {
    repeat: usize,
}

impl DenseVisitor for Kernels {
    type Output = Result<Vec<KernelRow>>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        let data = list::Data::new(volume)?;
        let mut kernels = data.kernels()?;
        let names: Vec<&str> = kernels.iter().map(|kernel| kernel.name).collect();
        let mut answers: Vec<Option<Answer>> = vec![None; kernels.len()];
        let mut runs: Vec<_> = kernels
            .iter_mut()
            .zip(&mut answers)
            .map(|(kernel, answer)| move || *answer = Some((kernel.run)()))
            .collect();
        let mut variants: Vec<&mut dyn FnMut()> = runs.iter_mut().map(|run| run as _).collect();
        let times = interleave_all(self.repeat, &mut variants);
        drop(runs);
        let reference = names.iter().position(|&name| name == REFERENCE);
        let reference =
            reference.with_context(|| format!("expected a kernel named {REFERENCE}, found {names:?}"))?;
        let reference = median(times[reference].clone());
        let row = |((name, times), answer): ((&str, Vec<f64>), Option<Answer>)| {
            let quartiles = [0.25, 0.75].map(|share| quantile(times.clone(), share));
            let seconds = median(times);
            let answer = answer.with_context(|| format!("{name}: did not run"))?;
            ensure!(answer[0] > 0.0 && answer[1].is_finite(), "{name}: found nothing");
            Ok(KernelRow {
                kernel: name.to_owned(),
                ms: 1e3 * seconds,
                times_reference: seconds / reference,
                spread: 0.5 * (quartiles[1] - quartiles[0]) / seconds,
                answer,
            })
        };
        names.into_iter().zip(times).zip(answers).map(row).collect()
    }
}
