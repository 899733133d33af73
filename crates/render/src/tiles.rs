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

    /// Its lowest pixel, and the one before which it ends.
    pub(crate) fn corners(self) -> [[u32; 2]; 2] {
        [self.low, self.high]
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
    let mut image = Image::empty([width, height]);
    // Rows of tiles. Whoever has rendered a tile puts it in its place: one thread doing that for all would take a tenth of the time of fast frames.
    let bands = image.pixels_mut().chunks_mut((width * TILE_EDGE) as usize);
    let bands: Vec<Mutex<&mut [Pixel]>> = bands.map(Mutex::new).collect();
    let tile = |n: u32| {
        let unused = idle().pop();
        let mut state = unused.unwrap_or_else(&per_thread);
        let this = place(n);
        let (pixels, count) = render(&mut state, this);
        idle().push(state);
        let (left, tile_width) = (this.low[0] as usize, (this.high[0] - this.low[0]) as usize);
        let mut band = bands[(n / columns) as usize].lock().unwrap_or_else(PoisonError::into_inner);
        let rows = band.chunks_exact_mut(width as usize).zip(pixels.chunks_exact(tile_width));
        rows.for_each(|(row, of_tile)| row[left..left + tile_width].copy_from_slice(of_tile));
        drop(band);
        progress(1 + finished.fetch_add(1, Ordering::Relaxed), tiles);
        count
    };
    let counts = (0..tiles).into_par_iter().with_max_len(1).map(tile).collect();
    drop(bands);
    (image, counts)
}
