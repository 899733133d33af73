//! What surfaces are looked for.

use isoray_grid::Scalar;
use isoray_octree::Node;

/// The least values that are inside of some isosurfaces, mostly of one.
#[derive(Clone, Debug, PartialEq)]
pub struct Thresholds<T> {
    pub(crate) first: T,
    pub(crate) others: Vec<T>,
}

impl<T: Scalar> Thresholds<T> {
    /// The children of `node` whose cells can hold any of the surfaces.
    #[inline(always)]
    pub(crate) fn active(&self, node: &Node<T::Stored>) -> u32 {
        self.others.iter().fold(node.active(self.first), |active, &other| active | node.active(other))
    }

    /// Whether it is this one alone.
    #[inline(always)]
    pub(crate) fn is_only(&self, threshold: T) -> bool {
        self.first == threshold && self.others.is_empty()
    }
}
