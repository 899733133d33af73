//! Commands and flags.

mod build;
mod mesh;
mod series;
mod surface;
mod synth;
mod transfer;
mod volume;

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use glam::DVec3;

pub(crate) use build::{BuildArgs, CoarseArg, LevelArgs, LossArgs, Surfaces};
pub(crate) use mesh::MeshArgs;
pub(crate) use series::{StepArgs, Steps};
pub(crate) use surface::{ClipArgs, DistanceArg, IsovalueArg, NormalsArg, SurfaceArgs, TraversalArg};
pub(crate) use synth::{SynthArgs, SynthName, SynthType};
pub(crate) use transfer::{PreviewArgs, TransferArgs, TransferCommand};
pub(crate) use volume::{SchemeArg, ShadingArg, StructureArg, VolumeArgs};

/// Exact pictures of scalar volumes: isosurfaces, and volume rendering with a bounded error.
///
/// isoray compresses a volume losslessly into an octree and traces rays through it: every pixel shows the
/// true surface of the trilinearly interpolated data, or the light that all of it sends, to within a bound.
/// Without a command it renders a bundled CT scan to isoray.png.
#[derive(Debug, Parser)]
#[command(version, max_term_width = 100)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Compress a volume into an octree volume (.ovol), losslessly, or a time series into a folder of them (.ovol.d)
    Build(BuildArgs),
    /// Describe a volume: dimensions, placement, values, sizes; or, with --cpu, this build
    Info(InfoArgs),
    /// Verify an octree volume completely: checksums and every node
    Check(CheckArgs),
    /// Render an isosurface to a picture, or with --volume the volume
    Render(Box<RenderArgs>),
    /// Look at transfer functions: what colour and extinction values have
    #[command(subcommand)]
    Tf(TransferCommand),
    /// Make a volume to try things on: turbulence of any size, test signals, noise
    Synth(SynthArgs),
}

/// What a file does not say of itself, and which of its values are meant.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Input")]
pub(crate) struct InputArgs {
    /// Raw files: number of samples along x, y and z; x is the fastest in the file
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_dims, allow_hyphen_values = true)]
    pub(crate) dims: Option<[u32; 3]>,
    /// Raw files: type of a sample: u8, i8, u16, i16, f32, or u32, i32, u64, i64, f64, which become f32
    #[arg(long = "type", value_name = "TYPE")]
    pub(crate) sample: Option<isoray_io::SampleType>,
    /// Raw files: byte order [default: little]
    #[arg(long, value_enum)]
    pub(crate) endian: Option<Endian>,
    /// Raw files: bytes before the first sample [default: 0]
    #[arg(long, value_name = "N")]
    pub(crate) skip: Option<u64>,
    /// Raw files: distance between samples along x, y and z in world units [default: 1,1,1]
    #[arg(long, value_name = "A,B,C", value_parser = parse_triple, allow_hyphen_values = true)]
    pub(crate) spacing: Option<DVec3>,
    /// Raw files: world position of the first sample [default: 0,0,0]
    #[arg(long, value_name = "A,B,C", value_parser = parse_triple, allow_hyphen_values = true)]
    pub(crate) origin: Option<DVec3>,
    /// Files with several values per sample: which one, from 0
    #[arg(long, value_name = "N")]
    pub(crate) component: Option<usize>,
    /// Files with several arrays or fields: the name of the one to read
    #[arg(long, value_name = "NAME")]
    pub(crate) field: Option<String>,
    /// Adaptive meshes with values at cells: what becomes of the field at the domain's border, where no rule is exact for linear fields and bounded
    /// [default: linear]
    #[arg(long, value_enum)]
    pub(crate) border: Option<BorderArg>,
}

/// A field at the border of the domain.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum BorderArg {
    /// It goes on as inside: exact for linear fields, and possibly beyond all values
    #[default]
    Linear,
    /// It stays within the values, and is flat
    Bounded,
}

