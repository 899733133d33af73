//! Generated volumes: the same samples on every run, `u8`, x fastest.

use std::f64::consts::PI;

use rayon::prelude::*;

/// The signal of Marschner and Lobb (1994) on `n`³ samples of `[−1, 1]³`, `n ≥ 2`, scaled to 0…255: rings of
/// frequency 6 and amplitude ¼ on a slope. The customary isovalue is 127.5. Hardly anything in it is
/// constant: an octree's worst case.
pub fn marschner_lobb(n: usize) -> Vec<u8> {
    const FREQUENCY: f64 = 6.0;
    const AMPLITUDE: f64 = 0.25;
    let position = |i: usize| 2.0 * i as f64 / (n - 1) as f64 - 1.0;
    let rings: Vec<f64> = (0..n * n)
        .map(|at| {
            let radius = (position(at % n).powi(2) + position(at / n).powi(2)).sqrt();
            AMPLITUDE * (1.0 + (2.0 * PI * FREQUENCY * (PI * radius / 2.0).cos()).cos())
        })
        .collect();
    layers(n, |k, layer| {
        let slope = 1.0 - (PI * position(k) / 2.0).sin();
        for (sample, ring) in layer.iter_mut().zip(&rings) {
            *sample = ((slope + ring) / (2.0 * (1.0 + AMPLITUDE)) * 255.0).round().clamp(0.0, 255.0) as u8;
        }
    })
}

/// Two fluids of value 10 and 240 and between them, across z, an overturning turbulent mixing layer some half
/// of the volume thick, `n ≥ 2`. The customary isovalue is 100.
///
/// Inside the layer the mixing coordinate is the height over a rough interface, displaced by value noise of
/// octaves whose amplitude falls with the 0.68th power of their wavelength and dies out towards the layer's
/// faces.
pub fn turbulence(n: usize) -> Vec<u8> {
    const FLUIDS: [f32; 2] = [10.0, 240.0];
    // Lengths, in samples of the 512³ volume; others are scaled.
    let scale = n as f32 / 512.0;
    let half_thickness = 135.0 * scale;
    let transition = 40.0 * scale;

    let mut interface = vec![0f32; n * n];
    let longest = 160.0 * scale;
    for octave in octaves(longest, 0) {
        let amplitude = (octave.wavelength / longest).powf(0.75);
        for (j, row) in interface.chunks_mut(n).enumerate() {
            let mut noise = NoiseRow::new(&octave, j as f32, 0.0);
            row.iter_mut().enumerate().for_each(|(i, height)| *height += amplitude * noise.at(i as f32));
        }
    }
    interface.iter_mut().for_each(|height| *height *= 34.0 * scale);

    layers(n, |k, layer| {
        let z = k as f32 - n as f32 / 2.0;
        if z.abs() > half_thickness {
            layer.fill(FLUIDS[usize::from(z > 0.0)] as u8);
            return;
        }
        let envelope = (1.0 - (z / half_thickness).powi(2)).max(0.0);
        for (j, (row, interface)) in layer.chunks_mut(n).zip(interface.chunks(n)).enumerate() {
            let mut heights: Vec<f32> = interface.iter().map(|height| z * 0.45 - height * 0.6).collect();
            for octave in octaves(64.0 * scale, 20) {
                let amplitude = envelope * 3.4 * scale * (octave.wavelength / scale).powf(0.68);
                let mut noise = NoiseRow::new(&octave, j as f32, k as f32);
                heights
                    .iter_mut()
                    .enumerate()
                    .for_each(|(i, height)| *height += amplitude * noise.at(i as f32));
            }
            for (sample, height) in row.iter_mut().zip(heights) {
                let mixed = (height / transition + 0.5).clamp(0.0, 1.0);
                *sample = lerp(FLUIDS[0], FLUIDS[1], mixed).round() as u8;
            }
        }
    })
}

/// `n` layers of `n`² samples; `fill` gets each with its `k`.
fn layers(n: usize, fill: impl Fn(usize, &mut [u8]) + Sync) -> Vec<u8> {
    assert!(n >= 2, "a volume of cells has at least two samples along each axis");
    let mut samples = vec![0; n * n * n];
    samples.par_chunks_mut(n * n).enumerate().for_each(|(k, layer)| fill(k, layer));
    samples
}

/// One octave of value noise.
struct Octave {
    wavelength: f32,
    seed: u32,
}

/// Octaves from the longest wavelength down to two samples.
fn octaves(longest: f32, seed: u32) -> impl Iterator<Item = Octave> {
    std::iter::successors(Some(longest), |l| Some(l * 0.5))
        .take_while(|&l| l >= 2.0)
        .zip(seed..)
        .map(|(wavelength, seed)| Octave { wavelength, seed })
}

/// Value noise in `[−1, 1]` along a row of constant y and z: random numbers at the integer points of space in
/// units of the wavelength, blended by smoothsteps.
struct NoiseRow<'a> {
    octave: &'a Octave,
    low: [i32; 2],
    blend: [f32; 2],
    /// The eight numbers around the last position, x fastest, and their lowest x.
    corners: [f32; 8],
    column: Option<i32>,
}

impl<'a> NoiseRow<'a> {
    fn new(octave: &'a Octave, y: f32, z: f32) -> Self {
        let split = [y, z].map(|c| split(c / octave.wavelength));
        Self { octave, low: split.map(|s| s.0), blend: split.map(|s| s.1), corners: [0.0; 8], column: None }
    }

    fn at(&mut self, x: f32) -> f32 {
        let (column, u) = split(x / self.octave.wavelength);
        if self.column != Some(column) {
            let [j, k] = self.low;
            self.corners = std::array::from_fn(|n| {
                let n = n as i32;
                random([column + (n & 1), j + (n >> 1 & 1), k + (n >> 2)], self.octave.seed)
            });
            self.column = Some(column);
        }
        let c = &self.corners;
        let [v, w] = self.blend;
        let along_x = |n: usize| lerp(c[n], c[n + 1], u);
        lerp(lerp(along_x(0), along_x(2), v), lerp(along_x(4), along_x(6), v), w)
    }
}

/// The integer below, and the smoothstep of the rest.
fn split(x: f32) -> (i32, f32) {
    let below = x.floor();
    let t = x - below;
    (below as i32, t * t * (3.0 - 2.0 * t))
}

fn lerp(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}

/// A number in `[−1, 1]` that depends on nothing but the lattice point and the seed.
fn random([x, y, z]: [i32; 3], seed: u32) -> f32 {
    let mut h = (x as u32).wrapping_mul(0x8da6_b343)
        ^ (y as u32).wrapping_mul(0xd816_3841)
        ^ (z as u32).wrapping_mul(0xcb1a_b31f)
        ^ seed.wrapping_mul(0x9e37_79b1);
    h = (h ^ h >> 15).wrapping_mul(0x2c1b_3c6d);
    h = (h ^ h >> 12).wrapping_mul(0x297a_2d39);
    h ^= h >> 15;
    h as f32 * (2.0 / 4_294_967_296.0) - 1.0
}
