//! From a file with an adaptive mesh to the mesh in memory.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use isoray_amr::{Mesh, MeshOptions, Patches};
use isoray_grid::natural_order;
use isoray_io::AmrDataset;
use isoray_octree::{Coarse, Fidelity, HISTOGRAM_BINS, Meta};
use serde::Serialize;

use crate::cli::InputArgs;
use crate::failure::{usage, warn};

/// A mesh, and what is said of any volume.
pub(crate) struct MeshVolume {
    pub(crate) mesh: Mesh,
    pub(crate) meta: Meta,
    /// `None` if all levels are there.
    pub(crate) detail: Option<MeshDetail>,
}

/// What level of detail leaves of a mesh, before and afterwards.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub(crate) struct MeshDetail {
    pub(crate) patches: [usize; 2],
    /// Of all patches, also where finer ones cover them.
    pub(crate) cells: [u64; 2],
}

/// What is made of the patches of a file before they become a mesh.
pub(crate) type Prepare<'a> = &'a dyn Fn(Patches) -> Result<Patches>;

/// Which file has patches that do not make a mesh.
pub(crate) fn no_mesh(path: &Path) -> String {
    format!("{}: its patches do not make a mesh", path.display())
}

/// The meshes in a folder that is none itself, in the order of the numbers in their names.
pub(crate) fn steps(folder: &Path) -> Result<Vec<PathBuf>> {
    let entries =
        std::fs::read_dir(folder).with_context(|| format!("{}: cannot be read", folder.display()))?;
    let mut steps = Vec::new();
    for entry in entries {
        let path = entry.with_context(|| format!("{}: cannot be read", folder.display()))?.path();
        if path.is_dir() && AmrDataset::recognises(&path) {
            steps.push(path);
        }
    }
    steps.sort_by(|a, b| natural_order(a, b));
    Ok(steps)
}

/// Whether it is a folder of meshes, the steps of a simulation.
pub(crate) fn is_series(path: &Path) -> bool {
    path.is_dir() && !AmrDataset::recognises(path) && steps(path).is_ok_and(|steps| !steps.is_empty())
}

/// Whether it is a mesh, or a folder of them.
pub(crate) fn is_mesh(path: &Path) -> bool {
    AmrDataset::recognises(path) || is_series(path)
}

/// Opens a file that [`AmrDataset`] recognises.
pub(crate) fn open(path: &Path, args: &InputArgs) -> Result<AmrDataset> {
    if args.describes_raw() || args.component.is_some() {
        return Err(usage(format!(
            "{}: an adaptive mesh needs no --dims, --type, --endian, --skip, --spacing, --origin or --component",
            path.display()
        )));
    }
    Ok(AmrDataset::open(path)?)
}

/// Reads a field and makes the mesh, of what `prepare` leaves of it; warnings go to stderr.
pub(crate) fn read(
    dataset: &AmrDataset,
    args: &InputArgs,
    prepare: Option<Prepare<'_>>,
) -> Result<MeshVolume> {
    let path = dataset.path();
    let (patches, warnings) = dataset.read_with_warnings(args.field.as_deref())?;
    warnings.iter().for_each(warn);
    let size = |patches: &Patches| (patches.patches.len(), patches.cell_count());
    let (patches, detail) = match prepare {
        None => (patches, None),
        Some(prepare) => {
            let before = size(&patches);
            let patches = prepare(patches)?;
            let after = size(&patches);
            (patches, Some(MeshDetail { patches: [before.0, after.0], cells: [before.1, after.1] }))
        }
    };
    let options = MeshOptions { border: args.border.unwrap_or_default().into(), ..MeshOptions::default() };
    let mesh = Mesh::new(patches, options).with_context(|| no_mesh(path))?;
    let empty = mesh.empty_cells();
    if empty > 0 {
        let all: u64 = mesh.size().leaves.iter().sum();
        warn(format!("{}: {empty} of {all} cells are NaN or infinite; they are not drawn", path.display()));
    }
    let histogram: Box<[u64; HISTOGRAM_BINS]> = Box::new(mesh.histogram());
    let meta = Meta {
        dims: mesh.dims(),
        index_to_world: mesh.index_to_world(),
        range: mesh.range().map(|range| range.map(f64::from)),
        non_finite: empty,
        histogram,
        fidelity: Fidelity::LOSSLESS,
        coarse: Coarse::None,
    };
    Ok(MeshVolume { mesh, meta, detail })
}
