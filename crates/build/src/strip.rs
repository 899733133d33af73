//! A strip of blocks: some rows of one layer of blocks, read and folded.

use isoray_grid::{Dims, RowSource, Scalar};
use isoray_octree::{CAP_EDGE, NODE_LEVEL, Range};

/// Samples along the edge of a block.
pub(crate) const BLOCK_EDGE: usize = 1 << NODE_LEVEL;
/// Rows of blocks in a strip. Few enough for the samples to stay in a second-level cache, and enough for the row beyond the last, which
/// the next strip reads once more, not to count.
const STRIP_ROWS: usize = 4;
/// Samples along an axis that the ranges of a cap cover: its own, and the first of the next one.
const SPAN: usize = CAP_EDGE as usize + 1;

/// Where a strip lies.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    pub(crate) dims: Dims,
    /// The first layer and row of samples.
    pub(crate) layer: u32,
    pub(crate) row: u32,
}

/// The strips of one layer of blocks, in order.
pub(crate) fn strips(dims: Dims, layer: u32) -> impl ExactSizeIterator<Item = Place> {
    let count = dims.axes()[1].div_ceil((STRIP_ROWS * BLOCK_EDGE) as u32);
    (0..count).map(move |n| Place { dims, layer, row: n * (STRIP_ROWS * BLOCK_EDGE) as u32 })
}

impl Place {
    /// Layers and rows of samples that are read: the strip's own and, if there is one, the next of each.
    fn extent(self) -> [usize; 2] {
        let [_, ny, nz] = self.dims.axes();
        let layers = (nz - self.layer) as usize;
        let rows = (ny - self.row) as usize;
        [layers.min(BLOCK_EDGE + 1), rows.min(STRIP_ROWS * BLOCK_EDGE + 1)]
    }

    /// Samples of its own.
    pub(crate) fn samples(self) -> u64 {
        let [layers, rows] = self.extent();
        let [layers, rows] = [layers.min(BLOCK_EDGE), rows.min(STRIP_ROWS * BLOCK_EDGE)];
        (layers * rows) as u64 * u64::from(self.dims.axes()[0])
    }

    /// Blocks along x, and rows of them.
    pub(crate) fn blocks(self) -> [usize; 2] {
        let [nx, ny, _] = self.dims.axes();
        let rows = ((ny - self.row) as usize).div_ceil(BLOCK_EDGE);
        [(nx as usize).div_ceil(BLOCK_EDGE), rows.min(STRIP_ROWS)]
    }
}

/// The samples of a strip, and what was found out about them.
#[derive(Debug)]
pub(crate) struct Strip<T> {
    pub(crate) place: Place,
    /// Layer by layer and row by row.
    samples: Vec<T>,
    /// For each row of blocks, and in it for each z and y of its caps, one row: at the first sample of a cap the least and the
    /// greatest finite sample of its cells, `(HIGHEST, LOWEST)` if there is none.
    low: Vec<T>,
    high: Vec<T>,
    /// Rows of the samples of one row of blocks, folded along z.
    folded: Vec<T>,
}

impl<T: Scalar> Strip<T> {
    /// An empty one.
    pub(crate) fn new(dims: Dims) -> Self {
        let [samples, low, high, folded] = [(); 4].map(|()| Vec::new());
        Self { place: Place { dims, layer: 0, row: 0 }, samples, low, high, folded }
    }

    /// Bytes that one takes for a volume of that size.
    pub(crate) fn bytes(dims: Dims) -> u64 {
        let [layers, rows] = Place { dims, layer: 0, row: 0 }.extent();
        let rows = layers * rows + 2 * STRIP_ROWS * 4 + 2 * SPAN * 2;
        rows as u64 * u64::from(dims.axes()[0]) * size_of::<T>() as u64
    }

    fn width(&self) -> usize {
        self.place.dims.axes()[0] as usize
    }

    /// Reads the strip at `place`, and finds the ranges of its caps.
    pub(crate) fn read<E: std::error::Error + Send + Sync + 'static>(
        &mut self,
        place: Place,
        rows: &(dyn RowSource<T, Error = E> + '_),
    ) -> Result<(), E> {
        self.place = place;
        let ([layers, count], nx) = (place.extent(), self.width());
        self.samples.resize(layers * count * nx, T::default());
        for (layer, samples) in (place.layer..).zip(self.samples.chunks_exact_mut(count * nx)) {
            rows.read_rows(layer, place.row, samples)?;
        }
        self.find_ranges();
        Ok(())
    }