impl From<BorderArg> for isoray_amr::Border {
    fn from(border: BorderArg) -> Self {
        match border {
            BorderArg::Linear => Self::Linear,
            BorderArg::Bounded => Self::Bounded,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Endian {
    /// Least significant byte first
    Little,
    /// Most significant byte first
    Big,
}

#[derive(Debug, Args)]
pub(crate) struct InfoArgs {
    /// Octree volume, a series of them (.ovol.d), or any file that `build` reads
    #[arg(required_unless_present = "cpu")]
    pub(crate) file: Option<PathBuf>,
    /// Instead, tell which instruction sets this build uses, and which the machine has
    #[arg(long, conflicts_with = "file")]
    pub(crate) cpu: bool,
    /// Print JSON instead of text
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) source: InputArgs,
}

#[derive(Debug, Args)]
pub(crate) struct CheckArgs {
    /// Octree volume, or a series of them (.ovol.d)
    pub(crate) file: PathBuf,
}

#[derive(Debug, Args)]
pub(crate) struct RenderArgs {
    /// Octree volume, a series of them (.ovol.d, with --step or --steps), or any file that `build` reads (it is then
    /// compressed in memory)
    pub(crate) file: PathBuf,
    /// The picture: .png for looking at, .exr for linear colour, and depth and normals of a surface.
    /// Of a series: %d or %04d becomes the number of the step
    #[arg(short, long, value_name = "OUT.png|OUT.exr")]
    pub(crate) output: PathBuf,
    /// Size of the picture in pixels
    #[arg(long, value_name = "WxH", default_value = "1024x1024", value_parser = parse_size)]
    pub(crate) size: [u32; 2],
    /// Light: its position, or dir: and the direction to it, in world space, or `headlight`, from the eye; may be given several times, which
    /// share the light. A volume has one, from its direction as seen from the centre [default: headlight]
    #[arg(long, value_name = "X,Y,Z|dir:X,Y,Z|headlight", value_parser = parse_light, allow_hyphen_values = true)]
    pub(crate) light: Vec<LightArg>,
    /// What rays go through: the octree, or all samples as an array with ranges of values, or what takes less memory [default: auto]
    #[arg(long, value_enum)]
    pub(crate) structure: Option<StructureArg>,
    /// Background colour of a PNG, linear RGB from 0 to 1 (EXR has none: alpha is 0 there)
    #[arg(long, value_name = "R,G,B", default_value = "0.03,0.03,0.04", value_parser = parse_color, allow_hyphen_values = true)]
    pub(crate) background: DVec3,
    /// Leave the background of a PNG transparent
    #[arg(long)]
    pub(crate) transparent: bool,
    /// Number of threads [default: all cores]
    #[arg(long, value_name = "N", value_parser = parse_threads)]
    pub(crate) threads: Option<usize>,
    /// Render the frame N times; the time told by --stats is their median
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) repeat: u32,
    /// Print times, throughput, work per ray and sizes, or write them to a file as JSON.
    /// Put it after FILE, or the next word is taken for the name of the JSON file
    #[arg(long, value_name = "FILE.json", num_args = 0..=1)]
    pub(crate) stats: Option<Option<PathBuf>>,
    #[command(flatten)]
    pub(crate) steps: StepArgs,
    #[command(flatten)]
    pub(crate) surface: SurfaceArgs,
    #[command(flatten)]
    pub(crate) clip: ClipArgs,
    #[command(flatten)]
    pub(crate) volume: VolumeArgs,
    #[command(flatten)]
    pub(crate) transfer: TransferArgs,
    #[command(flatten)]
    pub(crate) mesh: MeshArgs,
    #[command(flatten)]
    pub(crate) camera: CameraArgs,
    #[command(flatten)]
    pub(crate) source: InputArgs,
}

/// Without any of these the whole volume is framed.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Camera (world space; by default the whole volume is framed)")]
pub(crate) struct CameraArgs {
    /// Position of the eye [default: as far away as shows the whole volume]
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_triple, allow_hyphen_values = true)]
    pub(crate) eye: Option<DVec3>,
    /// The point in the middle of the picture [default: the volume's centre]
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_triple, allow_hyphen_values = true)]
    pub(crate) look_at: Option<DVec3>,
    /// Direction that is up in the picture
    #[arg(long, value_name = "X,Y,Z", default_value = "0,0,1", value_parser = parse_triple, allow_hyphen_values = true)]
    pub(crate) up: DVec3,
    /// Perspective: angle from the lower to the upper edge of the picture, in degrees
    #[arg(long, value_name = "DEG", default_value_t = 45.0, allow_negative_numbers = true)]
    pub(crate) fov: f64,
    /// Orthographic instead of perspective: height of the picture in world units
    #[arg(long, value_name = "H", conflicts_with = "fov", allow_negative_numbers = true)]
    pub(crate) ortho_height: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum LightArg {
    Headlight,
    Point(DVec3),
    Direction(DVec3),
}

