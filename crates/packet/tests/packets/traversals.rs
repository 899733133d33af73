//! All ways of packets.

use isoray_packet::{Slicing, Traversal};

/// One of them: of every ten, three are by slabs.
pub(crate) fn one_of(n: usize) -> Traversal {
    const STUDIED: [Slicing; 4] = [Slicing::Extents, Slicing::Kept, Slicing::Macrocells, Slicing::Active];
    match n % 10 {
        0 | 5 => Traversal::Auto,
        1 | 4 => Traversal::Coherent(Slicing::default()),
        7 => Traversal::Coherent(STUDIED[n / 10 % STUDIED.len()]),
        _ => Traversal::Masked,
    }
}
