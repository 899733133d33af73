//! Many rays at a time through an octree volume, with the hits of single rays, bit for bit.
//!
//! A packet of rays goes down the octree as one [`Beam`](isoray_trace::Beam): a cube is visited once for all rays that may meet it. In the blocks
//! with surface that are left, the rays are intersected with each cell in lanes, [`LANES`] at once.
//!
//! Two ways lead there ([`Traversal`]): block by block, told by the hull of all rays and in lanes, *masked*; or by slabs across the axis along which they run, *coherent*, as
//! published (Knoll 2009). Masked packets are the faster ones in all views and volumes that were measured, and what [`Traversal::Auto`] takes unless rays are too far apart.
//!
//! ```
//! use isoray_build::build;
//! use isoray_grid::{DenseVolume, Dims};
//! use isoray_packet::{PacketTracer, TracePackets, Traversal};
//! use isoray_trace::Ray;
//!
//! let samples: Vec<u8> = (0..4096).map(|n| (n % 16) as u8).collect(); // 16³ of them: a ramp along x, the fastest axis
//! let mut array = DenseVolume::new(Dims::new([16; 3])?, &samples)?;
//! let volume = build(&mut array, glam::DAffine3::IDENTITY, |_| {})?;
//! let view = volume.view();
//! let mut tracer = PacketTracer::new(&view);
//! let direction = |n: usize| [1.0, 0.01 * (n % 4) as f32 + 0.001, 0.01 * (n / 4) as f32 + 0.001];
//! let rays: [Ray; 16] = std::array::from_fn(|n| Ray {
//!     origin: [-5.0, 7.5, 3.25],
//!     direction: direction(n),
//!     t_min: 0.0,
//!     t_max: f32::INFINITY,
//! });
//! let mut hits = [None; 16];
//! tracer.first_hits(&rays, 9.5, Traversal::Auto, &mut hits, &mut ());
//! assert!(hits.iter().all(|hit| hit.unwrap().t == 14.5));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod detail;
mod far_shadows;
mod frustum;
mod hull;
mod kind;
mod lanes;
mod packet;
mod packlet;
mod pairs;
mod tracer;

pub use detail::DetailPacketTracer;
pub use far_shadows::FarShadows;
pub use isoray_trace::Slicing;
pub use lanes::LANES;
pub use tracer::{PacketTracer, Packets, TracePackets, Traversal, first_hits_singly, occluded_singly};
