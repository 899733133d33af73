//! Rays through whole volumes: no change of side between consecutive cells without a hit.

use std::ops::{ControlFlow, Range};
use std::path::PathBuf;

use anyhow::{Result, bail};
use isoray_cell::Cubic;
use isoray_grid::Scalar;
use isoray_octree::lod::{Detail, DetailRequest, DetailView, DistanceMeasure, PixelWidth};
use isoray_octree::{Coarse, OctreeVolume};
use isoray_oracle::{OracleRay, RayKind, SplitMix64, adversarial_ray};
use isoray_trace::{Candidate, DetailTracer, Hit, HitPolicy, Ray, Trace, Tracer};
use serde::{Deserialize, Serialize};

use super::shard;
use crate::catalog::{Dense, DenseVisitor, Entry, data_folder};

/// Flags of `cargo xtask stress traverse`.
#[derive(Debug, clap::Args)]
#[group(skip)]
pub(crate) struct Args {
    #[command(flatten)]
    shard: shard::Args,
    /// Folder of real volumes; those that are there are traversed [default: ../shared/data, if there is one]
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// At levels of detail, from another eye and with other pixels for every hundred rays, half of which come from that eye
    #[arg(long)]
    lod: bool,
    /// Only volumes whose name contains this
    #[arg(long)]
    only: Option<String>,
}

/// The rays aimed where comparisons tie.
const AIMED: [RayKind; 5] = [
    RayKind::ThroughVertex,
    RayKind::ThroughEdge,
    RayKind::AlongEdges,
    RayKind::Diagonal,
    RayKind::FromVertex,
];

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct Tally {
    rays: u64,
    aimed: u64,
    /// Cells that can hold surface.
    cells: u64,
    crossings: u64,
    /// Crossings at a face between levels of detail.
    jumps: u64,
    slips: u64,
    offending: shard::Offending,
}

impl shard::Tally for Tally {
    fn merge(&mut self, other: Self) {
        self.rays += other.rays;
        self.aimed += other.aimed;
        self.cells += other.cells;
        self.crossings += other.crossings;
        self.jumps += other.jumps;
        self.slips += other.slips;
        self.offending.merge(other.offending);
    }
}

/// Follows the side that the ray is on. Between two cells that can hold surface all are on one side, as are the faces to them.
#[derive(Default)]
pub(super) struct Sides {
    is_inside: Option<bool>,
    pub(super) cells: u64,
    pub(super) crossings: u64,
    pub(super) jumps: u64,
    pub(super) slips: u64,
}

impl HitPolicy for Sides {
    fn candidate(&mut self, candidate: &Candidate) -> ControlFlow<()> {
        let cubic = Cubic::along(&candidate.corners, &candidate.segment);
        let [begins, ends] = [cubic.starts_inside(), cubic.ends_inside()];
        let roots = cubic.roots();
        let passed_unseen = self.is_inside.is_some_and(|before| before != begins);
        let crossed_unseen = (roots.len() % 2 == 1) != (begins != ends);
        let first_differs = roots.first().copied() != cubic.first_root().get();
        self.slips += u64::from(passed_unseen) + u64::from(crossed_unseen) + u64::from(first_differs);
        self.cells += 1;
        self.crossings += roots.len() as u64;
        self.is_inside = Some(ends);
        ControlFlow::Continue(())
    }

    fn jump(&mut self, hit: &Hit) -> ControlFlow<()> {
        self.slips += u64::from(self.is_inside == Some(hit.is_entering));
        self.jumps += 1;
        self.is_inside = Some(hit.is_entering);
        ControlFlow::Continue(())
    }
}

pub(crate) fn run(args: &Args) -> Result<()> {
    let data = data_folder(args.data.as_deref())?;
    Entry::tell_missing(&data);
    let entries = Entry::all(&[Entry::turbulence(256)], &data);
    let entries = Entry::named_like(entries, args.only.as_deref())?;
    let surfaces: usize = entries.iter().map(|e| e.isovalues.len()).sum();
    let shard = shard::Args { count: args.shard.count.div_ceil(surfaces as u64), ..args.shard.clone() };
    let mut total = Tally::default();
    for entry in &entries {
        let tally = entry.visit(Volume { entry, shard: &shard, is_lod: args.lod })??;
        shard::Tally::merge(&mut total, tally);
    }
    println!("{}", row("all", &total));
    match total.slips {
        0 => Ok(()),
        n => bail!("{n} changes of side without a hit; offending inputs:\n{}", total.offending),
    }
}

fn row(name: &str, tally: &Tally) -> String {
    let Tally { rays, aimed, cells, crossings, jumps, slips, .. } = tally;
    let at_faces = if *jumps > 0 { format!(", {jumps} of levels alone") } else { String::new() };
    format!(
        "{name:<28} {rays:>11} rays, {aimed:>10} aimed at edges and vertices, {cells:>12} cells, {crossings:>11} crossings{at_faces}: {slips} slips"
    )
}

struct Volume<'a> {
    entry: &'a Entry,
    shard: &'a shard::Args,
    is_lod: bool,
}

/// Rays that are traced with one eye.
const PER_EYE: u64 = 100;

