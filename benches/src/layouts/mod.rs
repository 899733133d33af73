//! How large a volume is in other node layouts than the one that is used.
//!
//! One pass over the samples ([`Tally::of`]) counts what all layouts with one edge of caps share; what a layout takes is a sum of these
//! counts. The layout of `.ovol` files and that of the 2006 paper are among them, so that the counts can be compared
//! with structures that exist.

mod tally;
#[cfg(test)]
mod tests;

pub use tally::Tally;

/// What a cap's samples are stored as. Integers; of floating-point numbers the bits are taken, in the order of the numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Payload {
    /// As they are.
    Raw,
    /// Distances from the least value of the range in the parent, in 1, 2, 4, 8, 16 or 32 bits.
    Powers,
    /// The same in as many bits as the range needs.
    Range,
    /// Distances from the cap's own least sample, in as many bits as its own samples need; that sample and a byte for the number of bits
    /// come with each cap.
    Own,
}

impl Payload {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Raw, Self::Powers, Self::Range, Self::Own];

    /// A short name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Raw => "raw",
            Self::Powers => "2^n bits",
            Self::Range => "range bits",
            Self::Own => "own bits",
        }
    }
}

/// What a node holds beside the least and the greatest value of eight children.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NodeKind {
    /// Eight values and eight 32-bit links.
    Links,
    /// Eight values, one 32-bit link and eight offsets of a byte: that of the 2006 paper.
    Offsets,
    /// Eight values, one 32-bit link and a mask of eight bits: that of `.ovol` files.
    Mask,
    /// The same with values only of the children that are not stored.
    MaskWithoutValues,
}

impl NodeKind {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Links, Self::Offsets, Self::Mask, Self::MaskWithoutValues];

    /// A short name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Links => "8 links",
            Self::Offsets => "8 offsets",
            Self::Mask => "mask",
            Self::MaskWithoutValues => "mask, values of leaves",
        }
    }
}
