//! Writing `.ovol` files.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use isoray_grid::Scalar;
use rayon::prelude::*;
use zerocopy::IntoBytes;
use zerocopy::little_endian::{F64, U32, U64};

use crate::cap::cap_unit;
use crate::format::{
    ALIGNMENT, Header, KIND_CAPS, KIND_NODES, MAGIC, SectionEntry, VERSION, header_checksum,
};
use crate::geometry::{CAP_LEVEL, NODE_LEVEL};
use crate::volume::OctreeVolume;

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
    /// Writes the volume to `path`, whole or not at all: under a temporary name in the same folder, renamed
    /// when it is complete.
    ///
    /// # Errors
    /// What the operating system says of creating, writing or renaming the file.
    pub fn save(&self, path: &Path) -> Result<(), SaveError> {
        self.try_save(path).map_err(|source| SaveError { path: path.to_owned(), source })
    }

    fn try_save(&self, path: &Path) -> io::Result<()> {
        let folder = match path.parent() {
            Some(folder) if folder != Path::new("") => folder,
            _ => Path::new("."),
        };
        let mut builder = tempfile::Builder::new();
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            builder.permissions(std::fs::Permissions::from_mode(0o666)); // less what the umask takes away
        }
        let mut file = builder.prefix(".isoray-").suffix(".tmp").tempfile_in(folder)?;
        self.write_to(&mut io::BufWriter::with_capacity(1 << 20, file.as_file_mut()))?;
        file.persist(path)?;
        Ok(())
    }

    /// Writes the bytes of the file to `out`.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write_to(&self, out: &mut impl Write) -> io::Result<()> {
        let view = self.view();
        let mut sections: Vec<(u32, u32, &[u8])> = vec![(KIND_CAPS, CAP_LEVEL, view.caps())];
        for level in NODE_LEVEL..=view.root_level() {
            sections.push((KIND_NODES, level, view.nodes(level).as_bytes()));
        }
        let mut end = size_of::<Header>() + sections.len() * size_of::<SectionEntry>();
        let mut table = Vec::with_capacity(sections.len());
        for &(kind, level, bytes) in &sections {
            let offset = end.next_multiple_of(ALIGNMENT);
            end = offset + bytes.len();
            table.push(SectionEntry {
                kind: kind.into(),
                level: level.into(),
                offset: U64::new(offset as u64),
                length: U64::new(bytes.len() as u64),
                checksum: U32::new(checksum(bytes)),
                reserved: U32::ZERO,
            });
        }
        let header = self.header(&table, end);
        out.write_all(header.as_bytes())?;
        out.write_all(table.as_bytes())?;
        let mut written = size_of::<Header>() + table.as_bytes().len();
        for (entry, (_, _, bytes)) in table.iter().zip(sections) {
            out.write_all(&[0; ALIGNMENT][..entry.offset.get() as usize - written])?;
            out.write_all(bytes)?;
            written = entry.offset.get() as usize + bytes.len();
        }
        out.flush()
    }

    fn header(&self, table: &[SectionEntry], file_length: usize) -> Header {
        let meta = self.meta();
        let [min, max] = meta.range.unwrap_or([f64::NAN; 2]);
        let mut header = Header {
            magic: MAGIC,
            version: VERSION.into(),
            scalar: T::TYPE as u8,
            root_level: self.view().root_level() as u8,
            cap_level: CAP_LEVEL as u8,
            reserved: 0,
            dims: meta.dims.axes().map(U32::new),
            section_count: U32::new(table.len() as u32),
            index_to_world: meta.index_to_world.to_cols_array().map(F64::new),
            range: [min.into(), max.into()],
            non_finite: meta.non_finite.into(),
            file_length: U64::new(file_length as u64),
            cap_unit: U32::new(cap_unit::<T>() as u32),
            checksum: U32::ZERO,
            histogram: meta.histogram.map(U64::new),
            padding: [0; 24],
        };
        header.checksum = U32::new(header_checksum(&header, table));
        header
    }
}

/// Bytes that one task sums.
const CHECKSUM_CHUNK: usize = 1 << 22;

/// CRC-32 on all cores.
pub(crate) fn checksum(bytes: &[u8]) -> u32 {
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
