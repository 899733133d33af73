//! Interior nodes.

use isoray_grid::{Scalar, Threshold};
use zerocopy::little_endian::U32;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// An interior node: what traversal needs of its eight children (Knoll 2006, section 4.1), in
/// `24·size + 5` bytes without padding.
///
/// Octant `n` is the child whose low corner is offset by half the node's edge along x if `n & 1`, y if
/// `n & 2`, z if `n & 4`. A child region is either *stored*, when its bit in `mask` is set, or a *scalar leaf*,
/// all samples of which equal `values[n]`, or lies outside the domain, when it has an empty range.
#[derive(Clone, Copy, Debug, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned)]
#[repr(C)]
pub struct Node<S: Unaligned> {
    /// Least finite sample of each child's cells, their forward corners included. Where coarse samples are means, those of children of edge 8
    /// and more bound them too; see [`mod@lod`](crate::lod).
    pub mins: [S; 8],
    /// Greatest finite sample of each child's cells. A child without cells or finite samples has
    /// `min = ` the type's highest value and `max = ` its lowest.
    pub maxs: [S; 8],
    /// The coarse sample at each child's low corner, by default the volume's own there; of a scalar leaf, every sample.
    pub values: [S; 8],
    /// Where the stored children begin: an index into the nodes one level down, or, at the
    /// lowest level, into the caps in units of [`cap_unit`](crate::cap_unit) bytes. They lie contiguously in octant order.
    pub first: U32,
    /// Bit `n`: child `n` is stored.
    pub mask: u8,
}

impl<S: Unaligned + Copy> Node<S> {
    /// Whether child `octant` is stored (and not a scalar leaf).
    #[inline(always)]
    pub fn is_stored(&self, octant: u32) -> bool {
        self.mask >> octant & 1 == 1
    }

    /// How many stored children come before `octant`.
    #[inline(always)]
    pub fn rank(&self, octant: u32) -> u32 {
        (u32::from(self.mask) & ((1 << octant) - 1)).count_ones()
    }

    /// The stored children before `octant`.
    pub fn stored_before(&self, octant: u32) -> impl Iterator<Item = u32> {
        let mask = self.mask;
        (0..octant).filter(move |&n| mask >> n & 1 == 1)
    }

    /// Index of stored child `octant` among the nodes one level down.
    #[inline(always)]
    pub fn child(&self, octant: u32) -> usize {
        self.first.get() as usize + self.rank(octant) as usize
    }

    /// The children whose cells can hold the surface, as a bit mask: `min < v ≤ max`.
    #[inline(always)]
    pub fn active<T: Scalar<Stored = S>>(&self, threshold: T) -> u32 {
        let both = std::array::from_fn(|n| if n < 8 { self.mins[n] } else { self.maxs[n - 8] });
        let at_least = T::at_least_16(&both, threshold);
        at_least >> 8 & !at_least & 0xff
    }

    /// The children whose finite samples are all `≥ threshold`, and those of which the ranges do not tell on which side they are: on both, or
    /// without cells. All others are below. As bit masks.
    #[inline(always)]
    pub fn sides<T: Scalar<Stored = S>>(&self, threshold: T) -> [u32; 2] {
        let both = std::array::from_fn(|n| if n < 8 { self.mins[n] } else { self.maxs[n - 8] });
        let at_least = T::at_least_16(&both, threshold);
        // The least is greater than the greatest where there are no cells.
        let (least, greatest) = (at_least & 0xff, at_least >> 8);
        [least & greatest, least ^ greatest]
    }

    /// Whether the finite samples of child `octant` are all `≥ threshold`, or all below it; `None` if neither, or if the range
    /// does not tell because the child has no cells.
    #[inline(always)]
    pub fn side<T: Scalar>(&self, octant: u32, threshold: T) -> Option<bool>
    where
        S: Into<T>,
    {
        let octant = octant as usize & 7;
        let (min, max): (T, T) = (self.mins[octant].into(), self.maxs[octant].into());
        let inside = min >= threshold;
        (min <= max && inside == (max >= threshold)).then_some(inside)
    }

    /// The coarse sample at the low corner of child `octant`; of a scalar leaf, every sample.
    #[inline(always)]
    pub fn value<T>(&self, octant: u32) -> T
    where
        S: Into<T>,
    {
        self.values[octant as usize & 7].into()
    }

    /// The range of child `octant`.
    #[inline(always)]
    pub fn range<T: Scalar>(&self, octant: usize) -> Range<T>
    where
        S: Into<T>,
    {
        Range { min: self.mins[octant].into(), max: self.maxs[octant].into() }
    }
}

/// Value range of the cells of a region: samples outside the domain and non-finite ones take no part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range<T> {
    /// Least value.
    pub min: T,
    /// Greatest value; below `min` when the range is empty.
    pub max: T,
}

impl<T: Scalar> Range<T> {
    /// The range of no sample.
    pub const EMPTY: Self = Self { min: T::HIGHEST, max: T::LOWEST };

    /// The smallest range that holds both.
    pub fn union(self, other: Self) -> Self {
        Self {
            min: if other.min < self.min { other.min } else { self.min },
            max: if other.max > self.max { other.max } else { self.max },
        }
    }

    /// Extends the range by a sample, unless that is NaN or infinite.
    pub fn include(&mut self, s: T) {
        if s.is_finite() {
            *self = self.union(Self { min: s, max: s });
        }
    }

    /// Whether a surface of isovalue `v` can lie in cells of this range: `min < v ≤ max`.
    pub fn straddles(self, v: f32) -> bool {
        match T::threshold(v) {
            Threshold::AtLeast(least) => self.min < least && least <= self.max,
            Threshold::NoSurface => false,
        }
    }
}
