//! `isoray build` under duress: short memory, full disks, files that shrink, kills, and rivals for one output.

mod bytes;
#[cfg(target_os = "linux")]
mod full;
mod inputs;
mod kill;
#[cfg(target_os = "linux")]
mod memory;
mod rivals;
#[path = "../cli/sandbox.rs"]
mod sandbox;
mod truncated;
