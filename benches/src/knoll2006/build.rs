//! Bottom-up consolidation (sections 3.1, 3.3 and 4.1).

use isoray_grid::{Dims, Scalar};

use super::{LEAF, OctCap, OctNode, PaperOctree, child_cell};

/// The least and greatest finite sample of a region's cells; above its maximum where there is none.
#[derive(Clone, Copy)]
struct MinMax<T> {
    min: T,
    max: T,
}

impl<T: Scalar> MinMax<T> {
    const NONE: Self = Self { min: T::HIGHEST, max: T::LOWEST };

    #[inline(always)]
    fn join(&mut self, min: T, max: T) {
        self.min = if min < self.min { min } else { self.min };
        self.max = if max > self.max { max } else { self.max };
    }
}

/// What a region became.
enum Region<T> {
    /// No sample of the domain.
    Outside,
    /// Samples of one value.
    Leaf(T),
    Cap(OctCap<T>),
    Node(OctNode<T>),
}

struct Builder<'a, T> {
    dims: Dims,
    samples: &'a [T],
    max_depth: usize,
    nodes: Vec<Vec<OctNode<T>>>,
    caps: Vec<OctCap<T>>,
}

impl<T: Scalar> PaperOctree<T> {
    /// Compresses `samples`, `i` fastest, without loss.
    ///
    /// # Panics
    /// Unless there are `dims.samples()` of them.
    pub fn build(dims: Dims, samples: &[T]) -> Self {
        assert_eq!(samples.len(), dims.samples(), "one sample for every lattice point of {dims}");
        let [nx, ny, nz] = dims.axes();
        // At least a root and its caps.
        let max_depth = (nx.max(ny).max(nz).next_power_of_two().ilog2() as usize).max(2);
        let nodes = vec![Vec::new(); max_depth - 1];
        let mut builder = Builder { dims, samples, max_depth, nodes, caps: Vec::new() };
        let root = match builder.region(0, [0; 3]) {
            (Region::Node(node), _) => node,
            (Region::Leaf(value), range) => OctNode {
                child_scalars: [value; 8],
                child_mins: [range.min; 8],
                child_maxs: [range.max; 8],
                child_start: 0,
                child_offset: [LEAF; 8],
            },
            (Region::Outside | Region::Cap(_), _) => unreachable!("the root holds samples and is no cap"),
        };
        let Builder { mut nodes, mut caps, .. } = builder;
        nodes[0].push(root);
        nodes.iter_mut().for_each(Vec::shrink_to_fit);
        caps.shrink_to_fit();
        let child_bit_depth =
            std::array::from_fn(|d| if d < max_depth { 1 << (max_depth - d - 1) } else { 0 });
        Self { dims, max_depth, nodes, caps, child_bit_depth }
    }
}

impl<T: Scalar> Builder<'_, T> {
    /// The region of `depth` at `cell`, its descendants stored, but not itself.
    fn region(&mut self, depth: usize, cell: [i32; 3]) -> (Region<T>, MinMax<T>) {
        let n = self.dims.axes();
        if (0..3).any(|a| cell[a] as u32 >= n[a]) {
            return (Region::Outside, MinMax::NONE);
        }
        if depth == self.max_depth - 1 {
            return self.cap(cell);
        }
        let bit = 1 << (self.max_depth - depth - 1);
        let children = std::array::from_fn(|n| self.region(depth + 1, child_cell(cell, n, bit)));
        self.node(depth, children)
    }

    /// The cap at `cell`, or a leaf if its samples are equal. Its range takes in the 27 samples of its cells.
    fn cap(&self, cell: [i32; 3]) -> (Region<T>, MinMax<T>) {
        let n = self.dims.axes();
        // Beyond the border the last sample stands in: it widens no range and spoils no leaf.
        let at: [[usize; 3]; 3] =
            std::array::from_fn(|a| std::array::from_fn(|k| (cell[a] as usize + k).min(n[a] as usize - 1)));
        let mut range = MinMax::NONE;
        let mut scalars = [T::default(); 8];
        for (k, z) in at[2].into_iter().enumerate() {
            for (j, y) in at[1].into_iter().enumerate() {
                let row = (z * n[1] as usize + y) * n[0] as usize;
                for (i, x) in at[0].into_iter().enumerate() {
                    let s = self.samples[row + x];
                    if s.is_finite() {
                        range.join(s, s);
                    }
                    if i < 2 && j < 2 && k < 2 {
                        scalars[i << 2 | j << 1 | k] = s;
                    }
                }
            }
        }
        let is_leaf = scalars.iter().all(|s| s.same_bits(scalars[0]));
        (if is_leaf { Region::Leaf(scalars[0]) } else { Region::Cap(scalars) }, range)
    }

    /// The node with these children, or a leaf if they are leaves of one value.
    fn node(&mut self, depth: usize, children: [(Region<T>, MinMax<T>); 8]) -> (Region<T>, MinMax<T>) {
        let mut range = MinMax::NONE;
        let mut node = OctNode {
            child_scalars: [T::default(); 8],
            child_mins: children.each_ref().map(|c| c.1.min),
            child_maxs: children.each_ref().map(|c| c.1.max),
            child_start: 0,
            child_offset: [LEAF; 8],
        };
        let mut only_value = None;
        let mut is_leaf = true;
        let mut stored = 0;
        for (n, (child, child_range)) in children.into_iter().enumerate() {
            range.join(child_range.min, child_range.max);
            let start = match child {
                Region::Outside => continue,
                Region::Leaf(value) => {
                    node.child_scalars[n] = value;
                    is_leaf &= only_value.get_or_insert(value).same_bits(value);
                    continue;
                }
                Region::Cap(cap) => push(&mut self.caps, cap),
                Region::Node(child) => push(&mut self.nodes[depth + 1], child),
            };
            if stored == 0 {
                node.child_start = start;
            }
            node.child_offset[n] = stored;
            stored += 1;
        }
        match only_value {
            Some(value) if is_leaf && stored == 0 => (Region::Leaf(value), range),
            _ => (Region::Node(node), range),
        }
    }
}

/// Appends, and says where.
fn push<E>(array: &mut Vec<E>, element: E) -> u32 {
    array.push(element);
    u32::try_from(array.len() - 1).expect("the paper's links have 32 bits")
}
