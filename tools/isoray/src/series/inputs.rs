//! Which files are meant, and whether they are one volume or a series.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use glob::MatchOptions;
use isoray_grid::folder_of;
use isoray_grid::natural_order;
use isoray_octree::{Series, is_series};

use super::number::NumberPattern;
use crate::failure::usage;

/// What a build has to do.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Inputs {
    /// One volume from a file, or a folder of slices.
    One(PathBuf),
    /// One volume from files with a layer each.
    Slices(Vec<PathBuf>),
    /// A volume for each.
    Series(Vec<PathBuf>),
}

/// Finds the files that are meant by names, wildcards and numbered patterns, in the order of the numbers in their names.
///
/// # Errors
/// A pattern that nothing matches; several files for an output that is no series.
pub(crate) fn expand(given: &[PathBuf], output: &Path) -> Result<Inputs> {
    let mut files = Vec::new();
    for path in given {
        files.extend(matches(path)?);
    }
    files.sort_by(|a, b| natural_order(a, b));
    files.dedup();
    if is_series(output) {
        return Ok(Inputs::Series(files));
    }
    let is_slice = |path: &PathBuf| {
        path.extension().is_some_and(|e| e.eq_ignore_ascii_case("tif") || e.eq_ignore_ascii_case("tiff"))
    };
    match <[PathBuf; 1]>::try_from(files) {
        Ok([file]) => Ok(Inputs::One(file)),
        Err(files) if cfg!(feature = "tiff") && files.iter().all(is_slice) => Ok(Inputs::Slices(files)),
        Err(files) => Err(usage(format!(
            "{} files match: expected an output folder ending in .ovol.d, found {}",
            files.len(),
            output.display()
        ))),
    }
}

/// The files that one argument means, at least one.
fn matches(given: &Path) -> Result<Vec<PathBuf>> {
    if is_series(given) && given.is_dir() {
        return Ok(Series::open(given)?.files().to_vec());
    }
    // Whatever characters are in the name of a file, it is meant by that name.
    if given.exists() {
        return Ok(vec![given.to_owned()]);
    }
    let found = if let Some(pattern) = NumberPattern::parse(given) {
        numbered(&pattern)?
    } else if let Some(pattern) = given.to_str().filter(|text| text.contains(['*', '?', '['])) {
        wildcard(pattern)?
    } else {
        // Opening it will tell what is wrong with it.
        return Ok(vec![given.to_owned()]);
    };
    if found.is_empty() {
        bail!("{}: expected at least one file that matches, found none", given.display());
    }
    Ok(found)
}

fn numbered(pattern: &NumberPattern) -> Result<Vec<PathBuf>> {
    let folder = folder_of(&pattern.folder().join("file")).to_owned();
    let failed = || format!("{}: cannot list the folder", folder.display());
    let mut found = Vec::new();
    for entry in std::fs::read_dir(&folder).with_context(failed)? {
        let name = entry.with_context(failed)?.file_name();
        if name.to_str().is_some_and(|name| pattern.matches(name)) {
            found.push(pattern.folder().join(name));
        }
    }
    Ok(found)
}

/// Series are not found by wildcards: the one that is being built may well have a name like its inputs.
fn wildcard(pattern: &str) -> Result<Vec<PathBuf>> {
    let options = MatchOptions { require_literal_leading_dot: true, ..MatchOptions::new() };
    let paths = glob::glob_with(pattern, options).map_err(|e| usage(format!("{pattern}: {e}")))?;
    let mut found = Vec::new();
    for path in paths {
        let path = path.with_context(|| format!("{pattern}: cannot list a folder"))?;
        if !is_series(&path) {
            found.push(path);
        }
    }
    Ok(found)
}
