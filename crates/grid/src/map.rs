//! The workspace's one memory-map opener.

use std::fs::File;
use std::io;
use std::ops::Deref;
use std::path::Path;
use std::sync::Arc;

/// A whole file, mapped read-only; clones share the mapping.
#[derive(Clone, Debug)]
pub struct MappedFile(Arc<memmap2::Mmap>);

/// In which order the pages of a file will be asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// Any: only those are read that are asked for.
    Random,
    /// One after the other: the next are read ahead.
    Sequential,
}

impl MappedFile {
    /// Tells the operating system what to expect. It changes how much is read from the disk, and nothing else; where the
    /// system takes no advice it does nothing.
    pub fn expect(&self, access: Access) {
        #[cfg(unix)]
        {
            let advice = match access {
                Access::Random => memmap2::Advice::Random,
                Access::Sequential => memmap2::Advice::Sequential,
            };
            // Advice that is not taken is no error.
            let _ = self.0.advise(advice);
        }
        #[cfg(not(unix))]
        let _ = access;
    }
}

impl Deref for MappedFile {
    type Target = [u8];
    fn deref(&self) -> &[u8] {
        &self.0
    }
}

/// Maps the file at `path` read-only; its pages are read when they are first touched.
///
/// The file must not be shortened while it is mapped: the operating system then ends the process at the
/// next access to a page that is gone. Replacing it by renaming another over it is safe.
///
/// # Errors
/// What the operating system says of opening or mapping it.
pub fn map_file(path: &Path) -> io::Result<MappedFile> {
    let file = File::open(path)?;
    #[expect(
        unsafe_code,
        reason = "mapping a file has no safe form; every reader of the workspace goes through here"
    )]
    // SAFETY: the map is private to this process and read-only, and is handed out as bytes only, for which
    // every bit pattern is valid. A concurrent writer can change what is read, which readers survive by
    // bounds-checking every link and length; that the file is not shortened is documented above.
    let map = unsafe { memmap2::Mmap::map(&file)? };
    Ok(MappedFile(Arc::new(map)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_bytes_and_reports_missing_files() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a");
        std::fs::write(&path, b"abc").unwrap();
        assert_eq!(&*map_file(&path).unwrap(), b"abc");
        assert_eq!(map_file(&dir.path().join("b")).unwrap_err().kind(), io::ErrorKind::NotFound);
    }
}
