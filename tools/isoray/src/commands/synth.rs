//! `isoray synth`.

use std::io::{self, Write};
use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result, anyhow};
use isoray_grid::{Dims, ScalarType, SlabSource};
use isoray_synth::{LayersError, MarschnerLobb, Mixing, MixingParams, Noise, Ramp, Sample, Sphere};
use rayon::prelude::*;
use zerocopy::IntoBytes;

use super::{bytes, use_threads};
use crate::cli::{SynthArgs, SynthName, SynthType};
use crate::failure::usage;
use crate::output::{check_output, to_stdout, write_stream};
use crate::progress::Progress;

/// What one slab takes at most, but for single layers that take more.
const SLAB_BYTES: usize = 32 << 20;
/// Layers of a slab at most: the bar should move, and more gain nothing.
const SLAB_LAYERS: usize = 64;
/// What a layer takes at most: two are held, and a system may promise more memory than it has.
const MOST_LAYER_BYTES: u64 = 8 << 30;

pub(crate) fn run(args: &SynthArgs) -> Result<()> {
    let format = Format::of(&args.output)?;
    refuse_idle_flags(args)?;
    let dims = Dims::new(args.size).map_err(|e| usage(format!("--size: {e}")))?;
    let layer = dims.layer() as u64 * scalar(args.sample).size() as u64;
    if layer > MOST_LAYER_BYTES {
        return Err(usage(format!(
            "--size: a layer of {dims} takes {}: expected at most {}",
            bytes(layer),
            bytes(MOST_LAYER_BYTES)
        )));
    }
    use_threads(args.threads)?;
    check_output(&args.output, &[])?;
    match args.sample {
        SynthType::U8 => make::<u8>(args, dims, format),
        SynthType::U16 => make::<u16>(args, dims, format),
        SynthType::F32 => make::<f32>(args, dims, format),
    }
}

