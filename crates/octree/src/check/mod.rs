//! Verifying a structure node by node.

mod block;
mod contents;
mod links;

use isoray_grid::Scalar;

use crate::counts::Counts;
use crate::fidelity::Coarse;
use crate::node::Range;
use crate::view::OctreeView;

/// A node that breaks the structure's rules.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("level {level}, element {index}: {what}")]
pub struct Malformed {
    /// Level of the node; 2 is the caps'.
    pub level: u32,
    /// Its index.
    pub index: usize,
    /// The rule it breaks.
    pub what: &'static str,
}

/// Verifies every node: each stored element is linked to exactly once, ranges bound the samples of the
/// cells and are tight, values are those of the low corners, as in a volume whose coarse samples are injected.
///
/// Safe on any bytes: it takes time in proportion to the structure, whatever the dimensions say.
///
/// # Errors
/// A node that breaks a rule.
pub fn check_well_formed<T: Scalar>(view: &OctreeView<'_, T>) -> Result<(), Malformed> {
    check_well_formed_as(view, Coarse::Injected)
}

/// As [`check_well_formed`], of a volume with coarse samples of some kind: values are those samples, ranges bound them too and are tight. A volume
/// without them has the values and ranges of one whose coarse samples are injected.
///
/// # Errors
/// A node that breaks a rule.
pub fn check_well_formed_as<T: Scalar>(view: &OctreeView<'_, T>, kind: Coarse) -> Result<(), Malformed> {
    check_with_progress(view, kind, &mut |_| {}).map(|_| ())
}

/// What all samples have in common.
pub(crate) struct Statistics<T> {
    pub(crate) range: Range<T>,
    pub(crate) counts: Counts<T>,
}

/// As [`check_well_formed`], and calls `progress` with the share that is done, up to 1, now and then.
pub(crate) fn check_with_progress<T: Scalar>(
    view: &OctreeView<'_, T>,
    kind: Coarse,
    progress: &mut (dyn FnMut(f64) + Send),
) -> Result<Statistics<T>, Malformed> {
    let level = view.root_level();
    let root = view.root().ok_or(Malformed { level, index: 0, what: "the root is missing" })?;
    // Links first: once every element is known to have one parent, the passes over it are bounded, where
    // damaged links could make one subtree appear under any number of nodes.
    links::check(view, root)?;
    contents::check(view, root, kind, progress)
}
