//! Tiles over threads.

use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use crate::image::{Image, Pixel};

/// Edge of a tile in pixels: enough to amortise a task, few enough to balance the threads of a small image.
const TILE_EDGE: u32 = 16;

/// A rectangle of pixels: from `low` to before `high`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tile {
    low: [u32; 2],
    high: [u32; 2],
}

impl Tile {
    /// The pixels, row by row.
    pub(crate) fn pixels(self) -> impl Iterator<Item = [u32; 2]> {
        (self.low[1]..self.high[1]).flat_map(move |y| (self.low[0]..self.high[0]).map(move |x| [x, y]))
    }

    /// The squares of this edge that it is made of, row by row; some may be cut short.
    pub(crate) fn squares(self, edge: u32) -> impl Iterator<Item = Self> {
        let Self { low, high } = self;
        let from = move |a: usize| (low[a]..high[a]).step_by(edge as usize);
        let square = move |[x, y]: [u32; 2]| Self {
            low: [x, y],
            high: [high[0].min(x + edge), high[1].min(y + edge)],
        };
        from(1).flat_map(move |y| from(0).map(move |x| square([x, y])))
    }

    /// Where a pixel comes, row by row.
    pub(crate) fn index(self, [x, y]: [u32; 2]) -> usize {
        ((y - self.low[1]) * (self.high[0] - self.low[0]) + x - self.low[0]) as usize
    }

    /// Number of pixels.
    pub(crate) fn len(self) -> usize {
        ((self.high[0] - self.low[0]) * (self.high[1] - self.low[1])) as usize
    }
}

/// Renders an image tile by tile on the threads of the current rayon pool, each of which works with what `per_thread` gives it, one tile after
/// the other. Returns the image and what `render` told of each tile, in order. `progress` is called with the number of tiles done and of all.
pub(crate) fn in_tiles<S: Send, C: Send>(
    [width, height]: [u32; 2],
    per_thread: impl Fn() -> S + Sync + Send,
    render: impl Fn(&mut S, Tile) -> (Vec<Pixel>, C) + Sync + Send,
    progress: impl Fn(u32, u32) + Sync,
) -> (Image, Vec<C>) {
    let columns = width.div_ceil(TILE_EDGE);
    let tiles = columns * height.div_ceil(TILE_EDGE);
    let finished = AtomicU32::new(0);
    let place = |n: u32| {
        let low = [n % columns * TILE_EDGE, n / columns * TILE_EDGE];
        Tile { low, high: [width.min(low[0] + TILE_EDGE), height.min(low[1] + TILE_EDGE)] }
    };
    // Those that no thread works with at the moment. Rayon's own `map_init` would make one for each tile.
    let idle = Mutex::new(Vec::new());
    let idle = || idle.lock().unwrap_or_else(PoisonError::into_inner);
    let tile = |n: u32| {
        let unused = idle().pop();
        let mut state = unused.unwrap_or_else(&per_thread);
        let done = render(&mut state, place(n));
        idle().push(state);
        progress(1 + finished.fetch_add(1, Ordering::Relaxed), tiles);
        done
    };
    let done: Vec<(Vec<Pixel>, C)> = (0..tiles).into_par_iter().with_max_len(1).map(tile).collect();
    let mut image = Image::empty([width, height]);
    let mut counts = Vec::with_capacity(done.len());
    for (n, (pixels, count)) in (0..).zip(done) {
        let Tile { low: [x0, y0], high: [x1, _] } = place(n);
        let tile_width = (x1 - x0) as usize;
        for (y, row) in (y0 as usize..).zip(pixels.chunks_exact(tile_width)) {
            let start = y * width as usize + x0 as usize;
            image.pixels_mut()[start..start + tile_width].copy_from_slice(row);
        }
        counts.push(count);
    }
    (image, counts)
}
