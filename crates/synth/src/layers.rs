//! Filling layers, row by row, on all threads.

use isoray_grid::Dims;
use rayon::prelude::*;

/// Layers that a volume does not have.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{samples} samples from layer {first} on: expected whole layers of a {dims} volume")]
pub struct LayersError {
    /// Size of the lattice.
    pub dims: Dims,
    /// The first layer that was asked for.
    pub first: u32,
    /// How many samples were asked for.
    pub samples: usize,
}

/// Checks that `samples` from layer `first` on are whole layers of the volume, and tells how many.
pub(crate) fn count(dims: Dims, first: u32, samples: usize) -> Result<u32, LayersError> {
    let layers = samples / dims.layer();
    let left = dims.axes()[2].saturating_sub(first) as usize;
    if !samples.is_multiple_of(dims.layer()) || layers > left {
        return Err(LayersError { dims, first, samples });
    }
    Ok(layers as u32)
}

/// Rows that one task fills at least, so that short rows are worth a task: some ten thousand samples.
pub(crate) fn rows_per_task(width: usize) -> usize {
    (1 << 14) / width.max(1) + 1
}

/// Has `fill` fill every row of the layers from `first` on in `out`, whole ones; it is told `j` and `k`, and given
/// something to work in that `init` makes for each task.
pub(crate) fn fill_rows<T: Send, S>(
    dims: Dims,
    first: u32,
    out: &mut [T],
    init: impl Fn() -> S + Sync + Send,
    fill: impl Fn(&mut S, [u32; 2], &mut [T]) + Sync + Send,
) {
    let [width, height, _] = dims.axes();
    out.par_chunks_mut(width as usize).with_min_len(rows_per_task(width as usize)).enumerate().for_each_init(
        init,
        |scratch, (at, row)| {
            let at = at as u64;
            let [j, k] = [at % u64::from(height), at / u64::from(height)];
            fill(scratch, [j as u32, first + k as u32], row);
        },
    );
}