fn scalar(sample: SynthType) -> ScalarType {
    match sample {
        SynthType::U8 => ScalarType::U8,
        SynthType::U16 => ScalarType::U16,
        SynthType::F32 => ScalarType::F32,
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Format {
    Raw,
    Nrrd,
}

impl Format {
    fn of(output: &Path) -> Result<Self> {
        match output.extension() {
            Some(e) if e.eq_ignore_ascii_case("raw") => Ok(Self::Raw),
            Some(e) if e.eq_ignore_ascii_case("nrrd") => Ok(Self::Nrrd),
            _ => Err(usage(format!(
                "--output {}: expected a name that ends in .nrrd or .raw",
                output.display()
            ))),
        }
    }
}

/// Refuses flags that the volume does not depend on.
fn refuse_idle_flags(args: &SynthArgs) -> Result<()> {
    use SynthName::{Mixing, Noise, Ramp};
    let flags = [
        ("--seed", args.seed.is_some(), &[Mixing, Noise][..]),
        ("--time", args.time.is_some(), &[Mixing]),
        ("--direction", args.direction.is_some(), &[Ramp]),
    ];
    for (flag, is_given, users) in flags {
        if is_given && !users.contains(&args.name) {
            let users: Vec<&str> = users.iter().map(|&user| word(user)).collect();
            return Err(usage(format!("{flag}: {} has none, only {}", word(args.name), users.join(" and "))));
        }
    }
    Ok(())
}

/// The name as it is written on the command line.
fn word(name: SynthName) -> &'static str {
    match name {
        SynthName::Mixing => "mixing",
        SynthName::MarschnerLobb => "marschner-lobb",
        SynthName::Sphere => "sphere",
        SynthName::Ramp => "ramp",
        SynthName::Noise => "noise",
    }
}

fn make<T: Sample>(args: &SynthArgs, dims: Dims, format: Format) -> Result<()> {
    let seed = args.seed.unwrap_or(0);
    match args.name {
        SynthName::Mixing => {
            let params = MixingParams { seed, time: args.time.unwrap_or(1.0) };
            let source = Mixing::new(dims, params).map_err(|e| usage(format!("--time: {e}")))?;
            write::<T>(args, format, source)
        }
        SynthName::MarschnerLobb => write::<T>(args, format, MarschnerLobb::new(dims)),
        SynthName::Sphere => write::<T>(args, format, Sphere::new(dims)),
        SynthName::Ramp => {
            let direction = args.direction.map_or(Ramp::DIRECTION, |d| d.to_array());
            let source = Ramp::new(dims, direction).map_err(|e| usage(format!("--direction: {e}")))?;
            write::<T>(args, format, source)
        }
        SynthName::Noise => write::<T>(args, format, Noise::new(dims, seed)),
    }
}

/// Writes the file and tells of it.
fn write<T: Sample>(
    args: &SynthArgs,
    format: Format,
    mut source: impl SlabSource<T, Error = LayersError> + Send,
) -> Result<()> {
    let begin = Instant::now();
    let dims = source.dims();
    let output = args.output.display();
    let mut slabs = Slabs::new(dims).ok_or_else(|| {
        let layer = bytes((dims.layer() * size_of::<T>()) as u64);
        anyhow!("{output}: cannot be made: expected memory for two layers of {dims}, {layer} each")
    })?;
    write_stream(&args.output, |file| {
        if format == Format::Nrrd {
            file.write_all(header(T::TYPE, dims).as_bytes())?;
        }
        slabs.stream(&mut source, file)
    })
    .with_context(|| format!("{output}: cannot be written"))?;
    let seconds = begin.elapsed().as_secs_f64();
    let size = bytes((dims.samples() * size_of::<T>()) as u64);
    let rate = dims.samples() as f64 / seconds / 1e6;
    to_stdout(|out| {
        writeln!(
            out,
            "{output}: {dims} {} samples, {size}, {seconds:.2} s, {rate:.1} million voxels/s",
            T::TYPE
        )?;
        if format == Format::Raw {
            let [x, y, z] = dims.axes();
            writeln!(
                out,
                "A raw file says nothing of itself. Read it with --dims {x},{y},{z} --type {}",
                T::TYPE
            )?;
        }
        Ok(())
    })
}

fn header(scalar: ScalarType, dims: Dims) -> String {
    let [x, y, z] = dims.axes();
    let name = match scalar {
        ScalarType::U8 => "uint8",
        ScalarType::I8 => "int8",
        ScalarType::U16 => "uint16",
        ScalarType::I16 => "int16",
        ScalarType::F32 => "float",
    };
    format!("NRRD0004\ntype: {name}\ndimension: 3\nsizes: {x} {y} {z}\nendian: little\nencoding: raw\n\n")
}

/// Two slabs of samples: while one is written, the next is made in the other.
struct Slabs<T> {
    dims: Dims,
    slabs: [Vec<T>; 2],
}

impl<T: Sample> Slabs<T> {
    /// Nothing if there is no memory for them.
    fn new(dims: Dims) -> Option<Self> {
        let layers = (SLAB_BYTES / size_of::<T>() / dims.layer()).clamp(1, SLAB_LAYERS);
        let length = layers.min(dims.axes()[2] as usize) * dims.layer();
        let mut slabs = [Vec::new(), Vec::new()];
        for slab in &mut slabs {
            slab.try_reserve_exact(length).ok()?;
            slab.resize(length, T::default());
        }
        Some(Self { dims, slabs })
    }

    /// Writes the samples of `source`, little-endian.
    fn stream<S>(&mut self, source: &mut S, out: &mut (impl Write + Send)) -> io::Result<()>
    where
        S: SlabSource<T, Error = LayersError> + Send,
    {
        let mut bar = Progress::new("making");
        let layer = self.dims.layer();
        let layers = self.dims.axes()[2];
        let [made, next] = &mut self.slabs;
        let mut ready = 0; // Samples in `made`.
        let mut first = 0;
        while first < layers || ready > 0 {
            let count = (next.len() / layer).min((layers - first) as usize);
            let (written, read) = rayon::join(
                || write_samples(&made[..ready], out),
                || source.read_layers(first, &mut next[..count * layer]),
            );
            written?;
            read.map_err(io::Error::other)?;
            std::mem::swap(made, next);
            ready = count * layer;
            first += count as u32;
            bar.update(first.into(), layers.into());
        }
        Ok(())
    }
}

fn write_samples<T: Sample>(samples: &[T], out: &mut impl Write) -> io::Result<()> {
    if cfg!(target_endian = "little") {
        out.write_all(samples.as_bytes())
    } else {
        let stored: Vec<T::Stored> = samples.par_iter().map(|&sample| sample.into()).collect();
        out.write_all(stored.as_bytes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A disk with so many bytes left.
    struct Disk(usize);

    impl Write for Disk {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            match bytes.len().min(self.0) {
                0 => Err(io::ErrorKind::StorageFull.into()),
                n => {
                    self.0 -= n;
                    Ok(n)
                }
            }
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_full_disk_is_an_error_wherever_it_fills() {
        // Slabs of 64 layers.
        let dims = Dims::new([3, 2, 150]).unwrap();
        let stream =
            |bytes| Slabs::<u16>::new(dims).unwrap().stream(&mut Noise::new(dims, 0), &mut Disk(bytes));
        for bytes in [0, 1, 767, 768, 1799] {
            assert_eq!(stream(bytes).unwrap_err().kind(), io::ErrorKind::StorageFull, "{bytes}");
        }
        stream(1800).unwrap();
    }
}
