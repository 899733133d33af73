//! The program as its users meet it: the real binary in an empty folder.

mod damage;
mod files;
mod flags;
mod inputs;
mod looks;
mod meshes;
mod outputs;
mod pictures;
mod printed;
mod sandbox;
mod series;
mod series_pictures;
mod synth;
mod transfer;
mod volumes;
mod warnings;
