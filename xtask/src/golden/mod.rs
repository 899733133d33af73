//! `cargo xtask golden`: pictures against stored references and against the float64 oracle.

mod mesh;
mod rays;
mod reference;
mod report;
mod single_level;
mod verify;
mod volume;

use std::path::PathBuf;

use anyhow::{Result, bail};
use isoray_grid::{Scalar, ScalarType};

use crate::catalog::{Dense, DenseVisitor, Entry, Place};
use crate::root;
use report::Tally;

/// Flags of `cargo xtask golden`.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Also check every structured volume of this folder
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// Pixels along each side of the views of the data folder's volumes
    #[arg(long, default_value_t = 256)]
    size: u32,
    /// Only volumes whose name contains this
    #[arg(long)]
    only: Option<String>,
    /// Replace the stored references by what this build renders
    #[arg(long)]
    bless: bool,
}

/// Pixels along each side of a fixture scene.
const FIXTURE_SIZE: u32 = 64;

pub(crate) fn run(args: &Args) -> Result<()> {
    let mut failures = Vec::new();
    println!("{}", Tally::HEADER);
    let fixtures = [Entry::fixture(), Entry::marschner_lobb(64), Entry::turbulence(64)];
    for entry in fixtures.iter().filter(|e| args.wants(e)) {
        let scenes = Scenes { entry, size: FIXTURE_SIZE, references: Some(args.bless) };
        failures.extend(entry.visit(scenes)??);
    }
    if let Some(data) = &args.data {
        let generated = [Entry::marschner_lobb(256), Entry::turbulence(256)];
        for entry in Entry::real(data).iter().chain(&generated).filter(|e| args.wants(e)) {
            failures.extend(entry.visit(Scenes { entry, size: args.size, references: None })??);
        }
    }
    println!("\n{}", rays::HEADER);
    for entry in fixtures.iter().filter(|e| args.wants(e)) {
        failures.extend(entry.visit(rays::Rays { entry, size: FIXTURE_SIZE })??);
    }
    if let Some(data) = &args.data {
        for entry in Entry::real(data).iter().filter(|e| args.wants(e)) {
            failures.extend(entry.visit(rays::Rays { entry, size: args.size / 2 })??);
        }
    }
    println!("\n{}", volume::HEADER);
    for entry in fixtures.iter().filter(|e| args.wants(e)) {
        failures.extend(entry.visit(volume::Volumes { entry, size: FIXTURE_SIZE / 2 })??);
    }
    if let Some(data) = &args.data {
        for entry in Entry::real(data).iter().filter(|e| args.wants(e)) {
            failures.extend(entry.visit(volume::Volumes { entry, size: args.size / 2 })??);
        }
    }
    println!("\n{}", mesh::HEADER);
    for source in mesh::Source::all()
        .iter()
        .filter(|source| args.only.as_ref().is_none_or(|only| source.name.contains(only)))
    {
        failures.extend(mesh::check(source, args.bless)?);
    }
    println!("\n{}", single_level::HEADER);
    for entry in fixtures.iter().filter(|e| args.wants(e)) {
        failures.extend(entry.visit(single_level::SingleLevel { entry })??);
    }
    match failures.len() {
        0 => Ok(()),
        n => bail!("{n} golden checks failed:\n  {}", failures.join("\n  ")),
    }
}

impl Args {
    fn wants(&self, entry: &Entry) -> bool {
        self.only.as_ref().is_none_or(|only| entry.name.contains(only))
    }
}

/// All isovalues and views of one volume.
struct Scenes<'a> {
    entry: &'a Entry,
    size: u32,
    /// Compare with stored references, or replace them.
    references: Option<bool>,
}

impl DenseVisitor for Scenes<'_> {
    type Output = Result<Vec<String>>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Result<Vec<String>> {
        let octree = volume.octree()?;
        let lattice = verify::lattice(volume);
        let mut failures = Vec::new();
        for isovalue in with_half_steps::<T>(&self.entry.isovalues) {
            for place in Place::ALL {
                let camera = volume.camera(place, self.size)?;
                let name = format!("{} at {isovalue}, {}", self.entry.name, place.name());
                let rendered = verify::render(&octree, &camera, isovalue);
                let tally = verify::against_oracle(&octree, &lattice, &camera, isovalue, &rendered);
                println!("{}", tally.row(&name));
                let differing = verify::differing_traversals(&octree, &camera, isovalue, &rendered.forward);
                failures.extend(differing.into_iter().map(|what| format!("{name}: {what}")));
                let is_generic = place != Place::Along && !is_sample_value::<T>(isovalue);
                failures.extend(tally.failures(is_generic).into_iter().map(|what| format!("{name}: {what}")));
                if let Some(bless) = self.references.filter(|_| self.entry.isovalues.contains(&isovalue)) {
                    let file = reference::file_name(&root().join("fixtures/golden"), &name);
                    let outcome = reference::check(&file, &rendered.forward, tally.grazing(), bless)?;
                    failures.extend(outcome.into_iter().map(|what| format!("{name}: {what}")));
                }
            }
        }
        Ok(failures)
    }
}

/// An isovalue that samples can be equal to: plateaus at exactly that value then end in edges where the surface's place
/// hangs on the last bit, and many rays graze by definition.
fn is_sample_value<T: Scalar>(isovalue: f32) -> bool {
    T::TYPE != ScalarType::F32 && isovalue.fract() == 0.0
}

/// The isovalues, and for those that samples can be equal to also the one half a step below, which parts the samples alike.
fn with_half_steps<T: Scalar>(isovalues: &[f32]) -> Vec<f32> {
    let below = isovalues.iter().filter(|&&v| is_sample_value::<T>(v)).map(|v| v - 0.5);
    isovalues.iter().copied().chain(below).collect()
}
