//! Small volume files.

use crate::sandbox::Sandbox;

/// Size of the ball.
pub(crate) const SIZE: [usize; 3] = [12, 10, 11];
/// Flags that describe the raw ball.
pub(crate) const RAW_FLAGS: &str = "--dims 12,10,11 --type u8";

/// A ball that is bright in the middle.
pub(crate) fn ball() -> Vec<u8> {
    let [nx, ny, nz] = SIZE;
    let square = |n: usize, count: usize| (n as f64 - (count as f64 - 1.0) / 2.0).powi(2);
    let at = |n: usize| {
        let radius = (square(n % nx, nx) + square(n / nx % ny, ny) + square(n / (nx * ny), nz)).sqrt();
        (250.0 - 35.0 * radius).max(0.0) as u8
    };
    (0..nx * ny * nz).map(at).collect()
}

/// An NRRD file of `sizes` and type, with these bytes of samples.
pub(crate) fn nrrd(sizes: &str, sample: &str, encoding: &str, body: &[u8]) -> Vec<u8> {
    let header = format!(
        "NRRD0004\ntype: {sample}\ndimension: 3\nsizes: {sizes}\nendian: little\nencoding: {encoding}\n\n"
    );
    [header.as_bytes(), body].concat()
}

/// The ball as NRRD.
pub(crate) fn ball_nrrd() -> Vec<u8> {
    nrrd("12 10 11", "uint8", "raw", &ball())
}

/// The ball as MetaImage.
pub(crate) fn ball_mha() -> Vec<u8> {
    let header = "ObjectType = Image\nNDims = 3\nDimSize = 12 10 11\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n";
    [header.as_bytes(), &ball()].concat()
}

/// The ball as NIfTI-1.
pub(crate) fn ball_nii() -> Vec<u8> {
    const UINT8: i16 = 2;
    const SAMPLES: usize = 352;
    let mut header = vec![0; SAMPLES];
    header[0..4].copy_from_slice(&348_i32.to_le_bytes());
    for (i, n) in [3_i16, 12, 10, 11, 1, 1, 1, 1].into_iter().enumerate() {
        header[40 + 2 * i..42 + 2 * i].copy_from_slice(&n.to_le_bytes());
    }
    header[70..72].copy_from_slice(&UINT8.to_le_bytes());
    header[72..74].copy_from_slice(&8_i16.to_le_bytes());
    for i in 0..4 {
        header[76 + 4 * i..80 + 4 * i].copy_from_slice(&1.0_f32.to_le_bytes());
    }
    header[108..112].copy_from_slice(&(SAMPLES as f32).to_le_bytes());
    header[344..348].copy_from_slice(b"n+1\0");
    [header, ball()].concat()
}

/// A volume of 4³ floating-point samples from 0 to 63, of which `change` may change some.
pub(crate) fn floats(change: impl FnOnce(&mut [f32])) -> Vec<u8> {
    let mut samples: Vec<f32> = (0..64_u8).map(f32::from).collect();
    change(&mut samples);
    let body: Vec<u8> = samples.iter().flat_map(|s| s.to_le_bytes()).collect();
    nrrd("4 4 4", "float", "raw", &body)
}

/// A sandbox with `ball.ovol`, built by the program.
pub(crate) fn with_ovol() -> Sandbox {
    let sandbox = Sandbox::with("ball.nrrd", &ball_nrrd());
    sandbox.succeeds("build ball.nrrd -o ball.ovol");
    sandbox
}
