//! Flags of `isoray build`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::{InputArgs, parse_threads};
use crate::memory::parse_bytes;

#[derive(Debug, Args)]
pub(crate) struct BuildArgs {
    /// Volume to read: NRRD, MetaImage, NIfTI, VTK image data (.vti, .vtk), NumPy (.npy), TIFF (a file of many
    /// pages or a folder of slices), or a raw file with --dims and --type.
    /// Several make a series: a list, a pattern with * or ?, or one like step_%04d.raw for the numbers that exist;
    /// the order is that of the numbers in their names. TIFF files with one page each make a volume
    #[arg(required = true, value_name = "INPUT")]
    pub(crate) inputs: Vec<PathBuf>,
    /// The octree volume to write, or the folder of a series of them. Steps that are there already, undamaged and built
    /// from the same inputs with the same flags, are kept
    #[arg(short, long, value_name = "OUT.ovol|OUT.ovol.d")]
    pub(crate) output: PathBuf,
    /// Number of threads [default: all cores]
    #[arg(long, value_name = "N", value_parser = parse_threads)]
    pub(crate) threads: Option<usize>,
    /// Most memory to use, like 2GiB or 500MB [default: a quarter of the machine's]
    #[arg(long, value_name = "LIMIT", value_parser = parse_bytes)]
    pub(crate) memory: Option<u64>,
    #[command(flatten)]
    pub(crate) loss: LossArgs,
    #[command(flatten)]
    pub(crate) levels: LevelArgs,
    #[command(flatten)]
    pub(crate) source: InputArgs,
}

/// What may be lost. Without these flags the volume is stored losslessly.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Loss (none by default; bounds given together all hold)")]
pub(crate) struct LossArgs {
    /// Most that a sample may be off, in the data's units
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    pub(crate) tolerance: Option<f64>,
    /// Most that isosurfaces may be displaced, in voxels; 0 keeps them exactly, and so much for all other values may change.
    /// Needs --surfaces
    #[arg(long, value_name = "D", requires = "surfaces", allow_negative_numbers = true)]
    pub(crate) surface_tolerance: Option<f64>,
    /// The isovalues meant by --surface-tolerance: a list, or all from one to another
    #[arg(long, value_name = "V,V,...|LO:HI", requires = "surface_tolerance", allow_hyphen_values = true, value_parser = parse_surfaces)]
    pub(crate) surfaces: Option<Surfaces>,
    /// Values that matter: samples from LO to HI and all isosurfaces of such values are kept exactly, and what is
    /// outside is clamped where no such surface can feel it
    #[arg(long, value_name = "LO:HI", allow_hyphen_values = true, value_parser = parse_range)]
    pub(crate) range: Option<[f64; 2]>,
}

/// Coarse samples.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Levels of detail")]
pub(crate) struct LevelArgs {
    /// Where coarse samples come from [default: injected]
    #[arg(long, value_name = "KIND", value_enum)]
    pub(crate) lod: Option<CoarseArg>,
    /// No levels of detail
    #[arg(long, conflicts_with = "lod")]
    pub(crate) no_lod: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum CoarseArg {
    /// The sample at the same place: takes no room, displaces no surface
    Injected,
    /// The mean of the children's at the low corner, as in the papers: displaces surfaces by up to half a coarse voxel
    Mean,
    /// A mean of 27 samples around the same place: smoother
    Filtered,
}

/// Isovalues.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Surfaces {
    List(Vec<f32>),
    Range([f32; 2]),
}

fn parse_range(text: &str) -> Result<[f64; 2], String> {
    let wrong = || format!("expected two numbers in ascending order like 10:200, found '{text}'");
    let (low, high) = text.split_once(':').ok_or_else(wrong)?;
    match [low, high].map(|end| end.trim().parse::<f64>()) {
        [Ok(low), Ok(high)] if low <= high => Ok([low, high]),
        _ => Err(wrong()),
    }
}

fn parse_surfaces(text: &str) -> Result<Surfaces, String> {
    if text.contains(':') {
        return parse_range(text).map(|ends| Surfaces::Range(ends.map(|end| end as f32)));
    }
    let wrong = || format!("expected isovalues like 42,100 or a range like 10:200, found '{text}'");
    let parsed = text.split(',').map(|v| v.trim().parse::<f32>().ok().filter(|v| v.is_finite()));
    parsed.collect::<Option<Vec<_>>>().map(Surfaces::List).ok_or_else(wrong)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn surfaces_and_ranges() {
        assert_eq!(parse_surfaces("42, -1.5"), Ok(Surfaces::List(vec![42.0, -1.5])));
        assert_eq!(parse_surfaces("-300:250"), Ok(Surfaces::Range([-300.0, 250.0])));
        assert_eq!(parse_range("1:1"), Ok([1.0, 1.0]));
        for wrong in ["", "a", "1,", "2:1", "1:nan", "nan", "1:2:3"] {
            assert!(parse_surfaces(wrong).unwrap_err().contains("expected"), "{wrong}");
        }
    }
}
