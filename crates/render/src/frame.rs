//! Frames of an isosurface.

use crate::camera::Camera;
use crate::image::{Image, Pixel};
use crate::shade::{Normals, Scene, shade};
use crate::tiles::{Tile, in_tiles};
use glam::{DAffine3, Vec3};
use isoray_cell::unit_normal;
use isoray_grid::Scalar;
use isoray_octree::OctreeView;
use isoray_trace::{Counters, FirstHit, Hit, Tracer, Work, central_gradient};

/// What a frame cost and showed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FrameStatistics {
    /// Primary rays: one a pixel.
    pub rays: u64,
    /// Those that hit.
    pub hits: u64,
    /// Hits at which the gradient vanishes, so that the surface has no normal.
    pub flat: u64,
    /// Nodes, samples and cells.
    pub work: Work,
}

impl FrameStatistics {
    fn join(mut self, other: Self) -> Self {
        self.rays += other.rays;
        self.hits += other.hits;
        self.flat += other.flat;
        self.work += other.work;
        self
    }
}

/// Renders one frame on the threads of the current rayon pool; bit-identical for any number of them.
pub fn render<T: Scalar>(
    view: &OctreeView<'_, T>,
    index_to_world: DAffine3,
    camera: &Camera,
    scene: &Scene,
) -> Image {
    render_with_progress(view, index_to_world, camera, scene, |_, _| {})
}

/// As [`render`], and calls `progress` with the number of tiles done and of tiles in all after each of them: on the
/// thread that finished it, so that calls can overlap and numbers overtake one another.
pub fn render_with_progress<T: Scalar>(
    view: &OctreeView<'_, T>,
    index_to_world: DAffine3,
    camera: &Camera,
    scene: &Scene,
    progress: impl Fn(u32, u32) + Sync,
) -> Image {
    frame::<T, ()>(view, index_to_world, camera, scene, progress).0
}

/// As [`render`], and counts the work, which costs a little.
pub fn render_counted<T: Scalar>(
    view: &OctreeView<'_, T>,
    index_to_world: DAffine3,
    camera: &Camera,
    scene: &Scene,
) -> (Image, FrameStatistics) {
    let (image, tiles) = frame::<T, Work>(view, index_to_world, camera, scene, |_, _| {});
    let mut sum = FrameStatistics::default();
    for (statistics, work) in tiles {
        sum = sum.join(FrameStatistics { work, ..statistics });
    }
    (image, sum)
}

/// Everything that all pixels share.
struct Context<'a, T: Scalar> {
    view: &'a OctreeView<'a, T>,
    world_to_index: DAffine3,
    /// The rows of the matrix that takes gradients to world space: ∇s transforms with the inverse transpose.
    normal_matrix: [[f64; 3]; 3],
    camera: &'a Camera,
    scene: &'a Scene,
}

/// Counters of one tile.
type TileCount<C> = (FrameStatistics, C);

fn frame<T: Scalar, C: Counters + Default + Send + Clone>(
    view: &OctreeView<'_, T>,
    index_to_world: DAffine3,
    camera: &Camera,
    scene: &Scene,
    progress: impl Fn(u32, u32) + Sync,
) -> (Image, Vec<TileCount<C>>) {
    let world_to_index = index_to_world.inverse();
    let normal_matrix = world_to_index.matrix3.to_cols_array_2d();
    let context = Context { view, world_to_index, normal_matrix, camera, scene };
    let tile = |tracer: &mut Tracer<'_, T>, tile| context.tile::<C>(tracer, tile);
    in_tiles(camera.size(), || Tracer::new(view), tile, progress)
}

impl<T: Scalar> Context<'_, T> {
    fn tile<C: Counters + Default>(
        &self,
        tracer: &mut Tracer<'_, T>,
        tile: Tile,
    ) -> (Vec<Pixel>, TileCount<C>) {
        let mut pixels = Vec::with_capacity(tile.len());
        let mut statistics = FrameStatistics::default();
        let mut counters = C::default();
        for [x, y] in tile.pixels() {
            let mut first = FirstHit::default();
            let ray = self.camera.index_ray(&self.world_to_index, x, y);
            tracer.trace(&ray, self.scene.isovalue, &mut first, &mut counters);
            statistics.rays += 1;
            pixels.push(first.0.map_or(Pixel::EMPTY, |hit| {
                let pixel = self.pixel(x, y, &hit);
                statistics.hits += 1;
                statistics.flat += u64::from(pixel.normal == Vec3::ZERO);
                pixel
            }));
        }
        (pixels, (statistics, counters))
    }

    fn pixel(&self, x: u32, y: u32, hit: &Hit) -> Pixel {
        let gradient = match self.scene.normals {
            Normals::Forward => hit.gradient(),
            Normals::Central => central_gradient(self.view, hit),
        };
        let normal = unit_normal(gradient.map(f64::from), &self.normal_matrix);
        let normal = Vec3::from_array(normal.direction.map(|c| c as f32));
        let (origin, direction) = self.camera.world_ray(x, y);
        let position = origin + direction * f64::from(hit.t);
        let color = shade(self.scene, normal, position, direction);
        Pixel { color: color.extend(1.0), depth: hit.t, normal }
    }
}
