//! The meshes that are measured.

use std::path::Path;

use isoray_amr::Patches;
use isoray_benches::clumps::{clumps, clumps_4};
use isoray_io::AmrDataset;

/// A mesh to be made.
pub(crate) struct Source {
    pub(super) name: String,
    pub(super) patches: Patches,
}

/// Files, relative to the data folder, and their fields.
const FILES: [(&str, &str, &str); 4] = [
    ("Rayleigh-Taylor", "amr/amrex_rt/plt00846", "density"),
    ("cylinder", "amr/plt_eb_3d", "density"),
    ("chombo", "amr/chombo3d/chombo3d.vtm", "phi"),
    ("thermal", "amr/gerris_thermal/thermal-1.50.vtk", "T"),
];

/// That of short runs.
pub(super) fn short() -> Source {
    Source { name: "clumps 3".to_owned(), patches: clumps(3, 0.05, 32) }
}

pub(super) fn sources(quick: bool, data: &Path) -> Vec<Source> {
    if quick {
        return vec![short()];
    }
    let mut sources = vec![Source { name: "clumps 4".to_owned(), patches: clumps_4() }];
    for (name, file, field) in FILES {
        match AmrDataset::open(&data.join(file)).and_then(|dataset| dataset.read(Some(field))) {
            Ok(patches) => sources.push(Source { name: name.to_owned(), patches }),
            Err(error) => println!("SKIPPED: {name}: {error}"),
        }
    }
    sources
}
