//! Adaptive meshes: what they take to make, throughput, level of detail, and the tables of Marchesin and Colin de Verdière 2009.

mod detail;
mod errors;
mod hits;
mod meshes;
pub(crate) mod tables;

use std::path::Path;

use anyhow::{Context, Result, ensure};
use isoray_amr::{Mesh, MeshOptions, MeshSize, Patches, SplitRule};
use isoray_benches::clumps::clumps;
use isoray_render::Image;
use serde::Serialize;

use super::timer::interleave_kept;
use crate::finest::Finest;
use detail::DetailRow;
use meshes::Source;
use tables::{EPSILON, Scene, TableRow, difference};

/// What the suite measured.
#[derive(Debug, Default, Serialize)]
pub(crate) struct AmrSuite {
    pub(crate) meshes: Vec<MeshRow>,
    pub(crate) tables: Vec<TableRow>,
    pub(crate) detail: Vec<DetailRow>,
    pub(crate) errors: Vec<errors::ErrorRow>,
    pub(crate) hits: Vec<hits::HitRow>,
}

/// A mesh by one rule of cutting.
#[derive(Debug, Serialize)]
pub(crate) struct MeshRow {
    mesh: String,
    rule: &'static str,
    patches: usize,
    leaves: u64,
    /// Of the leaves, those that finer ones touch, in %.
    hybrid_percent: f64,
    blocks: u64,
    nodes: u64,
    bytes_per_leaf: f64,
    /// On all threads, from patches in memory.
    seconds: f64,
    /// Boxes and bricks met by a ray of the far view that integrates the volume.
    met_per_ray: f64,
}

const RULES: [(&str, SplitRule); 2] =
    [("homogeneity", SplitRule::Homogeneity), ("surface area", SplitRule::SurfaceArea)];

/// The patches of the mesh of short runs.
pub(crate) fn short_patches() -> Patches {
    meshes::short().patches
}

/// Patches of a mesh that is made in some milliseconds.
pub(crate) fn few_patches() -> Patches {
    clumps(2, 0.05, 32)
}

/// The meshes whose names have `only` in them.
pub(crate) fn sources(quick: bool, data: &Path, only: Option<&str>) -> Vec<Source> {
    let all = meshes::sources(quick, data).into_iter();
    all.filter(|source| only.is_none_or(|only| source.name.contains(only))).collect()
}

pub(crate) fn run(suite: &mut AmrSuite, sources: &[Source], quick: bool, repeat: usize) -> Result<()> {
    println!(
        "\nAdaptive meshes. Hybrid: % of the leaves that finer ones touch. Made on all threads, from patches in memory.\n{:<22} {:<12} {:>8} {:>10} {:>8} {:>8} {:>8} {:>10} {:>8} {:>10}",
        "mesh", "cut by", "patches", "leaves", "hybrid", "boxes", "nodes", "bytes/leaf", "made, s", "met/ray"
    );
    for source in sources {
        for row in rows(source, repeat)? {
            println!(
                "{:<22} {:<12} {:>8} {:>10} {:>8.2} {:>8} {:>8} {:>10.1} {:>8.3} {:>10.2}",
                row.mesh,
                row.rule,
                row.patches,
                row.leaves,
                row.hybrid_percent,
                row.blocks,
                row.nodes,
                row.bytes_per_leaf,
                row.seconds,
                row.met_per_ray
            );
            suite.meshes.push(row);
        }
    }
    println!("{}", detail::HEADER);
    for source in sources {
        suite.detail.extend(detail::rows(source, quick, repeat)?);
    }
    println!("{}", tables::HEADER);
    for source in sources {
        let mesh = Mesh::new(&source.patches, MeshOptions::default())?;
        suite.tables.extend(tables::rows(&source.name, &mesh, quick, repeat)?);
    }
    Ok(())
}

/// What is compared with the oracle.
pub(crate) fn errors(suite: &mut AmrSuite, sources: &[Source], quick: bool, repeat: usize) -> Result<()> {
    println!("{}", hits::HEADER);
    let mut finest = Vec::new();
    for Source { name, patches } in sources {
        let mesh = Mesh::new(patches, MeshOptions::default())?;
        let of = Finest::new(patches)?;
        suite.hits.extend(hits::rows(name, &mesh, &of, quick)?);
        finest.push((mesh, of));
    }
    println!("{}", errors::HEADER);
    for (Source { name, patches }, (mesh, of)) in sources.iter().zip(&finest) {
        suite.errors.extend(errors::rows(name, (patches, mesh), of, quick, repeat)?);
    }
    Ok(())
}

/// However a mesh is cut, its leaves are the same, the hybrid ones among them too, and so is its field: pictures are each within the bound of what is right.
fn same_field(sizes: [&MeshSize; 2], images: [&Image; 2]) -> Result<()> {
    let [one, other] = sizes.map(|size| (&size.leaves, size.hybrid));
    ensure!(one == other, "expected the same leaves, and as many hybrid ones, found {one:?} and {other:?}");
    let (by, most) = (difference(images[0], images[1]), 2.0 * EPSILON);
    ensure!(by <= most, "expected pixels that differ by {most} at most, found {by}");
    Ok(())
}

/// # Errors
/// Meshes of the same patches that are not the same.
fn rows(source: &Source, repeat: usize) -> Result<Vec<MeshRow>> {
    let make = |rule| Mesh::new(&source.patches, MeshOptions { rule, ..MeshOptions::default() });
    let (times, made) =
        interleave_kept(repeat.min(3), &mut [&mut || make(RULES[0].1), &mut || make(RULES[1].1)]);
    let (mut rows, mut first) = (Vec::new(), None);
    for (((name, _), seconds), mesh) in RULES.into_iter().zip(times).zip(made) {
        let mesh = mesh?;
        let size = mesh.size();
        let (image, met_per_ray) = Scene::new(&mesh, 256)?.unlit();
        let (other_size, other_image) = first.get_or_insert_with(|| (size.clone(), image.clone()));
        same_field([other_size, &size], [other_image, &image])
            .with_context(|| format!("{}: cut by {name} and by {}", source.name, RULES[0].0))?;
        let MeshSize { leaves, hybrid, blocks, nodes, bytes } = size;
        let leaves: u64 = leaves.iter().sum();
        ensure!(leaves > 0, "{}: no leaves", source.name);
        rows.push(MeshRow {
            mesh: source.name.clone(),
            rule: name,
            patches: source.patches.patches.len(),
            leaves,
            hybrid_percent: 100.0 * hybrid as f64 / leaves as f64,
            blocks,
            nodes,
            bytes_per_leaf: bytes as f64 / leaves as f64,
            seconds,
            met_per_ray,
        });
    }
    Ok(rows)
}
