//! Rays through whole volumes: no change of side between consecutive cells without a hit.

use std::ops::ControlFlow;
use std::path::PathBuf;

use anyhow::{Result, bail};
use isoray_cell::Cubic;
use isoray_grid::Scalar;
use isoray_oracle::{OracleRay, RayKind, SplitMix64, adversarial_ray};
use isoray_trace::{Candidate, HitPolicy, Ray, Tracer};
use serde::{Deserialize, Serialize};

use super::shard;
use crate::catalog::{Dense, DenseVisitor, Entry};
use crate::root;

/// Flags of `cargo xtask stress traverse`.
#[derive(Debug, clap::Args)]
#[group(skip)]
pub(crate) struct Args {
    #[command(flatten)]
    shard: shard::Args,
    /// Folder of real volumes; those that are there are traversed
    #[arg(long, value_name = "DIR", default_value = "../shared/data")]
    data: PathBuf,
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
    slips: u64,
    offending: shard::Offending,
}

impl shard::Tally for Tally {
    fn merge(&mut self, other: Self) {
        self.rays += other.rays;
        self.aimed += other.aimed;
        self.cells += other.cells;
        self.crossings += other.crossings;
        self.slips += other.slips;
        self.offending.merge(other.offending);
    }
}

/// Follows the side that the ray is on. Between two cells that can hold surface all are on one side, as are the faces to them.
#[derive(Default)]
struct Sides {
    is_inside: Option<bool>,
    cells: u64,
    crossings: u64,
    slips: u64,
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
}

pub(crate) fn run(args: &Args) -> Result<()> {
    let entries = Entry::all(&[Entry::turbulence(256)], &root().join(&args.data));
    let entries = Entry::named_like(entries, args.only.as_deref())?;
    let surfaces: usize = entries.iter().map(|e| e.isovalues.len()).sum();
    let shard = shard::Args { count: args.shard.count.div_ceil(surfaces as u64), ..args.shard.clone() };
    let mut total = Tally::default();
    for entry in &entries {
        let tally = entry.visit(Volume { entry, shard: &shard })??;
        shard::Tally::merge(&mut total, tally);
    }
    println!("{}", row("all", &total));
    match total.slips {
        0 => Ok(()),
        n => bail!("{n} changes of side without a hit; offending inputs:\n{}", total.offending),
    }
}

fn row(name: &str, tally: &Tally) -> String {
    let Tally { rays, aimed, cells, crossings, slips, .. } = tally;
    format!(
        "{name:<28} {rays:>11} rays, {aimed:>10} aimed at edges and vertices, {cells:>12} cells, {crossings:>11} crossings: {slips} slips"
    )
}

struct Volume<'a> {
    entry: &'a Entry,
    shard: &'a shard::Args,
}

impl DenseVisitor for Volume<'_> {
    type Output = Result<Tally>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        let octree = volume.octree()?;
        let mut total = Tally::default();
        for &isovalue in &self.entry.isovalues {
            let name = format!("{} at {isovalue}", self.entry.name);
            let tally = self.shard.run(&format!("traverse {name}"), |inputs| {
                let mut tally = Tally::default();
                let view = octree.view();
                let mut tracer = Tracer::new(&view);
                for n in inputs {
                    let ray = input(volume.dims.axes(), self.shard.seed << 40 | n);
                    let mut sides = Sides::default();
                    tracer.trace(&ray, isovalue, &mut sides, &mut ());
                    tally.rays += 1;
                    tally.aimed += n & 1;
                    tally.cells += sides.cells;
                    tally.crossings += sides.crossings;
                    tally.slips += sides.slips;
                    if sides.slips > 0 {
                        tally.offending.keep(&name, &ray);
                    }
                }
                tally
            })?;
            println!("{}", row(&name, &tally));
            shard::Tally::merge(&mut total, tally);
        }
        Ok(total)
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
