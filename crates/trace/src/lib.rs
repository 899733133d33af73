//! One ray at a time through a volume: crossings of isosurfaces, whether there is any, or what a medium emits and absorbs.
//!
//! A program traces its own rays against its own array:
//!
//! ```
//! use isoray_trace::{DenseVolume, Dims, GridTracer, GridVolume, Ray};
//!
//! let samples: Vec<u8> = (0..4096).map(|n| (n % 16) as u8).collect(); // 16³ of them: a ramp along x, the fastest axis
//! let volume = GridVolume::new(DenseVolume::new(Dims::new([16; 3])?, &samples)?); // borrowed; finds ranges of values
//! let mut tracer = GridTracer::new(&volume); // one per thread
//! let ray = Ray { origin: [-5.0, 7.5, 3.25], direction: [1.0, 0.0, 0.0], t_min: 0.0, t_max: f32::INFINITY };
//! let hit = tracer.first_hit(&ray, 9.5).unwrap();
//! assert_eq!((hit.t, hit.cell, hit.gradient()), (14.5, [9, 7, 3], [1.0, 0.0, 0.0]));
//! assert!(tracer.any_hit(&ray, 3.0) && !tracer.any_hit(&ray, 200.0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`GridTracer`] goes through an array, or bricks, by way of macrocells; [`Tracer`] through an octree volume of `isoray-octree`, which is smaller
//! and mostly faster to trace. Both are [`Trace`], and find the same hits, bit for bit.
//!
//! Rays and hits are in *index space*, where samples lie at integer coordinates; the ray's parameter `t` is whatever
//! the caller made it (the renderer maps a unit world direction, so that `t` is world distance). A *hit*
//! is the smallest `t ≥ t_min` at which the ray passes between inside (`s ≥ v`) and outside
//! (`s < v`) within the domain. Entering the domain is none, nor is starting inside.
//!
//! # Several surfaces, and rays that start on one
//!
//! [`Trace::crossings`] gives all crossings of several isosurfaces in the order in which the ray meets them, for instance to look through one at
//! another. [`Trace::occluded`] traces a ray from a hit, as to a light, without an offset that would have to be chosen; see
//! [`DepartingRay`]. [`first_hits`] and [`any_hits`] trace many rays on all cores.
//!
//! ```
//! use std::ops::ControlFlow;
//! # use isoray_build::build;
//! # use isoray_grid::{DenseVolume, Dims};
//! use isoray_trace::{Ray, Trace, Tracer};
//!
//! // A ball of radius 9 in a volume of 24³ samples, as the distance from its centre; surfaces of radius 4 and 9.
//! # let dims = Dims::new([24; 3])?;
//! # let distance = |n: i32| (f64::from(n) - 11.5).powi(2);
//! # let samples: Vec<f32> =
//! #     (0..24 * 24 * 24).map(|n| (distance(n % 24) + distance(n / 24 % 24) + distance(n / 576)).sqrt() as f32).collect();
//! # let volume = build(&mut DenseVolume::new(dims, &samples)?, glam::DAffine3::IDENTITY, |_| {})?;
//! # let view = volume.view();
//! let isovalues = [4.0, 9.0];
//! let opacities = [1.0, 0.4];
//! let mut tracer = Tracer::new(&view);
//! let ray = Ray { origin: [-5.0, 12.0, 12.5], direction: [1.0, 0.0, 0.0], t_min: 0.0, t_max: f32::INFINITY };
//! let mut transmittance = 1.0;
//! let mut met = Vec::new();
//! let end = tracer.crossings(
//!     &ray,
//!     &isovalues,
//!     &mut |crossing| {
//!         met.push(crossing.surface);
//!         transmittance *= 1.0 - opacities[crossing.surface];
//!         if transmittance == 0.0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
//!     },
//!     &mut (),
//! );
//! assert!(end.is_break() && met == [1, 0]); // through the outer surface onto the inner one
//!
//! // The point that the ray hits first is seen from outside, where the distance is larger: light from where the ray comes reaches it, light
//! // from behind does not.
//! let hit = tracer.first_hit(&ray, 9.0).unwrap();
//! let to_light = |direction| hit.departing_ray(direction, f32::INFINITY, true);
//! assert!(!tracer.occluded(&to_light([-1.0, 0.3, 0.0]), 9.0, &mut ()));
//! assert!(tracer.occluded(&to_light([1.0, 0.3, 0.0]), 9.0, &mut ()));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Emission and absorption
//!
//! [`VolumeTracer`] integrates along rays through octree volumes, [`DenseVolumeTracer`] through arrays. Both hand the same stretches in the same
//! cells to a scheme of `isoray-preint`, in order:
//!
//! ```
//! use isoray_preint::{Bounded, ControlPoint, TransferFunction, Visibility};
//! use isoray_trace::{DenseVolume, DenseVolumeTracer, Dims, GridVolume, Ray};
//!
//! // A ramp along x; a medium where it is above 8, twice as dense at 15 as half-way there.
//! let samples: Vec<u8> = (0..4096).map(|n| (n % 16) as u8).collect();
//! let volume = GridVolume::new(DenseVolume::new(Dims::new([16, 16, 16])?, &samples)?);
//! let point = |value, extinction| ControlPoint { value, color: [1.0, 0.5, 0.0], extinction };
//! let transfer = TransferFunction::new(vec![point(8.0, 0.0), point(15.0, 0.4)])?;
//!
//! let mut tracer = DenseVolumeTracer::new(&volume, &Visibility::new(&transfer));
//! let ray = Ray { origin: [-5.0, 7.5, 3.25], direction: [1.0, 0.0, 0.0], t_min: 0.0, t_max: f32::INFINITY };
//! let seen = tracer.integrate(&ray, 1.0, &Bounded::new(&transfer, 1e-4, 1.0), None, &mut ());
//! assert!((seen.alpha() - (1.0 - (-1.4_f64).exp())).abs() < 1e-4);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # How a ray's path is defined
//!
//! A ray crosses the lattice plane `x_a = k` at `t = (k − o_a)/d_a`, evaluated in `f64` by this one expression everywhere. The
//! difference is exact and the quotient correctly rounded, so planes that the ray crosses at the same point give the same `t`: a ray through an edge or
//! a vertex steps across it at once, and cells that it only touches are not on its path. (A product with the reciprocal alone would lose this.)
//! Its path is the sequence of cells between consecutive distinct crossings; a plane counts as crossed at its own `t`. Every
//! traversal that compares these numbers, in whatever order it descends, visits the same cells. In a cell, the point at which the
//! ray enters or leaves has coordinate exactly 0 or 1 on every axis whose plane it crosses there, and `o_a − i_a + t·d_a` on the others, so both cells
//! at a face intersect the same point, and see the same value there (`isoray-cell`): no change of side falls between cells.
//!
//! A ray with a zero direction component lies in one column of cells: that of `⌊o_a⌋`, the last one if it runs in the domain's upper face.
//!
//! # Error
//!
//! Plane parameters in `f64` are exact to some 10⁻¹³ of a voxel even far from the origin, so that the only
//! errors are those of the cell's `f32` arithmetic and the final rounding of `t`. With plane parameters in `f32` a ray
//! from 1000 voxels away is displaced by up to 10⁻⁴ voxel: several hundred times the error of the cell's
//! values, and enough to lose grazing hits that the cell would have found.

