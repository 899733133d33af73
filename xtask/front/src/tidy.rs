//! `cargo xtask tidy`: house rules that no lint knows.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

use crate::root;

/// The crates in the order of the layers: each may depend on those above it only.
const LAYERS: [&str; 12] = [
    "oracle", "cell", "preint", "grid", "synth", "octree", "build", "trace", "packet", "amr", "io", "render",
];

/// Lines of a source file over which it must be split.
const MAX_LINES: usize = 600;
/// Bytes of a file in the repository.
const MAX_BYTES: u64 = 2 << 20;

pub(crate) fn run() -> Result<()> {
    let mut problems = layering()?;
    let files = tracked_files(&root())?;
    problems.extend(files.iter().filter_map(|file| oversize(file)));
    match problems.len() {
        0 => Ok(()),
        n => bail!("{n} house rules are broken:\n  {}", problems.join("\n  ")),
    }
}

/// Dependencies that point downwards, or to the oracle other than from tests.
fn layering() -> Result<Vec<String>> {
    let mut problems = Vec::new();
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(root().join("crates"))? {
        let folder = entry?.path();
        let name = folder.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        let manifest =
            fs::read_to_string(folder.join("Cargo.toml")).with_context(|| format!("crate {name}"))?;
        found.insert(name, manifest);
    }
    for (name, manifest) in &found {
        let Some(rank) = LAYERS.iter().position(|l| l == name) else {
            problems.push(format!("crates/{name} has no place in the table of layers"));
            continue;
        };
        for dependency in dependencies(manifest) {
            let allowed = LAYERS[..rank].contains(&dependency.as_str()) && dependency != "oracle";
            if !allowed {
                problems.push(format!("crates/{name} must not depend on isoray-{dependency}"));
            }
        }
    }
    Ok(problems)
}

/// The workspace crates under `[dependencies]`, by their short names.
fn dependencies(manifest: &str) -> Vec<String> {
    let mut section = "";
    let mut found = Vec::new();
    for line in manifest.lines() {
        if line.starts_with('[') {
            section = line.trim();
        } else if section == "[dependencies]"
            && let Some(rest) = line.strip_prefix("isoray-")
        {
            found.push(rest.chars().take_while(|c| c.is_ascii_alphanumeric()).collect());
        }
    }
    found
}

fn oversize(file: &Path) -> Option<String> {
    let bytes = fs::metadata(file).ok()?.len();
    let name = file.strip_prefix(root()).unwrap_or(file).display();
    if bytes > MAX_BYTES {
        return Some(format!("{name}: {bytes} bytes; at most {MAX_BYTES} belong in the repository"));
    }
    if file.extension().is_some_and(|e| e == "rs") {
        let lines = fs::read_to_string(file).ok()?.lines().count();
        return (lines > MAX_LINES).then(|| format!("{name}: {lines} lines; split it before {MAX_LINES}"));
    }
    None
}

/// All files but build outputs and what begins with a dot.
fn tracked_files(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        if name.starts_with('.') || name == "target" {
            continue;
        }
        if path.is_dir() { files.extend(tracked_files(&path)?) } else { files.push(path) }
    }
    Ok(files)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_only_real_dependencies() {
        let manifest =
            "[dependencies]\nisoray-grid.workspace = true\nglam = 1\n[dev-dependencies]\nisoray-oracle = 1\n";
        assert_eq!(dependencies(manifest), ["grid"]);
    }

    #[test]
    fn the_workspace_is_tidy() {
        run().unwrap();
    }
}
