//! `isoray info` of an adaptive mesh.

use std::io::{self, Write};
use std::path::Path;

use anyhow::Result;
use isoray_amr::Centering;
use isoray_io::AmrDataset;
use serde::Serialize;

use super::info::plain;
use crate::cli::InfoArgs;
use crate::failure::warn;
use crate::mesh;
use crate::output::to_stdout;

/// Everything that is printed, and the JSON form of it.
#[derive(Debug, Serialize)]
struct Info {
    file: String,
    format: String,
    /// Cells of level 0 along each axis.
    domain: [u32; 3],
    /// Three axes and the translation, of cells of level 0: world = x·i + y·j + z·k + t.
    index_to_world: [[f64; 3]; 4],
    levels: Vec<Level>,
    fields: Vec<Field>,
}

#[derive(Debug, Serialize)]
struct Level {
    level: usize,
    /// Cells of the next level along the edge of one.
    ratio: Option<u32>,
    boxes: usize,
    cells: u64,
}

#[derive(Debug, Serialize)]
struct Field {
    name: String,
    /// Where the values are: "cells" or "vertices".
    centering: &'static str,
    /// Of the values as they are in the file, in patches of all levels; `None` if none is finite.
    range: Option<[f32; 2]>,
    non_finite: usize,
}

pub(super) fn run(file: &Path, args: &InfoArgs) -> Result<()> {
    let dataset = mesh::open(file, &args.source)?;
    let names: Vec<String> = match args.source.field.as_deref() {
        Some(name) => vec![dataset.field(Some(name))?.name.clone()],
        None => dataset.fields().iter().map(|field| field.name.clone()).collect(),
    };
    let fields = names.iter().map(|name| field(&dataset, name)).collect::<Result<_>>()?;
    let affine = dataset.index_to_world();
    let levels = dataset.levels().iter().enumerate();
    let info = Info {
        file: file.display().to_string(),
        format: dataset.format().to_owned(),
        domain: dataset.domain().1,
        index_to_world: [affine.x_axis, affine.y_axis, affine.z_axis, affine.w_axis].map(plain),
        levels: levels
            .map(|(level, of)| Level { level, ratio: of.ratio, boxes: of.boxes, cells: of.cells })
            .collect(),
        fields,
    };
    let json = if args.json { Some(serde_json::to_string_pretty(&info)?) } else { None };
    to_stdout(|out| match json {
        Some(json) => writeln!(out, "{json}"),
        None => print(&info, out),
    })
}

fn field(dataset: &AmrDataset, name: &str) -> Result<Field> {
    let (patches, warnings) = dataset.read_with_warnings(Some(name))?;
    warnings.iter().for_each(warn);
    let values = || patches.patches.iter().flat_map(|patch| patch.values.iter());
    let finite = || values().copied().filter(|value| value.is_finite());
    let range = finite().reduce(f32::min).zip(finite().reduce(f32::max));
    Ok(Field {
        name: name.to_owned(),
        centering: match patches.centering {
            Centering::Cells => "cells",
            Centering::Vertices => "vertices",
        },
        range: range.map(|(low, high)| [low, high]),
        non_finite: values().count() - finite().count(),
    })
}

fn print(info: &Info, out: &mut dyn Write) -> io::Result<()> {
    let [x, y, z] = info.domain;
    writeln!(out, "file         {}", info.file)?;
    writeln!(out, "format       {}", info.format)?;
    writeln!(out, "domain       {x} x {y} x {z} cells of level 0")?;
    let [axis_x, axis_y, axis_z, origin] = info.index_to_world;
    writeln!(out, "cell         {axis_x:?}, {axis_y:?}, {axis_z:?} from {origin:?}")?;
    writeln!(out, "level        boxes        cells  ratio to the next")?;
    for Level { level, ratio, boxes, cells } in &info.levels {
        let ratio = ratio.map_or(String::new(), |ratio| ratio.to_string());
        writeln!(out, "{level:>5} {boxes:>12} {cells:>12}  {ratio}")?;
    }
    for Field { name, centering, range, non_finite } in &info.fields {
        let range = range.map_or("no finite value".to_owned(), |[low, high]| format!("{low} to {high}"));
        let others = if *non_finite > 0 { format!(", {non_finite} NaN or infinite") } else { String::new() };
        writeln!(out, "field        {name}, at {centering}, {range}{others}")?;
    }
    Ok(())
}
