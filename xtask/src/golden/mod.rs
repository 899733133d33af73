//! `cargo xtask golden`: pictures against stored references and against the float64 oracle.

mod compared;
mod detail_cells;
mod detail_field;
mod eye;
mod flip;
mod glow;
mod isosurfaces;
mod mesh;
mod mesh_cells;
mod mesh_pictures;
mod mesh_volume;
mod off;
mod picture;
mod pictures;
mod rays;
mod reference;
mod report;
mod scenes;
mod selection;
mod shadow;
mod single_level;
mod subjects;
mod truth;
mod unlike;
mod verify;
mod volume;

use std::path::PathBuf;

use anyhow::{Result, bail};
use isoray_grid::{Scalar, ScalarType};
use isoray_render::Scene;

use crate::catalog::{Dense, DenseVisitor, Entry, Place, data_folder};
use crate::for_oracle;
use eye::Eye;
use reference::References;
use report::Tally;
use selection::Selection;

/// Flags of `cargo xtask golden`.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Also check every structured volume of this folder
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// Pixels along each side of the views of the data folder's volumes
    #[arg(long, default_value_t = 256)]
    size: u32,
    /// Only checks whose name, as printed, contains this
    #[arg(long, value_name = "NAME")]
    only: Option<String>,
    /// Replace the stored references by what this build renders, if all of it agrees with the oracle
    #[arg(long)]
    update: bool,
}

/// Pixels along each side of a fixture scene.
const FIXTURE_SIZE: u32 = 64;

pub(crate) fn run(args: &Args) -> Result<()> {
    let selection = &Selection::new(args.only.clone());
    let mut references = References::new(args.update);
    let fixtures = [Entry::fixture(), Entry::marschner_lobb(64), Entry::turbulence(64)];
    let fixtures: Vec<&Entry> = fixtures.iter().filter(|e| selection.may_want(e)).collect();
    let data = args.data.as_deref().map(|folder| data_folder(Some(folder))).transpose()?;
    let real = data.as_deref().map(Entry::real).unwrap_or_default();
    let real: Vec<&Entry> = real.iter().filter(|e| selection.may_want(e)).collect();

    println!("{}", Tally::HEADER);
    let mut failures = Vec::new();
    for &entry in &fixtures {
        let references = Some(&mut references);
        failures.extend(entry.visit(Scenes { entry, selection, size: FIXTURE_SIZE, references })??);
    }
    if args.data.is_some() {
        let generated = [Entry::marschner_lobb(256), Entry::turbulence(256)];
        let generated = generated.iter().filter(|e| selection.may_want(e));
        for entry in real.iter().copied().chain(generated) {
            let scenes = Scenes { entry, selection, size: args.size, references: None };
            failures.extend(entry.visit(scenes)??);
        }
    }
    println!("\n{}", pictures::HEADER);
    failures.extend(pictures::check(selection, &mut references)?);
    println!("\n{}", rays::HEADER);
    for (entry, size) in with_sizes(&fixtures, &real, FIXTURE_SIZE, args.size / 2) {
        failures.extend(entry.visit(rays::Rays { entry, selection, size })??);
    }
    println!("\n{}", volume::HEADER);
    for (entry, size) in with_sizes(&fixtures, &real, FIXTURE_SIZE / 2, args.size / 2) {
        failures.extend(entry.visit(volume::Volumes { entry, selection, size })??);
    }
    println!("\n{}", mesh::HEADER);
    for source in &mesh::Source::all() {
        failures.extend(mesh::check(source, selection, &mut references)?);
    }
    println!("\n{}", single_level::HEADER);
    for &entry in &fixtures {
        failures.extend(entry.visit(single_level::SingleLevel { entry, selection })??);
    }
    selection.ensure_any()?;
    finish(failures, selection, &references)
}

/// Stores the new references, unless anything has failed. Where all scenes were looked at, files that none of them has are told, or removed.
fn finish(mut failures: Vec<String>, selection: &Selection, references: &References) -> Result<()> {
    let orphans = if selection.is_part() { Vec::new() } else { references.orphans()? };
    if !references.is_update() {
        failures.extend(orphans.iter().map(|name| format!("{name}: no scene has this reference")));
    }
    if !failures.is_empty() {
        let refusal = if references.is_update() { "; no reference is replaced" } else { "" };
        bail!("{} golden checks failed{refusal}:\n  {}", failures.len(), failures.join("\n  "));
    }
    if references.is_update() {
        let replaced = references.store(&orphans)?;
        println!("\n{replaced} references replaced, {} removed", orphans.len());
    }
    Ok(())
}

/// Volumes with the sizes of their pictures.
fn with_sizes<'e>(
    fixtures: &[&'e Entry],
    real: &[&'e Entry],
    of_fixtures: u32,
    of_real: u32,
) -> Vec<(&'e Entry, u32)> {
    let sized = |entries: &[&'e Entry], size| entries.iter().map(|&e| (e, size)).collect::<Vec<_>>();
    [sized(fixtures, of_fixtures), sized(real, of_real)].concat()
}

/// All isovalues and views of one volume.
struct Scenes<'a> {
    entry: &'a Entry,
    selection: &'a Selection,
    size: u32,
    /// What it is compared with, if that is stored.
    references: Option<&'a mut References>,
}

impl DenseVisitor for Scenes<'_> {
    type Output = Result<Vec<String>>;

    fn visit<T: Scalar + Into<f64>>(mut self, volume: &Dense<T>) -> Result<Vec<String>> {
        let octree = volume.octree()?;
        let lattice = for_oracle::lattice(volume);
        let mut failures = Vec::new();
        for isovalue in with_half_steps::<T>(&self.entry.isovalues) {
            for place in Place::ALL {
                let name = format!("{} at {isovalue}, {}", self.entry.name, place.name());
                if !self.selection.wants(&name) {
                    continue;
                }
                let eye = Eye::new(place.view(volume.dims, &volume.index_to_world), self.size)?;
                let camera = eye.camera;
                failures.extend(eye.failures(&volume.index_to_world).map(|what| format!("{name}: {what}")));
                let rendered = verify::render(&octree, &camera, isovalue);
                let tally = verify::against_oracle(&octree, &lattice, &camera, isovalue, &rendered);
                println!("{}", tally.row(&name));
                let differing = verify::differing_traversals(
                    &octree.view(),
                    volume.index_to_world,
                    &camera,
                    &Scene::of(isovalue),
                    &rendered.forward,
                    &name,
                )?;
                failures.extend(differing.into_iter().map(|what| format!("{name}: {what}")));
                let is_generic = place != Place::Along && !is_sample_value::<T>(isovalue);
                let mut broken = tally.failures(is_generic);
                if !broken.is_empty() {
                    let [expected, found] =
                        verify::pictures(&octree, &lattice, &camera, isovalue, &rendered.forward);
                    let shown = reference::show(&format!("{name}, oracle"), &expected, &found)?;
                    broken.push(format!("shown in {}", shown.display()));
                }
                failures.extend(broken.into_iter().map(|what| format!("{name}: {what}")));
                if let Some(references) =
                    self.references.as_deref_mut().filter(|_| self.entry.isovalues.contains(&isovalue))
                {
                    let width = camera.size()[0];
                    let is_grazing = |n: usize| tally.is_grazing([n as u32 % width, n as u32 / width]);
                    let outcome = references.surface(&name, &rendered.forward, is_grazing)?;
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
