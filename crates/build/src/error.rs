//! What a build says of itself.

use isoray_grid::Dims;
use isoray_octree::SaveError;

/// How far a build has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Samples done.
    pub done: u64,
    /// Samples in all.
    pub total: u64,
}

/// A build that could not be finished.
#[derive(Debug, thiserror::Error)]
pub enum BuildError<E: std::error::Error + 'static> {
    /// The source failed.
    #[error(transparent)]
    Source(E),
    /// The volume could not be stored.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A limit that does not even allow for what has to be held at once.
    #[error(
        "a {dims} volume needs at least {needed} bytes of memory to be built with {threads} threads, and the limit is {limit}"
    )]
    Limit {
        /// Size of the lattice.
        dims: Dims,
        /// The limit.
        limit: u64,
        /// The least that would do.
        needed: u64,
        /// Threads that each need some of it.
        threads: usize,
    },
}

/// Why the parts of a structure could not be stored.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// The file could not be written.
    #[error(transparent)]
    Save(#[from] SaveError),
    /// More than 32-bit links can address.
    #[error("the volume is too large and too noisy: {found} bytes of caps, expected at most {most}")]
    TooLarge {
        /// Bytes of caps so far.
        found: u64,
        /// Bytes that links can address.
        most: u64,
    },
    /// The operating system gives no memory for what has to be held at once.
    #[error("the volume needs {bytes} bytes of memory for its {what}, more than can be had")]
    Memory {
        /// What was to be held.
        what: &'static str,
        /// Bytes of it.
        bytes: u64,
    },
}

/// Makes room for `additional` elements more; beyond what is asked for only where that can be had.
pub(crate) fn reserve<S>(vec: &mut Vec<S>, additional: usize, what: &'static str) -> Result<(), StoreError> {
    vec.try_reserve(additional).or_else(|_| vec.try_reserve_exact(additional)).map_err(|_| {
        let bytes = (vec.len() as u128 + additional as u128) * size_of::<S>() as u128;
        StoreError::Memory { what, bytes: u64::try_from(bytes).unwrap_or(u64::MAX) }
    })
}
