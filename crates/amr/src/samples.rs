//! The samples of bricks.

use isoray_trace::parts::SAMPLES;

use crate::bricks::EDGE;
use crate::visit::BrickAt;

/// Samples along the edge of a brick.
const ALONG: u32 = EDGE + 1;

/// Writes the samples of a brick, 5³, x fastest; what lies beyond its block means nothing.
pub(crate) fn fill(samples: &mut [f32; SAMPLES], at: &BrickAt<'_>) {
    let block = &at.mesh.skeleton.blocks[at.block as usize];
    let cells = block.cells();
    let [low, _] = at.layout.cells;
    // Vertices of the block; those beyond are any.
    let along: [[usize; ALONG as usize]; 3] = std::array::from_fn(|a| {
        std::array::from_fn(|n| {
            (at.numbers[a] * EDGE + n as u32).saturating_sub(low[a]).min(cells[a]) as usize
        })
    });
    let [nx, ny, _] = cells.map(|n| n as usize + 1);
    let rows = samples.as_chunks_mut::<{ ALONG as usize }>().0;
    for (n, row) in rows.iter_mut().enumerate() {
        let start = block.first + nx * (along[1][n % 5] + ny * along[2][n / 5]);
        let of_row = &at.mesh.values[start..start + nx];
        *row = along[0].map(|x| of_row[x]);
    }
}
