//! `isoray` without a command: the bundled scan.

use std::ffi::OsStr;
use std::io::{self, Write};
use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::Parser;

use super::render::{self, Stats};
use crate::cli::{Cli, Command};
use crate::output::to_stdout;

/// CT scan of a tooth; `fixtures/tooth/README.md` tells its origin.
const TOOTH: &[u8] = include_bytes!("../../../../fixtures/tooth/tooth.nrrd");
const OUTPUT: &str = "isoray.png";

pub(crate) fn run() -> Result<()> {
    let mut file =
        tempfile::Builder::new().suffix(".nrrd").tempfile().context("cannot write a temporary file")?;
    file.write_all(TOOTH).context("cannot write a temporary file")?;
    let flags = ["--isovalue", "600", "--size", "800x800", "--normals", "central", "-o", OUTPUT];
    let arguments = ["isoray", "render"].into_iter().chain(flags).chain(["--"]).map(OsStr::new);
    let arguments = arguments.chain([file.path().as_os_str()]);
    let Some(Command::Render(args)) = Cli::try_parse_from(arguments)?.command else {
        return Ok(());
    };
    to_stdout(|out| {
        writeln!(out, "Rendering the bundled CT scan of a tooth (103 x 94 x 161 samples) at isovalue 600.")
    })?;
    let stats = render::render(&args)?;
    to_stdout(|out| tell(&stats, out))
}

/// What was done, where the picture is, and what to try next.
fn tell(stats: &Stats, out: &mut dyn Write) -> io::Result<()> {
    let frame = &stats.frame;
    let picture = std::env::current_dir().unwrap_or_else(|_| PathBuf::from(".")).join(OUTPUT);
    writeln!(
        out,
        "Built the octree volume in {:.0} ms ({:.0} % of the raw size; a noisy scan does not compress), traced {} rays in {:.0} ms on {} threads.",
        frame.build_s * 1e3,
        100.0 * frame.structure_bytes as f64 / frame.raw_bytes as f64,
        frame.rays,
        frame.render_s * 1e3,
        frame.threads
    )?;
    writeln!(out, "The picture is {}", picture.display())?;
    writeln!(out)?;
    writeln!(out, "Next, with a scan of your own (NRRD, MetaImage, NIfTI or raw):")?;
    writeln!(out, "  isoray info   SCAN                        what is in it")?;
    writeln!(out, "  isoray render SCAN -o scan.png            its surface, at a proposed isovalue")?;
    writeln!(
        out,
        "  isoray render SCAN --volume -o scan.png   all of it, as a proposed transfer function shows it"
    )?;
    writeln!(out, "  isoray build  SCAN -o scan.ovol           compress it once, open it instantly")?;
    writeln!(out, "  isoray render --help                      camera, light, transfer functions, statistics")
}
