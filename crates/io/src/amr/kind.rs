//! Telling meshes of several levels from other files.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use crate::decode::{fill, open_at};
use crate::vtk::{hierarchy, image_data, legacy};

/// First words of a plotfile's `Header`; a version follows.
pub(super) const PLOTFILE_MAGIC: [&str; 2] = ["HyperCLaw-V", "NavierStokes-V"];
/// Bytes that tell the format of a file: VTK's comment line has at most 256.
const HEAD: usize = 1024;

/// The formats of meshes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// The folder with the `Header`.
    Plotfile(PathBuf),
    Hierarchy,
    Hexahedra,
    Enzo,
    Ramses,
}

/// The format of the mesh at `path`, if there is one.
pub(super) fn kind(path: &Path) -> Option<Kind> {
    if path.is_dir() { folder(path) } else { file(path) }
}

fn folder(path: &Path) -> Option<Kind> {
    let header = path.join("Header");
    if header.is_file() && (is_plotfile(&head(&header)?) || path.join("Level_0").is_dir()) {
        return Some(Kind::Plotfile(path.to_owned()));
    }
    let names = std::fs::read_dir(path).ok()?.filter_map(|entry| Some(entry.ok()?.file_name()));
    let mut ramses = [false; 2];
    for name in names {
        let name = name.to_string_lossy();
        if name.ends_with(".hierarchy") {
            return Some(Kind::Enzo);
        }
        ramses[0] |= is_info(&name);
        ramses[1] |= name.starts_with("amr_") && name.contains(".out");
    }
    (ramses == [true; 2]).then_some(Kind::Ramses)
}

fn file(path: &Path) -> Option<Kind> {
    let head = head(path)?;
    let text = String::from_utf8_lossy(&head);
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    if is_plotfile(&head) {
        // The folder of a name alone is the current one.
        let folder = path.parent().filter(|p| *p != Path::new("")).unwrap_or(Path::new("."));
        return Some(Kind::Plotfile(folder.to_owned()));
    }
    if image_data::is_header(&head) {
        return hierarchy::TYPES.iter().any(|t| text.contains(t)).then_some(Kind::Hierarchy);
    }
    if head.starts_with(legacy::MAGIC) {
        return text.to_ascii_uppercase().contains("UNSTRUCTURED_GRID").then_some(Kind::Hexahedra);
    }
    if is_info(&name) && text.trim_start().starts_with("ncpu") {
        return Some(Kind::Ramses);
    }
    let is_hierarchy = path.extension() == Some(OsStr::new("hierarchy")) && text.contains("GridRank");
    // The parameters of a run lie beside its hierarchy.
    let mut beside = path.as_os_str().to_owned();
    beside.push(".hierarchy");
    (is_hierarchy || Path::new(&beside).is_file()).then_some(Kind::Enzo)
}

fn is_plotfile(head: &[u8]) -> bool {
    PLOTFILE_MAGIC.iter().any(|magic| head.starts_with(magic.as_bytes()))
}

/// Whether a file is called like RAMSES's `info_00004.txt`.
fn is_info(name: &str) -> bool {
    name.strip_prefix("info_").is_some_and(|rest| rest.ends_with(".txt"))
}

fn head(path: &Path) -> Option<Vec<u8>> {
    let mut head = vec![0; HEAD];
    let (n, result) = fill(&mut open_at(path, 0).ok()?, &mut head);
    result.ok()?;
    head.truncate(n);
    Some(head)
}
