//! Emission and absorption along rays through all of a volume.

use isoray_grid::{DenseVolume, GridVolume};
use isoray_octree::OctreeVolume;
use isoray_preint::{Integrate, Visibility};
use isoray_trace::{DenseVolumeTracer, Ray, VolumeTracer};

use super::{Answer, Viewing, dims, octree, transfer};
use crate::volumes::marschner_lobb;

/// A picture of the Marschner-Lobb signal as a medium, in an octree volume and in an array.
#[derive(Debug)]
pub struct VolumeRays {
    octree: OctreeVolume<u8>,
    array: GridVolume<DenseVolume<'static, u8>>,
    visible: Visibility,
    rays: Vec<Ray>,
}

impl VolumeRays {
    /// Pixels along each side.
    const PIXELS: u32 = 48;

    /// The rays of a view of it. The samples are kept as long as the program runs.
    pub fn new(viewing: Viewing) -> Self {
        let samples: &'static [u8] = marschner_lobb(super::EDGE).leak();
        let view = viewing(dims(), Self::PIXELS, Self::PIXELS);
        let array = DenseVolume::new(dims(), samples).expect("they fill the lattice");
        Self {
            octree: octree(samples),
            array: GridVolume::new(array),
            visible: Visibility::new(&transfer()),
            rays: view.directions.iter().map(|&direction| view.ray(direction)).collect(),
        }
    }

    /// How many.
    pub fn count(&self) -> u64 {
        self.rays.len() as u64
    }

    /// Through the octree.
    #[inline(never)]
    pub fn octree(&self, scheme: &impl Integrate) -> Answer {
        let view = self.octree.view();
        let mut tracer = VolumeTracer::new(&view, &self.visible);
        Answer::of_radiances(self.rays.iter().map(|ray| tracer.integrate(ray, 1.0, scheme, None, &mut ())))
    }

    /// Through the array.
    #[inline(never)]
    pub fn array(&self, scheme: &impl Integrate) -> Answer {
        let mut tracer = DenseVolumeTracer::new(&self.array, &self.visible);
        Answer::of_radiances(self.rays.iter().map(|ray| tracer.integrate(ray, 1.0, scheme, None, &mut ())))
    }
}