impl Tally {
    fn trace(&mut self, tracer: &mut impl Trace, (n, ray): (u64, Ray), isovalue: f32, name: &str) {
        let mut sides = Sides::default();
        tracer.trace(&ray, isovalue, &mut sides, &mut ());
        self.rays += 1;
        self.aimed += n & 1;
        self.cells += sides.cells;
        self.crossings += sides.crossings;
        self.jumps += sides.jumps;
        self.slips += sides.slips;
        if sides.slips > 0 {
            self.offending.keep(name, &ray);
        }
    }
}

/// Levels of detail as they may be for a picture: mostly several, some of them next to much coarser ones.
fn detail<T: Scalar>(volume: &Dense<T>, n: u64) -> Detail {
    let mut random = SplitMix64::new(!n);
    let eye: [f64; 3] = volume.dims.axes().map(|n| random.range(-1.0, 2.0) * f64::from(n));
    let eye = volume.index_to_world.transform_point3(eye.into());
    let measure = match random.below(3) {
        0 => DistanceMeasure::Slices([(); 3].map(|()| random.range(-1.0, 1.0)).into()),
        _ => DistanceMeasure::True,
    };
    let request = DetailRequest {
        pixel: PixelWidth::PerDistance(1.0, eye),
        ratio: random.range(-8.0, 0.0).exp2(),
        measure,
        blend: if random.coin() { 0.0 } else { random.unit() },
    };
    Detail::new(volume.dims, &volume.index_to_world, &request)
}

impl DenseVisitor for Volume<'_> {
    type Output = Result<Tally>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        let octree = volume.octree()?;
        let mut total = Tally::default();
        for &isovalue in &self.entry.isovalues {
            let name = format!("{} at {isovalue}", self.entry.name);
            let shots = Shots { volume, octree: &octree, isovalue, name: &name, seed: self.shard.seed };
            let kind = if self.is_lod { "traverse lod" } else { "traverse" };
            let tally =
                self.shard.run(&format!("{kind} {name}"), |inputs| shots.block(inputs, self.is_lod))?;
            println!("{}", row(&name, &tally));
            shard::Tally::merge(&mut total, tally);
        }
        Ok(total)
    }
}

/// The rays that are sent to one isosurface.
struct Shots<'a, T: Scalar> {
    volume: &'a Dense<T>,
    octree: &'a OctreeVolume<T>,
    isovalue: f32,
    name: &'a str,
    seed: u64,
}

impl<T: Scalar> Shots<'_, T> {
    fn block(&self, inputs: Range<u64>, is_lod: bool) -> Tally {
        let &Self { isovalue, name, seed, .. } = self;
        let mut tally = Tally::default();
        let view = self.octree.view();
        let ray = |n| (n, input(self.volume.dims.axes(), seed << 40 | n));
        if !is_lod {
            let mut tracer = Tracer::new(&view);
            inputs.map(ray).for_each(|ray| tally.trace(&mut tracer, ray, isovalue, name));
            return tally;
        }
        for some in inputs.clone().step_by(PER_EYE as usize) {
            let detail = detail(self.volume, seed << 40 | some);
            let view = DetailView::new(&view, Coarse::default(), detail);
            let mut tracer = DetailTracer::new(&view);
            let origin = view.detail().eye().map(|c| c as f32);
            for (n, ray) in (some..inputs.end.min(some + PER_EYE)).map(ray) {
                let ray = if n & 2 == 0 { ray } else { Ray { origin, t_min: 0.0, ..ray } };
                tally.trace(&mut tracer, (n, ray), isovalue, name);
            }
        }
        tally
    }
}

/// As [`run`], a few rays to the surfaces of one volume.
pub(super) fn few(entry: &Entry, count: u64, seed: u64, is_lod: bool) -> Result<shard::Outcome> {
    entry.visit(Few { entry, count, seed, is_lod })?
}

struct Few<'a> {
    entry: &'a Entry,
    count: u64,
    seed: u64,
    is_lod: bool,
}

impl DenseVisitor for Few<'_> {
    type Output = Result<shard::Outcome>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        let octree = volume.octree()?;
        let mut total = Tally::default();
        let surfaces = self.entry.isovalues.len() as u64;
        for &isovalue in &self.entry.isovalues {
            let shots = Shots { volume, octree: &octree, isovalue, name: &self.entry.name, seed: self.seed };
            let count = self.count.div_ceil(surfaces);
            let tally = shard::few(count, 40 * PER_EYE, |inputs| shots.block(inputs, self.is_lod));
            shard::Tally::merge(&mut total, tally);
        }
        Ok(shard::Outcome {
            cases: total.rays,
            doubtful: None,
            failures: total.slips,
            offending: total.offending,
        })
    }
}

/// Every other ray is aimed at edges and vertices.
fn input(dims: [u32; 3], n: u64) -> Ray {
    let seed = SplitMix64::new(n).next_u64();
    let OracleRay { origin, direction, t_min, t_max } = match n & 1 {
        1 => AIMED[(n / 2 % AIMED.len() as u64) as usize].generate(dims, seed),
        _ => adversarial_ray(dims, seed),
    };
    Ray { origin, direction, t_min, t_max }
}
