//! NIfTI-1 and NIfTI-2: one file, gzip or not, or a pair of `.hdr` and `.img`.
//!
//! Definition of the formats: <https://nifti.nimh.nih.gov/nifti-1> and <https://nifti.nimh.nih.gov/nifti-2>.

use std::path::{Path, PathBuf};

use glam::DAffine3;
use zerocopy::byteorder::{F32, F64, I16, I32, I64};
use zerocopy::{BigEndian, ByteOrder, FromBytes, Immutable, KnownLayout, LittleEndian, Unaligned};

use crate::coding::Coding;
use crate::dataset::Header;
use crate::error::{ReadError, Warning};
use crate::layout::{Layout, Order, Start, dims};
use crate::nifti_world::{Transforms, world};
use crate::sample::{Endian, SampleType, Scale};

/// Name of the formats.
pub(crate) const FORMAT: &str = "NIfTI";
/// Length of a NIfTI-1 header, which is its first field.
const NIFTI1_BYTES: usize = 348;
/// Length of a NIfTI-2 header, which is its first field.
pub(crate) const NIFTI2_BYTES: usize = 540;
/// Bytes after the header that tell of extensions; samples in the same file come after them.
const EXTENDER_BYTES: u64 = 4;

/// The header of NIfTI-1, unused fields left out of view.
#[derive(FromBytes, KnownLayout, Immutable, Unaligned)]
#[repr(C)]
struct Nifti1<O: ByteOrder> {
    sizeof_hdr: I32<O>,
    _unused0: [u8; 36],
    dim: [I16<O>; 8],
    _intent: [u8; 14],
    datatype: I16<O>,
    _bitpix: I16<O>,
    _slice_start: I16<O>,
    pixdim: [F32<O>; 8],
    vox_offset: F32<O>,
    scl_slope: F32<O>,
    scl_inter: F32<O>,
    _unused1: [u8; 132],
    qform_code: I16<O>,
    sform_code: I16<O>,
    quatern: [F32<O>; 3],
    qoffset: [F32<O>; 3],
    srow: [[F32<O>; 4]; 3],
    _intent_name: [u8; 16],
    magic: [u8; 4],
}

/// The header of NIfTI-2, unused fields left out of view.
#[derive(FromBytes, KnownLayout, Immutable, Unaligned)]
#[repr(C)]
struct Nifti2<O: ByteOrder> {
    sizeof_hdr: I32<O>,
    magic: [u8; 8],
    datatype: I16<O>,
    _bitpix: I16<O>,
    dim: [I64<O>; 8],
    _intent: [u8; 24],
    pixdim: [F64<O>; 8],
    vox_offset: I64<O>,
    scl_slope: F64<O>,
    scl_inter: F64<O>,
    _unused0: [u8; 152],
    qform_code: I32<O>,
    sform_code: I32<O>,
    quatern: [F64<O>; 3],
    qoffset: [F64<O>; 3],
    srow: [[F64<O>; 4]; 3],
    _unused1: [u8; 44],
}

const _: () = assert!(size_of::<Nifti1<LittleEndian>>() == NIFTI1_BYTES);
const _: () = assert!(size_of::<Nifti2<LittleEndian>>() == NIFTI2_BYTES);

/// What both headers say.
struct Fields {
    format: &'static str,
    endian: Endian,
    /// Samples are in the same file.
    single: bool,
    header_bytes: u64,
    dim: [i64; 8],
    datatype: i16,
    vox_offset: f64,
    slope: f64,
    intercept: f64,
    transforms: Transforms,
}

/// Whether `head` begins with a header of either version, in either byte order.
pub(crate) fn is_header(head: &[u8]) -> bool {
    fields(head).is_some()
}

/// Reads the fields, if this is a header.
fn fields(head: &[u8]) -> Option<Fields> {
    nifti1::<LittleEndian>(head, Endian::Little)
        .or_else(|| nifti1::<BigEndian>(head, Endian::Big))
        .or_else(|| nifti2::<LittleEndian>(head, Endian::Little))
        .or_else(|| nifti2::<BigEndian>(head, Endian::Big))
}

