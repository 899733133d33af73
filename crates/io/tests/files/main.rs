//! Files written by the tests themselves, damaged ones, and real ones.

mod amr_mutations;
mod amr_plotfile;
mod amr_real;
mod amr_vtk;
#[path = "../damage/mod.rs"]
mod damage;
mod damaged;
mod image_data;
mod images;
mod legacy_vtk;
mod make;
mod make_amr;
mod make_vtk;
mod mutations;
mod numpy;
mod real;
mod real_vtk;
mod round_trips;
#[cfg(feature = "tiff")]
mod stacks;
#[cfg(feature = "tiff")]
mod tiff_file;
mod truncated;
