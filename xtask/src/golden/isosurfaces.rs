//! Isosurfaces of a volume, whatever it is, rendered and compared with the oracle.

use anyhow::Result;
use glam::DAffine3;
use isoray_grid::Dims;
use isoray_oracle::Lattice;
use isoray_render::{SURFACE_COLOR, Scene, Surface, SurfaceSource, render};

use super::compared::Compared;
use super::eye::Eye;
use super::pictures::Outcome;
use super::scenes::{Of, Surfaces};
use super::subjects::Extent;
use super::truth::{ByPlace, Truth};
use super::verify::differing_traversals;

/// The level of detail of the cell at a point of index space, if that can be told.
pub(crate) type LevelAt<'a> = &'a (dyn Fn([f64; 3]) -> Option<u32> + Sync);

/// What the oracle's lattice is to the volume; see [`Truth`].
#[derive(Clone, Copy)]
pub(crate) struct Precision<'a> {
    pub(crate) scale: f32,
    pub(crate) rounding: f64,
    pub(crate) has_shadows: bool,
    pub(crate) level: Option<LevelAt<'a>>,
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
        Precision { scale, rounding, has_shadows, level }: Precision<'_>,
        scene: &Scene<'_>,
        title: &str,
    ) -> Result<Outcome> {
        let camera = &self.eye.camera;
        let image = render(source, self.to_world, camera, scene);
        let mut broken = differing_traversals(source, self.to_world, camera, scene, &image, title)?;
        let index_to_world = self.to_world;
        let eye = self.eye;
        let truth = Truth { lattice, scale, rounding, index_to_world, eye, scene, has_shadows, level };
        let (compared, shown) = Compared::surfaces(&truth, &image, title)?;
        broken.extend(compared.failures());
        broken.extend(shown.iter().map(|path| format!("the oracle's picture beside it: {}", path.display())));
        Ok(Outcome { image, compared, broken, without: Vec::new() })
    }
}
