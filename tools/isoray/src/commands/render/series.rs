//! Steps of a series.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Result;
use isoray_octree::{PREFETCH_BUDGET, is_series};
use serde::Serialize;

use super::look::Look;
use super::{Stats, check_data, detail, flags, picture, tell, write_json};
use crate::cli::{RenderArgs, Steps};
use crate::commands::use_threads;
use crate::failure::usage;
use crate::load::{Data, Loaded, warn_about};
use crate::mesh;
use crate::output::to_stdout;
use crate::series::NumberPattern;

/// The statistics of one picture of several.
#[derive(Serialize)]
struct StepStats {
    step: usize,
    #[serde(flatten)]
    stats: Stats,
}

/// The steps: octree volumes, or adaptive meshes.
enum Series {
    Volumes(isoray_octree::Series),
    Meshes(Vec<PathBuf>),
}

impl Series {
    fn open(args: &RenderArgs) -> Result<Self> {
        let path = &args.file;
        if !is_series(path) {
            return Ok(Self::Meshes(mesh::steps(path)?));
        }
        if !args.source.is_empty() {
            let file = path.display();
            return Err(usage(format!("{file}: a series needs no flags that describe an input")));
        }
        Ok(Self::Volumes(isoray_octree::Series::open(path)?))
    }

    fn files(&self) -> &[PathBuf] {
        match self {
            Self::Volumes(series) => series.files(),
            Self::Meshes(files) => files,
        }
    }

    /// For the view of `look`, if there is one already.
    fn load(&self, step: usize, args: &RenderArgs, look: Option<&Look>) -> Result<Loaded> {
        match self {
            Self::Volumes(series) => open(series, step),
            Self::Meshes(files) => detail::load(&files[step], args, look.map(|look| &look.camera)),
        }
    }

    /// Reads a step from the disk so that nobody waits for it later, until what is returned is dropped.
    fn prefetch(&self, step: usize) -> Option<impl Sized> {
        match self {
            Self::Volumes(series) => Some(series.prefetch(step, PREFETCH_BUDGET)),
            Self::Meshes(_) => None,
        }
    }
}

/// Refuses the flags where there is no series.
pub(super) fn refuse(args: &RenderArgs) -> Result<()> {
    let given = [("--step", args.steps.step.is_some()), ("--steps", args.steps.steps.is_some())];
    match given.iter().find(|flag| flag.1) {
        Some((flag, _)) => Err(usage(format!(
            "{flag}: expected a series, a folder ending in .ovol.d or one of plotfiles, found {}",
            args.file.display()
        ))),
        None => Ok(()),
    }
}

/// Renders the steps that the flags name, one after the other.
pub(super) fn run(args: &RenderArgs) -> Result<()> {
    flags::check(args)?;
    let pattern = pattern(args)?;
    let series = Series::open(args)?;
    let steps = chosen(args, series.files().len())?;
    let frames: Vec<_> = steps
        .into_iter()
        .map(|step| (step, pattern.as_ref().map_or_else(|| args.output.clone(), |p| p.path(step))))
        .collect();
    let inputs: Vec<&Path> = series.files().iter().map(PathBuf::as_path).collect();
    let pictures: Vec<&Path> = frames.iter().map(|(_, picture)| picture.as_path()).collect();
    flags::check_outputs(args, &inputs, &pictures)?;
    use_threads(args.threads)?;
    let all = frames_of(args, &series, &frames)?;
    match (&args.stats, &all[..]) {
        (Some(Some(file)), [StepStats { stats, .. }]) if args.steps.steps.is_none() => {
            write_json(file, stats)
        }
        (Some(Some(file)), all) => write_json(file, all),
        (Some(None) | None, _) => Ok(()),
    }
}

/// Of each step and its picture, the statistics. While a step is rendered, the next one is read from the disk.
fn frames_of(args: &RenderArgs, series: &Series, frames: &[(usize, PathBuf)]) -> Result<Vec<StepStats>> {
    let mut look: Option<Look> = None;
    let mut all = Vec::new();
    for (n, (step, output)) in frames.iter().enumerate() {
        let loaded = series.load(*step, args, look.as_ref())?;
        check_data(args, &loaded.volume)?;
        let _next = frames.get(n + 1).map(|(next, _)| series.prefetch(*next));
        let look = match &look {
            Some(look) => look,
            None => look.insert(Look::new(args, &loaded.volume)?),
        };
        let stats = picture(args, &loaded, look, output)?;
        tell(args, output, Some(*step), &stats)?;
        if args.stats == Some(None) {
            to_stdout(|out| stats.print(out))?;
        }
        all.push(StepStats { step: *step, stats });
    }
    Ok(all)
}

fn open(series: &isoray_octree::Series, step: usize) -> Result<Loaded> {
    let begin = Instant::now();
    let volume = series.step(step)?;
    warn_about(&series.files()[step], volume.meta());
    let format = "octree volume".to_owned();
    Ok(Loaded {
        volume: Data::Octree(Box::new(volume)),
        format,
        open_s: begin.elapsed().as_secs_f64(),
        build_s: 0.0,
    })
}

/// Where in the names of pictures the number of the step is, which several need.
fn pattern(args: &RenderArgs) -> Result<Option<NumberPattern>> {
    let pattern = NumberPattern::parse(&args.output);
    if args.steps.steps.is_some() && pattern.is_none() {
        return Err(usage(format!(
            "--output {}: expected a name with a place for the number of the step, like frame_%04d.png",
            args.output.display()
        )));
    }
    Ok(pattern)
}

/// The steps that the flags name, of `count`; the only one, if there is only one.
fn chosen(args: &RenderArgs, count: usize) -> Result<Vec<usize>> {
    let last = count - 1;
    let beyond = |flag: &str, found: usize| {
        let file = args.file.display();
        Err(usage(format!("{flag}: expected steps from 0 to {last}, the last in {file}, found {found}")))
    };
    match (args.steps.step, args.steps.steps) {
        (Some(step), _) if step > last => beyond("--step", step),
        (Some(step), _) => Ok(vec![step]),
        (None, Some(Steps { first, .. })) if first > last => beyond("--steps", first),
        (None, Some(Steps { last: Some(end), .. })) if end > last => beyond("--steps", end),
        (None, Some(Steps { first, last: end, stride })) => {
            Ok((first..=end.unwrap_or(last)).step_by(stride).collect())
        }
        (None, None) if count == 1 => Ok(vec![0]),
        (None, None) => Err(usage(format!(
            "{}: a series of {count} steps: expected --step N, from 0 to {last}, or --steps A:B -o frame_%04d.png",
            args.file.display()
        ))),
    }
}
