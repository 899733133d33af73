//! `isoray tf`.

use std::path::Path;

use anyhow::Result;
use isoray_io::transfer::COLORMAPS;
use isoray_io::{PixelData, write_png};

use crate::cli::{PreviewArgs, TransferArgs, TransferCommand};
use crate::failure::usage;
use crate::load::load;
use crate::output::{check_output, to_stdout};
use crate::plot::{SIDES, draw};
use crate::transfer::{build, check, transfer_function};

pub(crate) fn run(command: &TransferCommand) -> Result<()> {
    match command {
        TransferCommand::Preview(args) => preview(args),
        TransferCommand::List => {
            to_stdout(|out| COLORMAPS.iter().try_for_each(|name| writeln!(out, "{name}")))
        }
    }
}

fn preview(args: &PreviewArgs) -> Result<()> {
    let transfer =
        TransferArgs { tf: args.file.clone().or(args.transfer.tf.clone()), ..args.transfer.clone() };
    let output = args.output.display();
    if !args.output.extension().is_some_and(|e| e.eq_ignore_ascii_case("png")) {
        return Err(usage(format!("--output {output}: expected a name that ends in .png")));
    }
    let [width, height] = args.size;
    let [least, most] = SIDES;
    if args.size.iter().any(|side| !(least..=most).contains(side)) {
        return Err(usage(format!(
            "--size: expected {least} to {most} pixels a side, found {width}x{height}"
        )));
    }
    if args.volume.is_none() && !args.source.is_empty() {
        return Err(usage("--volume VOLUME is missing: the other flags tell its layout"));
    }
    check(&transfer)?;
    let inputs: Vec<&Path> =
        [&transfer.tf, &args.volume].into_iter().flatten().map(|p| p.as_path()).collect();
    check_output(&args.output, &inputs)?;

    let loaded = args.volume.as_ref().map(|path| load(path, &args.source)).transpose()?;
    let meta = loaded.as_ref().map(|l| l.volume.meta());
    let function = match meta {
        Some(meta) => transfer_function(&transfer, meta)?,
        None => build(&transfer, None)?,
    };
    let pixels = draw(&function, meta, args.size, transfer.log);
    write_png(&args.output, width, height, PixelData::Rgb8(&pixels))?;
    let points = function.points();
    let [first, last] = [points.first(), points.last()].map(|p| p.map_or(0.0, |p| p.value));
    let densest = points.iter().map(|p| p.extinction).fold(0.0, f32::max);
    to_stdout(|out| {
        writeln!(
            out,
            "{output}: {width} x {height} pixels, {} control points, values {first} to {last}, extinction up to {densest}",
            points.len()
        )
    })
}
