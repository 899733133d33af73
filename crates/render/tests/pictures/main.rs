//! The camera, and what pictures of known fields look like.

mod camera;
mod framing;
mod images;
mod looks;
mod rounding;
mod traversals;
mod volumes;
