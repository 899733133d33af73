//! Comparison with an earlier build: by pairs of runs in turn where its program is at hand, else by what was stored.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail, ensure};
use serde::{Deserialize, Serialize};

use super::kernels::{KernelRow, REFERENCE};
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
        let Compared { rows, alone } = match &self.program {
            Some(program) => by_pairs(program, PAIRS[usize::from(quick)])?,
            None => self.by_stored_times(now)?,
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
        for (names, whose) in alone.iter().zip(["this build", "the baseline"]) {
            if !names.is_empty() {
                println!("Not compared, since {whose} alone has them: {}.", names.join("; "));
            }
        }
        Ok(rows)
    }

    /// Over the reference's, which each side has its own time of.
    fn by_stored_times(&self, now: &[KernelRow]) -> Result<Compared> {
        let Paired { both, alone } = Paired::new(now, &self.kernels)?;
        let [of_now, of_then] = [reference(now, "this build")?, reference(&self.kernels, "the baseline")?];
        let compared = |[now, then]: [&KernelRow; 2]| {
            let spreads = [now.spread, then.spread, of_now.spread, of_then.spread];
            let noise = spreads.iter().map(|s| s * s).sum::<f64>().sqrt();
            let ratio = (now.ms / of_now.ms) / (then.ms / of_then.ms);
            row(&now.kernel, ratio, noise, 0, answers_agree(now, then))
        };
        Ok(Compared { rows: both.into_iter().map(compared).collect(), alone })
    }
}

/// What came of a comparison.
#[derive(Debug)]
struct Compared {
    rows: Vec<ComparisonRow>,
    /// Kernels that only one side has: this build, and the baseline.
    alone: [Vec<String>; 2],
}

/// The kernels of two builds by their names, which are all that says what is the same.
#[derive(Debug)]
struct Paired<'r> {
    /// Now and then.
    both: Vec<[&'r KernelRow; 2]>,
    /// As in [`Compared`].
    alone: [Vec<String>; 2],
}

impl<'r> Paired<'r> {
    /// # Errors
    /// None but the reference is in both: nothing of the renderer would be compared, and nothing found to be worse.
    fn new(now: &'r [KernelRow], then: &'r [KernelRow]) -> Result<Self> {
        let both: Vec<_> = now.iter().filter_map(|row| Some([row, find(then, &row.kernel)?])).collect();
        let alone = [alone(now, then), alone(then, now)];
        ensure!(
            both.iter().any(|[row, _]| row.kernel != REFERENCE),
            "expected kernels of both builds, found none; this build alone has {}; the baseline alone {}",
            alone[0].join(", "),
            alone[1].join(", ")
        );
        Ok(Self { both, alone })
    }
}

/// Names of the kernels that others lack.
fn alone(rows: &[KernelRow], others: &[KernelRow]) -> Vec<String> {
    let names = rows.iter().map(|row| &row.kernel);
    names.filter(|name| find(others, name).is_none()).cloned().collect()
}

/// The kernel that times are related to.
fn reference<'r>(rows: &'r [KernelRow], whose: &str) -> Result<&'r KernelRow> {
    find(rows, REFERENCE).with_context(|| {
        let names: Vec<&str> = rows.iter().map(|row| row.kernel.as_str()).collect();
        format!("expected a kernel named {REFERENCE} in {whose}, found {}", names.join(", "))
    })
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
fn by_pairs(program: &Path, pairs: usize) -> Result<Compared> {
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
    let [then, now] = runs.first().context("no pairs")?;
    let Paired { both, alone } = Paired::new(now, then)?;
    let rows = both.into_iter().map(|[now, then]| {
        let ratios = runs.iter().filter_map(|[then, now_]| {
            Some((find(now_, &now.kernel)?.ms / find(then, &now.kernel)?.ms).ln())
        });
        let (center, error) = median_and_error(ratios.collect());
        row(&now.kernel, center.exp(), error, pairs, answers_agree(now, then))
    });
    Ok(Compared { rows: rows.collect(), alone })
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

    /// Of another name.
    fn named(kernel: &str, row: KernelRow) -> KernelRow {
        KernelRow { kernel: kernel.to_owned(), ..row }
    }

    fn stored(kernels: Vec<KernelRow>) -> Baseline {
        Baseline { path: PathBuf::new(), kernels, program: None }
    }

    fn verdict(now: KernelRow, then: KernelRow) -> Verdict {
        let with_reference = |row| vec![named(REFERENCE, kernel(1.0, 5.0)), row];
        let baseline = stored(with_reference(then));
        baseline.by_stored_times(&with_reference(now)).unwrap().rows[1].verdict
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
    fn the_reference_is_found_by_its_name() {
        // Last, on a machine that is half as fast.
        let rows = |ms: [f64; 2], spread: f64| {
            let reference = KernelRow { spread, ..named(REFERENCE, kernel(ms[1], 5.0)) };
            vec![kernel(ms[0], 5.0), reference]
        };
        let verdict_of = |spread: f64| {
            let compared = stored(rows([1.0, 1.0], 0.01)).by_stored_times(&rows([2.6, 2.0], spread)).unwrap();
            assert!((compared.rows[0].ratio - 1.3).abs() < 1e-12, "{compared:?}");
            compared.rows[0].verdict
        };
        assert_eq!(verdict_of(0.01), Verdict::Slower);
        // Its noise is that of all.
        assert_eq!(verdict_of(0.2), Verdict::Same);
        let without = stored(vec![kernel(1.0, 5.0)]).by_stored_times(&rows([1.0, 1.0], 0.01));
        let error = without.unwrap_err().to_string();
        assert!(error.contains("named reference in the baseline, found rays"), "{error}");
    }

    #[test]
    fn kernels_that_one_build_has_alone_are_listed_and_are_not_all() {
        let list = |names: &[&str]| -> Vec<KernelRow> {
            names.iter().map(|name| named(name, kernel(1.0, 5.0))).collect()
        };
        let now = list(&[REFERENCE, "rays", "new"]);
        let then = list(&[REFERENCE, "gone", "rays"]);
        let paired = Paired::new(&now, &then).unwrap();
        assert_eq!(paired.alone, [vec!["new".to_owned()], vec!["gone".to_owned()]]);
        let names = paired.both.iter().map(|pair| pair.map(|row| row.kernel.as_str()));
        assert!(names.eq([[REFERENCE; 2], ["rays"; 2]]));
        let error = Paired::new(&now, &list(&[REFERENCE, "gone"])).unwrap_err().to_string();
        assert!(error.contains("this build alone has rays, new; the baseline alone gone"), "{error}");
        assert!(Paired::new(&now, &[]).is_err());
        assert!(stored(list(&["gone"])).by_stored_times(&now).is_err());
    }

    #[test]
    fn the_error_of_a_median_falls_with_the_root_of_their_number() {
        let values = |n: usize| (0..n).map(|n| (n % 5) as f64).collect::<Vec<_>>();
        let [few, many] = [25, 2500].map(|n| median_and_error(values(n)));
        assert_eq!([few.0, many.0], [2.0, 2.0]);
        assert!((few.1 / many.1 - 10.0).abs() < 1e-9);
    }
}
