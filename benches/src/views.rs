//! The two standard views.

use isoray_grid::Dims;

/// Vertical field of view of both views, in degrees.
const FIELD_OF_VIEW: f64 = 45.0;

/// Edge of a tile in pixels, as in the renderer.
const TILE_EDGE: u32 = 16;

/// The primary rays of a picture, in index space: a common origin and a unit direction per pixel, tile by tile
/// as pictures are rendered.
#[derive(Clone, Debug)]
pub struct View {
    /// The eye.
    pub origin: [f32; 3],
    /// One unit vector a pixel, through the pixel's centre.
    pub directions: Vec<[f32; 3]>,
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

    /// From centre + N·`offset` to the centre, y upwards.
    fn new(dims: Dims, offset: [f64; 3], width: u32, height: u32) -> Self {
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
        let directions = tiled([width, height]).map(|[x, y]| direction(x, y)).collect();
        Self { origin: eye.map(|c| c as f32), directions }
    }
}

/// The pixels of an image, tile by tile, each by rows from the top.
fn tiled([width, height]: [u32; 2]) -> impl Iterator<Item = [u32; 2]> {
    let tiles = |n: u32| (0..n).step_by(TILE_EDGE as usize);
    let within = |from: u32, n: u32| from..n.min(from + TILE_EDGE);
    tiles(height).flat_map(move |top| tiles(width).map(move |left| [left, top])).flat_map(
        move |[left, top]| within(top, height).flat_map(move |y| within(left, width).map(move |x| [x, y])),
    )
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
    v.map(|c| c / length)
}
