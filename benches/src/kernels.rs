//! The kernels of the project, each with what it works on: criterion times them, and gungraun counts their instructions, so that both measure the same work.
//!
//! Each is a structure that has all that is made before; its methods do the work, and say by an [`Answer`] what came of it. Volumes and meshes are small, generated, and the same on
//! every run.
//!
//! - [`Roots`]: first roots in cells, one at a time and in lanes.
//! - [`Rays`]: first hits in an octree volume, of single rays and of packets.
//! - [`Building`]: octree volumes from samples.
//! - [`Stretches`]: emission and absorption in cells, by several schemes; [`VolumeRays`]: along rays through all of a volume.
//! - [`Clumps`]: an adaptive mesh, made from patches, and rays through it.
//! - [`Points`]: samples of an octree volume, and their neighbours.

mod building;
mod integrals;
mod mesh;
mod points;
mod rays;
mod roots;
mod volume;

use glam::DAffine3;
use isoray_build::build;
use isoray_grid::{DenseVolume, Dims};
use isoray_octree::OctreeVolume;
use isoray_preint::{ControlPoint, Radiance, TransferFunction};

use crate::views::View;

pub use building::Building;
pub use integrals::{Stretches, adaptive, bounded, fixed, table};
pub use mesh::Clumps;
pub use points::Points;
pub use rays::Rays;
pub use roots::Roots;
pub use volume::VolumeRays;

/// Samples along each edge of the volumes.
const EDGE: usize = 64;
/// Of the Marschner-Lobb signal.
const ISOVALUE: f32 = 127.5;

/// The rays of a view: [`View::far`] or [`View::close`], of a width and a height in pixels.
pub type Viewing = fn(Dims, u32, u32) -> View;

/// How much was found, and a sum over it: equal where the same was found, in the same order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Answer {
    /// How many of what was looked for.
    pub found: u64,
    /// Sum of their values, times or sizes.
    pub sum: f64,
}

impl Answer {
    /// That of all values found.
    fn of(values: impl Iterator<Item = f64>) -> Self {
        values.fold(Self { found: 0, sum: 0.0 }, |Self { found, sum }, value| Self {
            found: found + 1,
            sum: sum + value,
        })
    }

    /// That of rays which show anything: the sum of their opacities and colours.
    fn of_radiances(radiances: impl Iterator<Item = Radiance>) -> Self {
        let shown = radiances.filter(|radiance| radiance.alpha() > 0.0);
        Self::of(shown.map(|radiance| radiance.alpha() + radiance.color.iter().sum::<f64>()))
    }

    /// Itself, if anything was found.
    ///
    /// # Panics
    /// If not, or if what was found are no numbers: then nothing is worth measuring.
    #[track_caller]
    pub fn checked(self) -> Self {
        assert!(self.found > 0 && self.sum.is_finite(), "nothing of use was found: {self:?}");
        self
    }
}

/// Lets all that is done in parallel run on the calling thread: times then are those of one thread, and counts of instructions, which are taken on one, are complete and do not depend
/// on who was first. To be called before anything runs in parallel; a second call changes nothing.
pub fn on_this_thread() {
    // An error says that there is a pool already.
    let _ = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global();
}

/// The lattice of generated volumes.
fn dims() -> Dims {
    Dims::new([EDGE as u32; 3]).expect("the edge is between the limits")
}

/// The octree volume of samples, in index space.
fn octree(samples: &[u8]) -> OctreeVolume<u8> {
    let mut source = DenseVolume::new(dims(), samples).expect("they fill the lattice");
    build(&mut source, DAffine3::IDENTITY, |_| {}).expect("memory can be read, and there is enough of it")
}

/// A translucent shell and a dense one in a haze, of values from 0 to 255, per unit of index space: most of what rays meet shows something, and most of them go on.
fn transfer() -> TransferFunction {
    const COLORS: [[f32; 3]; 2] = [[0.85, 0.35, 0.12], [0.25, 0.5, 0.9]];
    let point = |value, shell: usize, extinction| ControlPoint { value, color: COLORS[shell], extinction };
    let points = [
        point(0.0, 0, 0.0),
        point(90.0, 0, 0.002),
        point(100.0, 0, 0.1),
        point(110.0, 0, 0.005),
        point(160.0, 1, 0.005),
        point(170.0, 1, 0.4),
        point(180.0, 1, 0.01),
        point(255.0, 1, 0.01),
    ];
    TransferFunction::new(points.into()).expect("its points ascend")
}
