//! Pictures of volumes by every scheme.

use anyhow::{Context, Result, bail};
use glam::DAffine3;
use isoray_grid::{DenseVolume, Dims, GridVolume, Scalar};
use isoray_oracle::{OracleRay, integrate_ray};
use isoray_preint::{
    Bounded, Cuts, Integrate, LinearPieces, Linearised, PreintegrationTable, TableAxes, TransferFunction,
    Visibility,
};
use isoray_render::{Clip, Image, VolumeScene, VolumeShading, VolumeSource, gradient_scale, render_volume};

use super::compared::{Compared, Truths, exactly};
use super::eye::Eye;
use super::off;
use super::pictures::{DenseScene, Outcome};
use super::scenes::{Lamp, Layers, Scheme};
use super::subjects::Extent;
use super::truth::kept;
use crate::for_oracle::{self, breaks};
use crate::shells::{lit, shells};

/// What schemes without a bound may be off by, which is no promise of theirs: the most in these scenes, 3.3·10⁻² by adaptive cuts, 2.6·10⁻² by tables and 5.5·10⁻³ by four pieces, and a
/// quarter more.
const ADAPTIVE: f64 = 4.2e-2;
const TABLE: f64 = 3.3e-2;
const FIXED: f64 = 7e-3;
/// Of meshes, in whose coarse cells there is more than one shell: 1.66·10⁻¹ and 2.3·10⁻², and a quarter more.
const ADAPTIVE_MESH: f64 = 2.1e-1;
const FIXED_MESH: f64 = 2.9e-2;

/// Transmittance at which rays of those schemes end, as in the program.
const TERMINATE: f64 = 0.001;

/// How a volume is lit, if it is.
pub(crate) fn shading(look: &Layers, gradient_scale: f64) -> Result<Option<VolumeShading>> {
    Ok(match look.light {
        None => None,
        Some(Lamp::Head) => Some(lit(gradient_scale, None)),
        Some(Lamp::From(direction)) => Some(lit(gradient_scale, Some(direction.into()))),
        Some(Lamp::At(_)) => bail!("volumes are lit by no lamp nearby"),
    })
}

/// The longest way through a cell, in the world: along the longest of its four diagonals.
pub(crate) fn longest_way(index_to_world: &DAffine3) -> f32 {
    let [x, y, z] = [0, 1, 2].map(|a| index_to_world.matrix3.col(a));
    [x + y + z, x + y - z, x - y + z, x - y - z].map(|d| d.length()).into_iter().fold(0.0, f64::max) as f32
}

impl Scheme {
    /// The scheme itself.
    pub(crate) fn with(
        self,
        transfer: &TransferFunction,
        brightest: f32,
        range: [f32; 2],
        longest: f32,
    ) -> Result<Box<dyn Integrate>> {
        let adaptive = Cuts::Adaptive { inflection: true, shading: true };
        let linear = |cuts| Linearised { cuts, pieces: LinearPieces::new(transfer), terminate: TERMINATE };
        Ok(match self {
            Self::Bounded(epsilon) | Self::ByLevel(epsilon) => {
                Box::new(Bounded::new(transfer, epsilon, brightest))
            }
            Self::Adaptive => Box::new(linear(adaptive)),
            Self::Fixed(pieces) => Box::new(linear(Cuts::Fixed(pieces))),
            Self::Table => {
                let pieces = PreintegrationTable::<f32>::new(transfer, TableAxes::new(range, longest))?;
                Box::new(Linearised { cuts: adaptive, pieces, terminate: TERMINATE })
            }
        })
    }

    /// What it may be off by: its own bound, or what was measured.
    pub(crate) fn bound(self, is_mesh: bool) -> f64 {
        match self {
            Self::Bounded(epsilon) | Self::ByLevel(epsilon) => epsilon,
            Self::Adaptive => {
                if is_mesh {
                    ADAPTIVE_MESH
                } else {
                    ADAPTIVE
                }
            }
            Self::Fixed(_) => {
                if is_mesh {
                    FIXED_MESH
                } else {
                    FIXED
                }
            }
            Self::Table => TABLE,
        }
    }
}

/// A volume, and what of it is to be seen.
struct Glow<'a, V> {
    volume: &'a V,
    dims: Dims,
    to_world: DAffine3,
    transfer: &'a TransferFunction,
    range: [f64; 2],
    scale: f64,
}

impl<V: VolumeSource> Glow<'_, V> {
    fn image(&self, look: &Layers, eye: &Eye) -> Result<Image> {
        let shading = shading(look, self.scale)?;
        let brightest = shading.map_or(1.0, |s| s.brightest(&self.to_world, self.range[1] - self.range[0]));
        let ends = self.range.map(|v| v as f32);
        let longest = longest_way(&self.to_world);
        let scheme = look.scheme.with(self.transfer, brightest, ends, longest)?;
        let clip = Extent::new(self.dims, &self.to_world).clip(look.cuts);
        let visible = Visibility::new(self.transfer);
        let scene = VolumeScene { visible: &visible, scheme: &scheme, shading, clip: Some(&clip) };
        Ok(render_volume(self.volume, self.to_world, &eye.camera, &scene, |_, _| {}))
    }
}

