//! Writing `.ovol` files.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use isoray_grid::{Dims, OutputFile, Scalar, folder_of, map_file};
use zerocopy::little_endian::{F64, U32, U64};
use zerocopy::{FromZeros, IntoBytes};

use crate::cap::{cap_reach, cap_unit};
use crate::fidelity::{Coarse, Fidelity, SurfaceFidelity};
use crate::format::{
    ALIGNMENT, Header, KIND_CAPS, KIND_NODES, MAGIC, SectionEntry, VERSION, header_checksum,
};
use crate::geometry::{CAP_LEVEL, NODE_LEVEL, root_level};
use crate::lod::fill_coarse;
use crate::node::Node;
use crate::volume::{Meta, OctreeVolume};

/// A volume that could not be written; nothing is left under its name or beside it.
#[derive(Debug, thiserror::Error)]
#[error("{}: cannot write the octree volume", path.display())]
pub struct SaveError {
    /// The file that was to be.
    pub path: PathBuf,
    /// What the operating system said.
    #[source]
    pub source: io::Error,
}

impl<T: Scalar> OctreeVolume<T> {
    /// Writes the volume to `path`, whole or not at all.
    ///
    /// # Errors
    /// What the operating system says of creating, writing or renaming the file.
    pub fn save(&self, path: &Path) -> Result<(), SaveError> {
        let view = self.view();
        let mut writer = VolumeWriter::<T>::create(path, self.meta().dims, usize::MAX)?;
        writer.push_caps(view.caps_alone())?;
        for level in NODE_LEVEL..=view.root_level() {
            writer.push_nodes(level, view.nodes(level))?;
        }
        writer.finish(self.meta())?;
        Ok(())
    }
}

/// Writes an `.ovol` file piece by piece, as its parts become known.
///
/// The caps go to the file at once. Nodes, which follow them, wait in memory, and beyond a limit in a nameless temporary file for each
/// level.
#[derive(Debug)]
pub struct VolumeWriter<T: Scalar> {
    path: PathBuf,
    out: OutputFile,
    dims: Dims,
    caps: Section,
    /// Caps that wait to be written in one piece.
    buffer: Vec<u8>,
    levels: Vec<Spool>,
    /// Bytes of nodes that may wait in memory.
    limit: usize,
    sample: std::marker::PhantomData<T>,
}

/// Caps written at once.
const BUFFER: usize = 1 << 20;

/// Length and checksum of what has been written of a section.
#[derive(Clone, Debug, Default)]
struct Section {
    length: u64,
    checksum: crc32fast::Hasher,
}

impl Section {
    fn add(&mut self, bytes: &[u8]) {
        self.length += bytes.len() as u64;
        self.checksum.update(bytes);
    }
}

/// Nodes of one level that wait: the first in a file, the rest in memory.
#[derive(Debug, Default)]
struct Spool {
    section: Section,
    file: Option<File>,
    memory: Vec<u8>,
}

impl<T: Scalar> VolumeWriter<T> {
    /// Begins the file that is to be at `path`; `limit` bytes of nodes may wait in memory.
    ///
    /// # Errors
    /// What the operating system says of creating the file.
    pub fn create(path: &Path, dims: Dims, limit: usize) -> Result<Self, SaveError> {
        let error = |source| SaveError { path: path.to_owned(), source };
        let levels: Vec<_> = (NODE_LEVEL..=root_level(dims)).map(|_| Spool::default()).collect();
        let mut out = OutputFile::create(path).map_err(error)?;
        out.file().seek(SeekFrom::Start(caps_offset(levels.len()))).map_err(error)?;
        let (caps, buffer, sample) = (Section::default(), Vec::new(), std::marker::PhantomData);
        Ok(Self { path: path.to_owned(), out, dims, caps, buffer, levels, limit, sample })
    }

    fn error(&self) -> impl Fn(io::Error) -> SaveError + use<T> {
        let path = self.path.clone();
        move |source| SaveError { path: path.clone(), source }
    }

