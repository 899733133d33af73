//! What the oracle says of shadow rays.

use isoray_oracle::{GRAZING_VOXELS, Lattice, OracleHit, OracleRay, judge_all};

/// The least sine of the angle between a surface and the shadow rays from it that are compared. With [`SMOOTH`] it tells on which side of the surface a reference ray starts: `d` voxels along it the field
/// has changed by `STEEP·SMOOTH·d` of the largest corner, and by less than `4d²` of it for the field's being no plane; `d` is 2.6·10⁻⁴ where coordinates are below 128, so that the second is half of
/// the first. With half the sine `d` is twice as large, and neither would tell.
const STEEP: f64 = 0.2;

/// The least gradient, per voxel and in terms of the largest difference from the isovalue of its cell's corners, around which the field is taken for a plane. What rounds corners by 2⁻²⁴ of that
/// difference, a few times, turns a normal by 10⁻³ of a degree.
const SMOOTH: f64 = 1e-2;

/// A point of a surface, in lattice space, and the way from there to a light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Departure {
    pub(crate) position: [f64; 3],
    /// In the cell, from 0 to 1.
    pub(crate) local: [f64; 3],
    pub(crate) gradient: [f64; 3],
    /// Difference from the isovalue, in magnitude, of the cell's corners.
    pub(crate) largest: f64,
    /// The direction of the light; of length 1.
    pub(crate) to_light: [f32; 3],
    /// How far away it is.
    pub(crate) t_max: f32,
}

impl Departure {
    /// Sine of the angle between the surface and the ray, positive towards larger values.
    pub(crate) fn slope(&self) -> f64 {
        let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|n| a[n] * b[n]).sum::<f64>();
        let to_light = self.to_light.map(f64::from);
        dot(self.gradient, to_light) / dot(self.gradient, self.gradient).sqrt()
    }

    /// What lies on the way, of the isosurface of `v`; `None` where that cannot be told: the rays that graze, at either end, and where the surface is no plane nearby.
    ///
    /// The reference starts a little off the surface, on a side that the slope tells, still in the same cell. Rounding its coordinates to 32 bits
    /// moves the start by up to half an ulp along each axis; so far off, that is an eighth of its distance from the surface.
    pub(crate) fn hits(&self, lattice: &impl Lattice, v: f32) -> Option<Vec<OracleHit>> {
        let largest = self.position.iter().fold(1f64, |m, &c| m.max(c)) as f32;
        let off = (8.0 / STEEP * 3f64.sqrt() / 2.0) as f32 * (largest.next_up() - largest);
        let verdict = judge_all(lattice, &self.ray(off), v);
        let moved = self.to_light.map(|d| 2.0 * f64::from(off * d));
        let stays = (0..3).all(|a| (0.0..=1.0).contains(&(self.local[a] + moved[a])));
        // A crossing next to the start may belong to either side of it.
        let is_clear = verdict.hits.first().is_none_or(|hit| hit.t > f64::from(4.0 * off));
        (!verdict.grazing && stays && is_clear && self.is_told()).then_some(verdict.hits)
    }

    /// Whether a ray that begins so far from the surface, and is taken to begin inside of it or outside, comes to the other side; `None` where that cannot be told.
    pub(crate) fn is_hidden_from(
        &self,
        lattice: &impl Lattice,
        v: f32,
        begin: f32,
        from_inside: bool,
    ) -> Option<bool> {
        let crosses = |begin: f32| {
            let verdict = judge_all(lattice, &self.ray(begin), v);
            let does = verdict.hits.iter().any(|hit| hit.entering != from_inside);
            (!verdict.grazing).then_some(does)
        };
        // Rounding moves the beginning by less than what moves a crossing that counts as the same.
        let by = (2.0 * GRAZING_VOXELS) as f32;
        let [sooner, later] = [begin - by, begin + by].map(crosses);
        let does = sooner?;
        (later? == does && self.is_told()).then_some(does)
    }

    /// The way from so far off the surface on.
    fn ray(&self, t_min: f32) -> OracleRay {
        let origin = self.position.map(|c| c as f32);
        OracleRay { origin, direction: self.to_light, t_min, t_max: self.t_max }
    }

    /// Whether it is told on which side of the surface the light is.
    fn is_told(&self) -> bool {
        self.slope().abs() >= STEEP && is_smooth(self.gradient, self.largest)
    }
}

/// Whether the field changes as its gradient tells around a point of a surface, and the normal is told. `largest` is the largest difference from the isovalue, in magnitude, of
/// the cell's corners.
pub(crate) fn is_smooth(gradient: [f64; 3], largest: f64) -> bool {
    gradient.iter().map(|g| g * g).sum::<f64>().sqrt() > SMOOTH * largest
}
