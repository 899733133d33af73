//! Frames of a volume: emission and absorption.

use glam::{DAffine3, DVec3, Vec3, Vec4};
use isoray_preint::{Integrate, Lighting, Radiance, Visibility};
use isoray_trace::{Counters, Ray, Work};

use crate::camera::Camera;
use crate::clip::Clip;
use crate::image::{Image, Pixel};
use crate::source::VolumeSource;
use crate::tiles::{Tile, in_tiles};

/// Shading of a volume: what the colour is multiplied by, `ambient + diffuse·|g·L| + specular·min(1, |g·H|)^exponent`, with
/// `g = ∇s/gradient_scale` in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeShading {
    /// Share that needs no light.
    pub ambient: f32,
    /// Factor of the diffuse term.
    pub diffuse: f32,
    /// Factor of the highlight; zero: there is none.
    pub specular: f32,
    /// The larger, the smaller the highlight; at least 1.
    pub exponent: f32,
    /// Change of value per world unit that counts as 1; positive. [`gradient_scale`](crate::gradient_scale()) proposes one.
    pub gradient_scale: f64,
    /// World direction to the light; `None`: each ray is lit along itself.
    pub light: Option<DVec3>,
}

/// What is drawn of a volume, and how it is integrated.
#[derive(Clone, Copy, Debug)]
pub struct VolumeScene<'a, I> {
    /// What can be seen.
    pub visible: &'a Visibility,
    /// How segments are integrated, according to a transfer function.
    pub scheme: &'a I,
    /// How it is lit; `None`: by itself alone.
    pub shading: Option<VolumeShading>,
    /// What is cut away; `None`: nothing.
    pub clip: Option<&'a Clip>,
}

/// What a frame of a volume cost.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VolumeStatistics {
    /// Primary rays: one a pixel.
    pub rays: u64,
    /// Those that met anything visible.
    pub lit: u64,
    /// Those that ended because what lies behind cannot matter.
    pub ended: u64,
    /// Pieces that were integrated.
    pub pieces: u64,
    /// The largest bound of a pixel's error, of a scheme that has one; what is spent on the transfer function is not in it.
    pub largest_bound: f64,
    /// Nodes, samples and cells.
    pub work: Work,
}

impl VolumeStatistics {
    /// Adds what a ray gathered.
    fn add(&mut self, radiance: &Radiance) {
        self.lit += u64::from(radiance.pieces > 0);
        self.ended += u64::from(radiance.is_done);
        self.pieces += u64::from(radiance.pieces);
        self.largest_bound = self.largest_bound.max(radiance.error);
    }

    fn join(mut self, other: Self) -> Self {
        self.rays += other.rays;
        self.lit += other.lit;
        self.ended += other.ended;
        self.pieces += other.pieces;
        self.largest_bound = self.largest_bound.max(other.largest_bound);
        self.work += other.work;
        self
    }
}

/// Renders one frame of an octree volume or of a dense one on the threads of the current rayon pool; bit-identical for any number of them. Pixels have no depth and no normal.
/// `progress` is called as by [`render_with_progress`](crate::render_with_progress).
pub fn render_volume<V: VolumeSource, I: Integrate>(
    volume: &V,
    index_to_world: DAffine3,
    camera: &Camera,
    scene: &VolumeScene<'_, I>,
    progress: impl Fn(u32, u32) + Sync,
) -> Image {
    frame::<V, I, ()>(volume, index_to_world, camera, scene, &progress).0
}

/// As [`render_volume`], and counts the work, which costs a little.
pub fn render_volume_counted<V: VolumeSource, I: Integrate>(
    volume: &V,
    index_to_world: DAffine3,
    camera: &Camera,
    scene: &VolumeScene<'_, I>,
) -> (Image, VolumeStatistics) {
    let (image, tiles) = frame::<V, I, Work>(volume, index_to_world, camera, scene, &|_, _| {});
    let add = |sum: VolumeStatistics, (statistics, work)| sum.join(VolumeStatistics { work, ..statistics });
    (image, tiles.into_iter().fold(VolumeStatistics::default(), add))
}

