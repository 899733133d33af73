//! Lossy compression, within bounds: samples that may differ a little are made equal, so that more regions consolidate.
//!
//! [`Lossy`] stands between a source and [`build`](crate::build()), which itself remains lossless. A [`Loss`] says what may be lost; for
//! each sample that gives an interval of values it may take, and the sample always is in it.
//!
//! ```
//! use isoray_build::{Isovalues, Loss, Lossy, SurfaceTolerance, build};
//! use isoray_grid::{DenseVolume, Dims};
//!
//! // A ball with soft edges, in noise.
//! let dims = Dims::new([40, 40, 40])?;
//! let samples: Vec<u8> = (0..64_000i32)
//!     .map(|n| {
//!         let square: i32 = [n % 40, n / 40 % 40, n / 1600].iter().map(|c| (c - 20) * (c - 20)).sum();
//!         (128 + (100 - square).clamp(-80, 80) + n * 7919 % 5) as u8
//!     })
//!     .collect();
//! let source = DenseVolume::new(dims, &samples)?;
//! let bytes = |loss: Loss| -> Result<_, Box<dyn std::error::Error>> {
//!     Ok(build(&mut Lossy::new(source, &loss)?, glam::DAffine3::IDENTITY, |_| {})?.file_bytes())
//! };
//! let lossless = build(&mut source.clone(), glam::DAffine3::IDENTITY, |_| {})?.file_bytes();
//!
//! // No sample is off by more than 2.
//! assert!(bytes(Loss { tolerance: 2.0, ..Loss::default() })? < lossless / 2);
//! // The isosurface of 128.5 stays where it is, within a tenth of a voxel.
//! let surface = SurfaceTolerance { displacement: 0.1, isovalues: Isovalues::List(vec![128.5]) };
//! assert!(bytes(Loss { surface: Some(surface), ..Loss::default() })? < lossless / 3);
//! // All isosurfaces from 120 to 140 stay exactly where they are.
//! assert!(bytes(Loss { range: Some([120.0, 140.0]), ..Loss::default() })? < lossless / 2);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # What is guaranteed
//!
//! **Tolerance** T: every sample s becomes an s′ with |s′ − s| ≤ T in exact arithmetic (Knoll 2006, section 3.1, consolidates by variance and
//! takes the average, which bounds no single sample). Says nothing about surfaces: where the field is flat they move far, appear and vanish.
//!
//! **Range** \[LO, HI\]: samples in it are kept to the bit, and so are all isosurfaces of values v with LO ≤ v ≤ HI. This is stronger than
//! clamping, which displaces surfaces in cells that reach beyond the range: a sample outside is only changed if none of its cells is met by an
//! isovalue of the range. A cell with corners of values from `min` to `max` is met by v if min < v ≤ max, so by one in the range if min < max, max ≥ LO and min < HI.
//! The others are all below LO, all at or above HI, or constant in between; they stay so if samples below LO stay *below* (LO itself is
//! inside for v = LO) and those above HI stay at or above it.
//!
//! **Surface tolerance** D in voxels, for isovalues V: every point of a changed isosurface of v ∈ V has a point of the original
//! one of v within D in index space, along a lattice axis, and the other way round; D above 1 acts as 1.
//! It is the distance of surfaces, not of hits along rays: a ray that grazes the surface can hit, miss, or hit farther behind.
//!
//! Samples that are not finite are always kept to the bit, and no others become such. Bounds that are given together all hold.
//!
//! # Why surfaces keep within D
//!
//! Let f be the field and g the changed one. A cell is *met* if a v ∈ V has min < v ≤ max there, *apart* if not, and *empty* if a corner
//! is not finite. The rules are:
//!
//! 1. A sample keeps to its *bracket*: between the neighbouring isovalues of a list, below or at and above the ends of a range. The corners of an apart
//!    cell that is constant, with a value inside a range, are kept. So apart cells stay apart: for each v they are inside, or outside, in f and in g alike.
//! 2. For a met cell c choose an axis on which c has neighbours to both sides, neither of them empty, and the four edges along it in c, and in
//!    those neighbours that are met, all rise, or all fall, by m or more: there |∂f/∂x| ≥ m, as the slope is a mean of the edges' differences. Of several such axes, the one with the largest m.
//!    The corners of c and of those met neighbours change by at most ε = m·D/(1 + 2D). If there is no such axis, the corners of c are kept.
//!
//! Then g has slope m − 2ε > 0 of the same sign in these cells. Say it rises along x. Take p in c, and say f reaches v there and g does not,
//! f(p) = v > g(p) ≥ v − ε; the other three cases (g(p) > v, and f and g exchanged) mirror it. Walk from p towards larger x. In c, g rises by
//! m − 2ε or more per voxel. If g reaches v before the face to the next cell n, it does so within ε/(m − 2ε) ≤ D, and passes from outside to inside.
//! Otherwise, at the point q of the face, g(q) < v ≤ f(q). If n is apart, that contradicts rule 1: its side is the same in f and g, and a constant one has
//! g = f. So n is met, g has slope m − 2ε in it too, and v is reached within the same distance: D ≤ 1, so that the walk does not leave n.
//! With f and g exchanged the slope is m, and ε/m is less. A surface is in a cell that is met in the field it belongs to; by
//! rule 1 that cell was met before and after by some value of V, and rule 2 holds for it. If p itself lies on a face and the surface
//! needs the cell behind it, that one is met: an apart one is all inside or all outside, and c, monotone from that face on, would be too.
//!
//! At the border of the domain, and beside empty cells, an axis cannot be used, since the surface may leave the domain there. Changes are
//! computed in `f64` with the bound scaled by 1 − 2⁻⁵⁰, which covers the five roundings in it.
//!
//! # Which samples become equal
//!
//! An aligned block of 8³ samples, cut at the border of the domain, becomes one value if its intervals have one in common; else each of its caps of 4³ does if
//! its own have; else samples stay, but for a range's outsiders, which are clamped as far as they may.
//! If it is bitwise constant already, it stays as it is, so that a volume never gets larger by a loss. The one value is, in this order:
//! the one that a range clamps to, if it is among those in common; the roundest of the middle half of them, if the tolerance is finite; the roundest of them.
//! *Roundest* means most trailing zeros: neighbours then tend to agree, and merge upwards.
//!
//! Measured on heptane, CT head and chest CT with tolerances of 1 to 32 255ths of the range: the roundest of all gives the same size within
//! 0.08 points of raw size, and hits up to 1.6 times as far off on average; the middle itself has them up to 1.5 times nearer, and is larger by up to
//! 0.3 points. Keeping what is constant costs 0.07 points at most, and spares 15 to 70 % of all samples a change where much is constant.
//! Trying 16³ before 8³ could save at most the node of a 16³ region, 0.8 % of raw size of 8-bit samples, for twice the memory, and is not done.
//!
//! What is handed out depends on samples only: not on threads, nor on how many layers are read at a time.

#[cfg(test)]
mod brute_force;
mod layers;
mod limits;
mod loss;
mod merge;
mod rules;
mod source;
mod surfaces;
mod values;

pub use loss::{Isovalues, Loss, LossError, SurfaceTolerance};
pub use merge::Changes;
pub use source::{Lossy, LossyError};

/// Samples along the edge of a block: what the builder makes a parent of caps, or a scalar leaf, of.
const BLOCK_EDGE: usize = 1 << isoray_octree::NODE_LEVEL;
