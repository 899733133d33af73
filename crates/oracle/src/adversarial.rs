//! Inputs on which intersectors usually fail, each made from a seed and always the same for it.
//!
//! A loop over seeds cycles through the kinds, so that a few dozen already hold every one of them:
//!
//! ```
//! use isoray_oracle::{DenseLattice, adversarial_isovalue, adversarial_lattice, adversarial_ray, all_hits};
//!
//! for seed in 0..500 {
//!     let dims = [4, 5, 3];
//!     let samples = adversarial_lattice(dims, seed);
//!     let v = adversarial_isovalue(&samples, seed);
//!     let volume = DenseLattice::from_vec(dims, samples).expect("as many as the dimensions say");
//!     let ray = adversarial_ray(dims, seed / 7);
//!     for hit in all_hits(&volume, &ray, f64::from(v)) {
//!         assert!(hit.t >= f64::from(ray.t_min));
//!     }
//! }
//! ```

mod cases;
mod cells;
mod lattices;
mod meshes;
mod random;
mod rays;
mod stretches;
mod transfers;

pub use cases::adversarial_case;
pub use cells::{CellKind, adversarial_cell};
pub use lattices::{LatticeKind, adversarial_isovalue, adversarial_lattice};
pub use meshes::{AmrKind, adversarial_averages, adversarial_corners, adversarial_mesh};
pub use random::SplitMix64;
pub use rays::{RayKind, adversarial_ray};
pub use stretches::{StretchKind, adversarial_stretch};
pub use transfers::{TransferKind, adversarial_transfer};
