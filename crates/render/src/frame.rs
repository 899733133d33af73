//! Frames of isosurfaces.

use glam::{DAffine3, DVec3, Vec3};
use isoray_cell::unit_normal;
use isoray_grid::Dims;
use isoray_packet::{TracePackets, Traversal};
use isoray_trace::{Counters, Crossing, Hit, Ray, Trace, Work};

use crate::camera::{Camera, into_index_space};
use crate::image::{Image, Pixel};
use crate::layers::Layers;
use crate::scene::{LEVEL_COLORS, Normals, Scene};
use crate::shade::{Point, PointShadows, Shader, Shadows};
use crate::source::SurfaceSource;
use crate::tiles::{Tile, in_tiles};

/// What a frame cost and showed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FrameStatistics {
    /// Primary rays: one a pixel.
    pub rays: u64,
    /// Those that hit, a surface or a cap.
    pub hits: u64,
    /// First hits at which the gradient vanishes, so that the surface has no normal.
    pub flat: u64,
    /// Nodes, samples and cells, those of shadow rays included.
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

/// Renders one frame of a volume on the threads of the current rayon pool; bit-identical for any number of them, and for an octree or a grid.
///
/// Translucent surfaces are composited front to back, in the order in which each ray crosses them; depth and normal are those of the first crossing. A
/// ray ends where what is behind could change no channel of linear colour by more than 2⁻¹³, less than half a step of eight bits even
/// where that is finest.
pub fn render<V: SurfaceSource>(
    volume: &V,
    index_to_world: DAffine3,
    camera: &Camera,
    scene: &Scene<'_>,
) -> Image {
    render_with_progress(volume, index_to_world, camera, scene, |_, _| {})
}

/// As [`render`], and calls `progress` with the number of tiles done and of tiles in all after each of them: on the
/// thread that finished it, so that calls can overlap and numbers overtake one another.
pub fn render_with_progress<V: SurfaceSource>(
    volume: &V,
    index_to_world: DAffine3,
    camera: &Camera,
    scene: &Scene<'_>,
    progress: impl Fn(u32, u32) + Sync,
) -> Image {
    frame::<V, ()>(volume, index_to_world, camera, scene, &progress).0
}

/// As [`render`], and counts the work, which costs a little.
pub fn render_counted<V: SurfaceSource>(
    volume: &V,
    index_to_world: DAffine3,
    camera: &Camera,
    scene: &Scene<'_>,
) -> (Image, FrameStatistics) {
    let (image, tiles) = frame::<V, Work>(volume, index_to_world, camera, scene, &|_, _| {});
    let mut sum = FrameStatistics::default();
    for (statistics, work) in tiles {
        sum = sum.join(FrameStatistics { work, ..statistics });
    }
    (image, sum)
}

/// Everything that all pixels share.
pub(crate) struct Context<'a> {
    pub(crate) dims: Dims,
    pub(crate) world_to_index: DAffine3,
    /// The rows of the matrix that takes gradients to world space: ∇s transforms with the inverse transpose.
    normal_matrix: [[f64; 3]; 3],
    camera: &'a Camera,
    pub(crate) scene: &'a Scene<'a>,
    pub(crate) isovalues: Vec<f32>,
}

/// A pixel's ray.
pub(crate) struct Look {
    pub(crate) pixel: [u32; 2],
    /// In world space.
    pub(crate) origin: DVec3,
    pub(crate) direction: DVec3,
}

/// What a thread traces with.
pub(crate) struct Tracing<R> {
    pub(crate) tracer: R,
    /// Room for the crossings of one ray.
    pub(crate) found: Vec<Crossing>,
    packet: PacketOfPixels,
}

/// Room for the rays of a packet, and what they hit.
#[derive(Default)]
struct PacketOfPixels {
    pixels: Vec<[u32; 2]>,
    rays: Vec<Ray>,
    hits: Vec<Option<Hit>>,
    /// By light.
    shadows: Vec<PointShadows>,
}

/// Counters of one tile.
type TileCount<C> = (FrameStatistics, C);

// Never inlined, so that crates share what one of them has compiled: it takes long.
#[inline(never)]
fn frame<V: SurfaceSource, C: Counters + Default + Send + Clone>(
    volume: &V,
    index_to_world: DAffine3,
    camera: &Camera,
    scene: &Scene<'_>,
    progress: &(dyn Fn(u32, u32) + Sync),
) -> (Image, Vec<TileCount<C>>) {
    let world_to_index = index_to_world.inverse();
    let context = Context {
        dims: volume.dims(),
        world_to_index,
        normal_matrix: world_to_index.matrix3.to_cols_array_2d(),
        camera,
        scene,
        isovalues: scene.surfaces.iter().map(|surface| surface.isovalue).collect(),
    };
    let tracing =
        || Tracing { tracer: volume.surface_tracer(), found: Vec::new(), packet: PacketOfPixels::default() };
    let tile = |tracing: &mut Tracing<V::SurfaceTracer<'_>>, tile| context.tile::<_, C>(tracing, tile);
    in_tiles(camera.size(), tracing, tile, progress)
}

