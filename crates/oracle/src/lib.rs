//! Slow, independent float64 references for isosurfaces and volume integrals of trilinear fields, and for the fields of adaptive meshes.
//!
//! Everything that renders in f32 is checked against this crate, and this crate shares no code with
//! what it checks. It is written to be read: formulas come from definitions, not from the papers'
//! transcriptions of them, and where a choice had to be made between speed and clarity, clarity won
//! unless a ray through a large volume would have taken milliseconds.
//!
//! # The question it answers
//!
//! A *lattice* ([`Lattice`]) holds samples at integer coordinates; between eight neighbours the field
//! is their trilinear interpolant. Everything here is in **index space**: positions are lattice
//! coordinates, and a ray's parameter `t` counts lengths of its own direction, which need not be unit.
//! A point is *inside* where `s >= v`, *outside* where `s < v`, and the hit of a ray is the first
//! parameter at which it passes from one to the other. [`first_hit`] finds it, the ray's
//! f32 numbers taken as exact:
//!
//! ```
//! use isoray_oracle::{DenseLattice, Field, OracleRay, Sphere, error_in_ulps, first_hit, judge};
//!
//! // The distance from a point, sampled at 33³ points: its isosurfaces are spheres.
//! let sphere = Sphere { centre: [16.0; 3] };
//! let volume = DenseLattice::from_field([33; 3], &sphere, |s| s as f32);
//! let ray = OracleRay { origin: [-4.0, 16.0, 16.0], direction: [2.0, 0.0, 0.0], t_min: 0.0, t_max: 100.0 };
//!
//! let hit = first_hit(&volume, &ray, 9.5).expect("the ray goes through the centre");
//! assert_eq!(hit.t, 5.25); // x = 6.5, two voxels per unit of t
//! assert_eq!(hit.cell, [6, 16, 16]);
//! assert!(!hit.entering); // the distance falls below the isovalue: from inside to outside
//! assert_eq!(sphere.gradient(hit.position), [-1.0, 0.0, 0.0]);
//!
//! // A renderer's f32 answer is judged in units in the last place, unless the ray only grazes.
//! let verdict = judge(&volume, &ray, 9.5);
//! assert!(!verdict.grazing);
//! assert!(error_in_ulps(5.250_000_5, verdict.hit.unwrap().t) <= 1.0);
//! ```
//!
//! # The stages
//!
//! 1. [`Lattice`] is the only thing a volume has to implement. [`DenseLattice`] owns samples,
//!    [`FnLattice`] adapts any closure, for example a reader of somebody else's volume.
//! 2. A ray is cut into *segments*: the stretches of positive length between consecutive crossings of
//!    lattice planes, each in one cell. Crossings are correctly rounded quotients, so that planes met
//!    at one point are met at one parameter, and rays through edges and vertices need no special case.
//! 3. A cell whose corners are all inside, or all outside, is so throughout, because the interpolant is
//!    a convex combination of them: no arithmetic, no error. In the other cells the cubic along the
//!    segment is split at its extrema, each monotone piece gives one or two *stretches* of one state,
//!    and a root is bisected to the last bit.
//! 4. A hit is a change of state between consecutive stretches, whether inside a cell or at the face
//!    between two. Touches have no length and so never appear; entering the domain, `t_min` and empty
//!    cells have no stretch before them and so are no hits. [`all_hits`] gives them all, [`first_hit`]
//!    stops at the first, [`judge`] says whether the answer hangs on a rounding error.
//! 5. A cell alone, without a volume around it, is a [`CellCase`], which judges a root that was found in it by its [`SegmentCubic`] in
//!    `f64`, and in [`DoubleDouble`] where that cannot decide.
//! 6. [`central_gradient`] is the reference for smooth normals; each hit carries the gradient of its own
//!    cell's interpolant.
//!
//! # Emission and absorption
//!
//! [`integrate_stretch`] and [`integrate_ray`] give what a medium between cells' faces emits towards the viewer, with a transfer function
//! of [`TransferPoints`], shaded by the gradient or not, to some 10⁻¹¹ of full colour per cell:
//!
//! ```
//! use isoray_oracle::{OracleStretch, TransferPoint, TransferPoints, integrate_stretch};
//!
//! // A field that rises from 0 to 2; extinction 3 from 1 up.
//! let corners = [0.0, 2.0, 0.0, 2.0, 0.0, 2.0, 0.0, 2.0];
//! let stretch = OracleStretch { corners, entry: [0.0, 0.5, 0.5], exit: [1.0, 0.5, 0.5], length: 1.0 };
//! let point = |extinction| TransferPoint { value: 1.0, color: [1.0, 0.5, 0.0], extinction };
//! let step = TransferPoints(vec![point(0.0), point(3.0)]);
//! let seen = integrate_stretch(&stretch, &step, None);
//! assert!((seen.alpha() - (1.0 - (-1.5_f64).exp())).abs() < 1e-14);
//! assert!((seen.color[1] - 0.5 * seen.alpha()).abs() < 1e-14);
//! ```
//!
//! # Adaptive meshes
//!
//! The field of a mesh of [`AmrCells`] of several sizes is an [`AmrLattice`]: the value at every point of the finest lattice, for all of the
//! above; an [`AmrField`] is the same, a point at a time. [`vertex_values`] makes values at corners of averages of cells:
//!
//! ```
//! use isoray_oracle::{AmrCells, AmrLattice, AmrLeaf, Border, OracleRay, first_hit, vertex_values};
//!
//! // The field is x. A cell of edge 4, then eight of edge 2.
//! let mut leaves = vec![AmrLeaf { low: [0; 3], edge: 4, value: 2.0 }];
//! for o in 0..8 {
//!     let low = [4 + 2 * (o & 1), 2 * (o >> 1 & 1), 2 * (o >> 2)];
//!     leaves.push(AmrLeaf { low, edge: 2, value: f64::from(low[0]) + 1.0 });
//! }
//! let averages = AmrCells::new([8, 4, 4], leaves).unwrap();
//! let field = AmrLattice::new(&vertex_values(&averages, Border::Linear));
//! let ray = OracleRay { origin: [-1.0, 0.3, 1.7], direction: [1.0, 0.0, 0.0], t_min: 0.0, t_max: 100.0 };
//! assert_eq!(first_hit(&field, &ray, 3.5).unwrap().t, 4.5);
//! ```
//!
//! # What to feed to the code under test
//!
//! [`Field`]s have a value and a gradient known in closed form: [`Sphere`], [`Ramp`],
//! [`MarschnerLobb`], [`Gyroid`]. The [`adversarial`] generators make the rays, lattices, cells and meshes on
//! which intersectors usually fail, each from a seed.

