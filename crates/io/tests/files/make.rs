//! Writers of small volume files, and a reader of whole volumes.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use flate2::Compression;
use flate2::write::{GzEncoder, ZlibEncoder};
use isoray_grid::{Scalar, ScalarType, SlabSource};
use isoray_io::{Dataset, Endian, ReadError, SampleType, Slabs, Warning};

/// Size of the lattice in the files made here.
pub(crate) const DIMS: [u32; 3] = [5, 4, 3];
/// Samples of one component.
pub(crate) const SAMPLES: usize = 60;

/// A value that every type holds exactly, another one for each sample and component.
pub(crate) fn value(sample: usize, component: usize) -> f64 {
    ((sample * 2 + component * 37) % 127) as f64
}

/// `v` as bytes of a file.
pub(crate) fn encode(v: f64, sample: SampleType, endian: Endian) -> Vec<u8> {
    let mut bytes = match sample {
        SampleType::U8 => (v as u8).to_le_bytes().to_vec(),
        SampleType::I8 => (v as i8).to_le_bytes().to_vec(),
        SampleType::U16 => (v as u16).to_le_bytes().to_vec(),
        SampleType::I16 => (v as i16).to_le_bytes().to_vec(),
        SampleType::U32 => (v as u32).to_le_bytes().to_vec(),
        SampleType::I32 => (v as i32).to_le_bytes().to_vec(),
        SampleType::U64 => (v as u64).to_le_bytes().to_vec(),
        SampleType::I64 => (v as i64).to_le_bytes().to_vec(),
        SampleType::F32 => (v as f32).to_le_bytes().to_vec(),
        SampleType::F64 => v.to_le_bytes().to_vec(),
    };
    if endian == Endian::Big {
        bytes.reverse();
    }
    bytes
}

/// All samples and components as bytes.
pub(crate) fn body(sample: SampleType, endian: Endian, components: usize, interleaved: bool) -> Vec<u8> {
    let one = |s, c| encode(value(s, c), sample, endian);
    if interleaved {
        (0..SAMPLES).flat_map(|s| (0..components).flat_map(move |c| one(s, c))).collect()
    } else {
        (0..components).flat_map(|c| (0..SAMPLES).flat_map(move |s| one(s, c))).collect()
    }
}

/// The numbers of [`body`] as text.
pub(crate) fn text_body() -> Vec<u8> {
    let mut text = String::new();
    for s in 0..SAMPLES {
        let separator = if s % 7 == 6 { "\n" } else { ", " };
        write!(text, "{}{separator}", value(s, 0)).unwrap();
    }
    text.into_bytes()
}

pub(crate) fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

pub(crate) fn zlib(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

/// The name that NRRD gives to a type.
pub(crate) fn nrrd_type(sample: SampleType) -> &'static str {
    match sample {
        SampleType::U8 => "unsigned char",
        SampleType::I8 => "int8_t",
        SampleType::U16 => "ushort",
        SampleType::I16 => "signed short int",
        SampleType::U32 => "uint32",
        SampleType::I32 => "int",
        SampleType::U64 => "unsigned long long int",
        SampleType::I64 => "longlong",
        SampleType::F32 => "float",
        SampleType::F64 => "double",
    }
}

/// The name that MetaImage gives to a type.
pub(crate) fn meta_type(sample: SampleType) -> &'static str {
    match sample {
        SampleType::U8 => "MET_UCHAR",
        SampleType::I8 => "MET_CHAR",
        SampleType::U16 => "MET_USHORT",
        SampleType::I16 => "MET_SHORT",
        SampleType::U32 => "MET_UINT",
        SampleType::I32 => "MET_INT",
        SampleType::U64 => "MET_ULONG_LONG",
        SampleType::I64 => "MET_LONG_LONG",
        SampleType::F32 => "MET_FLOAT",
        SampleType::F64 => "MET_DOUBLE",
    }
}

/// The name that VTK gives to a type in XML.
pub(crate) fn vtk_type(sample: SampleType) -> &'static str {
    match sample {
        SampleType::U8 => "UInt8",
        SampleType::I8 => "Int8",
        SampleType::U16 => "UInt16",
        SampleType::I16 => "Int16",
        SampleType::U32 => "UInt32",
        SampleType::I32 => "Int32",
        SampleType::U64 => "UInt64",
        SampleType::I64 => "Int64",
        SampleType::F32 => "Float32",
        SampleType::F64 => "Float64",
    }
}

/// The number that NIfTI gives to a type.
pub(crate) fn nifti_type(sample: SampleType) -> i16 {
    match sample {
        SampleType::U8 => 2,
        SampleType::I8 => 256,
        SampleType::U16 => 512,
        SampleType::I16 => 4,
        SampleType::U32 => 768,
        SampleType::I32 => 8,
        SampleType::U64 => 1280,
        SampleType::I64 => 1024,
        SampleType::F32 => 16,
        SampleType::F64 => 64,
    }
}

/// The header of an attached NRRD of one component, up to the blank line.
pub(crate) fn nrrd_header(sample: SampleType, endian: Endian, encoding: &str) -> String {
    let endian = if endian == Endian::Big { "big" } else { "little" };
    format!(
        "NRRD0004\n# a comment: with a colon\nsome key:=some: value\ntype: {}\ndimension: 3\nsizes: 5 4 3\n\
         spacings: 1 2 0.5\nendian: {endian}\nencoding: {encoding}\n",
        nrrd_type(sample)
    )
}