/// A pixel that shows a hit of an opaque surface, the point of this number among those of which shadows are known.
#[inline(always)]
fn seen_at<R: Trace, C: Counters>(point: &Point<'_>, number: usize, shader: &mut Shader<'_, R, C>) -> Pixel {
    let color = shader.shade(point, number).extend(1.0);
    let depth = point.hit.map_or(f32::INFINITY, |(hit, _)| hit.t);
    Pixel { color, depth, normal: point.normal }
}

impl Context<'_> {
    /// Whether a pixel can show more than the first crossing of one surface.
    fn is_layered(&self) -> bool {
        let is_single = matches!(self.scene.surfaces[..], [only] if only.opacity >= 1.0);
        !is_single || self.scene.cap
    }

    fn tile<R: TracePackets, C: Counters + Default>(
        &self,
        tracing: &mut Tracing<R>,
        tile: Tile,
    ) -> (Vec<Pixel>, TileCount<C>) {
        let mut counters = C::default();
        let pixels = match self.is_layered() {
            false => self.first_surface(tracing, tile, &mut counters),
            true => {
                counters.alone(tile.len());
                tile.pixels().map(|pixel| self.layers(tracing, pixel, &mut counters)).collect()
            }
        };
        let hits = pixels.iter().filter(|pixel| pixel.depth.is_finite());
        let statistics = FrameStatistics {
            rays: pixels.len() as u64,
            hits: hits.clone().count() as u64,
            flat: hits.filter(|pixel| pixel.normal == Vec3::ZERO).count() as u64,
            work: Work::default(),
        };
        (pixels, (statistics, counters))
    }

    fn look(&self, pixel: [u32; 2]) -> Look {
        let (origin, direction) = self.camera.world_ray(pixel[0], pixel[1]);
        Look { pixel, origin, direction }
    }

    /// The ray of a pixel in index space, without what is cut off.
    fn ray(&self, look: &Look) -> Option<Ray> {
        let ray = into_index_space(&self.world_to_index, look.origin, look.direction);
        if self.scene.clip.0.is_empty() {
            return Some(ray);
        }
        let kept = self.scene.clip.kept(look.origin, look.direction)?;
        let [t_min, t_max] = [kept.begin.max(0.0) as f32, kept.end as f32];
        Some(Ray { t_min, t_max, ..ray })
    }

    /// The rays of pixels, which stay those that have one.
    fn rays(&self, pixels: &mut Vec<[u32; 2]>, rays: &mut Vec<Ray>) {
        rays.clear();
        if !self.scene.clip.0.is_empty() {
            pixels.retain(|&pixel| {
                let ray = self.ray(&self.look(pixel));
                rays.extend(ray);
                ray.is_some()
            });
            return;
        }
        self.camera.add_index_rays(&self.world_to_index, pixels, rays);
    }

    /// Whether nothing is seen of a single opaque surface in a tile, as far as the hull of its rays tells.
    fn is_background<R: TracePackets, C: Counters>(
        &self,
        tracing: &mut Tracing<R>,
        tile: Tile,
        counters: &mut C,
    ) -> bool {
        self.scene.traversal != Traversal::Single
            && self
                .camera
                .hull(&self.world_to_index, tile.corners())
                .is_some_and(|hull| !tracing.tracer.may_hit(&hull, self.isovalues[0], counters))
    }

    /// What is seen of a single opaque surface, packet by packet.
    fn first_surface<R: TracePackets, C: Counters>(
        &self,
        tracing: &mut Tracing<R>,
        tile: Tile,
        counters: &mut C,
    ) -> Vec<Pixel> {
        /// Pixels along the edge of the squares whose rays share lanes.
        const PACKLET: u32 = 4;
        let mut seen = vec![Pixel::EMPTY; tile.len()];
        if self.is_background(tracing, tile, counters) {
            tile.squares(self.scene.packet_edge).for_each(|_| counters.packet(true));
            return seen;
        }
        for packet in tile.squares(self.scene.packet_edge) {
            let Tracing { tracer, packet: PacketOfPixels { pixels, rays, hits, shadows }, .. } = tracing;
            pixels.clear();
            pixels.extend(packet.squares(PACKLET).flat_map(Tile::pixels));
            self.rays(pixels, rays);
            hits.resize(rays.len(), None);
            tracer.first_hits(rays, self.isovalues[0], self.scene.traversal, hits, counters);
            let hits = pixels.iter().zip(&*hits).filter_map(|(&pixel, hit)| Some((pixel, hit.as_ref()?)));
            if !self.scene.has_shadows() {
                let mut shader = self.shader(tracer, counters, Shadows::Traced);
                for (pixel, hit) in hits {
                    let point = self.point(&self.look(pixel), hit, 0, shader.tracer);
                    seen[tile.index(pixel)] = seen_at(&point, 0, &mut shader);
                }
                continue;
            }
            let points: Vec<Point<'_>> =
                hits.map(|(pixel, hit)| self.point(&self.look(pixel), hit, 0, tracer)).collect();
            self.shadows(&points, tracer, shadows, counters);
            let mut shader = self.shader(tracer, counters, Shadows::Known(shadows));
            for (n, point) in points.iter().enumerate() {
                seen[tile.index(point.pixel)] = seen_at(point, n, &mut shader);
            }
        }
        seen
    }

    /// What is seen of several surfaces, or of translucent ones, or of caps.
    fn layers<R: Trace, C: Counters>(
        &self,
        tracing: &mut Tracing<R>,
        pixel: [u32; 2],
        counters: &mut C,
    ) -> Pixel {
        let look = self.look(pixel);
        let Some(ray) = self.ray(&look) else { return Pixel::EMPTY };
        Layers::default().gather(self, tracing, &look, &ray, counters).pixel()
    }

    /// Colour and normal at a hit.
    #[inline(always)]
    pub(crate) fn hit<R: Trace, C: Counters>(
        &self,
        look: &Look,
        hit: &Hit,
        surface: usize,
        tracer: &mut R,
        counters: &mut C,
    ) -> (Vec3, Vec3) {
        let point = self.point(look, hit, surface, tracer);
        (self.shader(tracer, counters, Shadows::Traced).shade(&point, 0), point.normal)
    }

    /// What is there at a hit.
    #[inline(always)]
    fn point<'h, R: Trace>(&self, look: &Look, hit: &'h Hit, surface: usize, tracer: &mut R) -> Point<'h> {
        let gradient = match self.scene.normals {
            Normals::Forward => hit.gradient(),
            Normals::Central => tracer.central_gradient(hit),
        };
        let normal = unit_normal(gradient.map(f64::from), &self.normal_matrix);
        Point {
            position: look.origin + look.direction * f64::from(hit.t),
            to_viewer: -look.direction,
            normal: Vec3::from_array(normal.direction.map(|c| c as f32)),
            color: self.hit_color(surface, hit),
            hit: Some((hit, surface)),
            pixel: look.pixel,
        }
    }

    /// Finds out which lights are hidden from the points of a packet, of the only surface: light by light, so that rays run side by side.
    fn shadows<R: TracePackets, C: Counters>(
        &self,
        points: &[Point<'_>],
        tracer: &mut R,
        shadows: &mut Vec<PointShadows>,
        counters: &mut C,
    ) {
        shadows.resize(self.scene.lights.len(), PointShadows::default());
        shadows.iter_mut().for_each(PointShadows::clear);
        let mut shader = self.shader(tracer, counters, Shadows::Traced);
        points.iter().for_each(|point| shader.collect(point, shadows));
        for of_light in shadows {
            of_light.trace(tracer, self.isovalues[0], self.scene.traversal, counters);
        }
    }

    pub(crate) fn shader<'s, R, C>(
        &'s self,
        tracer: &'s mut R,
        counters: &'s mut C,
        shadows: Shadows<'s>,
    ) -> Shader<'s, R, C> {
        Shader {
            scene: self.scene,
            isovalues: &self.isovalues,
            world_to_index: &self.world_to_index,
            tracer,
            counters,
            shadows,
        }
    }

    fn hit_color(&self, surface: usize, hit: &Hit) -> Vec3 {
        if self.scene.level_colors {
            return LEVEL_COLORS[hit.level as usize % LEVEL_COLORS.len()];
        }
        let (cell, local) = hit.in_finest(self.dims);
        self.color(surface, cell, local)
    }

    /// Of a surface at a point.
    pub(crate) fn color(&self, surface: usize, cell: [u32; 3], local: [f32; 3]) -> Vec3 {
        match self.scene.colors {
            Some(colors) => colors.color(cell, local),
            None => self.scene.surfaces[surface].color,
        }
    }
}
