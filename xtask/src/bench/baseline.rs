//! Comparison with an earlier build: by pairs of runs in turn where its program is at hand, else by what was stored.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail, ensure};
use serde::{Deserialize, Serialize};

use super::kernels::KernelRow;
use super::timer::median;

/// An earlier run.
pub(crate) struct Baseline {
    path: PathBuf,
    kernels: Vec<KernelRow>,
    /// The program that made it.
    program: Option<PathBuf>,
}

/// One kernel, now and then.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct ComparisonRow {
    pub(crate) kernel: String,
    /// Time now over that of the baseline.
    pub(crate) ratio: f64,
    /// Its standard error, as a share of it.
    pub(crate) noise: f64,
    /// Pairs of runs; 0 where stored times were compared.
    pub(crate) pairs: usize,
    pub(crate) verdict: Verdict,
}

/// What a comparison says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Verdict {
    /// No change beyond the noise.
    Same,
    /// Less time.
    Faster,
    /// More.
    Slower,
    /// It finds something else: its time says nothing.
    DifferentAnswer,
}

/// The members of a report that a comparison needs.
#[derive(Deserialize)]
struct Stored {
    kernels: Vec<KernelRow>,
}

/// Beside a stored report.
const PROGRAM: &str = "xtask";
/// Repetitions of every kernel in each run of a pair.
const REPEAT: &str = "5";
/// Pairs of runs, and in a short comparison.
const PAIRS: [usize; 2] = [15, 7];
/// A change is one beyond so many standard errors, which one in 700 is by chance if noise is normal;
const ERRORS: f64 = 3.2;
/// and beyond this share: the same sources built twice differ by up to so much, by where code and data come to lie.
const LEAST: f64 = 0.03;
/// Answers that differ by more than this share are not the same: sums of thousands of values in single precision.
const SAME_ANSWER: f64 = 1e-6;

impl Baseline {
    /// # Errors
    /// A file that is no report, or one without kernels.
    pub(crate) fn open(path: &Path) -> Result<Self> {
        let text =
            fs::read(path).with_context(|| format!("--baseline {}: cannot be read", path.display()))?;
        let expected =
            || format!("--baseline {}: expected a report with kernels, of `--save-baseline`", path.display());
        let Stored { kernels } = serde_json::from_slice(&text).with_context(expected)?;
        ensure!(!kernels.is_empty(), "{}; found none", expected());
        let program = path.with_file_name(PROGRAM);
        let program = program.is_file().then_some(program);
        Ok(Self { path: path.to_owned(), kernels, program })
    }

    /// Compares `now` with it.
    pub(crate) fn compare(&self, now: &[KernelRow], quick: bool) -> Result<Vec<ComparisonRow>> {
        let rows = match &self.program {
            Some(program) => by_pairs(program, PAIRS[usize::from(quick)])?,
            None => self.by_stored_times(now),
        };
        let how = match self.program {
            Some(_) => "in turn with its program",
            None => "with the times stored there, over the reference's: its program is not beside it",
        };
        println!("\nCompared with {}, {how}.", self.path.display());
        println!("{:<32} {:>14} {:>8} {:>6}", "kernel", "time now/then", "± %", "pairs");
        for ComparisonRow { kernel, ratio, noise, pairs, verdict } in &rows {
            let marked = verdict.name();
            println!("{kernel:<32} {ratio:>14.3} {:>8.1} {pairs:>6}  {marked}", 100.0 * noise);
        }
        Ok(rows)
    }

    fn by_stored_times(&self, now: &[KernelRow]) -> Vec<ComparisonRow> {
        let pairs = now.iter().filter_map(|now| Some((now, find(&self.kernels, &now.kernel)?)));
        let reference = |rows: &[KernelRow]| rows.first().map_or(0.0, |row| row.spread);
        let references = [reference(now), reference(&self.kernels)];
        pairs
            .map(|(now, then)| {
                let [a, b] = references;
                let noise = [now.spread, then.spread, a, b].iter().map(|s| s * s).sum::<f64>().sqrt();
                let ratio = now.times_reference / then.times_reference;
                row(&now.kernel, ratio, noise, 0, answers_agree(now, then))
            })
            .collect()
    }
}

/// Keeps a report and this program.
pub(crate) fn save(report: &Path, folder: &Path) -> Result<()> {
    fs::create_dir_all(folder).with_context(|| format!("{}: cannot be made", folder.display()))?;
    let program = std::env::current_exe().context("cannot tell where this program is")?;
    for (from, to) in [(report, folder.join("report.json")), (program.as_path(), folder.join(PROGRAM))] {
        // A program that runs cannot be written over, but be replaced.
        let _ = fs::remove_file(&to);
        fs::copy(from, &to).with_context(|| format!("{}: cannot be written", to.display()))?;
    }
    println!("kept: {}", folder.join("report.json").display());
    Ok(())
}

/// An error that names what is slower, or finds something else.
pub(crate) fn judge(rows: &[ComparisonRow]) -> Result<()> {
    let is_bad = |row: &&ComparisonRow| matches!(row.verdict, Verdict::Slower | Verdict::DifferentAnswer);
    let bad: Vec<String> = rows
        .iter()
        .filter(is_bad)
        .map(|row| format!("{}: {}, {:.3} times the time", row.kernel, row.verdict.name(), row.ratio))
        .collect();
    match bad.len() {
        0 => Ok(()),
        n => bail!("{n} kernels are worse than the baseline:\n  {}", bad.join("\n  ")),
    }
}

