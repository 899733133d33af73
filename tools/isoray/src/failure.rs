//! Errors and warnings as the user sees them.

use std::fmt;
use std::io::{self, Write};
use std::process::ExitCode;

/// Flags that make no sense: exit code 2, where other failures give 1.
#[derive(Debug)]
pub(crate) struct UsageError(String);

impl fmt::Display for UsageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for UsageError {}

/// A [`UsageError`].
pub(crate) fn usage(message: impl Into<String>) -> anyhow::Error {
    UsageError(message.into()).into()
}

/// Prints the error in one line, its causes indented under it, and tells the exit code.
pub(crate) fn report(error: &anyhow::Error) -> ExitCode {
    line("error", error);
    for cause in error.chain().skip(1) {
        line("  caused by", &cause);
    }
    ExitCode::from(if error.is::<UsageError>() { 2 } else { 1 })
}

/// Prints a warning.
pub(crate) fn warn(message: impl fmt::Display) {
    line("warning", &message);
}

/// Prints one line to stderr, whatever a file name in it contains.
fn line(kind: &str, message: &dyn fmt::Display) {
    let text = one_line(&message.to_string());
    // If stderr itself fails there is nowhere left to say so; the exit code still tells.
    let _ = writeln!(io::stderr(), "{kind}: {text}");
}

fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { '?' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_break_no_line() {
        assert_eq!(one_line("a\nb\x1b[2J: gone"), "a?b?[2J: gone");
    }
}
