//! An empty folder to run the program in.

use std::ffi::OsStr;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};
use std::sync::mpsc;
use std::time::Duration;

/// What a run printed, and its exit code.
#[derive(Debug)]
pub(crate) struct Outcome {
    pub(crate) code: i32,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

/// A run that takes longer hangs; no run here takes a hundredth of it.
const PATIENCE: Duration = Duration::from_secs(300);

/// A folder that is removed in the end.
pub(crate) struct Sandbox(tempfile::TempDir);

impl Sandbox {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    /// A sandbox with a file.
    pub(crate) fn with(name: &str, bytes: &[u8]) -> Self {
        let sandbox = Self::new();
        sandbox.write(name, bytes);
        sandbox
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, bytes: &[u8]) {
        std::fs::write(self.path(name), bytes).unwrap();
    }

    pub(crate) fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap()
    }

    /// Names of all files and folders, sorted.
    pub(crate) fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.path()).unwrap();
        let mut names: Vec<String> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// The program, to be run in the folder; it keeps its temporary files there, too.
    pub(crate) fn command<S: AsRef<OsStr>>(&self, arguments: impl IntoIterator<Item = S>) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_isoray"));
        command.args(arguments).current_dir(self.0.path()).env("TMPDIR", self.0.path());
        // Nor is help to be wrapped as wide as somebody's terminal.
        command.env_remove("COLUMNS");
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    /// Runs the program to its end, which must be no panic, no signal and no hang.
    pub(crate) fn run<S: AsRef<OsStr>>(&self, arguments: impl IntoIterator<Item = S>) -> Outcome {
        finish(&mut self.command(arguments))
    }

    /// Runs the program with the words of `line` as arguments.
    pub(crate) fn line(&self, line: &str) -> Outcome {
        self.run(line.split_whitespace())
    }

    /// A run that must succeed without a warning.
    pub(crate) fn succeeds(&self, line: &str) -> String {
        let outcome = self.line(line);
        assert!(outcome.code == 0 && outcome.stderr.is_empty(), "{line}: {outcome:?}");
        outcome.stdout
    }

    /// A run that must fail with `code` and one error of which each of `parts` is a part, and leave nothing.
    pub(crate) fn fails(&self, code: i32, line: &str, parts: &[&str]) {
        let before = self.names();
        let outcome = self.line(line);
        assert_eq!(outcome.code, code, "{line}: {outcome:?}");
        assert_one_error(&outcome.stderr, line);
        for part in parts {
            assert!(outcome.stderr.contains(part), "{line}: no '{part}' in {}", outcome.stderr);
        }
        assert_eq!(self.names(), before, "{line}: left files");
    }
}

/// Waits for a run to end; see [`Sandbox::run`].
pub(crate) fn finish(command: &mut Command) -> Outcome {
    let child = command.spawn().unwrap();
    let (sender, receiver) = mpsc::channel();
    std::thread::spawn(move || sender.send(child.wait_with_output()));
    let Output { status, stdout, stderr } = receiver.recv_timeout(PATIENCE).expect("it hangs").unwrap();
    let [stdout, stderr] = [stdout, stderr].map(|bytes| String::from_utf8(bytes).unwrap());
    assert!(!stderr.contains("panicked"), "{command:?}: {stderr}");
    let code = status.code().unwrap_or_else(|| panic!("{command:?}: ended by a signal: {stderr}"));
    Outcome { code, stdout, stderr }
}

/// One line `error: …` with indented causes; where the flags are refused before they are looked into,
/// the usage follows.
fn assert_one_error(stderr: &str, line: &str) {
    let mut lines = stderr.lines();
    assert!(lines.next().is_some_and(|l| l.starts_with("error: ") && l.len() > 20), "{line}: {stderr}");
    if !stderr.contains("For more information, try '--help'.") {
        assert!(lines.all(|l| l.starts_with("  caused by: ")), "{line}: {stderr}");
    }
}
