//! Interior levels, bottom-up.

use isoray_grid::{Dims, Scalar};
use isoray_octree::{NODE_LEVEL, Node, Range, root_level};

/// A finished node, not yet stored: whether it will be is up to its parent.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Region<T: Scalar> {
    pub(crate) range: Range<T>,
    /// The sample at its low corner.
    pub(crate) low: T,
    /// All its samples are bitwise equal to `low`.
    pub(crate) is_constant: bool,
    pub(crate) node: Node<T::Stored>,
}

impl<T: Scalar> Default for Region<T> {
    fn default() -> Self {
        Self::constant(T::default(), Range::EMPTY)
    }
}

impl<T: Scalar> Region<T> {
    /// A region whose samples are all `value`, and whose children all have the same range.
    pub(crate) fn constant(value: T, range: Range<T>) -> Self {
        Self::of_children([range; 8], [value; 8], 0, 0)
    }

    /// The region of eight children, of which those in `mask` are stored from `first` on. A child outside the domain has
    /// an empty range and the value of the first, which is always inside.
    pub(crate) fn of_children(ranges: [Range<T>; 8], values: [T; 8], first: u32, mask: u8) -> Self {
        let low = values[0];
        let node = Node {
            mins: ranges.map(|r| r.min.into()),
            maxs: ranges.map(|r| r.max.into()),
            values: values.map(Into::into),
            first: if mask == 0 { 0 } else { first }.into(),
            mask,
        };
        let is_constant = mask == 0 && values.iter().all(|v| v.same_bits(low));
        Self { range: ranges.into_iter().fold(Range::EMPTY, Range::union), low, is_constant, node }
    }
}

impl<T: Scalar> Region<T> {
    /// The same with links that count from `base` further down.
    pub(crate) fn moved(mut self, base: u32) -> Self {
        if self.node.mask != 0 {
            self.node.first += base;
        }
        self
    }
}

/// One layer of regions of one level, x fastest.
#[derive(Clone, Debug)]
pub(crate) struct Layer<T: Scalar> {
    pub(crate) size: [usize; 2],
    pub(crate) regions: Vec<Region<T>>,
}

/// Takes layers of regions from the bottom, in order, and makes the levels above of them.
#[derive(Debug)]
pub(crate) struct Consolidation<T: Scalar> {
    /// By level, a layer that waits for the one above it.
    pending: Vec<Option<Layer<T>>>,
    /// By level, the nodes that have been stored since the last [`drain`](Self::drain), and how many there were before.
    levels: Vec<Vec<Node<T::Stored>>>,
    drained: Vec<u32>,
}

impl<T: Scalar> Consolidation<T> {
    pub(crate) fn new(dims: Dims) -> Self {
        let count = (root_level(dims) - NODE_LEVEL + 1) as usize;
        Self { pending: vec![None; count], levels: vec![Vec::new(); count], drained: vec![0; count] }
    }

    /// Adds the next layer of parents of caps.
    pub(crate) fn push(&mut self, layer: Layer<T>) {
        self.push_at(0, layer);
    }

    fn push_at(&mut self, level: usize, layer: Layer<T>) {
        match self.pending[level].take() {
            None => self.pending[level] = Some(layer),
            Some(below) => {
                let combined = self.combine(level, &below, Some(&layer));
                self.push_at(level + 1, combined);
            }
        }
    }

    /// The layer one level up; children that are not constant are stored.
    fn combine(&mut self, level: usize, below: &Layer<T>, above: Option<&Layer<T>>) -> Layer<T> {
        let size = below.size.map(|n| n.div_ceil(2));
        let (stored, drained) = (&mut self.levels[level], self.drained[level]);
        let parents = (0..size[0] * size[1]).map(|n| {
            let [x, y] = [n % size[0], n / size[0]];
            let child = |octant: usize| {
                let layer = if octant & 4 == 0 { Some(below) } else { above };
                let [cx, cy] = [2 * x + (octant & 1), 2 * y + (octant >> 1 & 1)];
                layer.filter(|l| cx < l.size[0] && cy < l.size[1]).map(|l| &l.regions[cy * l.size[0] + cx])
            };
            parent(std::array::from_fn(child), stored, drained)
        });
        let regions = parents.collect();
        Layer { size, regions }
    }

    /// Hands out the nodes that have been stored since the last time, by level.
    pub(crate) fn drain<E>(
        &mut self,
        mut f: impl FnMut(u32, &[Node<T::Stored>]) -> Result<(), E>,
    ) -> Result<(), E> {
        for (level, (nodes, drained)) in (NODE_LEVEL..).zip(self.levels.iter_mut().zip(&mut self.drained)) {
            if !nodes.is_empty() {
                f(level, nodes)?;
                *drained += nodes.len() as u32;
                nodes.clear();
            }
        }
        Ok(())
    }

    /// Stores the root, once all layers are in.
    pub(crate) fn finish(&mut self) {
        let top = self.levels.len() - 1;
        for level in 0..top {
            if let Some(below) = self.pending[level].take() {
                let combined = self.combine(level, &below, None);
                self.push_at(level + 1, combined);
            }
        }
        let root = self.pending[top].take().and_then(|layer| layer.regions.first().map(|r| r.node));
        self.levels[top].extend(root);
    }
}

/// The region of up to eight children, of which the first is in the domain; `None` are those outside.
fn parent<T: Scalar>(
    children: [Option<&Region<T>>; 8],
    stored: &mut Vec<Node<T::Stored>>,
    drained: u32,
) -> Region<T> {
    let low = children[0].map_or(T::default(), |c| c.low);
    let first = drained + stored.len() as u32;
    let mut mask = 0;
    for (octant, child) in children.iter().enumerate() {
        if let Some(child) = child.filter(|c| !c.is_constant) {
            mask |= 1 << octant;
            stored.push(child.node);
        }
    }
    let ranges = children.map(|c| c.map_or(Range::EMPTY, |c| c.range));
    let values = children.map(|c| c.map_or(low, |c| c.low));
    Region::of_children(ranges, values, first, mask)
}
