//! Transfer-function files: both formats, what is wrong with wrong ones, and damaged ones.

#[path = "../damage/mod.rs"]
mod damage;
mod mutations;
mod paraview;
mod toml;
mod wrong;

use std::path::Path;

use isoray_io::{TransferFileError, TransferOptions, read_transfer_function};
use isoray_preint::TransferFunction;

/// Reads `text` from a file of that name.
fn read_as(
    name: &str,
    text: impl AsRef<[u8]>,
    options: &TransferOptions,
) -> Result<TransferFunction, TransferFileError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    read_transfer_function(&path, options)
}

/// Display brightness from 0 to 1 of linear light.
fn encode(linear: f32) -> f64 {
    let linear = f64::from(linear);
    if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

fn fixture(name: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/transfer").join(name)
}