/// A picture of a volume that is no mesh: by the octree and by the array.
pub(crate) fn dense<T: Scalar + Into<f64>>(of: &DenseScene<'_, T>, look: &Layers) -> Result<Outcome> {
    if matches!(look.scheme, Scheme::ByLevel(_)) {
        bail!("a volume that is no mesh has no levels to be coloured by");
    }
    let view = of.octree.view();
    let to_world = of.octree.meta().index_to_world;
    let range = of.octree.meta().range.context("no sample is finite")?;
    let scale = gradient_scale(&view, to_world);
    let own: Vec<f32> = of.scene.of.isovalues().iter().map(|&value| of.scene.of.own(value)).collect();
    let transfer = shells(&own, range.map(|v| v as f32), scale)?;
    let dims = of.volume.dims;
    let glow = Glow { volume: &view, dims, to_world, transfer: &transfer, range, scale };
    let image = glow.image(look, of.eye)?;
    let bound = look.scheme.bound(false);
    let truths = truths(of, look, &transfer, scale)?;
    let title = of.scene.long_title();
    let (compared, shown) = Compared::volume(&image, &truths, bound, &title)?;
    let mut broken = compared.failures();
    broken.extend(shown.map(|path| format!("the oracle's picture beside it: {}", path.display())));

    let grid = GridVolume::new(DenseVolume::new(dims, &of.volume.samples)?);
    let of_grid =
        Glow { volume: &grid, dims, to_world, transfer: &transfer, range, scale }.image(look, of.eye)?;
    let by_grid = format!("{title}, the grid");
    let (compared_grid, shown) = Compared::volume(&of_grid, &truths, bound, &by_grid)?;
    broken.extend(compared_grid.failures().into_iter().map(|what| format!("the grid: {what}")));
    broken.extend(shown.map(|path| format!("the grid's picture: {}", path.display())));
    if let Scheme::Fixed(pieces) = look.scheme {
        let error = |pieces: u32| -> Result<f64> {
            let image = glow.image(&Layers { scheme: Scheme::Fixed(pieces), ..*look }, of.eye)?;
            Ok(Compared::volume(&image, &truths, f64::INFINITY, &title)?.0.errors()[2])
        };
        let errors = [error(pieces / 2)?, error(pieces)?, error(2 * pieces)?];
        if breaks(errors[1], errors[0]) || breaks(errors[2], errors[1]) {
            broken.push(format!(
                "with half, all and twice the pieces errors are {errors:?}: they ought to fall"
            ));
        }
    }
    let mut without = Vec::new();
    for (what, look) in off::layers(look) {
        without.push((what, glow.image(&look, of.eye)?));
    }
    let moved = of.eye.moved(off::half_a_voxel(&to_world))?;
    without.push((off::MOVED, glow.image(look, &moved)?));
    Ok(Outcome { image, compared, broken, without })
}

/// What the oracle says.
fn truths<T: Scalar>(
    of: &DenseScene<'_, T>,
    look: &Layers,
    transfer: &TransferFunction,
    scale: f64,
) -> Result<Truths> {
    let to_world = of.volume.index_to_world;
    let points = for_oracle::transfer(transfer.points());
    let shading = shading(look, scale)?;
    let clip = Extent::new(of.volume.dims, &to_world).clip(look.cuts);
    let to_index = to_world.inverse();
    Ok(Truths::new(of.eye.camera.size(), |[x, y]| {
        let ray = for_oracle::ray(&of.eye.camera.index_ray(&to_index, x, y));
        let Some(ray) = clipped(of.eye, &clip, ray, [x, y]) else { return Some(exactly([0.0; 4])) };
        let shading = shading.map(|s| for_oracle::lit_by(&s, &to_world, of.eye.ray([x, y]).1));
        let radiance = integrate_ray(of.lattice, &ray, 1.0, &points, shading.as_ref());
        let [r, g, b] = radiance.color;
        Some(exactly([r, g, b, radiance.alpha()]))
    }))
}

/// The part of a ray that is kept.
pub(crate) fn clipped(eye: &Eye, clip: &Clip, ray: OracleRay, pixel: [u32; 2]) -> Option<OracleRay> {
    let (origin, direction) = eye.ray(pixel);
    let [begin, end] = kept(&clip.0, origin, direction)?.ends;
    Some(OracleRay { t_min: begin.max(0.0) as f32, t_max: end as f32, ..ray })
}
