//! The counting pass.

use isoray_grid::{Dims, Scalar};
use rayon::prelude::*;

use super::{NodeKind, Payload};

/// What layouts with caps of one edge have in common.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Bytes of a sample.
    sample: u64,
    /// Nodes, the root included.
    pub nodes: u64,
    /// Children of nodes that are stored, caps included.
    pub stored: u64,
    /// Caps.
    pub caps: u64,
    /// Samples of a cap that the domain's border does not cut short, its apron included.
    whole_cap: u64,
    /// Bytes of all caps, by payload.
    payload: [u64; Payload::ALL.len()],
}

/// A region that has been looked at.
#[derive(Clone, Copy)]
struct Region<T> {
    /// The sample at its low corner.
    low: T,
    is_constant: bool,
}

/// What caps look like.
#[derive(Clone, Copy, Debug)]
struct Shape {
    dims: Dims,
    /// Samples along an edge, without apron.
    edge: u32,
    has_apron: bool,
}

impl Tally {
    /// Counts what `samples`, x fastest, become with caps of `edge` samples along each axis, a power of two. With an apron caps hold
    /// also the first samples beyond, so that all corners of their cells are at hand; and a region is a leaf only if those
    /// corners are all alike.
    ///
    /// # Panics
    /// Unless there are `dims.samples()` samples, and `edge` is a power of two from 2 on.
    pub fn of<T: Scalar>(dims: Dims, samples: &[T], edge: u32, has_apron: bool) -> Self {
        assert_eq!(samples.len(), dims.samples(), "one sample for every lattice point of {dims}");
        assert!(edge >= 2 && edge.is_power_of_two(), "caps of {edge}³ samples");
        let shape = Shape { dims, edge, has_apron };
        let whole = u64::from(edge) + u64::from(has_apron);
        let tally = Self { sample: size_of::<T>() as u64, whole_cap: whole.pow(3), ..Self::default() };
        // The lowest nodes with their caps, each of which is looked at once.
        let mut size = dims.axes().map(|n| n.div_ceil(2 * edge) as usize);
        let layer = |z: usize| {
            let mut tally = Self::default();
            let mut regions = Vec::with_capacity(size[0] * size[1]);
            for n in 0..size[0] * size[1] {
                let origin = [n % size[0], n / size[0], z].map(|p| p as u32 * 2 * edge);
                let (region, own) = shape.parent(samples, origin);
                regions.push(region);
                tally = tally.with(own);
            }
            (regions, tally)
        };
        let layers: Vec<_> = (0..size[2]).into_par_iter().map(layer).collect();
        let mut tally = layers.iter().fold(tally, |tally, layer| tally.with(layer.1));
        let mut regions: Vec<_> = layers.into_iter().flat_map(|layer| layer.0).collect();
        // Levels above them, whose nodes are stored where they are not constant.
        while regions.len() > 1 {
            let below = size;
            size = size.map(|n| n.div_ceil(2));
            let at = |p: [usize; 3]| regions[(p[2] * below[1] + p[1]) * below[0] + p[0]];
            let mut above = Vec::with_capacity(size.iter().product());
            for n in 0..size.iter().product() {
                let place = [n % size[0], n / size[0] % size[1], n / (size[0] * size[1])];
                let child = |octant: usize| {
                    let p: [usize; 3] = std::array::from_fn(|a| 2 * place[a] + (octant >> a & 1));
                    (0..3).all(|a| p[a] < below[a]).then(|| at(p))
                };
                let (region, stored) = join((0..8).filter_map(child));
                tally.nodes += stored;
                tally.stored += stored;
                above.push(region);
            }
            regions = above;
        }
        // The root is stored whatever it is, and nobody's child.
        tally.nodes += 1;
        tally
    }

    fn with(self, other: Self) -> Self {
        let payload = std::array::from_fn(|n| self.payload[n] + other.payload[n]);
        Self {
            stored: self.stored + other.stored,
            nodes: self.nodes + other.nodes,
            caps: self.caps + other.caps,
            payload,
            ..self
        }
    }

    /// Bytes of all nodes.
    pub fn node_bytes(&self, kind: NodeKind) -> u64 {
        let (size, nodes) = (self.sample, self.nodes);
        match kind {
            NodeKind::Links => nodes * (24 * size + 8 * 4),
            NodeKind::Offsets => nodes * (24 * size + 4 + 8),
            NodeKind::Mask => nodes * (24 * size + 4 + 1),
            NodeKind::MaskWithoutValues => nodes * (24 * size + 4 + 1) - self.stored * size,
        }
    }

    /// Bytes of all caps. Those at the domain's border hold no more than what is inside it; those of one parent begin at a multiple of eight
    /// samples.
    pub fn cap_bytes(&self, payload: Payload) -> u64 {
        self.payload[payload as usize]
    }

