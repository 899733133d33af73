//! What the steps of a series were built of, so that a build that was broken off need not begin anew.

use std::collections::BTreeMap;
use std::fs::{self, Metadata};
use std::io;
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

use anyhow::{Context, Result};
use isoray_grid::folder_of;
use serde::{Deserialize, Serialize};

use crate::cli::BuildArgs;
use crate::failure::warn;
use crate::output::write_file;

/// The record's name in the folder of the series.
const NAME: &str = "series.json";

/// For every step that was built, by the name of its file, what it was built of.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Record {
    steps: BTreeMap<String, Origin>,
}

/// What decides the bytes of a step.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Origin {
    /// Name of the input, without its folder.
    input: String,
    /// Bytes of the input.
    length: u64,
    /// When the input was last changed, in nanoseconds since 1970.
    modified_ns: u64,
    /// The flags that matter.
    options: String,
}

impl Record {
    /// The record of a folder; empty, with a warning, if it cannot be understood.
    pub(super) fn read(folder: &Path) -> Self {
        let path = folder.join(NAME);
        let parsed = match fs::read(&path) {
            Ok(bytes) => serde_json::from_slice(&bytes).map_err(|e| e.to_string()),
            Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(Self::default()),
            Err(e) => Err(e.to_string()),
        };
        parsed.unwrap_or_else(|e| {
            warn(format!("{}: cannot be used, and so all steps are built again: {e}", path.display()));
            Self::default()
        })
    }

    /// Whether a step was built of this.
    pub(super) fn matches(&self, step: &str, origin: &Origin) -> bool {
        self.steps.get(step) == Some(origin)
    }

    /// Notes that a step was built.
    pub(super) fn note(&mut self, folder: &Path, step: &str, origin: Origin) -> Result<()> {
        self.steps.insert(step.to_owned(), origin);
        let path = folder.join(NAME);
        let json = serde_json::to_vec_pretty(self)?;
        write_file(&path, &json).with_context(|| format!("{}: cannot be written", path.display()))
    }
}

impl Origin {
    pub(super) fn new(input: &Path, args: &BuildArgs) -> Result<Self> {
        let (length, modified_ns) =
            size_and_age(input).with_context(|| format!("{}: cannot be opened", input.display()))?;
        Ok(Self {
            input: input.file_name().unwrap_or_default().to_string_lossy().into_owned(),
            length,
            modified_ns,
            options: format!("{:?}, {:?}, {:?}", args.loss, args.levels, args.source),
        })
    }
}

/// Bytes of all files of an input, and when the latest was changed.
fn size_and_age(input: &Path) -> io::Result<(u64, u64)> {
    let of = |metadata: Metadata| {
        let modified = metadata.modified().ok().and_then(|time| time.duration_since(UNIX_EPOCH).ok());
        (metadata.len(), modified.map_or(0, |time| time.as_nanos() as u64))
    };
    let mut all = of(fs::metadata(input)?);
    for part in parts(input)? {
        let (length, modified) = of(fs::metadata(part)?);
        all = (all.0 + length, all.1.max(modified));
    }
    Ok(all)
}

/// The files that belong to an input beside itself: those in a folder of slices, and those that share the name of a header
/// without samples.
fn parts(input: &Path) -> io::Result<Vec<PathBuf>> {
    const HEADERS: [&str; 3] = ["nhdr", "mhd", "hdr"];
    let files = |folder: &Path| -> io::Result<Vec<PathBuf>> {
        fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect()
    };
    if input.is_dir() {
        return files(input);
    }
    if !input.extension().is_some_and(|e| HEADERS.iter().any(|h| e.eq_ignore_ascii_case(h))) {
        return Ok(Vec::new());
    }
    let mut parts = files(folder_of(input))?;
    parts.retain(|p| p.file_stem() == input.file_stem() && p.file_name() != input.file_name() && p.is_file());
    Ok(parts)
}
