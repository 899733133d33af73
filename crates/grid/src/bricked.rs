//! Arrays in bricks (Parker 1998, section 3.1 and appendix B).

use crate::{Dims, Samples, Scalar, SlabSource};

/// The sizes of bricks.
///
/// Parker's are chosen by the machine: a brick of `brick³` samples fills a cache line, a macrobrick of `macrobrick³` bricks a page of memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BrickSizes {
    /// Samples along the edge of a brick, `n` in the paper; at least 1.
    pub brick: u32,
    /// Bricks along the edge of a macrobrick, `m` in the paper; at least 1.
    pub macrobrick: u32,
}

/// Bricks that cannot be.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BrickError<E = std::convert::Infallible> {
    /// A size of zero.
    #[error("bricks of {brick}³ samples and macrobricks of {macrobrick}³ bricks: expected at least one of each", brick = .0.brick, macrobrick = .0.macrobrick)]
    Empty(BrickSizes),
    /// Whole macrobricks around the volume are not addressable on this machine.
    #[error("a {dims} volume in macrobricks of edge {edge} overflows the address space")]
    TooLarge {
        /// Of the volume.
        dims: Dims,
        /// Samples along the edge of a macrobrick.
        edge: u64,
    },
    /// What kept the samples from being read.
    #[error(transparent)]
    Source(E),
}

/// A volume in bricks of `n³` samples, in macrobricks of `m³` bricks; whatever lies near in space lies near in memory.
///
/// The place of sample `(x, y, z)` is `F_x(x) + F_y(y) + F_z(z)`, with the three functions in tables of one word a coordinate. With `N` macrobricks along
/// each axis (rounded up; the paper rounds down) and `x = (X·m + i)·n + p` and so on, it is
/// `(((Z·N_y + Y)·N_x + X)·m³ + (k·m + j)·m + i)·n³ + (r·n + q)·n + p`, x fastest as everywhere here.
/// A look-up costs three loads from the tables, the eight corners of a cell six. The padding up to whole macrobricks holds default values that
/// nobody asks for.
#[derive(Clone, Debug)]
pub struct BrickedVolume<T> {
    dims: Dims,
    samples: Vec<T>,
    /// `F_x`, `F_y`, `F_z`.
    addresses: [Vec<usize>; 3],
}

impl<T: Scalar> BrickedVolume<T> {
    /// Reads `source` into bricks, layer by layer.
    ///
    /// # Errors
    /// Sizes of zero, more padding than can be addressed, or a source that cannot be read.
    pub fn new<S: SlabSource<T>>(source: &mut S, sizes: BrickSizes) -> Result<Self, BrickError<S::Error>> {
        let dims = source.dims();
        let (addresses, count) = addresses(dims, sizes)?;
        let mut samples = vec![T::default(); count];
        let [nx, ny, nz] = dims.axes();
        let mut layer = vec![T::default(); dims.layer()];
        for z in 0..nz {
            source.read_layers(z, &mut layer).map_err(BrickError::Source)?;
            for (y, row) in (0..ny as usize).zip(layer.chunks_exact(nx as usize)) {
                let start = addresses[1][y] + addresses[2][z as usize];
                row.iter().zip(&addresses[0]).for_each(|(&s, x)| samples[start + x] = s);
            }
        }
        Ok(Self { dims, samples, addresses })
    }

    /// Bytes of samples beyond the volume's own.
    pub fn padding_bytes(&self) -> usize {
        (self.samples.len() - self.dims.samples()) * size_of::<T>()
    }

    /// Bytes of the tables.
    pub fn table_bytes(&self) -> usize {
        self.addresses.iter().map(|table| size_of_val(table.as_slice())).sum()
    }

    /// Bytes in all.
    pub fn bytes(&self) -> usize {
        size_of_val(self.samples.as_slice()) + self.table_bytes()
    }
}

/// The tables, and the number of samples with the padding.
fn addresses<E>(dims: Dims, sizes: BrickSizes) -> Result<([Vec<usize>; 3], usize), BrickError<E>> {
    let BrickSizes { brick, macrobrick } = sizes;
    if brick == 0 || macrobrick == 0 {
        return Err(BrickError::Empty(sizes));
    }
    let (n, m) = (u64::from(brick), u64::from(macrobrick));
    let edge = n * m;
    let macrobricks = dims.axes().map(|axis| u128::from(u64::from(axis).div_ceil(edge)));
    let count = u128::from(edge).checked_pow(3).and_then(|one| one.checked_mul(macrobricks.iter().product()));
    // As for dense volumes: 16 bytes a sample must be addressable.
    let count = count.filter(|&count| count <= isize::MAX as u128 / 16);
    let Some(count) = count else { return Err(BrickError::TooLarge { dims, edge }) };
    let table = |a: usize| {
        // Distances, in samples, of macrobricks, of bricks in one, and of samples in one of those.
        let before: u128 = macrobricks[..a].iter().product();
        let [among_macrobricks, among_bricks, in_brick] = [
            before as usize * edge.pow(3) as usize,
            (m.pow(a as u32) * n.pow(3)) as usize,
            n.pow(a as u32) as usize,
        ];
        let place = |c: u64| {
            let [sample, brick, macrobrick] = [c % n, c / n % m, c / edge].map(|c| c as usize);
            macrobrick * among_macrobricks + brick * among_bricks + sample * in_brick
        };
        (0..u64::from(dims.axes()[a])).map(place).collect()
    };
    Ok(([0, 1, 2].map(table), count as usize))
}

