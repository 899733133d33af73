//! The camera, and what pictures of known fields look like.

mod camera;
mod framing;
mod images;
mod rounding;
mod traversals;
