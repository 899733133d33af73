//! Opening and verifying `.ovol` files.

use std::error::Error;
use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use glam::DAffine3;
use isoray_grid::{Access, Dims, DimsError, MappedFile, Scalar, ScalarType, map_file};
use rayon::prelude::*;
use zerocopy::FromBytes;
use zerocopy::little_endian::F64;

use crate::check::{Malformed, Statistics, check_with_progress};
use crate::fidelity::{Coarse, Fidelity, SurfaceFidelity};
use crate::format::{Header, KIND_CAPS, KIND_NODES, MAGIC, SectionEntry, VERSION, header_checksum};
use crate::geometry::{CAP_LEVEL, NODE_LEVEL, root_level};
use crate::node::Node;
use crate::volume::{AnyVolume, HISTOGRAM_BINS, Meta, OctreeVolume, Section, VolumeVisitor};

/// An `.ovol` file that cannot be used, and why.
#[derive(Debug)]
pub struct OpenError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong with it.
    pub problem: OpenProblem,
}

impl fmt::Display for OpenError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.path.display(), self.problem)
    }
}

/// The message already tells the problem, so the cause is the problem's own.
impl Error for OpenError {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        self.problem.source()
    }
}

/// What can be wrong with an `.ovol` file.
#[derive(Debug, thiserror::Error)]
pub enum OpenProblem {
    /// The operating system refused it.
    #[error("cannot be opened")]
    Io(#[source] io::Error),
    /// It does not begin like one.
    #[error("not an octree volume: expected a file that begins with \"ISORAYOV\"")]
    Magic,
    /// It ends before its header does.
    #[error("truncated: expected at least {expected} bytes of header and section table, found {found}")]
    TruncatedHeader {
        /// Bytes that should be there.
        expected: usize,
        /// Bytes that are.
        found: usize,
    },
    /// Written by another version of this crate.
    #[error("format version {0}: this program reads version {VERSION}; build the volume again")]
    Version(u32),
    /// A checksum does not match.
    #[error("damaged: the checksum of {what} is {found:08x}, expected {expected:08x}")]
    Checksum {
        /// Which part.
        what: String,
        /// As stored.
        expected: u32,
        /// As computed.
        found: u32,
    },
    /// A header field has a value that no writer gives it.
    #[error("damaged header: {0}")]
    Field(&'static str),
    /// Impossible dimensions.
    #[error(transparent)]
    Dims(#[from] DimsError),
    /// The length differs from that in the header.
    #[error("truncated or padded: expected {expected} bytes, found {found}")]
    Length {
        /// As stored.
        expected: u64,
        /// As it is.
        found: u64,
    },
    /// The structure breaks its rules.
    #[error("damaged structure: a node breaks a rule")]
    Malformed(#[source] Malformed),
    /// What the header says of the samples is not so.
    #[error("damaged header: {0} is not that of the samples")]
    Statistics(&'static str),
}

/// Whether `start`, the first bytes of a file, are those of an `.ovol` file.
pub fn is_ovol(start: &[u8]) -> bool {
    start.starts_with(&MAGIC)
}

impl AnyVolume {
    /// Maps the file at `path` and checks its header and section table; nothing else is read until it is used.
    ///
    /// # Errors
    /// A file that cannot be mapped or whose header or section table is damaged. Damage further in does not
    /// show here: see [`verify`](Self::verify).
    pub fn open(path: &Path) -> Result<Self, OpenError> {
        let error = |problem| OpenError { path: path.to_owned(), problem };
        let file = map_file(path).map_err(|e| error(OpenProblem::Io(e)))?;
        // A ray needs some pages here and there; what lies between them need not be read.
        file.expect(Access::Random);
        open_mapped(file).map_err(error)
    }

    /// Verifies everything that [`open`](Self::open) does not: the checksum of each section, the zeros between
    /// them, the structure node by node, and what the header says of the samples.
    ///
    /// # Errors
    /// The first damage found.
    pub fn verify(&self, path: &Path) -> Result<(), OpenError> {
        self.verify_with_progress(path, &mut |_| {})
    }

    /// As [`verify`](Self::verify), and calls `progress` with the share of the work that is done, up to 1, now and then.
    ///
    /// # Errors
    /// The first damage found.
    pub fn verify_with_progress(
        &self,
        path: &Path,
        progress: &mut (dyn FnMut(f64) + Send),
    ) -> Result<(), OpenError> {
        self.visit(Verify { progress }).map_err(|problem| OpenError { path: path.to_owned(), problem })
    }
}

struct Verify<'a> {
    progress: &'a mut (dyn FnMut(f64) + Send),
}

/// Share of the time of verifying a file at which the checksums are done, as measured on large volumes.
const CHECKSUMS_DONE: f64 = 0.1;

impl VolumeVisitor for Verify<'_> {
    type Output = Result<(), OpenProblem>;

    fn visit<T: Scalar>(self, volume: &OctreeVolume<T>) -> Self::Output {
        if let Some(file) = volume.mapped() {
            file.expect(Access::Sequential);
            let (_, table, table_end) = read_header(file)?;
            let mut end = table_end;
            for entry in table {
                let section = section(&entry);
                let between = Section { offset: end, length: section.offset.saturating_sub(end) };
                if between.of(file).iter().any(|&b| b != 0) {
                    return Err(OpenProblem::Field("bytes between sections are not zero"));
                }
                let found = checksum(section.of(file));
                let expected = entry.checksum.get();
                if found != expected {
                    let what = match entry.kind.get() {
                        KIND_CAPS => "the caps".to_owned(),
                        _ => format!("the nodes of level {}", entry.level),
                    };
                    return Err(OpenProblem::Checksum { what, expected, found });
                }
                end = section.offset.saturating_add(section.length);
                (self.progress)(CHECKSUMS_DONE * end as f64 / file.len() as f64);
            }
        }
        let mut nodes = |done| (self.progress)(CHECKSUMS_DONE + (1.0 - CHECKSUMS_DONE) * done);
        let checked = check_with_progress(&volume.view(), volume.meta().coarse, &mut nodes);
        if let Some(file) = volume.mapped() {
            file.expect(Access::Random);
        }
        let statistics = checked.map_err(OpenProblem::Malformed)?;
        check_statistics(volume.meta(), &statistics)
    }
}

/// Compares value range, histogram and count of non-finite samples with those of the samples.
fn check_statistics<T: Scalar>(meta: &Meta, found: &Statistics<T>) -> Result<(), OpenProblem> {
    let Statistics { range, counts } = found;
    let range = (range.min <= range.max).then(|| [range.min, range.max].map(|s| f64::from(s.to_f32())));
    if range != meta.range {
        return Err(OpenProblem::Statistics("the value range"));
    }
    if counts.non_finite() != meta.non_finite {
        return Err(OpenProblem::Statistics("the number of NaN and infinite samples"));
    }
    let histogram = range.map_or_else(|| Box::new([0; HISTOGRAM_BINS]), |range| counts.histogram(range));
    if histogram != meta.histogram {
        return Err(OpenProblem::Statistics("the histogram"));
    }
    Ok(())
}

/// Bytes that one task sums.
const CHECKSUM_CHUNK: usize = 1 << 22;

/// CRC-32 on all cores.
fn checksum(bytes: &[u8]) -> u32 {
    let hash = |chunk: &[u8]| {
        let mut hasher = crc32fast::Hasher::new();
        hasher.update(chunk);
        hasher
    };
    let parts: Vec<_> = bytes.par_chunks(CHECKSUM_CHUNK).map(hash).collect();
    let mut whole = crc32fast::Hasher::new();
    parts.iter().for_each(|part| whole.combine(part));
    whole.finalize()
}

fn section(entry: &SectionEntry) -> Section {
    Section { offset: entry.offset.get() as usize, length: entry.length.get() as usize }
}

/// The header, the section table and where the latter ends; magic, version and checksum are right.
fn read_header(file: &[u8]) -> Result<(Header, Vec<SectionEntry>, usize), OpenProblem> {
    if !is_ovol(file) {
        return Err(OpenProblem::Magic);
    }
    let truncated = |expected| OpenProblem::TruncatedHeader { expected, found: file.len() };
    let (header, rest) = Header::read_from_prefix(file).map_err(|_| truncated(size_of::<Header>()))?;
    if header.version.get() != VERSION {
        return Err(OpenProblem::Version(header.version.get()));
    }
    let count = header.section_count.get() as usize;
    let table_end = count.saturating_mul(size_of::<SectionEntry>()).saturating_add(size_of::<Header>());
    let (table, _) =
        <[SectionEntry]>::ref_from_prefix_with_elems(rest, count).map_err(|_| truncated(table_end))?;
    let (expected, found) = (header.checksum.get(), header_checksum(&header, table));
    if expected != found {
        let what = "header and section table".to_owned();
        return Err(OpenProblem::Checksum { what, expected, found });
    }
    Ok((header, table.to_vec(), table_end))
}

fn open_mapped(file: MappedFile) -> Result<AnyVolume, OpenProblem> {
    let (header, table, table_end) = read_header(&file)?;
    let expected = header.file_length.get();
    if expected != file.len() as u64 {
        return Err(OpenProblem::Length { expected, found: file.len() as u64 });
    }
    let scalar = ScalarType::from_number(header.scalar).ok_or(OpenProblem::Field("unknown sample type"))?;
    let meta = meta_of(&header)?;
    let levels = 1 + (root_level(meta.dims) - NODE_LEVEL + 1) as usize;
    if u32::from(header.root_level) != root_level(meta.dims)
        || u32::from(header.cap_level) != CAP_LEVEL
        || header.cap_unit.get() as usize != 8 * scalar.size()
        || table.len() != levels
    {
        return Err(OpenProblem::Field("its levels do not fit its dimensions"));
    }
    let mut end = table_end;
    for (level, entry) in (CAP_LEVEL..).zip(&table) {
        let Section { offset, length } = section(entry);
        let kind = if level == CAP_LEVEL { KIND_CAPS } else { KIND_NODES };
        let element = match kind {
            KIND_CAPS => 1,
            _ => size_of::<Node<u8>>() + 24 * (scalar.size() - 1),
        };
        let fits = offset.checked_add(length).is_some_and(|e| offset >= end && e <= file.len());
        if entry.kind.get() != kind || entry.level.get() != level || !fits || length % element != 0 {
            return Err(OpenProblem::Field("a section is not where it belongs"));
        }
        end = offset + length;
    }
    if end != file.len() {
        return Err(OpenProblem::Field("bytes after the last section"));
    }
    let caps = section(&table[0]);
    let levels = table[1..].iter().map(section).collect();
    Ok(match scalar {
        ScalarType::U8 => OctreeVolume::<u8>::from_mapped(meta, file, levels, caps).into(),
        ScalarType::I8 => OctreeVolume::<i8>::from_mapped(meta, file, levels, caps).into(),
        ScalarType::U16 => OctreeVolume::<u16>::from_mapped(meta, file, levels, caps).into(),
        ScalarType::I16 => OctreeVolume::<i16>::from_mapped(meta, file, levels, caps).into(),
        ScalarType::F32 => OctreeVolume::<f32>::from_mapped(meta, file, levels, caps).into(),
    })
}

fn meta_of(header: &Header) -> Result<Meta, OpenProblem> {
    let dims = Dims::new(header.dims.map(|n| n.get()))?;
    let affine = header.index_to_world.map(|a| a.get());
    if affine.iter().any(|a| !a.is_finite()) {
        return Err(OpenProblem::Field("the index-to-world transform is not finite"));
    }
    let range = header.range.map(|r| r.get());
    let is_range = range.iter().all(|r| r.is_finite()) && range[0] <= range[1];
    if !is_range && !range.iter().all(|r| r.is_nan()) {
        return Err(OpenProblem::Field("the value range is no range"));
    }
    let histogram = Box::new(header.histogram.map(|n| n.get()));
    let non_finite = header.non_finite.get();
    // Sums over the counts then cannot overflow.
    let counted = histogram.iter().map(|&n| u128::from(n)).sum::<u128>() + u128::from(non_finite);
    if counted > dims.samples() as u128 {
        return Err(OpenProblem::Field("its histogram counts more samples than there are"));
    }
    Ok(Meta {
        dims,
        index_to_world: DAffine3::from_cols_array(&affine),
        range: is_range.then_some(range),
        non_finite,
        histogram,
        fidelity: fidelity_of(header)?,
        coarse: Coarse::from_number(header.coarse)
            .ok_or(OpenProblem::Field("unknown kind of coarse samples"))?,
    })
}

fn fidelity_of(header: &Header) -> Result<Fidelity, OpenProblem> {
    let wrong = || OpenProblem::Field("the bounds of its loss are none");
    let range = |ends: [F64; 2]| {
        let [low, high] = ends.map(|end| end.get());
        match low <= high {
            true => Ok(Some([low, high])),
            false if low.is_nan() && high.is_nan() => Ok(None),
            false => Err(wrong()),
        }
    };
    let (tolerance, displacement) = (header.tolerance.get(), header.displacement.get());
    let isovalues = range(header.isovalues)?;
    let surface = isovalues.map(|isovalues| SurfaceFidelity {
        displacement,
        isovalues,
        is_range: header.is_range.get() == 1,
    });
    let is_bound = surface.map_or(displacement.is_nan(), |surface| surface.displacement >= 0.0);
    if !(tolerance >= 0.0 && is_bound && header.is_range.get() <= 1) {
        return Err(wrong());
    }
    Ok(Fidelity { tolerance, surface, range: range(header.kept)? })
}
