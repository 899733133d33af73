//! Isosurfaces of a volume, whatever it is, rendered and compared with the oracle.

use anyhow::Result;
use glam::DAffine3;
use isoray_grid::Dims;
use isoray_oracle::{Lattice, OracleHit};
use isoray_render::{SURFACE_COLOR, Scene, Surface, SurfaceSource, render};

use super::compared::Compared;
use super::eye::Eye;
use super::pictures::Outcome;
use super::scenes::{Of, Surfaces};
use super::subjects::Extent;
use super::truth::{ByPlace, Truth};
use super::verify::differing_traversals;

/// Cells of several sizes, each of a level, of which a lattice is that of the finest. Points are in its coordinates.
pub(crate) trait Cells: Sync {
    /// The level of the cell at a point, if that can be told.
    fn level_at(&self, point: [f64; 3]) -> Option<u32>;

    /// The gradient by central differences on the lattice of the level of the cell that is hit, if rounding does not change it.
    fn central_gradient(&self, hit: &OracleHit) -> Option<[f64; 3]>;
}

/// How far from a face of a cell, in units of the lattice, it is told in which of two cells a hit is. Where it is not grazed, a surface is found to 10⁻⁵ voxels in all of the pictures; what is
/// off by more than this is in another cell's gradient than is expected, and fails.
pub(crate) const BESIDE: f64 = 1e-4;

/// What the oracle's lattice is to the volume; see [`Truth`].
#[derive(Clone, Copy)]
pub(crate) struct Precision<'a> {
    pub(crate) scale: f32,
    pub(crate) rounding: f64,
    pub(crate) cells: Option<&'a dyn Cells>,
    pub(crate) far_shadows: bool,
}

/// A volume that is looked at.
pub(crate) struct Subject<'a> {
    pub(crate) dims: Dims,
    pub(crate) to_world: DAffine3,
    pub(crate) eye: &'a Eye,
}

impl Subject<'_> {
    pub(crate) fn scene<'c>(&self, look: &Surfaces, of: Of, colors: Option<&'c ByPlace>) -> Scene<'c> {
        let extent = Extent::new(self.dims, &self.to_world);
        const COLORS: [[f32; 3]; 2] = [[0.85, 0.35, 0.2], [0.3, 0.5, 0.85]];
        let last = look.surfaces.len() - 1;
        let surface = |(n, &(value, opacity)): (usize, &(f32, f32))| Surface {
            isovalue: of.own(value),
            color: if n == last { SURFACE_COLOR } else { COLORS[n % 2].into() },
            opacity,
        };
        Scene {
            surfaces: look.surfaces.iter().enumerate().map(surface).collect(),
            normals: look.normals,
            lights: look.lamps.iter().map(|&lamp| extent.light(lamp)).collect(),
            specular: look.specular,
            shadows: look.shadows,
            sky_samples: look.sky_samples,
            clip: extent.clip(look.cuts),
            cap: look.cap,
            colors: colors.map(|colors| colors as _),
            level_colors: look.by_level,
            ..Scene::of(0.0)
        }
    }

    /// Renders a scene by all ways that rays can go, and compares it with the oracle.
    pub(crate) fn compared<S: SurfaceSource, L: Lattice>(
        &self,
        source: &S,
        lattice: &L,
        Precision { scale, rounding, cells, far_shadows }: Precision<'_>,
        scene: &Scene<'_>,
        title: &str,
    ) -> Result<Outcome> {
        let camera = &self.eye.camera;
        let image = render(source, self.to_world, camera, scene);
        let mut broken = differing_traversals(source, self.to_world, camera, scene, &image, title)?;
        let index_to_world = self.to_world;
        let eye = self.eye;
        let truth = Truth { lattice, scale, rounding, index_to_world, eye, scene, cells, far_shadows };
        let (compared, shown) = Compared::surfaces(&truth, &image, title)?;
        broken.extend(compared.failures());
        broken.extend(shown.iter().map(|path| format!("the oracle's picture beside it: {}", path.display())));
        Ok(Outcome { image, compared, broken, without: Vec::new() })
    }
}