    /// A row of samples; beyond the domain the last one is repeated, which changes no range.
    pub(crate) fn row(&self, layer: usize, row: usize) -> &[T] {
        row_of(&self.samples, self.place, layer, row)
    }

    /// The range of the cells of a cap, given by its place among those of the strip; the cap is inside the domain.
    #[inline(always)]
    pub(crate) fn range(&self, cap: [usize; 3]) -> Range<T> {
        let at = ranges_row(cap[1], cap[2]) * self.width() + cap[0] * CAP_EDGE as usize;
        Range { min: self.low[at], max: self.high[at] }
    }

    /// Axis by axis, whole rows at once.
    fn find_ranges(&mut self) {
        let nx = self.width();
        let [_, rows] = self.place.blocks();
        self.low.resize(4 * rows * nx, T::default());
        self.high.resize(4 * rows * nx, T::default());
        self.folded.resize(2 * (BLOCK_EDGE + 1) * nx, T::default());
        for (row, z) in (0..rows).flat_map(|row| [(row, 0), (row, 1)]) {
            let (low, high) = self.folded.split_at_mut((BLOCK_EDGE + 1) * nx);
            for (y, (low, high)) in low.chunks_exact_mut(nx).zip(high.chunks_exact_mut(nx)).enumerate() {
                let of = |n| row_of(&self.samples, self.place, z * (SPAN - 1) + n, row * BLOCK_EDGE + y);
                fold(std::array::from_fn(of), |s| if s.is_finite() { s } else { T::HIGHEST }, less, low);
                fold(std::array::from_fn(of), |s| if s.is_finite() { s } else { T::LOWEST }, greater, high);
            }
            for y in 0..2 {
                let at = ranges_row(2 * row + y, z) * nx..;
                let of = |folded: &'_ [T], n: usize| {
                    let at = (y * (SPAN - 1) + n) * nx;
                    at..at + nx.min(folded.len())
                };
                let lows = std::array::from_fn(|n| &low[of(low, n)]);
                let highs = std::array::from_fn(|n| &high[of(high, n)]);
                fold_along(lows, less, &mut self.low[at.clone()][..nx]);
                fold_along(highs, greater, &mut self.high[at][..nx]);
            }
        }
    }
}

/// The row of [`Strip::low`] with the ranges of caps at some y and z.
fn ranges_row(y: usize, z: usize) -> usize {
    y / 2 * 4 + z * 2 + y % 2
}

fn row_of<T>(samples: &[T], place: Place, layer: usize, row: usize) -> &[T] {
    let ([layers, rows], nx) = (place.extent(), place.dims.axes()[0] as usize);
    &samples[(layer.min(layers - 1) * rows + row.min(rows - 1)) * nx..][..nx]
}

fn less<T: Scalar>(a: T, b: T) -> T {
    if b < a { b } else { a }
}

fn greater<T: Scalar>(a: T, b: T) -> T {
    if b > a { b } else { a }
}

/// Folds five rows into one.
#[inline(always)]
fn fold<T: Scalar>(rows: [&[T]; SPAN], clean: impl Fn(T) -> T, pick: impl Fn(T, T) -> T, out: &mut [T]) {
    let [a, b, c, d, e] = rows.map(|row| &row[..out.len()]);
    for (x, out) in out.iter_mut().enumerate() {
        *out = pick(pick(pick(clean(a[x]), clean(b[x])), pick(clean(c[x]), clean(d[x]))), clean(e[x]));
    }
}

/// Folds five rows into one, and every five neighbours along it, fewer at its end, into the first of them.
#[inline(always)]
fn fold_along<T: Scalar>(rows: [&[T]; SPAN], pick: impl Fn(T, T) -> T + Copy, out: &mut [T]) {
    fold(rows, |s| s, pick, out);
    // Two, four, five neighbours.
    for step in [1, 2, 1] {
        for x in step..out.len() {
            out[x - step] = pick(out[x - step], out[x]);
        }
    }
}