fn parse_numbers<T: std::str::FromStr>(text: &str, separator: char, what: &str) -> Result<Vec<T>, String> {
    let parse = |part: &str| part.trim().parse().map_err(|_| format!("expected {what}, found '{text}'"));
    text.split(separator).map(parse).collect()
}

fn parse_triple(text: &str) -> Result<DVec3, String> {
    const WHAT: &str = "three numbers separated by commas, like 1,2.5,-3";
    match parse_numbers(text, ',', WHAT)?[..] {
        [x, y, z] if [x, y, z].iter().all(|c: &f64| c.is_finite()) => Ok(DVec3::new(x, y, z)),
        _ => Err(format!("expected {WHAT}, found '{text}'")),
    }
}

fn parse_dims(text: &str) -> Result<[u32; 3], String> {
    const WHAT: &str = "three whole numbers separated by commas, like 256,256,128";
    parse_numbers(text, ',', WHAT)?.try_into().map_err(|_| format!("expected {WHAT}, found '{text}'"))
}

fn parse_size(text: &str) -> Result<[u32; 2], String> {
    const WHAT: &str = "width and height in pixels, like 1024x768";
    parse_numbers(text, 'x', WHAT)?.try_into().map_err(|_| format!("expected {WHAT}, found '{text}'"))
}

fn parse_color(text: &str) -> Result<DVec3, String> {
    let color = parse_triple(text)?;
    let is_color = color.to_array().iter().all(|c| (0.0..=1.0).contains(c));
    if is_color { Ok(color) } else { Err(format!("expected three numbers from 0 to 1, found '{text}'")) }
}

fn parse_light(text: &str) -> Result<LightArg, String> {
    if text == "headlight" {
        return Ok(LightArg::Headlight);
    }
    match text.strip_prefix("dir:") {
        Some(direction) => match parse_triple(direction)? {
            DVec3::ZERO => Err(format!("expected a direction that is not zero, found '{text}'")),
            direction => Ok(LightArg::Direction(direction)),
        },
        None => {
            let or = |e| format!("{e}; or dir: before them; or the word headlight");
            parse_triple(text).map(LightArg::Point).map_err(or)
        }
    }
}

fn parse_threads(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(n) if (1..=4096).contains(&n) => Ok(n),
        _ => Err(format!("expected a whole number from 1 to 4096, found '{text}'")),
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn flags_are_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn numbers_with_a_leading_minus() {
        let args = ["isoray", "render", "a.nrrd", "--eye", "-10,5,3", "--isovalue", "-300", "-o", "a.png"];
        let Some(Command::Render(args)) = Cli::try_parse_from(args).unwrap().command else { panic!() };
        assert_eq!(args.camera.eye, Some(DVec3::new(-10.0, 5.0, 3.0)));
        assert_eq!(args.surface.isovalue[0].value, -300.0);
    }

    #[test]
    fn stats_with_and_without_a_file() {
        let parse = |extra: &[&str]| {
            let args = [&["isoray", "render", "a.nrrd", "-o", "a.png"], extra].concat();
            let Some(Command::Render(args)) = Cli::try_parse_from(args).unwrap().command else { panic!() };
            args.stats
        };
        assert_eq!(parse(&[]), None);
        assert_eq!(parse(&["--stats"]), Some(None));
        assert_eq!(parse(&["--stats", "s.json"]), Some(Some("s.json".into())));
    }

    #[test]
    fn malformed_values_say_what_was_expected() {
        assert!(parse_triple("1,2").unwrap_err().contains("three numbers"));
        assert!(parse_triple("1,nan,2").is_err());
        assert!(parse_size("1024").unwrap_err().contains("1024x768"));
        assert!(parse_dims("4,-1,3").unwrap_err().contains("whole numbers"));
        assert!(parse_color("2,0,0").is_err());
    }
}
