//! An adaptive mesh.

use isoray_amr::{Mesh, MeshOptions, MeshTracer, MeshVolumeTracer, Patches};
use isoray_preint::{Bounded, ControlPoint, TransferFunction, Visibility};
use isoray_trace::{Ray, Trace};

use super::Answer;
use crate::clumps::clumps;
use crate::views::View;

/// A mesh of clumps in two levels, and pictures of it from outside.
#[derive(Debug)]
pub struct Clumps {
    patches: Patches,
    mesh: Mesh,
    isovalue: f32,
    transfer: TransferFunction,
    surface_rays: Vec<Ray>,
    volume_rays: Vec<Ray>,
}

impl Clumps {
    /// Pixels along each side, of surfaces and of volumes.
    const PIXELS: [u32; 2] = [96, 32];
    /// Bound of every channel of a pixel.
    const EPSILON: f64 = 1.0 / 510.0;

    /// Always the same.
    pub fn generate() -> Self {
        let patches = clumps(2, 0.05, 32);
        let mesh = made(&patches);
        let [low, high] = mesh.range().expect("it has values");
        let rays = |pixels| {
            let view = View::far(mesh.dims(), pixels, pixels);
            view.directions.iter().map(|&direction| view.ray(direction)).collect()
        };
        let [surface_rays, volume_rays] = Self::PIXELS.map(rays);
        let point = |value, extinction| ControlPoint { value, color: [0.9, 0.6, 0.3], extinction };
        let middle = 0.5 * (low + high);
        let points = vec![point(low + 0.1 * (high - low), 0.0), point(middle, 0.05), point(high, 0.2)];
        let transfer = TransferFunction::new(points).expect("its points ascend");
        Self { isovalue: middle, mesh, patches, transfer, surface_rays, volume_rays }
    }

    /// How many leaves it has.
    pub fn leaves(&self) -> u64 {
        self.mesh.size().leaves.iter().sum()
    }

    /// How many rays look for its surface, and how many are integrated along.
    pub fn rays(&self) -> [u64; 2] {
        [&self.surface_rays, &self.volume_rays].map(|rays| rays.len() as u64)
    }

    /// Makes it from its patches: leaves, and bytes that they take.
    #[inline(never)]
    pub fn make(&self) -> Answer {
        let size = made(&self.patches).size();
        Answer { found: size.leaves.iter().sum(), sum: size.bytes as f64 }
    }

    /// First hits with the isosurface half-way between its least and its greatest value.
    #[inline(never)]
    pub fn surface(&self) -> Answer {
        let mut tracer = MeshTracer::new(&self.mesh);
        let hits = self.surface_rays.iter().filter_map(|ray| tracer.first_hit(ray, self.isovalue));
        Answer::of(hits.map(|hit| f64::from(hit.t)))
    }

    /// The scheme of [`volume`](Self::volume).
    pub fn scheme(&self) -> Bounded {
        Bounded::new(&self.transfer, Self::EPSILON, 1.0)
    }

    /// What rays through it gather.
    #[inline(never)]
    pub fn volume(&self, scheme: &Bounded) -> Answer {
        let mut tracer = MeshVolumeTracer::new(&self.mesh, &Visibility::new(&self.transfer));
        let rays = self.volume_rays.iter();
        Answer::of_radiances(rays.map(|ray| tracer.integrate(ray, 1.0, scheme, None, &mut ())))
    }
}

fn made(patches: &Patches) -> Mesh {
    Mesh::new(patches, MeshOptions::default()).expect("the patches cover their domain")
}
