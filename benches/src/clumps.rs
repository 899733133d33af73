//! Adaptive meshes of any depth: clumps of matter, refined where they are steep.

mod list;

use glam::{DAffine3, DVec3};
use isoray_amr::{Centering, Patch, Patches};

use self::list::CLUMPS;

/// Cells along the edge of a box.
const BOX: u32 = 16;

/// *Clumps 4*, which programs are compared on.
pub fn clumps_4() -> Patches {
    clumps(4, 0.02, 64)
}

/// Gaussian clumps and a broad one, in boxes of 16³: one is refined, octant by octant, where neighbouring cells of it differ by more than `threshold`. Boxes of `levels` levels, the coarsest of
/// `base`³ cells.
pub fn clumps(levels: u32, threshold: f32, base: u32) -> Patches {
    let mut boxes = Vec::new();
    let along = base / BOX;
    for n in 0..along.pow(3) {
        emit(&mut boxes, 0, [n % along, n / along % along, n / along.pow(2)], (levels, threshold, base));
    }
    Patches {
        centering: Centering::Cells,
        ratios: vec![2; levels as usize - 1],
        index_to_world: DAffine3::from_scale(DVec3::splat(1.0 / f64::from(base))),
        domain: ([0; 3], [base; 3]),
        patches: boxes,
    }
}

fn emit(boxes: &mut Vec<Patch>, level: u32, at: [u32; 3], params: (u32, f32, u32)) {
    let (levels, threshold, base) = params;
    let edge = 1.0 / f64::from(base << level);
    let n = BOX as usize;
    let centre = |a: usize, c: usize| (f64::from(at[a] * BOX) + c as f64 + 0.5) * edge;
    let mut values = Vec::with_capacity(n * n * n);
    for z in 0..n {
        for y in 0..n {
            for x in 0..n {
                values.push(density([centre(0, x), centre(1, y), centre(2, z)]));
            }
        }
    }
    let steep = |octant: u32| {
        let half = n / 2;
        let low = [0, 1, 2].map(|a| (octant >> a & 1) as usize * half);
        let value = |[x, y, z]: [usize; 3]| values[x + n * (y + n * z)];
        (0..half * half * half).any(|c| {
            let p = [low[0] + c % half, low[1] + c / half % half, low[2] + c / (half * half)];
            (0..3).any(|a| {
                let mut next = p;
                next[a] += 1;
                next[a] < low[a] + half && (value(next) - value(p)).abs() > threshold
            })
        })
    };
    let refined: Vec<u32> =
        if level + 1 == levels { Vec::new() } else { (0..8).filter(|&o| steep(o)).collect() };
    boxes.push(Patch { level, low: at.map(|c| (c * BOX) as i32), cells: [BOX; 3], values: values.into() });
    for octant in refined {
        emit(boxes, level + 1, std::array::from_fn(|a| 2 * at[a] + (octant >> a & 1)), params);
    }
}

/// Sixty Gaussians, the first of which is broad and faint.
fn density(p: [f64; 3]) -> f32 {
    let mut sum = 0.0f32;
    for (n, [x, y, z, radius]) in CLUMPS.into_iter().enumerate() {
        let square = (p[0] - x).powi(2) + (p[1] - y).powi(2) + (p[2] - z).powi(2);
        let reach = square / (2.0 * radius * radius);
        if reach < 40.0 {
            let height = if n == 0 { 0.12 } else { 0.35 * (0.03 / radius).sqrt() };
            sum += (height * (-reach).exp()) as f32;
        }
    }
    sum
}