    /// Bytes of all caps if those at the domain's border are as large as the others.
    pub fn whole_cap_bytes(&self) -> u64 {
        self.caps * self.whole_cap * self.sample
    }
}

/// The region of these parts, and how many of them have to be stored.
fn join<T: Scalar>(children: impl Iterator<Item = Region<T>>) -> (Region<T>, u64) {
    let mut joined: Option<Region<T>> = None;
    let mut stored = 0;
    for child in children {
        stored += u64::from(!child.is_constant);
        let all = joined.get_or_insert(child);
        all.is_constant &= child.is_constant && child.low.same_bits(all.low);
    }
    let region = joined.unwrap_or(Region { low: T::default(), is_constant: true });
    (region, stored)
}

impl Shape {
    /// The lowest node at `origin` and its caps; whether it is stored itself is up to its parent.
    fn parent<T: Scalar>(self, samples: &[T], origin: [u32; 3]) -> (Region<T>, Tally) {
        let mut tally = Tally::default();
        let children = (0..8u32).filter_map(|octant| {
            let corner = std::array::from_fn(|a| origin[a] + (octant >> a & 1) * self.edge);
            let is_inside = (0..3).all(|a| corner[a] < self.dims.axes()[a]);
            is_inside.then(|| self.cap(samples, corner, &mut tally.payload))
        });
        let (region, stored) = join(children);
        tally.caps = stored;
        tally.stored = stored;
        let unit = 8 * size_of::<T>() as u64;
        tally.payload = tally.payload.map(|bytes| bytes.next_multiple_of(unit));
        (region, tally)
    }

    /// The cap at `corner`; unless it is constant, its bytes are added.
    fn cap<T: Scalar>(
        self,
        samples: &[T],
        corner: [u32; 3],
        bytes: &mut [u64; Payload::ALL.len()],
    ) -> Region<T> {
        let n = self.dims.axes();
        let inside = |edge: u32| -> [u32; 3] { std::array::from_fn(|a| (n[a] - corner[a]).min(edge)) };
        let (own, around) = (inside(self.edge), inside(self.edge + 1));
        let held = if self.has_apron { around } else { own };
        let low = samples[self.dims.linear(corner)];
        // Of the samples that are held, bits in the order of values, and whether all are the first and finite.
        let (mut least, mut greatest, mut is_constant, mut is_finite) = (u32::MAX, 0, true, true);
        // Of the cells' corners, the finite ones.
        let (mut range_least, mut range_greatest) = (u32::MAX, 0);
        for z in 0..around[2] {
            for y in 0..around[1] {
                let start = self.dims.linear([corner[0], corner[1] + y, corner[2] + z]);
                let row = &samples[start..][..around[0] as usize];
                for &sample in row {
                    let at = ordered(sample);
                    if sample.is_finite() {
                        range_least = range_least.min(at);
                        range_greatest = range_greatest.max(at);
                    }
                }
                if y < held[1] && z < held[2] {
                    for &sample in &row[..held[0] as usize] {
                        let at = ordered(sample);
                        least = least.min(at);
                        greatest = greatest.max(at);
                        is_constant &= sample.same_bits(low);
                        is_finite &= sample.is_finite();
                    }
                }
            }
        }
        if !is_constant {
            let count = held.iter().map(|&n| u64::from(n)).product::<u64>();
            // Without cells no range is known; nor do ranges know of values that are not finite.
            let has_cells = (0..3).all(|a| corner[a] + 1 < n[a]);
            let full = 8 * size_of::<T>() as u64;
            let of_range = if has_cells && is_finite { width(range_least, range_greatest) } else { full };
            let size = size_of::<T>() as u64;
            let bits = |width: u64| (width * count).div_ceil(8);
            for (bytes, payload) in bytes.iter_mut().zip(Payload::ALL) {
                *bytes += match payload {
                    Payload::Raw => count * size,
                    Payload::Powers => bits(of_range.next_power_of_two()),
                    Payload::Range => bits(of_range),
                    Payload::Own => bits(width(least, greatest)) + size + 1,
                };
            }
        }
        Region { low, is_constant }
    }
}

/// Bits for distances in a range.
fn width(least: u32, greatest: u32) -> u64 {
    u64::from(u32::BITS - (greatest - least).leading_zeros())
}

/// A number for each value, ordered as the values are: that of an integer so that distances are kept.
fn ordered<T: Scalar>(sample: T) -> u32 {
    let bits = sample.to_bits();
    if T::IS_INTEGER {
        sample.steps_above(T::LOWEST) as u32
    } else if bits >> 31 == 0 {
        bits | 1 << 31
    } else {
        !bits
    }
}
