//! What one piece of a ray adds to a pixel.

/// Opacity and colour of a piece of a ray of length `l`, over which a parameter `x` runs from 0 to 1: with the optical depth
/// `T(x) = l·∫₀ˣ τ du`,
///
/// ```text
/// alpha = 1 − e^(−T(1))
/// front = ∫₀¹ (1 − x)·τ·c·l·e^(−T(x)) dx
/// back  = ∫₀¹      x ·τ·c·l·e^(−T(x)) dx
/// ```
///
/// Colours are premultiplied. In Marchesin and Colin de Verdière 2009, equations 10 and 15, `c` stands for `τ·c`, and the latter lacks `l`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Piece {
    /// Opacity, from 0 to 1.
    pub alpha: f32,
    /// Linear RGB, weighted by what is left of the way to the back.
    pub front: [f32; 3],
    /// Linear RGB, weighted by the way from the front.
    pub back: [f32; 3],
}

impl Piece {
    /// Linear RGB without shading.
    pub fn color(&self) -> [f32; 3] {
        self.shaded(1.0, 1.0)
    }

    /// Linear RGB with a factor that runs linearly from `front` to `back` (equation 14).
    pub fn shaded(&self, front: f32, back: f32) -> [f32; 3] {
        std::array::from_fn(|n| front * self.front[n] + back * self.back[n])
    }
}
