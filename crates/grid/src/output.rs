//! The workspace's one way to write a file: whole or not at all.

use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

/// Ends the names of files that are being written.
const SUFFIX: &str = ".isoray-part";

/// A file that gets its name when it is complete.
///
/// Until [`commit`](Self::commit) it lies under a temporary name in the same folder. Dropped without that it is removed;
/// what a process that was killed has left is removed by the next one that writes a file of that name. If two write the
/// same one, each writes its own, and the last to commit replaces the other's, whole.
#[derive(Debug)]
pub struct OutputFile {
    temporary: NamedTempFile,
    path: PathBuf,
}

impl OutputFile {
    /// A new file that is to replace what is at `path`, readable and writable by all whom the user's mask lets.
    ///
    /// # Errors
    /// What the operating system says of creating a file in that folder.
    pub fn create(path: &Path) -> io::Result<Self> {
        let folder = folder_of(path);
        let mut prefix = std::ffi::OsString::from(".");
        prefix.push(path.file_name().unwrap_or_default());
        prefix.push(".");
        remove_abandoned(folder, &prefix);
        let mut builder = tempfile::Builder::new();
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            builder.permissions(fs::Permissions::from_mode(0o666));
        }
        loop {
            let temporary = builder.prefix(&prefix).suffix(SUFFIX).tempfile_in(folder)?;
            // Tells others that it is in use. Where files cannot be locked, nobody takes one for abandoned either.
            let _ = temporary.as_file().lock_shared();
            // Between being made and being locked it may have been taken for abandoned.
            if temporary.path().exists() {
                return Ok(Self { temporary, path: path.to_owned() });
            }
        }
    }

    /// The file, open for reading and writing.
    pub fn file(&mut self) -> &mut File {
        self.temporary.as_file_mut()
    }

    /// Where the file lies until it is complete.
    pub fn temporary_path(&self) -> &Path {
        self.temporary.path()
    }

    /// Gives the file its name.
    ///
    /// # Errors
    /// What the operating system says of renaming it.
    pub fn commit(self) -> io::Result<()> {
        self.temporary.persist(&self.path).map_err(|e| e.error)?;
        Ok(())
    }
}

/// The folder that `path` lies in.
pub fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."))
}

/// Removes unfinished files that nobody holds a lock on. Failing to is no reason not to write.
fn remove_abandoned(folder: &Path, prefix: &std::ffi::OsStr) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let bytes = name.as_encoded_bytes();
        let is_unfinished =
            bytes.starts_with(prefix.as_encoded_bytes()) && bytes.ends_with(SUFFIX.as_bytes());
        if is_unfinished {
            remove_if_abandoned(&entry.path());
        }
    }
}

fn remove_if_abandoned(path: &Path) {
    let Ok(file) = File::open(path) else { return };
    match file.try_lock() {
        // Removed while it is locked: who has just made it waits for the lock, and then sees that it is gone.
        Ok(()) => drop(fs::remove_file(path)),
        Err(TryLockError::WouldBlock | TryLockError::Error(_)) => {}
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<_> =
            entries.map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_appears_when_it_is_complete() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.ovol");
        let mut file = OutputFile::create(&path).unwrap();
        file.file().write_all(b"whole").unwrap();
        assert!(!path.exists());
        file.commit().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"whole");
        drop(OutputFile::create(&path).unwrap());
        assert_eq!(names(folder.path()), ["a.ovol"]);
    }

    #[test]
    fn abandoned_files_are_removed_and_those_in_use_are_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.ovol");
        fs::write(folder.path().join(format!(".a.ovol.x{SUFFIX}")), b"killed").unwrap();
        fs::write(folder.path().join(format!(".b.ovol.x{SUFFIX}")), b"of another file").unwrap();
        let first = OutputFile::create(&path).unwrap();
        let mut second = OutputFile::create(&path).unwrap();
        assert!(first.temporary_path().exists());
        second.file().write_all(b"second").unwrap();
        second.commit().unwrap();
        first.commit().unwrap();
        assert_eq!(names(folder.path()), [format!(".b.ovol.x{SUFFIX}"), "a.ovol".to_owned()]);
        assert_eq!(fs::read(&path).unwrap(), b"", "the last to commit wins, whole");
    }

    #[test]
    fn rivals_never_take_each_other_for_abandoned() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.ovol");
        std::thread::scope(|scope| {
            for n in 0..4u8 {
                let path = &path;
                scope.spawn(move || {
                    for _ in 0..300 {
                        let mut file = OutputFile::create(path).unwrap();
                        file.file().write_all(&[n; 100]).unwrap();
                        file.commit().unwrap();
                    }
                });
            }
        });
        assert_eq!(names(folder.path()), ["a.ovol"]);
        let found = fs::read(&path).unwrap();
        assert!(found.len() == 100 && found.iter().all(|&n| n == found[0]));
    }
}
