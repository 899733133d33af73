//! Emission and absorption along a ray's segment in a hexahedral cell, with a bounded error.

mod transfer;

pub use transfer::{ControlPoint, LARGEST, TransferFunction, TransferFunctionError};
