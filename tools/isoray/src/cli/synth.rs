//! Flags of `isoray synth`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use glam::DVec3;

use super::{parse_dims, parse_threads, parse_triple};

#[derive(Debug, Args)]
pub(crate) struct SynthArgs {
    /// What to make
    #[arg(value_enum)]
    pub(crate) name: SynthName,
    /// Number of samples along x, y and z
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_dims, allow_hyphen_values = true)]
    pub(crate) size: [u32; 3],
    /// Type of a sample
    #[arg(long = "type", value_name = "TYPE", value_enum, default_value = "u8")]
    pub(crate) sample: SynthType,
    /// The file to write: .nrrd, or .raw without a header
    #[arg(short, long, value_name = "OUT.nrrd|OUT.raw")]
    pub(crate) output: PathBuf,
    /// Number of threads [default: all cores]
    #[arg(long, value_name = "N", value_parser = parse_threads)]
    pub(crate) threads: Option<usize>,
    /// mixing, noise: another seed gives another volume of the same kind [default: 0]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub(crate) seed: Option<u64>,
    /// mixing: how far it has come, from 0, an interface with gentle waves, to 1, full turbulence [default: 1]
    #[arg(long, value_name = "T", value_parser = parse_time, allow_negative_numbers = true)]
    pub(crate) time: Option<f64>,
    /// ramp: growth per voxel along x, y and z [default: 1,2,3]
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_triple, allow_hyphen_values = true)]
    pub(crate) direction: Option<DVec3>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum SynthName {
    /// Turbulent mixing of two fluids, 10 below and 240 above (in u16 257 times as much); isovalue 125
    Mixing,
    /// The test signal of Marschner and Lobb, from 0 to 255 (in u16 to 65535); isovalue 127.5
    MarschnerLobb,
    /// Signed distance from a sphere, positive inside: f32 in voxels; integers scaled to the type's range, with the
    /// sphere in the middle
    Sphere,
    /// Linear, from 0 on: integers are exact if --direction is whole and the largest value has room, else scaled to the
    /// type's range
    Ramp,
    /// Random samples, all values of the type alike; f32 from 0 to 255
    Noise,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum SynthType {
    /// Unsigned 8-bit integers
    U8,
    /// Unsigned 16-bit integers
    U16,
    /// 32-bit floating point numbers
    F32,
}

fn parse_time(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(time) if (0.0..=1.0).contains(&time) => Ok(time),
        _ => Err(format!("expected a number from 0 to 1, found '{text}'")),
    }
}
