//! `isoray` without a command: the bundled scan.

use std::io::Write;
use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::Parser;

use super::render;
use crate::cli::{Cli, Command};

/// CT scan of a tooth; `fixtures/tooth/README.md` tells its origin.
const TOOTH: &[u8] = include_bytes!("../../../../fixtures/tooth/tooth.nrrd");
const OUTPUT: &str = "isoray.png";

pub(crate) fn run() -> Result<()> {
    let mut file =
        tempfile::Builder::new().suffix(".nrrd").tempfile().context("cannot write a temporary file")?;
    file.write_all(TOOTH).context("cannot write a temporary file")?;
    let input = file.path().to_string_lossy();
    let arguments =
        ["isoray", "render", &input, "--isovalue", "600", "--size", "800x800", "--normals", "central"];
    let arguments = arguments.iter().copied().chain(["-o", OUTPUT]);
    let Some(Command::Render(args)) = Cli::try_parse_from(arguments)?.command else {
        return Ok(());
    };
    println!("Rendering the bundled CT scan of a tooth (103 x 94 x 161 samples) at isovalue 600.");
    let stats = render::render(&args)?;
    let picture = std::env::current_dir().unwrap_or_else(|_| PathBuf::from(".")).join(OUTPUT);
    println!(
        "Built the octree volume in {:.0} ms ({:.0} % of the raw size), traced {} rays in {:.0} ms on {} threads.",
        stats.build_s * 1e3,
        100.0 * stats.structure_bytes as f64 / stats.raw_bytes as f64,
        stats.rays,
        stats.render_s * 1e3,
        stats.threads
    );
    println!("The picture is {}", picture.display());
    println!();
    println!("Next, with a scan of your own (NRRD, MetaImage, NIfTI or raw):");
    println!("  isoray info   SCAN                        what is in it");
    println!("  isoray render SCAN -o scan.png            its surface, at a proposed isovalue");
    println!("  isoray build  SCAN -o scan.ovol           compress it once, open it instantly");
    println!("  isoray render --help                      camera, light, normals, statistics");
    Ok(())
}
