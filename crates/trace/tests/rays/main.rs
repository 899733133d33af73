//! Rays through volumes. One program: what they go through is compiled once.

mod batch;
mod crossings;
mod damage;
mod detail;
mod grid;
mod oracle;
mod volume;
mod volume_packet;
