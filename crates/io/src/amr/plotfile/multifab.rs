//! The file `Cell_H` of a level: its boxes, and where their values are.
//!
//! Lines: the version; how the values were distributed; the number of components; the number of ghost cells, or one for each
//! axis; `(N 0`, `N` boxes, `)`; `N`, and `N` times `FabOnDisk: FILE OFFSET`; ranges. From version 2 on, no header
//! stands before the values of a box, and a last line tells how numbers are written.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use super::header::{MOST_TEXT, is_inside};
use super::notation::{Notation, RealFormat, TypedBox};
use crate::error::ReadError;
use crate::lines::HeaderLines;

/// The boxes of a level.
#[derive(Clone, Debug)]
pub(super) struct MultiFab {
    pub(super) components: u64,
    pub(super) ghosts: [u32; 3],
    pub(super) boxes: Vec<TypedBox>,
    /// The file, as an index into `files`, and the byte of it at which a box's values or their header begin.
    pub(super) places: Vec<(usize, u64)>,
    pub(super) files: Vec<PathBuf>,
    /// How numbers are written, if no header stands before them.
    pub(super) bare: Option<RealFormat>,
}

/// Most ghost cells; no simulation has more than some ten.
const MOST_GHOSTS: u32 = 1 << 10;

/// Reads the file at `path`.
pub(super) fn read(path: &Path) -> Result<MultiFab, ReadError> {
    let lines = &mut HeaderLines::open_within(path, MOST_TEXT)?;
    let version: u32 = number(path, lines, "version of the file")?;
    if !(1..=4).contains(&version) {
        return Err(ReadError::field(path, "version of the file", "1 to 4", version));
    }
    let _distribution = lines.required("how values were distributed")?;
    let components = number(path, lines, "number of components")?;
    let ghosts = ghosts(path, &lines.required("number of ghost cells")?)?;
    let boxes = boxes(path, lines)?;
    let (places, files) = places(path, lines, boxes.len())?;
    let bare = if version == 1 { None } else { Some(real_format(path, lines)?) };
    Ok(MultiFab { components, ghosts, boxes, places, files, bare })
}

fn number<T: std::str::FromStr>(
    path: &Path,
    lines: &mut HeaderLines,
    field: &'static str,
) -> Result<T, ReadError> {
    let line = lines.required(field)?;
    line.trim().parse().map_err(|_| ReadError::field(path, field, "a whole number", line))
}

fn ghosts(path: &Path, line: &str) -> Result<[u32; 3], ReadError> {
    let mut notation = Notation::new(line);
    let each = if notation.rest().starts_with('(') {
        notation.vector::<u32>()
    } else {
        notation.number().map(|n| vec![n; 3])
    };
    let small = each.filter(|v| v.iter().all(|&n| n <= MOST_GHOSTS)).and_then(|v| v.try_into().ok());
    small.ok_or_else(|| {
        ReadError::field(path, "number of ghost cells", "one number, or one for each axis", line)
    })
}

fn boxes(path: &Path, lines: &mut HeaderLines) -> Result<Vec<TypedBox>, ReadError> {
    let head = lines.required("the number of boxes")?;
    let count = head.trim().strip_prefix('(').and_then(|rest| Notation::new(rest).number::<u64>());
    let count = count.ok_or_else(|| ReadError::field(path, "number of boxes", "(N 0", head))?;
    // The file must hold so many lines.
    let mut boxes = Vec::new();
    for _ in 0..count {
        let line = lines.required("a box")?;
        let expected = "a box, ((0,0,0) (15,15,31) (0,0,0))";
        let typed = Notation::new(&line).typed_box();
        boxes.push(typed.ok_or_else(|| ReadError::field(path, "boxes", expected, line))?);
    }
    let end = lines.required("the end of the boxes")?;
    if end.trim() != ")" {
        let expected = "a parenthesis after as many boxes as stated";
        return Err(ReadError::field(path, "boxes", expected, end));
    }
    Ok(boxes)
}

/// Where the values of each box are.
type Places = (Vec<(usize, u64)>, Vec<PathBuf>);

fn places(path: &Path, lines: &mut HeaderLines, count: usize) -> Result<Places, ReadError> {
    let stated: u64 = number(path, lines, "number of FABs")?;
    if stated != count as u64 {
        let expected = format!("one for each of {count} boxes");
        return Err(ReadError::mesh(path, "number of FABs", expected, stated));
    }
    let mut known: HashMap<String, usize> = HashMap::new();
    let (mut places, mut files) = (Vec::new(), Vec::new());
    for _ in 0..count {
        let line = lines.required("FabOnDisk: FILE OFFSET")?;
        let parts = line.trim().strip_prefix("FabOnDisk:").and_then(|rest| rest.rsplit_once(' '));
        let (name, offset) = parts
            .and_then(|(name, offset)| Some((name.trim(), offset.parse().ok()?)))
            .filter(|(name, _)| is_inside(Path::new(name)))
            .ok_or_else(|| ReadError::field(path, "place of a FAB", "FabOnDisk: FILE OFFSET", &line))?;
        let file = *known.entry(name.to_owned()).or_insert_with(|| {
            files.push(path.with_file_name(name));
            files.len() - 1
        });
        places.push((file, offset));
    }
    Ok((places, files))
}

/// The line after the ranges.
fn real_format(path: &Path, lines: &mut HeaderLines) -> Result<RealFormat, ReadError> {
    let expected = "how numbers are written: 32 or 64 bits, IEEE";
    loop {
        let line = lines.required(expected)?;
        if line.trim_start().starts_with("((") {
            let format = Notation::new(&line).real_format();
            return format.ok_or_else(|| ReadError::unsupported(path, "this number format", expected, line));
        }
    }
}
