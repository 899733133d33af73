//! The slices in a folder, in the order of their numbers.

use std::path::{Path, PathBuf};

use isoray_grid::natural_order;

use crate::error::ReadError;

/// Whether the name is that of a slice.
fn is_slice(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("tif") || e.eq_ignore_ascii_case("tiff"))
}

/// The slices in `folder`; hidden files are none.
pub(crate) fn slices(folder: &Path) -> Result<Vec<PathBuf>, ReadError> {
    let failed = |e| ReadError::io(folder, "list the folder", e);
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let hidden = path.file_name().is_some_and(|n| n.to_string_lossy().starts_with('.'));
        if is_slice(&path) && !hidden {
            found.push(path);
        }
    }
    found.sort_by(|a, b| natural_order(a, b));
    Ok(found)
}