/// Pixels along the edge of the squares whose rays go together: what they gather then stays in the nearest cache. With 8, heptane close took up to 1.05 of the
/// time.
const SQUARE_EDGE: u32 = 4;

// Never inlined, so that crates share what one of them has compiled: it takes long.
#[inline(never)]
fn frame<V: VolumeSource, I: Integrate, C: Counters + Default + Send>(
    volume: &V,
    index_to_world: DAffine3,
    camera: &Camera,
    scene: &VolumeScene<'_, I>,
    progress: &(dyn Fn(u32, u32) + Sync),
) -> (Image, Vec<(VolumeStatistics, C)>) {
    let world_to_index = index_to_world.inverse();
    let tile = |tracer: &mut V::Tracer<'_>, tile: Tile| {
        let mut pixels = vec![Pixel::EMPTY; tile.len()];
        let mut statistics = VolumeStatistics::default();
        let mut counters = C::default();
        let (mut places, mut rays) = (Vec::new(), Vec::new());
        for square in tile.squares(SQUARE_EDGE) {
            places.clear();
            rays.clear();
            statistics.rays += square.len() as u64;
            places.extend(square.pixels());
            camera.add_index_rays(&world_to_index, &places, &mut rays);
            if let Some(clip) = scene.clip {
                cut_off(camera, clip, &mut places, &mut rays);
            }
            let lighting = |n: usize| {
                let [x, y]: [u32; 2] = places[n];
                scene.shading.map(|s| s.lighting(&world_to_index, camera.world_ray(x, y).1))
            };
            let take = |n: usize, radiance: Radiance| {
                statistics.add(&radiance);
                let color = Vec3::from_array(radiance.color.map(|c| c as f32));
                pixels[tile.index(places[n])].color = Vec4::from((color, radiance.alpha() as f32));
            };
            V::integrate(tracer, &rays, scene.scheme, lighting, &mut counters, take);
        }
        (pixels, (statistics, counters))
    };
    in_tiles(camera.size(), || volume.tracer(scene.visible), tile, progress)
}

/// Leaves out of the rays of pixels what is clipped, and those of which nothing is left.
fn cut_off(camera: &Camera, clip: &Clip, places: &mut Vec<[u32; 2]>, rays: &mut Vec<Ray>) {
    let kept = places.drain(..).zip(rays.drain(..)).filter_map(|([x, y], ray)| {
        let (origin, direction) = camera.world_ray(x, y);
        let kept = clip.kept(origin, direction)?;
        Some(([x, y], Ray { t_min: kept.begin.max(0.0) as f32, t_max: kept.end as f32, ..ray }))
    });
    let kept: Vec<_> = kept.collect();
    (*places, *rays) = kept.into_iter().unzip();
}

impl VolumeShading {
    /// In index space, along a ray of unit world `direction`.
    pub fn lighting(&self, world_to_index: &DAffine3, direction: DVec3) -> Lighting {
        let to_viewer = -direction;
        let to_light = self.light.map_or(to_viewer, |light| light.normalize_or(to_viewer));
        let half = (to_light + to_viewer).normalize_or(to_viewer);
        // ∇s in the world is the inverse transpose of the map times that in index space.
        let in_index = |v: DVec3| (world_to_index.matrix3 * v / self.gradient_scale).as_vec3().to_array();
        Lighting {
            ambient: self.ambient,
            diffuse: self.diffuse,
            specular: self.specular,
            exponent: self.exponent,
            light: in_index(to_light),
            half: in_index(half),
        }
    }

    /// A bound of the factor in a volume whose values span `range`, placed in the world by `index_to_world`.
    ///
    /// The field changes by no more than the range from one sample to the next.
    pub fn brightest(&self, index_to_world: &DAffine3, range: f64) -> f32 {
        let rows = index_to_world.inverse().matrix3.transpose();
        // A unit vector's component along an axis of the index is at most the length of that row.
        let steepest =
            [rows.x_axis, rows.y_axis, rows.z_axis].map(|r| r.length() * range / self.gradient_scale);
        self.ambient + self.diffuse * steepest.iter().sum::<f64>() as f32 + self.specular
    }
}
