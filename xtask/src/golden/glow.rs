//! Pictures of volumes by every scheme.

use anyhow::{Context, Result};
use glam::DVec3;
use isoray_grid::Scalar;
use isoray_octree::OctreeVolume;
use isoray_oracle::{DenseLattice, OracleRay, integrate_ray};
use isoray_preint::{
    Bounded, Cuts, Integrate, LinearPieces, Linearised, PreintegrationTable, TableAxes, TransferFunction,
    Visibility,
};
use isoray_render::{Camera, Clip, VolumeScene, VolumeShading, gradient_scale, render_volume};

use super::compared::Compared;
use super::pictures::Outcome;
use super::scenes::{Layers, Of, Scheme};
use super::subjects::Extent;
use super::truth::kept;
use crate::for_oracle;
use crate::shells::shells;

/// Every so-manieth pixel along x and y is compared with the oracle.
const STEP: u32 = 2;

/// What schemes without a bound may be off by, which is no promise of theirs: in these scenes it is 3.3·10⁻² at most, of pieces taken for linear ones.
const UNBOUNDED: f64 = 0.05;

/// Transmittance at which rays of those schemes end, as in the program.
const TERMINATE: f64 = 0.001;

/// How it is lit, if it is.
fn shading(look: &Layers, gradient_scale: f64) -> Option<VolumeShading> {
    look.is_shaded.then_some(VolumeShading {
        ambient: 0.3,
        diffuse: 0.7,
        specular: 0.2,
        exponent: 20.0,
        gradient_scale,
        light: Some(DVec3::new(0.3, -0.5, 0.8)),
    })
}

impl Scheme {
    /// With a bound of errors; without one it is what was measured.
    pub(crate) fn with(
        self,
        transfer: &TransferFunction,
        brightest: f32,
        range: [f32; 2],
        longest: f32,
    ) -> Result<(Box<dyn Integrate>, f64)> {
        let adaptive = Cuts::Adaptive { inflection: true, shading: true };
        let linear = |cuts| Linearised { cuts, pieces: LinearPieces::new(transfer), terminate: TERMINATE };
        Ok(match self {
            Self::Bounded(epsilon) | Self::ByLevel(epsilon) => {
                (Box::new(Bounded::new(transfer, epsilon, brightest)), epsilon)
            }
            Self::Adaptive => (Box::new(linear(adaptive)), UNBOUNDED),
            Self::Fixed(pieces) => (Box::new(linear(Cuts::Fixed(pieces))), UNBOUNDED),
            Self::Table => {
                let pieces = PreintegrationTable::<f32>::new(transfer, TableAxes::new(range, longest))?;
                (Box::new(Linearised { cuts: adaptive, pieces, terminate: TERMINATE }), UNBOUNDED)
            }
        })
    }
}

/// A picture of a volume that is no mesh.
pub(crate) fn dense<T: Scalar>(
    look: &Layers,
    of: Of,
    octree: &OctreeVolume<T>,
    lattice: &DenseLattice<f32>,
    camera: &Camera,
) -> Result<Outcome> {
    let view = octree.view();
    let to_world = octree.meta().index_to_world;
    let range = octree.meta().range.context("no sample is finite")?;
    let scale = gradient_scale(&view, to_world);
    let ends = range.map(|v| v as f32);
    let transfer = shells(of.isovalues(), ends, scale)?;
    let shading = shading(look, scale);
    let brightest = shading.map_or(1.0, |s| s.brightest(&to_world, range[1] - range[0]));
    let diagonal = [0, 1, 2].map(|a| to_world.matrix3.col(a)).into_iter().sum::<DVec3>().length();
    let (scheme, bound) = look.scheme.with(&transfer, brightest, ends, diagonal as f32)?;
    let clip = Extent::new(view.dims(), &to_world).clip(look.cuts);
    let visible = Visibility::new(&transfer);
    let scene = VolumeScene { visible: &visible, scheme: &scheme, shading, clip: Some(&clip) };
    let image = render_volume(&view, to_world, camera, &scene, |_, _| {});
    let points = for_oracle::transfer(transfer.points());
    let to_index = to_world.inverse();
    let truth = |[x, y]: [u32; 2]| {
        let Some(ray) = clipped(camera, &clip, for_oracle::ray(&camera.index_ray(&to_index, x, y)), [x, y])
        else {
            return Some([Some(0.0); 4]);
        };
        let direction = camera.world_ray(x, y).1;
        let shading = shading.map(|s| for_oracle::shading(&s.lighting(&to_index, direction)));
        let radiance = integrate_ray(lattice, &ray, 1.0, &points, shading.as_ref());
        let [r, g, b] = radiance.color;
        Some([r, g, b, radiance.alpha()].map(Some))
    };
    let compared = Compared::volume(&image, STEP, Some(bound), truth);
    let broken = compared.failures();
    Ok((image, Some(compared), broken))
}

/// The part of a ray that is kept.
fn clipped(camera: &Camera, clip: &Clip, ray: OracleRay, [x, y]: [u32; 2]) -> Option<OracleRay> {
    let (origin, direction) = camera.world_ray(x, y);
    let [begin, end] = kept(&clip.0, origin, direction)?.ends;
    Some(OracleRay { t_min: begin.max(0.0) as f32, t_max: end as f32, ..ray })
}