fn nifti1<O: ByteOrder>(head: &[u8], endian: Endian) -> Option<Fields> {
    let (h, _) = Nifti1::<O>::ref_from_prefix(head).ok()?;
    let single = match &h.magic {
        b"n+1\0" => true,
        b"ni1\0" => false,
        _ => return None,
    };
    (usize::try_from(h.sizeof_hdr.get()) == Ok(NIFTI1_BYTES)).then(|| Fields {
        format: "NIfTI-1",
        endian,
        single,
        header_bytes: NIFTI1_BYTES as u64,
        dim: h.dim.map(|d| d.get().into()),
        datatype: h.datatype.get(),
        vox_offset: h.vox_offset.get().into(),
        slope: h.scl_slope.get().into(),
        intercept: h.scl_inter.get().into(),
        transforms: Transforms {
            pixdim: std::array::from_fn(|i| h.pixdim[i].get().into()),
            qform_code: h.qform_code.get().into(),
            sform_code: h.sform_code.get().into(),
            quatern: h.quatern.map(|v| v.get().into()),
            qoffset: h.qoffset.map(|v| v.get().into()),
            srow: h.srow.map(|row| row.map(|v| v.get().into())),
        },
    })
}

fn nifti2<O: ByteOrder>(head: &[u8], endian: Endian) -> Option<Fields> {
    let (h, _) = Nifti2::<O>::ref_from_prefix(head).ok()?;
    // The rest of the magic reveals line ends that a text transfer has changed.
    let single = match &h.magic {
        b"n+2\0\r\n\x1a\n" => true,
        b"ni2\0\r\n\x1a\n" => false,
        _ => return None,
    };
    (usize::try_from(h.sizeof_hdr.get()) == Ok(NIFTI2_BYTES)).then(|| Fields {
        format: "NIfTI-2",
        endian,
        single,
        header_bytes: NIFTI2_BYTES as u64,
        dim: h.dim.map(|d| d.get()),
        datatype: h.datatype.get(),
        // Beyond 2^53 no file has its samples.
        vox_offset: h.vox_offset.get() as f64,
        slope: h.scl_slope.get(),
        intercept: h.scl_inter.get(),
        transforms: Transforms {
            pixdim: std::array::from_fn(|i| h.pixdim[i].get()),
            qform_code: h.qform_code.get(),
            sform_code: h.sform_code.get(),
            quatern: h.quatern.map(|v| v.get()),
            qoffset: h.qoffset.map(|v| v.get()),
            srow: h.srow.map(|row| row.map(|v| v.get())),
        },
    })
}

/// Reads a header from `head`, the first (decompressed, if `gzip`) bytes of `path`.
pub(crate) fn header(path: &Path, head: &[u8], gzip: bool) -> Result<Header, ReadError> {
    let Some(fields) = fields(head) else {
        if head.len() < NIFTI1_BYTES {
            let (expected, found) = ("a NIfTI header of 348 or 540 bytes", head.len() as u64);
            return Err(ReadError::ShortHeader { path: path.to_owned(), expected, found });
        }
        let expected = "348 and n+1 or ni1 at byte 344, or 540 and n+2 or ni2 at byte 4";
        let found = format!("length {:02x?}, {:02x?} and {:02x?}", &head[..4], &head[344..347], &head[4..7]);
        return Err(ReadError::field(path, "header length and magic", expected, found));
    };
    let (sizes, components) = sizes(path, &fields.dim)?;
    let sample = sample_type(path, fields.datatype)?;
    let (data, gzip) = if fields.single { (path.to_owned(), gzip) } else { image_file(path)? };
    let mut layout = Layout::new(dims(path, sizes)?, sample, fields.endian, data);
    layout.components = components;
    layout.order = Order::Planar;
    layout.scale = scale(fields.slope, fields.intercept);
    let offset = offset(path, &fields)?;
    if gzip {
        layout.coding = Coding::Deflate;
        layout.stream_skip = offset;
    } else {
        layout.start = Start::At(offset);
    }
    let mut warnings = Vec::new();
    layout.index_to_world = index_to_world(path, &fields.transforms, &mut warnings);
    Ok(Header { format: fields.format, layout, warnings })
}