pub mod adversarial;
mod amr;
mod cell;
mod double_double;
mod field;
mod integral;
mod isosurface;
mod judge;
mod lattice;
mod normal;
mod path;
mod segment_cubic;
mod stretch;
mod ulp;

pub use adversarial::{
    AmrKind, CellKind, LatticeKind, RayKind, SplitMix64, StretchKind, TransferKind, adversarial_averages,
    adversarial_case, adversarial_cell, adversarial_corners, adversarial_isovalue, adversarial_lattice,
    adversarial_mesh, adversarial_ray, adversarial_stretch, adversarial_transfer,
};
pub use amr::{AmrCells, AmrField, AmrLattice, AmrLeaf, BadLeaf, Border, vertex_values};
pub use double_double::{DoubleDouble, Number};
pub use field::{Field, Gyroid, MarschnerLobb, Ramp, Sphere};
pub use integral::{
    OracleRadiance, OracleShading, OracleStretch, TransferPoint, TransferPoints, integrate_ray,
    integrate_stretch,
};
pub use isosurface::{OracleHit, OracleRay, all_hits, first_hit};
pub use judge::{AllVerdict, GRAZING_ULPS, GRAZING_VOXELS, Verdict, judge, judge_all};
pub use lattice::{DenseLattice, FnLattice, Lattice};
pub use normal::central_gradient;
pub use segment_cubic::{CellCase, CellVerdict, SegmentCubic};
pub use ulp::{error_in_ulps, ulps_f32};
