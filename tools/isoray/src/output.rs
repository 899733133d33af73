//! Where results go: standard output, and files that must be writable before any work is done for them.

use std::fs::File;
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::Path;

use anyhow::{Context, Result, bail};
use isoray_grid::{OutputFile, folder_of};

/// Writes to standard output. A reader that has seen enough (`| head`) is no error; a full disk is one.
pub(crate) fn to_stdout(write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<()> {
    let mut out = BufWriter::new(io::stdout().lock());
    match write(&mut out).and_then(|()| out.flush()) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => Err(e).context("standard output: cannot be written"),
        _ => Ok(()),
    }
}

/// Refuses, before any work is done for it, an output that could not be written, or that would replace one of
/// `inputs` or something that is no file.
pub(crate) fn check_output(output: &Path, inputs: &[&Path]) -> Result<()> {
    let folder = folder_of(output);
    if !folder.is_dir() {
        bail!("{}: cannot be written: there is no folder {}", output.display(), folder.display());
    }
    if output.is_dir() {
        bail!("{}: cannot be written: expected the name of a file, found a folder", output.display());
    }
    if output.exists() && !output.is_file() {
        bail!("{}: cannot be written: expected a file, found a device or pipe", output.display());
    }
    for input in inputs {
        if is_same_file(input, output) {
            bail!("{}: is an input and would be overwritten; choose another output", output.display());
        }
    }
    tempfile::tempfile_in(folder)
        .with_context(|| format!("{}: cannot be written: no file can be created there", output.display()))?;
    Ok(())
}

fn is_same_file(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}

/// Writes `bytes` to `path`, whole or not at all: under a temporary name in the same folder, then renamed.
pub(crate) fn write_file(path: &Path, bytes: &[u8]) -> io::Result<()> {
    write_stream(path, |file| file.write_all(bytes))
}

/// As [`write_file`], of what `write` writes; nothing is left where it fails.
pub(crate) fn write_stream(path: &Path, write: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
    let mut file = OutputFile::create(path)?;
    write(file.file())?;
    file.commit()
}
