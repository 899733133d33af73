//! What the benchmarks share: the published renderer that the project's is measured against, the generated
//! volumes, the two standard views, and what kernels are measured on.
//!
//! - [`knoll2006`] is the single-ray system of Knoll, Wald, Parker and Hansen (2006), with its errors
//!   corrected.
//! - [`volumes`] generates the Marschner–Lobb signal and a turbulent mixing layer, of any size.
//! - [`clumps`] generates adaptive meshes.
//! - [`cells`] has ray-cell pairs for the first-root finders.
//! - [`hashing`] finds samples in an octree, and their neighbours, in the ways of several papers.
//! - [`kernels`] has the work that criterion times and that instructions are counted of.
//! - [`layouts`] tells how large a volume is in other layouts of nodes and caps.
//! - [`path`] leads a ray through all cells.
//! - [`views`] has the rays of the far and the close view that all figures are given for.
//!
//! ```
//! use isoray_benches::{knoll2006::PaperOctree, views::View, volumes::marschner_lobb};
//! use isoray_grid::Dims;
//!
//! let dims = Dims::new([32; 3])?;
//! let tree = PaperOctree::build(dims, &marschner_lobb(32));
//! let view = View::far(dims, 16, 16);
//! let hits = view.directions.iter().filter_map(|&d| tree.first_hit(view.origin, d, 127.5)).count();
//! assert!(hits > 40);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod cells;
pub mod clumps;
pub mod hashing;
pub mod kernels;
pub mod knoll2006;
pub mod layouts;
pub mod path;
pub mod views;
pub mod volumes;
