//! How strong every octave is at a time.

/// One octave of the displacement, in units of the volume's height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Octave {
    /// Largest displacement by the part that depends on height, in the middle of the layer.
    pub(super) solid: f64,
    /// Largest displacement by the waves.
    pub(super) flat: f64,
}

/// All octaves.
#[derive(Clone, Debug)]
pub(super) struct Spectrum {
    /// Octave `n` has a spacing of `2^(n + 1)` voxels; at least one.
    pub(super) octaves: Vec<Octave>,
    /// Thickness of the interface itself.
    pub(super) thickness: f64,
    /// Height over the middle at which the solid octaves have faded away.
    half: f64,
    layers: f64,
}

// All lengths are in units of the volume's height. They were chosen by eye, and so that at time 1 the octree of 512³
// `u8` samples has a quarter of their size, and that of eight billion a sixth.

/// The largest spacing of full strength; the next octave is there in part, so that strengths are continuous in size.
const LARGEST: f64 = 1.0 / 9.0;
/// The least spacing of waves of full strength; those of half of it are not there.
const SHORTEST_WAVE: f64 = 1.0 / 24.0;
/// Displacement by waves per spacing, at time 0 and what time 1 adds.
const WAVES: [f64; 2] = [0.25, 0.5];
/// Displacement by a solid octave, in units of the ⅞th power of its spacing: all scales fold about alike, the large
/// ones a little less.
const FOLDS: f64 = 3.4;
/// Thickness of the interface, at time 0 and what time 1 adds; at least so many voxels.
const THICKNESS: [f64; 2] = [0.012, 0.26];
const LEAST_THICKNESS: f64 = 2.0;
/// Half the thickness of the layer that folds, at time 0 and what time 1 adds.
const HALF_LAYER: [f64; 2] = [0.02, 0.42];
/// Time at which the smallest octaves set in; the largest do at once.
const LAST_ONSET: f64 = 0.5;

impl Spectrum {
    pub(super) fn new(layers: u32, time: f64) -> Self {
        let height = f64::from(layers);
        let count = (1..).take_while(|&n| f64::from(1u32 << n) < 2.0 * LARGEST * height).count().max(1);
        let octaves = (1..=count).map(|n| octave(f64::from(1u32 << n) / height, time)).collect();
        let thickness = (THICKNESS[0] + THICKNESS[1] * smoothstep(time)).max(LEAST_THICKNESS / height);
        Self { octaves, thickness, half: HALF_LAYER[0] + HALF_LAYER[1] * time, layers: height }
    }

    /// Largest displacement by the part of octave `n` that depends on height, at layer `k` of its coefficients.
    pub(super) fn solid(&self, n: usize, k: i32) -> f64 {
        let spacing = f64::from(2u32 << n);
        let voxel = spacing * (f64::from(k) + 0.5) - 0.5;
        let share = (voxel - (self.layers - 1.0) / 2.0) / (self.layers * self.half);
        self.octaves[n].solid * (1.0 - share * share).max(0.0)
    }

    /// Height over the middle from which on nothing mixes.
    ///
    /// Coefficients beyond `half` are zero, and a spline reaches one and a half of its spacings further. There, or
    /// where all octaves together do not get, the waves remain.
    pub(super) fn reach(&self) -> f64 {
        let spacing = f64::from(1u32 << self.octaves.len()) / self.layers;
        let [solid, flat] =
            self.octaves.iter().fold([0.0; 2], |sum, octave| [sum[0] + octave.solid, sum[1] + octave.flat]);
        let waves = flat + self.thickness / 2.0;
        (waves + solid).min(waves.max(self.half + 1.5 * spacing))
    }
}

/// The octave of this spacing, in units of the volume's height.
fn octave(spacing: f64, time: f64) -> Octave {
    let present = (2.0 - spacing / LARGEST).clamp(0.0, 1.0);
    // Square roots, because powers are not the same on every machine.
    let root = spacing.sqrt();
    let power = root * root.sqrt() * root.sqrt().sqrt();
    let waves = (2.0 * spacing / SHORTEST_WAVE - 1.0).clamp(0.0, 1.0);
    let onset = LAST_ONSET * (1.0 - (spacing / LARGEST).min(1.0).sqrt());
    let grown = smoothstep(((time - onset) / (1.0 - onset)).max(0.0));
    Octave {
        solid: present * power * FOLDS * grown,
        flat: present * waves * spacing * (WAVES[0] + WAVES[1] * smoothstep(time)),
    }
}

fn smoothstep(t: f64) -> f64 {
    t * t * (3.0 - 2.0 * t)
}
