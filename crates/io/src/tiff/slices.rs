//! The slices in a folder, in the order of their numbers.

use std::cmp::Ordering;
use std::path::{Path, PathBuf};

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
    found.sort_by(|a, b| natural(&a.to_string_lossy(), &b.to_string_lossy()).then_with(|| a.cmp(b)));
    Ok(found)
}

/// Compares runs of digits as numbers, and all else as text.
fn natural(a: &str, b: &str) -> Ordering {
    let (mut a, mut b) = (a, b);
    loop {
        let ((a_run, a_rest), (b_run, b_rest)) = (run(a), run(b));
        if a_run.is_empty() || b_run.is_empty() {
            return a.len().cmp(&b.len());
        }
        let both = [a_run, b_run].map(|r| r.starts_with(|c: char| c.is_ascii_digit()));
        let order = if both == [true; 2] {
            let [x, y] = [a_run, b_run].map(|r| r.trim_start_matches('0'));
            x.len().cmp(&y.len()).then_with(|| x.cmp(y))
        } else {
            a_run.cmp(b_run)
        };
        if order.is_ne() {
            return order;
        }
        (a, b) = (a_rest, b_rest);
    }
}

/// The digits, or what is none, that `text` begins with, and the rest.
fn run(text: &str) -> (&str, &str) {
    let digits = text.starts_with(|c: char| c.is_ascii_digit());
    text.split_at(text.find(|c: char| c.is_ascii_digit() != digits).unwrap_or(text.len()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_in_order() {
        let sorted =
            ["", "a", "a2b", "a02c", "a10b", "a10b1", "a10b007", "a00000000000000000000000000011", "b"];
        for (i, a) in sorted.iter().enumerate() {
            for (j, b) in sorted.iter().enumerate() {
                assert_eq!(natural(a, b), i.cmp(&j), "{a} {b}");
            }
        }
        assert_eq!(natural("a01", "a1"), Ordering::Equal);
    }
}
