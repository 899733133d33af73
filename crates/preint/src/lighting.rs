//! Shading: a factor on the colour.

/// How the gradient of the field lights it (DESIGN, 'Transfer function'): the colour is multiplied by
/// `ambient + diffuse·|g·L| + specular·min(1, |g·H|)^exponent`, where `g = ∇s/G` is the gradient over a fixed scale, `L` the unit direction
/// to the light and `H` half-way between it and that to the viewer (Marchesin 2009, section 3.2). Light and half vector are constant along a
/// ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lighting {
    /// Share that needs no light.
    pub ambient: f32,
    /// Factor of the diffuse term.
    pub diffuse: f32,
    /// Factor of the highlight; it is left out if this is zero.
    pub specular: f32,
    /// The larger, the smaller the highlight; at least 1.
    pub exponent: f32,
    /// `g·L` is the product of this with the gradient in index space: the light's direction in index space, over `G`.
    pub light: [f32; 3],
    /// Likewise for `g·H`.
    pub half: [f32; 3],
}

impl Lighting {
    /// A bound of the factor, wherever `|∂s/∂x|` in index space is at most `steepest`.
    pub fn brightest(&self, steepest: f32) -> f32 {
        let lit: f32 = self.light.iter().map(|l| l.abs() * steepest).sum();
        self.ambient + self.diffuse * lit + self.specular
    }
}