mod batch;
mod beam;
mod blocks;
mod boxes;
mod branch;
mod brick;
mod cells;
mod content;
mod corner;
mod cubes;
mod dense;
mod descent;
mod detail_tracer;
mod detailed;
mod gather;
mod grid;
mod grid_steps;
mod hierarchy;
mod hit;
mod inside;
mod jump;
mod march;
mod normal;
mod offset;
mod place;
mod quotient;
mod ray;
mod ray_group;
mod ray_lanes;
mod reach;
mod region;
mod several;
mod shown;
mod steps;
mod stretch;
mod sweep;
mod thresholds;
mod trace;
mod tracer;
mod unpacked;
mod volume;
mod volume_packet;
mod walk;
mod work;

/// What traversals are made of, for those of other structures.
pub mod parts {
    pub use crate::brick::{Brick, SAMPLES};
    pub use crate::content::Beyond;
    pub use crate::corner::Corner;
    pub use crate::gather::Gather;
    pub use crate::grid_steps::{CORNER_STRIDES, Cubes, GridSteps, Strides};
    pub use crate::normal::CornerGradients;
    pub use crate::ray::ClippedRay;
    pub use crate::region::Region;
    pub use crate::several::{CellOnWay, Crossings, Departure};
    pub use crate::steps::{Cube, Steps};
}

pub use isoray_grid::{Branching, BrickSizes, BrickedVolume, DenseVolume, Dims, GridVolume, Samples, Scalar};

pub use batch::{any_hits, first_hits};
pub use beam::Beam;
pub use content::{Content, Finest};
pub use dense::DenseVolumeTracer;
pub use detail_tracer::{DetailTracer, LevelTracer, can_be_divided};
pub use detailed::Detailed;
pub use grid::GridTracer;
pub use hit::{AnyHit, Candidate, CountHits, FirstHit, Hit, HitPolicy};
pub use march::{Extents, March, Slicing};
pub use normal::central_gradient;
pub use quotient::{Doubles, quotient};
pub use ray::{DepartingRay, Ray};
pub use several::Crossing;
pub use sweep::{SurfaceBlock, Sweep};
pub use trace::Trace;
pub use tracer::Tracer;
pub use volume::VolumeTracer;
pub use work::{Counters, Work};
