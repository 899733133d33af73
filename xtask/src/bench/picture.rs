//! Pictures of a volume as an interactive program makes them, one after the other.

use glam::{DAffine3, DVec3};
use isoray_grid::Scalar;
use isoray_octree::lod::{Detail, DetailRequest, DetailView, DistanceMeasure};
use isoray_octree::{Coarse, OctreeView, OctreeVolume};
use isoray_render::{Camera, FrameStatistics, Image, Scene, render, render_counted};
use isoray_trace::Work;

/// The direction to a lamp: from the side and from above, so that there are shadows in every view.
pub(crate) const LAMP: DVec3 = DVec3::new(-0.5, 1.0, 0.6);

/// A volume that is looked at.
pub(crate) struct Pictures<'a, T: Scalar> {
    octree: OctreeView<'a, T>,
    to_world: DAffine3,
}

impl<'a, T: Scalar> Pictures<'a, T> {
    pub(crate) fn new(volume: &'a OctreeVolume<T>) -> Self {
        Self { octree: volume.view(), to_world: volume.meta().index_to_world }
    }

    /// At the finest level.
    pub(crate) fn exact(&self, camera: &Camera, scene: &Scene<'_>) -> Image {
        render(&self.octree, self.to_world, camera, scene)
    }

    /// Through levels of detail, even if there is one only: injected samples, true distance, hard transitions.
    pub(crate) fn at_levels(&self, camera: &Camera, scene: &Scene<'_>, detail: Detail) -> Image {
        let view = DetailView::new(&self.octree, Coarse::Injected, detail);
        render(&view, self.to_world, camera, scene)
    }

    /// As [`frame`](Self::frame), with the work that it takes.
    pub(crate) fn counted(&self, camera: &Camera, scene: &Scene<'_>, ratio: f64) -> (Image, Work) {
        let detail = self.detail(camera, ratio);
        let (image, FrameStatistics { work, .. }) = match *detail.levels().end() {
            0 => render_counted(&self.octree, self.to_world, camera, scene),
            _ => {
                let view = DetailView::new(&self.octree, Coarse::Injected, detail);
                render_counted(&view, self.to_world, camera, scene)
            }
        };
        (image, work)
    }

    /// Which levels of detail a camera sees.
    pub(crate) fn detail(&self, camera: &Camera, ratio: f64) -> Detail {
        let measure = DistanceMeasure::True;
        let request = DetailRequest { pixel: camera.pixel_width(), ratio, measure, blend: 0.0 };
        Detail::new(self.octree.dims(), &self.to_world, &request)
    }

    /// A frame, with all that must be made anew where the camera moves; and the coarsest level that it may show.
    pub(crate) fn frame(&self, camera: &Camera, scene: &Scene<'_>, ratio: f64) -> (Image, u32) {
        let detail = self.detail(camera, ratio);
        match *detail.levels().end() {
            0 => (self.exact(camera, scene), 0),
            coarsest => (self.at_levels(camera, scene, detail), coarsest),
        }
    }
}

/// Pixels that show a surface.
pub(crate) fn hits(image: &Image) -> u64 {
    image.pixels().iter().filter(|pixel| pixel.depth.is_finite()).count() as u64
}
