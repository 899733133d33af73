//! The cascade against its definition, octave by octave and point by point, in `f64`.

use super::*;
use crate::random::Row;

/// The coefficient of the sum of octave `n` and all coarser ones; octave −1 is the displacement.
fn coefficient(spectrum: &Spectrum, seed: u64, n: i32, p: [i32; 3]) -> f64 {
    let mut sum = 0.0;
    if let Some(octave) = usize::try_from(n).ok().and_then(|n| spectrum.octaves.get(n)) {
        let [i, j, k] = p;
        // Rows begin at −2.
        let random = |lattice, k| f64::from(Row::new(seed, lattice, j, k).signed((i + 2) as u32));
        sum += spectrum.solid(n as usize, k) * random(2 * n as u32, k);
        sum += octave.flat * random(2 * n as u32 + 1, 0);
    }
    if n + 1 < spectrum.octaves.len() as i32 {
        for corner in 0..8 {
            let mut weight = 1.0;
            let coarser = std::array::from_fn(|axis| {
                let near = p[axis].div_euclid(2);
                if corner >> axis & 1 == 0 {
                    weight *= 0.75;
                    near
                } else {
                    weight *= 0.25;
                    near + if p[axis].rem_euclid(2) == 1 { 1 } else { -1 }
                }
            });
            sum += weight * coefficient(spectrum, seed, n + 1, coarser);
        }
    }
    sum
}

#[test]
fn samples_are_what_the_definition_gives() {
    for (size, time) in [([37, 22, 90], 1.0), ([8, 5, 61], 0.6), ([1, 1, 40], 1.0), ([64, 3, 33], 0.2)] {
        let dims = Dims::new(size).unwrap();
        let mut volume = Mixing::new(dims, MixingParams { seed: 3, time }).unwrap();
        let mut samples = vec![0f32; dims.samples()];
        volume.read_layers(0, &mut samples).unwrap();
        let mut mixed = 0;
        for n in 0..400 {
            let at = n * 7919 % dims.samples();
            let [width, height] = [size[0] as usize, size[1] as usize];
            let p = [at % width, at / width % height, at / (width * height)].map(|c| c as i32);
            let displacement = coefficient(&volume.spectrum, 3, -1, p);
            let q = (volume.height(p[2] as u32) + displacement) / volume.spectrum.thickness;
            let expected = 10.0 + 230.0 * (q + 0.5).clamp(0.0, 1.0);
            // Displacements are below 1 and take some dozens of roundings of 2^-24 each; the slope is 230 over the
            // thickness.
            let within = 64.0 * 230.0 / volume.spectrum.thickness / f64::from(1 << 24);
            assert!((f64::from(samples[at]) - expected).abs() < within, "{size:?} {p:?}: {expected}");
            mixed += usize::from(expected > 10.0 && expected < 240.0);
        }
        assert!(mixed >= 5, "{size:?}: {mixed}");
    }
}

#[test]
fn nothing_is_cut_off() {
    for layers in [1, 2, 5, 17, 64, 300, 512, 1920] {
        for time in [0.0, 0.1, 0.5, 1.0] {
            let spectrum = Spectrum::new(layers, time);
            let reach = spectrum.reach();
            // The largest displacement that coefficients of 1 everywhere give, layer by layer.
            for k in 0..layers as i32 {
                let height = (f64::from(k) - (f64::from(layers) - 1.0) / 2.0) / f64::from(layers);
                let displacement = bound(&spectrum, -1, k);
                // The two sums are of the same numbers, differently rounded.
                assert!(
                    height.abs() <= reach || height.abs() + 1e-12 >= displacement + spectrum.thickness / 2.0,
                    "{layers} layers at time {time}: {height}, {displacement}"
                );
            }
        }
    }
}

fn bound(spectrum: &Spectrum, n: i32, k: i32) -> f64 {
    let own = match usize::try_from(n) {
        Ok(n) => spectrum.solid(n, k) + spectrum.octaves[n].flat,
        Err(_) => 0.0,
    };
    if n + 1 == spectrum.octaves.len() as i32 {
        return own;
    }
    let near = k.div_euclid(2);
    let far = if k.rem_euclid(2) == 1 { near + 1 } else { near - 1 };
    own + 0.75 * bound(spectrum, n + 1, near) + 0.25 * bound(spectrum, n + 1, far)
}
