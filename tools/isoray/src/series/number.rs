//! File names with a place for a number, written as for `printf`.

use std::path::{Path, PathBuf};

/// A path whose file name has one `%d` or, for numbers with leading zeros, `%04d` in it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct NumberPattern {
    folder: PathBuf,
    before: String,
    /// Least number of digits.
    width: usize,
    after: String,
}

/// The most digits of a pattern; names of files are hardly longer.
const MOST_DIGITS: usize = 200;

impl NumberPattern {
    /// `None` if the name has no such place, or several.
    pub(crate) fn parse(path: &Path) -> Option<Self> {
        let (before, width, after) = split(path.file_name()?.to_str()?)?;
        if split(after).is_some() {
            return None;
        }
        let (before, after) = (before.to_owned(), after.to_owned());
        Some(Self { folder: path.parent().map(Path::to_owned).unwrap_or_default(), before, width, after })
    }

    /// The path with a number.
    pub(crate) fn path(&self, number: usize) -> PathBuf {
        let Self { folder, before, width, after } = self;
        folder.join(format!("{before}{number:0width$}{after}"))
    }

    /// The folder in which such files lie; empty for the current one.
    pub(crate) fn folder(&self) -> &Path {
        &self.folder
    }

    /// Whether a file's name is the pattern's with some number.
    pub(crate) fn matches(&self, name: &str) -> bool {
        let rest = name.strip_prefix(self.before.as_str());
        rest.and_then(|r| r.strip_suffix(self.after.as_str())).is_some_and(|digits| {
            let is_number = !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit());
            let is_padded = digits.len() == self.width;
            is_number && (is_padded || digits.len() > self.width && !digits.starts_with('0'))
        })
    }
}

/// What is before the first place for a number, its least number of digits, and what is after it.
fn split(name: &str) -> Option<(&str, usize, &str)> {
    name.match_indices('%').find_map(|(at, _)| {
        let rest = &name[at + 1..];
        let digits = rest.find(|c: char| !c.is_ascii_digit())?;
        let after = rest[digits..].strip_prefix('d')?;
        let width = match &rest[..digits] {
            "" => 1,
            padded => padded.strip_prefix('0')?.parse().ok().filter(|w| (1..=MOST_DIGITS).contains(w))?,
        };
        Some((&name[..at], width, after))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_put_in_and_found() {
        let pattern = |text: &str| NumberPattern::parse(Path::new(text)).unwrap();
        assert_eq!(pattern("a/frame_%04d.png").path(7), Path::new("a/frame_0007.png"));
        assert_eq!(pattern("100%_%d").path(12345), Path::new("100%_12345"));
        let padded = pattern("a_%03d.raw");
        for (name, fits) in [
            ("a_007.raw", true),
            ("a_1234.raw", true),
            ("a_0123.raw", false),
            ("a_07.raw", false),
            ("a_.raw", false),
            ("a_0x7.raw", false),
            ("b_007.raw", false),
            ("a_007.nrrd", false),
        ] {
            assert_eq!(padded.matches(name), fits, "{name}");
        }
        let plain = pattern("%d");
        assert!(plain.matches("0") && plain.matches("18446744073709551616") && !plain.matches("01"));
        assert!(!pattern("aa%da").matches("aa"), "nothing is used twice");
    }

    #[test]
    fn names_without_one_place() {
        for name in ["", "a", "%", "%d%d", "%04", "%4d", "%0d", "%0999d", "%s", "a%d/b"] {
            assert_eq!(NumberPattern::parse(Path::new(name)), None, "{name}");
        }
    }
}