    /// Appends caps. The first call's begin at link 0, and each multiple of [`cap_unit`] bytes is one more.
    ///
    /// # Errors
    /// What the operating system says of writing them.
    pub fn push_caps(&mut self, bytes: &[u8]) -> Result<(), SaveError> {
        self.caps.add(bytes);
        let mut write = || {
            if self.buffer.len() + bytes.len() > BUFFER {
                self.out.file().write_all(&self.buffer)?;
                self.buffer.clear();
            }
            if bytes.len() > BUFFER {
                return self.out.file().write_all(bytes);
            }
            self.buffer.extend_from_slice(bytes);
            Ok(())
        };
        write().map_err(self.error())
    }

    /// Appends nodes to those of `level`.
    ///
    /// # Errors
    /// What the operating system says of putting them into a temporary file.
    pub fn push_nodes(&mut self, level: u32, nodes: &[Node<T::Stored>]) -> Result<(), SaveError> {
        let Some(spool) = self.levels.get_mut(level.wrapping_sub(NODE_LEVEL) as usize) else { return Ok(()) };
        spool.section.add(nodes.as_bytes());
        spool.memory.extend_from_slice(nodes.as_bytes());
        let waiting: usize = self.levels.iter().map(|spool| spool.memory.len()).sum();
        if waiting > self.limit {
            let folder = folder_of(&self.path);
            self.levels.iter_mut().try_for_each(|spool| spool.spill(folder)).map_err(self.error())?;
        }
        Ok(())
    }

    /// Bytes of all nodes so far.
    pub fn node_bytes(&self) -> u64 {
        self.levels.iter().map(|spool| spool.section.length).sum()
    }

    /// Makes the coarse samples of a structure that is complete, but for this, those of `kind`: [`fill_coarse`] with all nodes in memory.
    ///
    /// # Errors
    /// What the operating system says of reading what has been written, or of so much memory.
    pub fn fill_coarse(&mut self, kind: Coarse) -> Result<(), SaveError> {
        let error = self.error();
        let mut fill = || {
            let mut levels = Vec::with_capacity(self.levels.len());
            for spool in &mut self.levels {
                levels.push(std::mem::take(spool).into_nodes::<T>()?);
            }
            let file = self.out.file();
            file.write_all(&self.buffer)?;
            self.buffer.clear();
            // To be overwritten by what comes next.
            let reach = cap_reach::<T>();
            file.write_all(&[0; 256][..reach])?;
            file.seek(SeekFrom::Current(-(reach as i64)))?;
            let map = map_file(self.out.temporary_path())?;
            let start = caps_offset(levels.len()) as usize;
            let caps = map.get(start..).and_then(|rest| rest.get(..self.caps.length as usize + reach));
            fill_coarse::<T>(self.dims, &mut levels, caps.ok_or(io::ErrorKind::UnexpectedEof)?, kind);
            Ok(levels)
        };
        let levels = fill().map_err(error)?;
        for (level, nodes) in (NODE_LEVEL..).zip(levels) {
            nodes
                .chunks(BUFFER / size_of::<Node<T::Stored>>())
                .try_for_each(|some| self.push_nodes(level, some))?;
        }
        Ok(())
    }

    /// Completes the file; its length in bytes.
    ///
    /// # Errors
    /// What the operating system says of writing or renaming it.
    pub fn finish(mut self, meta: &Meta) -> Result<u64, SaveError> {
        self.push_caps(&[0; 256][..cap_reach::<T>()])?;
        let error = self.error();
        self.try_finish(meta).map_err(error)
    }

    fn try_finish(mut self, meta: &Meta) -> io::Result<u64> {
        let file = self.out.file();
        file.write_all(&self.buffer)?;
        let mut end = caps_offset(self.levels.len());
        let mut table = Vec::with_capacity(1 + self.levels.len());
        let mut entry = |kind, level: u32, section: Section| {
            let offset = end.next_multiple_of(ALIGNMENT as u64);
            let padding = (offset - end) as usize;
            end = offset + section.length;
            table.push(SectionEntry {
                kind: U32::new(kind),
                level: level.into(),
                offset: offset.into(),
                length: section.length.into(),
                checksum: section.checksum.finalize().into(),
                reserved: U32::ZERO,
            });
            padding
        };
        entry(KIND_CAPS, CAP_LEVEL, self.caps);
        for (level, spool) in (NODE_LEVEL..).zip(self.levels) {
            let padding = entry(KIND_NODES, level, spool.section.clone());
            file.write_all(&[0; ALIGNMENT][..padding])?;
            spool.copy_to(file)?;
        }
        let header = header::<T>(meta, self.dims, &table, end);
        file.seek(SeekFrom::Start(0))?;
        file.write_all(header.as_bytes())?;
        file.write_all(table.as_bytes())?;
        self.out.commit()?;
        Ok(end)
    }
}

