//! Readers for the volume and transfer-function files people have, and image writers.
//!
//! **Open.** [`Dataset::open`] reads and checks a header and no samples. The first bytes of the file tell its
//! format, whatever its name:
//!
//! | format | files | read |
//! |---|---|---|
//! | NRRD 1 to 5 | `.nrrd`, `.nhdr` and its data file | raw, gzip or zlib, text; byte and line skips; spacings or directions |
//! | MetaImage | `.mha`, `.mhd` and its data file | raw, zlib or gzip, text; direction cosines |
//! | NIfTI-1, NIfTI-2 | `.nii`, `.nii.gz`, `.hdr` and `.img` | rescaled if the header says so; sform, qform, voxel sizes |
//! | VTK image data | `.vti` | text, base64, appended raw or base64; zlib or LZ4 blocks; spacing and direction |
//! | legacy VTK | `.vtk` | structured points, text or binary; all kinds of arrays but strings |
//! | NumPy 1 to 3 | `.npy` | integers and floats of 8 to 64 bits, C or Fortran order |
//! | TIFF, feature `tiff` | `.tif`, `.tiff`, a folder of them | pages in strips or tiles; LZW, deflate, PackBits; BigTIFF |
//! | headerless | any | the layout is given as a [`RawLayout`] |
//!
//! [`AmrDataset::open`] does the same for meshes of several levels; [`AmrDataset::recognises`] tells whether a
//! path is one:
//!
//! | format | files | read |
//! |---|---|---|
//! | AMReX and BoxLib plotfiles | the folder, or its `Header` | three dimensions; cells or vertices; 32- and 64-bit FABs of both byte orders, with or without headers; ghost cells are dropped |
//! | VTK overlapping AMR | `.vthb`, the older `.vtm`, and their `.vti` | what `.vti` files can hold, at cells or points |
//! | octrees as legacy VTK hexahedra | `.vtk` | hexahedra or voxels, text or binary, up to version 5; values at points or cells |
//! | Enzo, RAMSES | the folder, `.hierarchy`, `info_*.txt` | recognised, not read yet |
//!
//! The header is turned into one description: the size of the lattice, the type of the samples, and the
//! affine map from index coordinates to the world. That world is the file's own, in its units and with its
//! axes: NIfTI's x points to the right of a patient, that of most NRRD and MetaImage files to the left.
//!
//! - **VTK.** The image is one piece. Of several arrays the active scalars are read, else the only array, of the
//!   points or, if they have none, of the cells; [`OpenOptions::field`] names another. Values at cells are read
//!   as the lattice of the cells' centres: the volume is smaller by half a cell on each side. LZMA blocks are not
//!   read. In legacy files `long` has 64 bits, and one-component `COLOR_SCALARS` count as scalars: bytes in
//!   binary files, fractions from 0 to 1 in text.
//! - **NumPy.** The last axis of an array in C order is x: its shape is (z, y, x), (y, x) for one layer, or
//!   (z, y, x, component). In Fortran order the first one is: (x, y, z), (x, y), or (x, y, z, component).
//! - **TIFF.** Pages are layers; smaller copies and masks are passed over, and all others must agree in size and
//!   type. A folder, and `Dataset::open_slices`, have one page a file, a folder in the order of the numbers in
//!   the names. Colours and extra samples are components. Distances are 1 unless ImageJ has written them, in the
//!   unit that it names; the resolution alone is that of a printer or scanner. Row 0 is y = 0.
//!
//! **Types.** Samples are handed out as the five types of [`ScalarType`](isoray_grid::ScalarType). Integers of
//! 32 and 64 bits, 64-bit floats and samples that a NIfTI header rescales become `f32`; how many of them lost
//! digits is a [`Warning`]. Of a file with several components one must be chosen.
//!
//! **Read.** [`Dataset::slabs`] streams the samples as an [`SlabSource`](isoray_grid::SlabSource), also from
//! compressed files, and never holds more than a slab and a block or page; [`Dataset::mapped`] lends them straight from a memory
//! map where the file has them as they are handed out.
//!
//! ```
//! use isoray_grid::SlabSource;
//! use isoray_io::{Dataset, OpenOptions, PixelData, write_png};
//!
//! let folder = tempfile::tempdir()?;
//! let path = folder.path().join("ramp.nrrd");
//! let header = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 3 2\nspacings: 1 1 2\nencoding: raw\n\n";
//! let samples: Vec<u8> = (0..24).map(|i| 10 * i).collect();
//! std::fs::write(&path, [header.as_bytes(), &samples].concat())?;
//!
//! let dataset = Dataset::open(&path, &OpenOptions::default())?;
//! assert_eq!(dataset.dims().axes(), [4, 3, 2]);
//! assert_eq!(dataset.index_to_world().matrix3.z_axis.z, 2.0);
//!
//! // The upper layer as a grey image of 4 × 3 pixels.
//! let mut layer = [0u8; 12];
//! dataset.slabs::<u8>()?.read_layers(1, &mut layer)?;
//! let pixels: Vec<u8> = layer.iter().flat_map(|&grey| [grey; 3]).collect();
//! write_png(&folder.path().join("layer.png"), 4, 3, PixelData::Rgb8(&pixels))?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! **Meshes.** [`AmrDataset::read`] hands out the boxes of all levels as [`Patches`](isoray_amr::Patches), with 32-bit
//! floats. Levels are refined by 2 or 4, the same along each axis.
//!
//! - **Plotfiles.** The map to the world takes the stated corner of the domain for that of the cell (0, 0, 0), as
//!   AMReX does, unless the places of the boxes fit the domain's lowest cell better. All boxes must lie in the domain
//!   that the `Header` states for their level, and near the place that it states for them. The oldest FABs, `FAB:`, do
//!   not state their byte order and are not read.
//! - **VTK.** Marks of covered cells (`vtkGhostType`) are passed over, since the finest level wins. The domain is the
//!   smallest box around level 0. Components of an array become fields, `NAME:0`, `NAME:1`, ….
//! - **Hexahedra.** Each must be a cube at a multiple of its edge, which is that of the largest, halved some times.
//!   Coordinates may be off by what six decimal digits, or the binary type, leave. Each cell becomes a patch of its own.
//! - **Left to others.** Whether boxes overlap, cut coarse cells or leave gaps is a matter of the whole mesh.
//!
//! **Transfer functions.** [`read_transfer_function`] reads isoray's own TOML files and ParaView's presets; the
//! module [`transfer`] describes both formats, and has colour maps.
//!
//! **Damage.** Whatever the bytes of a file, the outcome is samples or a [`ReadError`] that names the file,
//! what was expected and what was found. Nothing is allocated by what a header claims: an uncompressed file's
//! length is checked when it is opened, and a compressed one is decoded into the caller's slab. A plotfile's boxes must
//! not share values, and its files must lie in it.
//!
//! **Write.** [`write_png`] and [`write_exr`] write to a temporary name in the same folder and rename, so
//! that no partial image ever has the name asked for.

mod amr;
mod coding;
mod dataset;
mod decode;
mod detect;
mod error;
mod layout;
mod lines;
mod metaimage;
mod nifti;
mod nifti_world;
mod npy;
mod nrrd;
mod raw;
mod rows;
mod sample;
mod slabs;
#[cfg(feature = "tiff")]
mod tiff;
pub mod transfer;
mod vtk;
mod write;

pub use amr::{AmrDataset, AmrField, AmrLevel};
pub use dataset::{Dataset, MappedSamples, OpenOptions};
pub use error::{ReadError, Warning};
pub use raw::RawLayout;
pub use sample::{Endian, SampleType, SampleTypeError};
pub use slabs::Slabs;
pub use transfer::{TransferFileError, TransferOptions, read_transfer_function};
pub use write::{ExrChannel, PixelData, WriteError, write_exr, write_png};
