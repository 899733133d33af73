//! Building a series.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result, bail};
use isoray_grid::natural_order;
use isoray_io::Dataset;
use isoray_octree::{AnyVolume, Series, Shape};

use super::record::{Origin, Record};
use super::steps;
use crate::cli::BuildArgs;
use crate::commands::bytes;
use crate::conversion::convert;
use crate::failure::warn;
use crate::load::{is_octree_volume, open_octree_volume};
use crate::output::{check_output, to_stdout};
use crate::progress::Progress;

struct Step {
    input: PathBuf,
    /// Name of the file in the folder.
    name: String,
    /// The file.
    output: PathBuf,
}

/// Builds a volume of each input into the folder that is the output; steps that are finished are verified and kept.
pub(crate) fn build(args: &BuildArgs, inputs: &[PathBuf]) -> Result<()> {
    args.loss.loss()?;
    let folder = &args.output;
    let job = Job { args, steps: named(inputs, folder)?, shape: common_shape(args, inputs)? };
    check_folder(folder, &job.steps)?;
    let is_new = !folder.exists();
    if is_new {
        fs::create_dir(folder).with_context(|| format!("{}: cannot be created", folder.display()))?;
    }
    let result = job.run();
    if is_new && result.is_err() {
        // Succeeds only if no step was finished, and then nothing is to be left.
        let _ = fs::remove_dir(folder);
    }
    result
}

/// The steps in the order of a series.
fn named(inputs: &[PathBuf], folder: &Path) -> Result<Vec<Step>> {
    let step = |input: &PathBuf| {
        let name = format!("{}.ovol", input.file_stem().unwrap_or_default().to_string_lossy());
        Step { input: input.clone(), output: folder.join(&name), name }
    };
    let mut steps: Vec<Step> = inputs.iter().map(step).collect();
    steps.sort_by(|a, b| natural_order(&a.output, &b.output));
    if let Some(hidden) = steps.iter().find(|step| step.name.starts_with('.')) {
        bail!("{}: would become a hidden file, which no series has", hidden.input.display());
    }
    for pair in steps.windows(2) {
        if pair[0].name == pair[1].name {
            let [a, b] = [&pair[0], &pair[1]].map(|step| step.input.display());
            bail!("{b}: would become step {}, as {a} does; expected inputs of different names", pair[1].name);
        }
    }
    Ok(steps)
}

/// Reads every header, and no samples.
fn common_shape(args: &BuildArgs, inputs: &[PathBuf]) -> Result<Shape> {
    let shape = |input: &Path| -> Result<Shape> {
        if is_octree_volume(input, &args.source)? {
            return Ok(Shape::of(&open_octree_volume(input, &args.source)?));
        }
        // What it warns of it will warn of when it is built.
        let dataset = Dataset::open(input, &args.source.options()?)?;
        let (dims, scalar, index_to_world) = (dataset.dims(), dataset.scalar(), dataset.index_to_world());
        Ok(Shape { dims, scalar, index_to_world })
    };
    let (first, rest) = inputs.split_first().context("a series without inputs")?;
    let expected = shape(first)?;
    for input in rest {
        if let Some(difference) = expected.difference(&shape(input)?) {
            bail!("{}: does not fit {}: {difference}", input.display(), first.display());
        }
    }
    Ok(expected)
}

/// Refuses, before any work is done, a folder that cannot be one, and steps that would replace their inputs.
fn check_folder(folder: &Path, steps: &[Step]) -> Result<()> {
    if folder.is_dir() {
        return steps.iter().try_for_each(|step| check_output(&step.output, &[&step.input]));
    }
    if folder.exists() {
        bail!("{}: expected a folder for the steps of a series, found a file", folder.display());
    }
    check_output(folder, &[])
}

struct Job<'a> {
    args: &'a BuildArgs,
    steps: Vec<Step>,
    shape: Shape,
}

impl Job<'_> {
    fn run(&self) -> Result<()> {
        let folder = &self.args.output;
        let mut record = Record::read(folder);
        self.warn_of_strangers();
        let begin = Instant::now();
        let (mut kept, mut total) = (0, 0);
        for (n, step) in self.steps.iter().enumerate() {
            // Before its samples are read: what changes meanwhile is to be noticed the next time.
            let origin = Origin::new(&step.input, self.args)?;
            let head = format!("[{}/{}] {}", n + 1, self.steps.len(), step.name);
            if record.matches(&step.name, &origin) && self.is_sound(step) {
                kept += 1;
                total += fs::metadata(&step.output).map_or(0, |m| m.len());
                to_stdout(|out| writeln!(out, "{head}: kept"))?;
                continue;
            }
            let begin = Instant::now();
            let built = convert(&step.input, &step.output, self.args)?;
            let seconds = begin.elapsed().as_secs_f64();
            record.note(folder, &step.name, origin)?;
            total += built.length;
            let (size, rate) = (of_raw(built.length, built.raw()), self.rate(1, seconds));
            to_stdout(|out| writeln!(out, "{head}: {size}, {seconds:.2} s, {rate}"))?;
        }
        self.tell(kept, total, begin.elapsed().as_secs_f64())
    }

    fn tell(&self, kept: usize, total: u64, seconds: f64) -> Result<()> {
        let (count, Shape { dims, scalar, .. }) = (self.steps.len(), self.shape);
        let raw = (dims.samples() * scalar.size()) as u64 * count as u64;
        let rate = match count - kept {
            0 => String::new(),
            built => format!(", {}", self.rate(built, seconds)),
        };
        to_stdout(|out| {
            let (folder, steps, size) = (self.args.output.display(), steps(count), of_raw(total, raw));
            writeln!(
                out,
                "{folder}: {steps}, {kept} kept, {dims} {scalar} samples, {size}, {seconds:.2} s{rate}"
            )
        })
    }

    fn rate(&self, volumes: usize, seconds: f64) -> String {
        let samples = self.shape.dims.samples() as f64 * volumes as f64;
        format!("{:.1} million voxels/s", samples / seconds / 1e6)
    }

    /// Whether the step's file is there and undamaged.
    fn is_sound(&self, step: &Step) -> bool {
        if !step.output.exists() {
            return false;
        }
        let verified = AnyVolume::open(&step.output).and_then(|volume| {
            let mut bar = Progress::new("checking");
            volume.verify_with_progress(&step.output, &mut |share| bar.update_share(share))?;
            Ok(Shape::of(&volume) == self.shape)
        });
        verified.unwrap_or_else(|e| {
            warn(format!("{e}; it is built again"));
            false
        })
    }

    /// Warns of steps in the folder that are none of this build's.
    fn warn_of_strangers(&self) {
        let folder = &self.args.output;
        let Ok(files) = Series::files_in(folder) else { return };
        for file in files.iter().filter(|file| self.steps.iter().all(|step| step.output != **file)) {
            warn(format!(
                "{}: no input has this name; it is left, and is a step of the series",
                file.display()
            ));
        }
    }
}

fn of_raw(length: u64, raw: u64) -> String {
    format!("{} of {} ({:.1} %)", bytes(length), bytes(raw), 100.0 * length as f64 / raw as f64)
}
