//! Files of a folder replaced by others, all of them or none.

use std::path::Path;
use std::{fs, io};

use anyhow::{Context, Result};

/// Moves a file.
pub(super) type Move<'m> = &'m mut dyn FnMut(&Path, &Path) -> io::Result<()>;

/// Moves a file, from one file system to another if need be.
pub(super) fn moved(from: &Path, to: &Path) -> io::Result<()> {
    match fs::rename(from, to) {
        Err(error) if error.kind() == io::ErrorKind::CrossesDevices => {
            fs::copy(from, to)?;
            fs::remove_file(from)
        }
        result => result,
    }
}

/// Moves the files `names` from the folder `new`, and those that they replace, and those to be `removed`, to the folder `old`.
///
/// # Errors
/// If one cannot be moved. Then all are back where they were, unless the error says of one that it is not.
pub(super) fn all(
    folder: &Path,
    [new, old]: [&Path; 2],
    names: &[&str],
    removed: &[String],
    by: Move<'_>,
) -> Result<()> {
    let mut done = Vec::new();
    let names = names.iter().copied();
    let mut one = |name: &str, is_new: bool| -> io::Result<()> {
        let place = folder.join(name);
        if place.exists() {
            by(&place, &old.join(name))?;
            done.push((old.join(name), place.clone()));
        }
        if is_new {
            by(&new.join(name), &place)?;
            done.push((place, new.join(name)));
        }
        Ok(())
    };
    let each = names.map(|name| (name, true)).chain(removed.iter().map(|name| (name.as_str(), false)));
    for (name, is_new) in each {
        let Err(error) = one(name, is_new) else { continue };
        for (from, to) in done.iter().rev() {
            by(from, to).with_context(|| format!("{}: cannot be put back", to.display()))?;
        }
        return Err(error).with_context(|| format!("{name}: cannot be replaced"));
    }
    Ok(())
}
