//! `isoray`: exact pictures of scalar volumes, from the command line.

use std::process::ExitCode;

fn main() -> ExitCode {
    isoray::run()
}
