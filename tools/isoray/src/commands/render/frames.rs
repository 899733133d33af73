//! Frames, timed.

use std::sync::Mutex;
use std::time::Instant;

use isoray_amr::Mesh;
use isoray_grid::Scalar;
use isoray_octree::OctreeVolume;
use isoray_render::Image;
use isoray_trace::Work;

use crate::progress::Progress;

/// The rendered frames.
pub(super) struct Rendered {
    pub(super) image: Image,
    /// Seconds of each frame.
    pub(super) times: Vec<f64>,
    /// Zero where nobody asks for it.
    pub(super) work: Work,
    pub(super) structure_bytes: u64,
    pub(super) raw_bytes: u64,
}

/// What is traced takes in memory, and its samples alone.
#[derive(Clone, Copy)]
pub(super) struct Bytes {
    pub(super) structure: u64,
    pub(super) raw: u64,
}

impl<T: Scalar> From<&OctreeVolume<T>> for Bytes {
    fn from(volume: &OctreeVolume<T>) -> Self {
        Self { structure: volume.structure_bytes() as u64, raw: volume.raw_bytes() as u64 }
    }
}

impl From<&Mesh> for Bytes {
    fn from(mesh: &Mesh) -> Self {
        let size = mesh.size();
        Self { structure: size.bytes, raw: size.leaves.iter().sum::<u64>() * size_of::<f32>() as u64 }
    }
}

impl Rendered {
    /// Renders `repeat` times, at least once, with a progress bar that `frame` calls with the tiles done and in all.
    pub(super) fn new(
        Bytes { structure, raw }: Bytes,
        repeat: u32,
        frame: impl Fn(&(dyn Fn(u32, u32) + Sync)) -> Image,
    ) -> Self {
        let bar = Mutex::new(Progress::new("rendering"));
        let mut times = Vec::new();
        let mut timed = |n: u32| {
            let begin = Instant::now();
            let image = frame(&|tiles, of| {
                // A thread that finds the bar in use leaves it to the next tile.
                if let Ok(mut bar) = bar.try_lock() {
                    let (tiles, of) = (u64::from(tiles), u64::from(of));
                    bar.update(u64::from(n) * of + tiles, u64::from(repeat) * of);
                }
            });
            times.push(begin.elapsed().as_secs_f64());
            image
        };
        let mut image = timed(0);
        for n in 1..repeat {
            image = timed(n);
        }
        Self { image, times, work: Work::default(), structure_bytes: structure, raw_bytes: raw }
    }
}