/// The header of a MetaImage of one component, up to and with its last field.
pub(crate) fn meta_header(sample: SampleType, endian: Endian, compressed: bool, data: &str) -> String {
    let msb = if endian == Endian::Big { "True" } else { "False" };
    let compressed = if compressed { "True" } else { "False" };
    format!(
        "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = {msb}\n\
         CompressedData = {compressed}\nDimSize = 5 4 3\nElementSpacing = 1 2 5.000000e-001\n\
         ElementType = {}\nElementDataFile = {data}\n",
        meta_type(sample)
    )
}

/// A NIfTI header, of which a test may change fields.
#[derive(Clone)]
pub(crate) struct Nifti {
    pub(crate) version: u8,
    pub(crate) single: bool,
    pub(crate) endian: Endian,
    pub(crate) dim: [i64; 8],
    pub(crate) datatype: i16,
    pub(crate) pixdim: [f64; 8],
    pub(crate) vox_offset: f64,
    pub(crate) scale: [f64; 2],
    pub(crate) sform: Option<[[f64; 4]; 3]>,
}

impl Nifti {
    pub(crate) fn new(version: u8, sample: SampleType, endian: Endian) -> Self {
        Self {
            version,
            single: true,
            endian,
            dim: [3, 5, 4, 3, 1, 1, 1, 1],
            datatype: nifti_type(sample),
            pixdim: [1.0, 1.0, 2.0, 0.5, 0.0, 0.0, 0.0, 0.0],
            vox_offset: if version == 1 { 352.0 } else { 544.0 },
            scale: [0.0, 0.0],
            sform: None,
        }
    }

    /// Header and extension bytes; samples follow.
    pub(crate) fn bytes(&self) -> Vec<u8> {
        let mut out = vec![0; if self.version == 1 { 352 } else { 544 }];
        let big = self.endian == Endian::Big;
        let mut put = |at: usize, mut bytes: Vec<u8>| {
            if big {
                bytes.reverse();
            }
            out[at..at + bytes.len()].copy_from_slice(&bytes);
        };
        let rows = self.sform.unwrap_or_default();
        let code = i32::from(self.sform.is_some());
        if self.version == 1 {
            put(0, 348i32.to_le_bytes().into());
            (0..8).for_each(|i| put(40 + 2 * i, (self.dim[i] as i16).to_le_bytes().into()));
            put(70, self.datatype.to_le_bytes().into());
            (0..8).for_each(|i| put(76 + 4 * i, (self.pixdim[i] as f32).to_le_bytes().into()));
            put(108, (self.vox_offset as f32).to_le_bytes().into());
            (0..2).for_each(|i| put(112 + 4 * i, (self.scale[i] as f32).to_le_bytes().into()));
            put(254, (code as i16).to_le_bytes().into());
            (0..12).for_each(|i| put(280 + 4 * i, (rows[i / 4][i % 4] as f32).to_le_bytes().into()));
            out[344..348].copy_from_slice(if self.single { b"n+1\0" } else { b"ni1\0" });
        } else {
            put(0, 540i32.to_le_bytes().into());
            put(12, self.datatype.to_le_bytes().into());
            (0..8).for_each(|i| put(16 + 8 * i, self.dim[i].to_le_bytes().into()));
            (0..8).for_each(|i| put(104 + 8 * i, self.pixdim[i].to_le_bytes().into()));
            put(168, (self.vox_offset as i64).to_le_bytes().into());
            (0..2).for_each(|i| put(176 + 8 * i, self.scale[i].to_le_bytes().into()));
            put(348, code.to_le_bytes().into());
            (0..12).for_each(|i| put(400 + 8 * i, rows[i / 4][i % 4].to_le_bytes().into()));
            out[4..12].copy_from_slice(if self.single { b"n+2\0\r\n\x1a\n" } else { b"ni2\0\r\n\x1a\n" });
        }
        out
    }
}

/// Writes `parts` one after the other.
pub(crate) fn write(folder: &Path, name: &str, parts: &[&[u8]]) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, parts.concat()).unwrap();
    path
}

/// All samples as `f32`, read `thickness` layers at a time, and the reader's warnings.
pub(crate) fn read(dataset: &Dataset, thickness: u32) -> Result<(Vec<f32>, Vec<Warning>), ReadError> {
    match dataset.scalar() {
        ScalarType::U8 => read_as::<u8>(dataset, thickness),
        ScalarType::I8 => read_as::<i8>(dataset, thickness),
        ScalarType::U16 => read_as::<u16>(dataset, thickness),
        ScalarType::I16 => read_as::<i16>(dataset, thickness),
        ScalarType::F32 => read_as::<f32>(dataset, thickness),
    }
}

fn read_as<T: Scalar>(dataset: &Dataset, thickness: u32) -> Result<(Vec<f32>, Vec<Warning>), ReadError> {
    let mut slabs: Slabs<T> = dataset.slabs()?;
    let (layer, layers) = (dataset.dims().layer(), dataset.dims().axes()[2]);
    let mut all = Vec::new();
    let mut first = 0;
    while first < layers {
        let n = thickness.min(layers - first);
        let mut slab = vec![T::default(); layer * n as usize];
        slabs.read_layers(first, &mut slab)?;
        all.extend(slab.into_iter().map(T::to_f32));
        first += n;
    }
    if let Some(mapped) = dataset.mapped::<T>() {
        assert!(mapped.iter().zip(&all).all(|(m, a)| m.to_f32().to_bits() == a.to_bits()));
        assert_eq!(mapped.len(), all.len());
    }
    Ok((all, slabs.warnings()))
}
