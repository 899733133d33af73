//! Octree volumes from samples.

use super::{Answer, octree};

/// The samples of a generated volume.
#[derive(Clone, Debug)]
pub struct Building {
    samples: Vec<u8>,
}

impl Building {
    /// Those that `generate` gives for a number of samples along each edge: a function of [`volumes`](crate::volumes).
    pub fn new(generate: fn(usize) -> Vec<u8>) -> Self {
        Self { samples: generate(super::EDGE) }
    }

    /// How many.
    pub fn count(&self) -> u64 {
        self.samples.len() as u64
    }

    /// Builds it: bytes that it takes, and those of the samples alone.
    #[inline(never)]
    pub fn build(&self) -> Answer {
        let octree = octree(&self.samples);
        Answer { found: octree.file_bytes() as u64, sum: octree.raw_bytes() as f64 }
    }
}
