//! The two standard views.

use isoray_grid::Dims;
use isoray_trace::Ray;

/// Vertical field of view of both views, in degrees.
const FIELD_OF_VIEW: f64 = 45.0;

/// Edge of a tile in pixels, as in the renderer.
pub const TILE_EDGE: u32 = 16;

/// The primary rays of a picture, in index space: a common origin and a unit direction per pixel, tile by tile
/// as pictures are rendered.
#[derive(Clone, Debug)]
pub struct View {
    /// The eye.
    pub origin: [f32; 3],
    /// One unit vector a pixel, through the pixel's centre.
    pub directions: Vec<[f32; 3]>,
    /// The same by packets of 2², 4², 8² and 16², in which squares of 4² follow each other.
    packets: [Vec<[f32; 3]>; 4],
}

impl View {
    /// From outside: the whole volume, eye at centre + N·(1.1, 0.9, 1.3) with N the number of samples along
    /// the longest axis.
    pub fn far(dims: Dims, width: u32, height: u32) -> Self {
        Self::new(dims, [1.1, 0.9, 1.3], width, height)
    }

    /// From inside: eye at centre + N·(0.25, 0.2, 0.3).
    pub fn close(dims: Dims, width: u32, height: u32) -> Self {
        Self::new(dims, [0.25, 0.2, 0.3], width, height)
    }

    /// The ray of a direction, from the eye on; a unit of its parameter is one of index space.
    pub fn ray(&self, direction: [f32; 3]) -> Ray {
        Ray { origin: self.origin, direction, t_min: 0.0, t_max: f32::INFINITY }
    }

    /// The directions in such an order that every `edge`², which is 2², 4², 8² or 16², are a square of the picture, and in the larger ones every sixteen a smaller
    /// one; if the picture is made of whole tiles.
    pub fn packets(&self, edge: u32) -> &[[f32; 3]] {
        &self.packets[(edge.ilog2() as usize).saturating_sub(1).min(3)]
    }

    /// From centre + N·`offset` to the centre, y upwards.
    pub fn new(dims: Dims, offset: [f64; 3], width: u32, height: u32) -> Self {
        let n = dims.axes();
        let longest = f64::from(n[0].max(n[1]).max(n[2]));
        let eye: [f64; 3] = std::array::from_fn(|a| f64::from(n[a] - 1) / 2.0 + longest * offset[a]);
        let forward = unit(offset.map(|o| -o));
        let right = unit(cross(forward, [0.0, 1.0, 0.0]));
        let up = cross(right, forward);
        let half = (FIELD_OF_VIEW / 2.0).to_radians().tan();
        let pixel = 2.0 * half / f64::from(height);
        let direction = |x: u32, y: u32| {
            let u = (f64::from(x) + 0.5 - f64::from(width) / 2.0) * pixel;
            let v = (f64::from(height) / 2.0 - f64::from(y) - 0.5) * pixel;
            unit(std::array::from_fn(|a| forward[a] + u * right[a] + v * up[a])).map(|c| c as f32)
        };
        // Tile by tile, in these by smaller and smaller squares down to pixels.
        let ordered = |edges: &[u32]| {
            let mut parts = vec![[[0; 2], [width, height]]];
            for &edge in [TILE_EDGE].iter().chain(edges).chain(&[1]) {
                parts = parts.into_iter().flat_map(|[low, high]| squares(low, high, edge)).collect();
            }
            parts.into_iter().map(|[[x, y], _]| direction(x, y)).collect()
        };
        let directions = ordered(&[]);
        let packets = [2, 4, 8, 16].map(|edge| ordered(&[edge, 4]));
        Self { origin: eye.map(|c| c as f32), directions, packets }
    }
}

/// The squares of this edge that a rectangle is made of, row by row.
fn squares(low: [u32; 2], high: [u32; 2], edge: u32) -> impl Iterator<Item = [[u32; 2]; 2]> {
    let from = move |a: usize| (low[a]..high[a]).step_by(edge as usize);
    from(1).flat_map(move |y| from(0).map(move |x| [[x, y], [high[0].min(x + edge), high[1].min(y + edge)]]))
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
    v.map(|c| c / length)
}