impl<T: Scalar> Samples for BrickedVolume<T> {
    type Sample = T;

    fn dims(&self) -> Dims {
        self.dims
    }

    #[inline(always)]
    fn sample(&self, [x, y, z]: [u32; 3]) -> T {
        let [fx, fy, fz] = &self.addresses;
        self.samples[fx[x as usize] + fy[y as usize] + fz[z as usize]]
    }

    #[inline(always)]
    fn corners(&self, cell: [u32; 3]) -> [T; 8] {
        let pair = |a: usize| {
            let table = &self.addresses[a][cell[a] as usize..];
            [table[0], table[1]]
        };
        let [x, y, z] = [pair(0), pair(1), pair(2)];
        std::array::from_fn(|n| self.samples[x[n & 1] + y[n >> 1 & 1] + z[n >> 2]])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::DenseVolume;

    fn check<T: Scalar>(axes: [u32; 3], brick: u32, macrobrick: u32, of: impl Fn(usize) -> T) {
        let dims = Dims::new(axes).unwrap();
        let samples: Vec<T> = (0..dims.samples()).map(of).collect();
        let mut dense = DenseVolume::new(dims, &samples).unwrap();
        let bricked = BrickedVolume::new(&mut dense, BrickSizes { brick, macrobrick }).unwrap();
        let edge = u64::from(brick * macrobrick);
        let padded: u64 = axes.iter().map(|&n| u64::from(n).div_ceil(edge) * edge).product();
        assert_eq!(bricked.samples.len() as u64, padded);
        assert_eq!(bricked.padding_bytes(), (padded as usize - dims.samples()) * size_of::<T>());
        let [nx, ny, nz] = axes;
        let mut places = std::collections::HashSet::new();
        for z in 0..nz {
            for y in 0..ny {
                for x in 0..nx {
                    let p = [x, y, z];
                    let place: usize = (0..3).map(|a| bricked.addresses[a][p[a] as usize]).sum();
                    assert!(places.insert(place), "{p:?}");
                    assert!(bricked.sample(p).same_bits(dense.sample(p)), "{p:?}");
                    if (0..3).all(|a| p[a] + 1 < axes[a]) {
                        let same = |(a, b): (&T, &T)| a.same_bits(*b);
                        let corners = [bricked.corners(p), Samples::corners(&dense, p)];
                        assert!(corners[0].iter().zip(&corners[1]).all(same), "{p:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn every_sample_is_where_it_was_put() {
        for (axes, brick, macrobrick) in [
            ([40, 20, 19], 5, 2),
            ([7, 11, 5], 1, 1),
            ([9, 8, 17], 4, 1),
            ([9, 8, 17], 1, 5),
            ([13, 1, 2], 3, 3),
            ([1, 1, 1], 7, 9),
            ([31, 6, 3], 2, 4),
        ] {
            check(axes, brick, macrobrick, |n| (n * 7 % 251) as u8);
            check(axes, brick, macrobrick, |n| (n * 7 % 251) as i8);
            check(axes, brick, macrobrick, |n| (n * 77 % 65_521) as u16);
            check(axes, brick, macrobrick, |n| (n * 77 % 65_521) as i16);
            check(axes, brick, macrobrick, |n| n as f32 * 0.25);
        }
    }

    #[test]
    fn the_plain_order_is_bricks_of_one_sample() {
        let dims = Dims::new([5, 4, 3]).unwrap();
        let (addresses, count) =
            addresses::<std::convert::Infallible>(dims, BrickSizes { brick: 1, macrobrick: 1 }).unwrap();
        assert_eq!(count, 60);
        assert_eq!(addresses, [vec![0, 1, 2, 3, 4], vec![0, 5, 10, 15], vec![0, 20, 40]]);
    }

    #[test]
    fn the_papers_example() {
        // 40×20×19 in 4×2×2 macrobricks of 2³ bricks of 5³: one layer of padding.
        let dims = Dims::new([40, 20, 19]).unwrap();
        let samples = vec![0u8; dims.samples()];
        let mut dense = DenseVolume::new(dims, &samples).unwrap();
        let bricked = BrickedVolume::new(&mut dense, BrickSizes { brick: 5, macrobrick: 2 }).unwrap();
        assert_eq!(bricked.padding_bytes(), 40 * 20);
        assert_eq!(bricked.bytes(), 40 * 20 * 20 + bricked.table_bytes());
    }

    #[test]
    fn sizes_that_cannot_be() {
        let dims = Dims::new([1 << 21, 2, 2]).unwrap();
        let of =
            |brick, macrobrick| addresses::<std::convert::Infallible>(dims, BrickSizes { brick, macrobrick });
        assert!(of(0, 2).unwrap_err().to_string().contains("expected at least one of each"));
        assert!(of(2, 0).is_err());
        assert!(of(1 << 20, 4).unwrap_err().to_string().contains("overflows"));
        assert!(of(u32::MAX, u32::MAX).is_err());
    }
}
