//! Coarse samples that are means of others: a pass over the finished structure.
//!
//! What depends on neighbours in all directions is not known while nodes are made, and only nodes change: caps are written once, and the
//! source is read once.

use isoray_octree::Coarse;

/// Whether coarse samples of this kind are made by a pass over the finished structure.
pub(crate) fn need_a_pass(kind: Coarse) -> bool {
    matches!(kind, Coarse::Mean | Coarse::Filtered)
}

/// Bytes that the pass needs: all nodes, the places of an eighth of them, and what every thread works on, a cube of 71³ samples of up to four
/// bytes with its coarse ones.
pub(crate) fn needed(nodes: u64, threads: usize) -> u64 {
    const WORK: u64 = 2 << 20;
    /// The process itself, and changes that wait to be made together.
    const OVERHEAD: u64 = 32 << 20;
    nodes.saturating_add(nodes / 8).saturating_add(OVERHEAD + WORK * threads as u64)
}
