//! Errors as the user sees them.

use std::process::ExitCode;

/// Flags that make no sense: exit code 2, where other failures give 1.
#[derive(Debug)]
pub(crate) struct UsageError(pub(crate) String);

impl std::fmt::Display for UsageError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
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
    eprintln!("error: {error}");
    for cause in error.chain().skip(1) {
        eprintln!("  caused by: {cause}");
    }
    ExitCode::from(if error.is::<UsageError>() { 2 } else { 1 })
}

/// Prints a warning.
pub(crate) fn warn(message: impl std::fmt::Display) {
    eprintln!("warning: {message}");
}
