//! Image writers; a file appears under its name only when it is complete.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, SmallVec, WritableImage,
};
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use isoray_grid::{OutputFile, folder_of};

/// Why an image could not be written; no file is left behind then.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// An image without pixels, or larger than its format can hold.
    #[error("{}: expected an image of 1 to {MAX_SIDE} pixels a side, found {width}x{height}", path.display())]
    Size {
        /// The file.
        path: PathBuf,
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
    },
    /// A slice that does not hold one value per pixel and channel.
    #[error("{}: {channel}: expected {expected} values, found {found}", path.display())]
    Length {
        /// The file.
        path: PathBuf,
        /// Name of the channel or pixel format.
        channel: String,
        /// Values of an image of this size.
        expected: u64,
        /// Values in the slice.
        found: usize,
    },
    /// No channel, two of one name, or a name that the format cannot hold.
    #[error("{}: expected channels of distinct names, found {found}", path.display())]
    Channels {
        /// The file.
        path: PathBuf,
        /// The names given.
        found: String,
    },
    /// The folder of the output is missing or cannot be written to.
    #[error("{}: expected a folder to write into, found {} to be none", path.display(), folder.display())]
    Folder {
        /// The file.
        path: PathBuf,
        /// Its folder.
        folder: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
    /// The image could not be encoded or written.
    #[error("{}: cannot write the image", path.display())]
    Encode {
        /// The file.
        path: PathBuf,
        /// What the encoder says.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// The complete file could not be given its name.
    #[error("{}: cannot move the complete image to its name", path.display())]
    Rename {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
}

/// Largest width or height in pixels; both formats count with signed 32-bit integers.
const MAX_SIDE: u32 = i32::MAX as u32;

/// 8-bit pixels, row 0 at the top.
#[derive(Clone, Copy, Debug)]
pub enum PixelData<'a> {
    /// Three bytes a pixel: red, green, blue, sRGB-encoded.
    Rgb8(&'a [u8]),
    /// Four bytes a pixel: red, green, blue, sRGB-encoded, and alpha, not premultiplied.
    Rgba8(&'a [u8]),
}

/// One channel of an EXR image, row 0 at the top.
#[derive(Clone, Copy, Debug)]
pub struct ExrChannel<'a> {
    /// Name, for instance `R`, `Z` or `N.X`.
    pub name: &'a str,
    /// One value per pixel; NaN and infinities are kept.
    pub data: &'a [f32],
}

/// Writes an 8-bit PNG of `width` × `height` pixels to `path`, replacing a file of that name.
///
/// # Errors
/// A slice of the wrong length, or a file that cannot be written; nothing is left behind then.
pub fn write_png(path: &Path, width: u32, height: u32, pixels: PixelData<'_>) -> Result<(), WriteError> {
    let (bytes, colour, name, per_pixel) = match pixels {
        PixelData::Rgb8(bytes) => (bytes, ExtendedColorType::Rgb8, "RGB", 3),
        PixelData::Rgba8(bytes) => (bytes, ExtendedColorType::Rgba8, "RGBA", 4),
    };
    check_size(path, width, height)?;
    check_length(path, name, u64::from(width) * u64::from(height) * per_pixel, bytes.len())?;
    replace(path, |file| Ok(PngEncoder::new(file).write_image(bytes, width, height, colour)?))
}

/// Writes an EXR of `width` × `height` pixels to `path`, replacing a file of that name: 32-bit floating
/// point, lossless (ZIP) compression.
///
/// # Errors
/// Channels of the wrong length or of equal names, or a file that cannot be written; nothing is left behind
/// then.
pub fn write_exr(
    path: &Path,
    width: u32,
    height: u32,
    channels: &[ExrChannel<'_>],
) -> Result<(), WriteError> {
    check_size(path, width, height)?;
    let pixels = u64::from(width) * u64::from(height);
    for channel in channels {
        check_length(path, channel.name, pixels, channel.data.len())?;
    }
    check_names(path, channels)?;
    let list: SmallVec<_> =
        channels.iter().map(|c| AnyChannel::new(c.name, FlatSamples::F32(c.data.to_vec()))).collect();
    let layer = Layer::new(
        (width as usize, height as usize),
        LayerAttributes::default(),
        Encoding::SMALL_LOSSLESS,
        AnyChannels::sort(list),
    );
    let image = Image::from_layer(layer);
    replace(path, |file| Ok(image.write().non_parallel().to_buffered(file)?))
}

/// Longest channel name that every reader of the format takes.
const MAX_NAME: usize = 31;

fn check_size(path: &Path, width: u32, height: u32) -> Result<(), WriteError> {
    let sides = 1..=MAX_SIDE;
    if sides.contains(&width) && sides.contains(&height) {
        Ok(())
    } else {
        Err(WriteError::Size { path: path.to_owned(), width, height })
    }
}

fn check_length(path: &Path, channel: &str, expected: u64, found: usize) -> Result<(), WriteError> {
    if expected == found as u64 {
        Ok(())
    } else {
        Err(WriteError::Length { path: path.to_owned(), channel: channel.to_owned(), expected, found })
    }
}

fn check_names(path: &Path, channels: &[ExrChannel<'_>]) -> Result<(), WriteError> {
    let mut names: Vec<&str> = channels.iter().map(|c| c.name).collect();
    names.sort_unstable();
    let legal = names.iter().all(|n| (1..=MAX_NAME).contains(&n.len()) && n.is_ascii() && !n.contains('\0'));
    if legal && !names.is_empty() && names.windows(2).all(|pair| pair[0] != pair[1]) {
        Ok(())
    } else {
        Err(WriteError::Channels { path: path.to_owned(), found: format!("{names:?}") })
    }
}

/// What an encoder says.
type Cause = Box<dyn std::error::Error + Send + Sync>;

/// Writes a temporary file in the folder of `path`, then renames it to `path`; on an error it is removed.
fn replace(
    path: &Path,
    encode: impl FnOnce(&mut BufWriter<&mut File>) -> Result<(), Cause>,
) -> Result<(), WriteError> {
    let mut file = OutputFile::create(path).map_err(|source| WriteError::Folder {
        path: path.to_owned(),
        folder: folder_of(path).to_owned(),
        source,
    })?;
    let mut writer = BufWriter::new(file.file());
    let written = encode(&mut writer).and_then(|()| {
        writer.flush()?;
        Ok(())
    });
    drop(writer);
    written.map_err(|source| WriteError::Encode { path: path.to_owned(), source })?;
    file.commit().map_err(|source| WriteError::Rename { path: path.to_owned(), source })
}