impl Verdict {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Same => "",
            Self::Faster => "faster",
            Self::Slower => "SLOWER",
            Self::DifferentAnswer => "ANOTHER ANSWER",
        }
    }
}

fn find<'r>(rows: &'r [KernelRow], kernel: &str) -> Option<&'r KernelRow> {
    rows.iter().find(|row| row.kernel == kernel)
}

fn answers_agree(a: &KernelRow, b: &KernelRow) -> bool {
    let agree = |(a, b): (f64, f64)| (a - b).abs() <= SAME_ANSWER * a.abs().max(b.abs());
    a.answer.into_iter().zip(b.answer).all(agree)
}

/// Both programs in turn, each first as often as the other.
fn by_pairs(program: &Path, pairs: usize) -> Result<Vec<ComparisonRow>> {
    let this = std::env::current_exe().context("cannot tell where this program is")?;
    let folder = tempfile::tempdir()?;
    let run = |program: &Path| kernels_of(program, &folder.path().join("kernels.json"));
    let mut runs = Vec::new();
    for n in 0..pairs {
        let pair = match n % 2 {
            0 => [run(program)?, run(&this)?],
            _ => {
                let now = run(&this)?;
                [run(program)?, now]
            }
        };
        runs.push(pair);
    }
    let first = runs.first().context("no pairs")?;
    let compared = first[1].iter().filter_map(|now| Some((now, find(&first[0], &now.kernel)?)));
    let rows = compared.map(|(now, then)| {
        let ratios = runs.iter().filter_map(|[then, now_]| {
            Some((find(now_, &now.kernel)?.ms / find(then, &now.kernel)?.ms).ln())
        });
        let (center, error) = median_and_error(ratios.collect());
        row(&now.kernel, center.exp(), error, pairs, answers_agree(now, then))
    });
    Ok(rows.collect())
}

fn row(kernel: &str, ratio: f64, noise: f64, pairs: usize, agrees: bool) -> ComparisonRow {
    let change = ratio.ln();
    let verdict = match change {
        _ if !agrees => Verdict::DifferentAnswer,
        c if c.abs() <= f64::max(ERRORS * noise, LEAST) => Verdict::Same,
        c if c > 0.0 => Verdict::Slower,
        _ => Verdict::Faster,
    };
    ComparisonRow { kernel: kernel.to_owned(), ratio, noise, pairs, verdict }
}

/// The median, and its standard error: that of the median of normal values is √(π/2) times that of their mean, and their standard deviation 1.4826 times the median distance from it.
fn median_and_error(values: Vec<f64>) -> (f64, f64) {
    let center = median(values.clone());
    let deviation = 1.4826 * median(values.iter().map(|value| (value - center).abs()).collect());
    (center, (std::f64::consts::FRAC_PI_2 / values.len() as f64).sqrt() * deviation)
}

fn kernels_of(program: &Path, json: &Path) -> Result<Vec<KernelRow>> {
    let mut command = Command::new(program);
    command.args(["bench", "kernels", "--repeat", REPEAT, "--json"]).arg(json).stdout(Stdio::null());
    let status = command.status().with_context(|| format!("{}: cannot be run", program.display()))?;
    ensure!(status.success(), "{} bench kernels: failed ({status})", program.display());
    let Stored { kernels } = serde_json::from_slice(&fs::read(json)?)
        .with_context(|| format!("{} bench kernels: no report of kernels", program.display()))?;
    Ok(kernels)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kernel(times_reference: f64, sum: f64) -> KernelRow {
        let (ms, spread, answer) = (times_reference, 0.01, [100.0, sum]);
        KernelRow { kernel: "rays".to_owned(), ms, times_reference, spread, answer }
    }

    fn verdict(now: KernelRow, then: KernelRow) -> Verdict {
        let baseline = Baseline { path: PathBuf::new(), kernels: vec![then], program: None };
        baseline.by_stored_times(&[now])[0].verdict
    }

    #[test]
    fn changes_beyond_the_noise_are_told() {
        assert_eq!(verdict(kernel(1.02, 5.0), kernel(1.0, 5.0)), Verdict::Same);
        assert_eq!(verdict(kernel(1.2, 5.0), kernel(1.0, 5.0)), Verdict::Slower);
        assert_eq!(verdict(kernel(0.8, 5.0), kernel(1.0, 5.0)), Verdict::Faster);
    }

    #[test]
    fn another_answer_is_told_however_fast() {
        assert_eq!(verdict(kernel(0.5, 5.001), kernel(1.0, 5.0)), Verdict::DifferentAnswer);
        let rows = [row("rays", 0.5, 0.01, 15, false)];
        assert!(judge(&rows).unwrap_err().to_string().contains("rays: ANOTHER ANSWER"));
    }

    #[test]
    fn the_error_of_a_median_falls_with_the_root_of_their_number() {
        let values = |n: usize| (0..n).map(|n| (n % 5) as f64).collect::<Vec<_>>();
        let [few, many] = [25, 2500].map(|n| median_and_error(values(n)));
        assert_eq!([few.0, many.0], [2.0, 2.0]);
        assert!((few.1 / many.1 - 10.0).abs() < 1e-9);
    }
}
