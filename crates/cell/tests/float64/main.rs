//! The mathematics of a cell against `f64`: bounds of the errors, and what must hold exactly.

mod cases;
mod corpus;
mod exact;
mod exactly;
mod finders;
mod normals;
mod roots;
mod values;