impl Spool {
    /// Moves what waits in memory to a file without a name in `folder`, which vanishes with the process.
    fn spill(&mut self, folder: &Path) -> io::Result<()> {
        let file = match &mut self.file {
            Some(file) => file,
            none => none.insert(tempfile::tempfile_in(folder)?),
        };
        file.write_all(&self.memory)?;
        self.memory = Vec::new();
        Ok(())
    }

    /// All of them, in memory.
    fn into_nodes<T: Scalar>(mut self) -> io::Result<Vec<Node<T::Stored>>> {
        let count = self.section.length as usize / size_of::<Node<T::Stored>>();
        let mut nodes: Vec<Node<T::Stored>> = Vec::new();
        nodes.try_reserve_exact(count).map_err(|_| io::ErrorKind::OutOfMemory)?;
        nodes.resize_with(count, Node::new_zeroed);
        let bytes = nodes.as_mut_slice().as_mut_bytes();
        let (spilled, waiting) = bytes.split_at_mut(bytes.len() - self.memory.len());
        if let Some(file) = &mut self.file {
            file.seek(SeekFrom::Start(0))?;
            file.read_exact(spilled)?;
        }
        waiting.copy_from_slice(&self.memory);
        Ok(nodes)
    }

    fn copy_to(mut self, out: &mut File) -> io::Result<()> {
        if let Some(file) = &mut self.file {
            file.seek(SeekFrom::Start(0))?;
            let mut buffer = vec![0; BUFFER];
            loop {
                let n = file.read(&mut buffer)?;
                if n == 0 {
                    break;
                }
                out.write_all(&buffer[..n])?;
            }
        }
        out.write_all(&self.memory)
    }
}

/// Where the first section begins in a file with nodes of so many levels.
fn caps_offset(levels: usize) -> u64 {
    let end = size_of::<Header>() + (1 + levels) * size_of::<SectionEntry>();
    end.next_multiple_of(ALIGNMENT) as u64
}

fn header<T: Scalar>(meta: &Meta, dims: Dims, table: &[SectionEntry], file_length: u64) -> Header {
    let [min, max] = meta.range.unwrap_or([f64::NAN; 2]);
    let Fidelity { tolerance, surface, range } = meta.fidelity;
    let no_surface = SurfaceFidelity { displacement: f64::NAN, isovalues: [f64::NAN; 2], is_range: false };
    let surface = surface.unwrap_or(no_surface);
    let mut header = Header {
        magic: MAGIC,
        version: VERSION.into(),
        scalar: T::TYPE as u8,
        root_level: root_level(dims) as u8,
        cap_level: CAP_LEVEL as u8,
        coarse: meta.coarse as u8,
        dims: dims.axes().map(U32::new),
        section_count: U32::new(table.len() as u32),
        index_to_world: meta.index_to_world.to_cols_array().map(F64::new),
        range: [min.into(), max.into()],
        non_finite: meta.non_finite.into(),
        file_length: U64::new(file_length),
        cap_unit: U32::new(cap_unit::<T>() as u32),
        checksum: U32::ZERO,
        histogram: meta.histogram.map(U64::new),
        tolerance: tolerance.into(),
        displacement: surface.displacement.into(),
        isovalues: surface.isovalues.map(F64::new),
        kept: range.unwrap_or([f64::NAN; 2]).map(F64::new),
        is_range: u32::from(surface.is_range).into(),
        padding: [0; 36],
    };
    header.checksum = U32::new(header_checksum(&header, table));
    header
}