/// The three sizes of space, and the product of those of time and vectors.
fn sizes(path: &Path, dim: &[i64; 8]) -> Result<([u64; 3], u64), ReadError> {
    const SPACE: usize = 3;
    let axes = usize::try_from(dim[0]).ok().filter(|n| (1..dim.len()).contains(n));
    let axes = axes.ok_or_else(|| ReadError::field(path, "dim[0]", "a number of axes, 1 to 7", dim[0]))?;
    if axes < SPACE {
        return Err(ReadError::unsupported(path, "this number of axes", "dim[0] of at least 3", axes));
    }
    let all: Option<Vec<u64>> =
        dim[1..=axes].iter().map(|&n| u64::try_from(n).ok().filter(|&n| n > 0)).collect();
    let all = all.ok_or_else(|| {
        ReadError::field(path, "dim", "a positive size for each axis", format!("{:?}", &dim[1..=axes]))
    })?;
    let components = all[SPACE..].iter().try_fold(1u64, |product, &n| product.checked_mul(n));
    let components = components.ok_or_else(|| {
        ReadError::field(path, "dim", "fewer than 2^64 components", format!("{:?}", &dim[1..=axes]))
    })?;
    Ok(([all[0], all[1], all[2]], components))
}

fn sample_type(path: &Path, datatype: i16) -> Result<SampleType, ReadError> {
    Ok(match datatype {
        2 => SampleType::U8,
        4 => SampleType::I16,
        8 => SampleType::I32,
        16 => SampleType::F32,
        64 => SampleType::F64,
        256 => SampleType::I8,
        512 => SampleType::U16,
        768 => SampleType::U32,
        1024 => SampleType::I64,
        1280 => SampleType::U64,
        _ => {
            let expected = "2 (u8), 4 (i16), 8 (i32), 16 (f32), 64 (f64), 256 (i8), 512 (u16), 768 (u32), 1024 (i64) or 1280 (u64)";
            return Err(ReadError::unsupported(path, "this datatype", expected, datatype));
        }
    })
}

/// The rescaling; none where the slope is 0 (which means unscaled), or where it changes nothing.
fn scale(slope: f64, intercept: f64) -> Option<Scale> {
    let scaled = slope != 0.0 && slope.is_finite() && intercept.is_finite();
    (scaled && (slope, intercept) != (1.0, 0.0)).then_some(Scale { slope, intercept })
}

/// The byte of the file, or of its decompressed stream, at which samples begin.
fn offset(path: &Path, fields: &Fields) -> Result<u64, ReadError> {
    /// Above, not every integer is an `f64`.
    const MOST: f64 = (1u64 << 53) as f64;
    let found = fields.vox_offset;
    let least = if fields.single { fields.header_bytes as f64 } else { 0.0 };
    if fields.single && found == 0.0 {
        return Ok(fields.header_bytes + EXTENDER_BYTES);
    }
    if found >= least && found <= MOST && found.fract() == 0.0 {
        Ok(found as u64)
    } else {
        let expected = "a whole number of bytes, after the header if samples are in the same file";
        Err(ReadError::field(path, "vox_offset", expected, found))
    }
}

/// The file of samples that belongs to a `.hdr`, and whether it is compressed.
fn image_file(path: &Path) -> Result<(PathBuf, bool), ReadError> {
    let plain = match path.extension() {
        Some(e) if e.eq_ignore_ascii_case("gz") => path.with_extension("").with_extension("img"),
        _ => path.with_extension("img"),
    };
    let mut compressed = plain.clone().into_os_string();
    compressed.push(".gz");
    let compressed = PathBuf::from(compressed);
    match std::fs::File::open(&plain) {
        Ok(_) => Ok((plain, false)),
        Err(_) if compressed.is_file() => Ok((compressed, true)),
        Err(source) => Err(ReadError::DataFile { path: path.to_owned(), data: plain, source }),
    }
}

/// The first transform that can be inverted; the others that should have come before it are warned of.
fn index_to_world(path: &Path, transforms: &Transforms, warnings: &mut Vec<Warning>) -> DAffine3 {
    let (map, ignored) = world(transforms);
    warnings.extend(
        ignored.into_iter().map(|transform| Warning::BadTransform { path: path.to_owned(), transform }),
    );
    map
}
