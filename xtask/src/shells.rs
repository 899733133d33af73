//! Volumes as translucent shells: the scenes on which volume rendering is checked and measured.

use anyhow::Result;
use glam::{DAffine3, DVec3};
use isoray_grid::Scalar;
use isoray_octree::{OctreeView, OctreeVolume};
use isoray_oracle::{DenseLattice, integrate_ray};
use isoray_preint::{ControlPoint, TransferFunction, Visibility};
use isoray_render::{Camera, Image, Pixel, VolumeScene, VolumeShading, gradient_scale};
use rayon::prelude::*;

use crate::catalog::{Dense, Entry, Place};
use crate::for_oracle::{self, apart, breaks};

/// A volume, what is seen of it and from where.
pub(crate) struct Subject<T: Scalar> {
    pub(crate) volume: OctreeVolume<T>,
    pub(crate) transfer: TransferFunction,
    pub(crate) visible: Visibility,
    pub(crate) shading: Option<VolumeShading>,
    /// Bound of the shading factor.
    pub(crate) brightest: f32,
    pub(crate) camera: Camera,
    pub(crate) index_to_world: DAffine3,
}

/// Half the width of a shell, as a share of the range of values.
const SHELL: f32 = 0.03;
/// Optical depth through half a shell, where the field is as steep as the scale of gradients.
const DEPTH: f64 = 0.25;
/// Extinction between and beyond the shells, as a share of theirs.
const HAZE: f32 = 0.04;

impl<T: Scalar + Into<f64>> Subject<T> {
    pub(crate) fn new(
        entry: &Entry,
        dense: &Dense<T>,
        is_shaded: bool,
        place: Place,
        size: u32,
    ) -> Result<Self> {
        let volume = dense.octree()?;
        let scale = gradient_scale(&volume.view(), dense.index_to_world);
        let [low, high] = volume.meta().range.unwrap_or([0.0, 1.0]);
        let transfer = shells(&entry.isovalues, [low as f32, high as f32], scale)?;
        let shading = is_shaded.then_some(lit(scale, Some(LIGHT)));
        Ok(Self {
            visible: Visibility::new(&transfer),
            brightest: shading.map_or(1.0, |s| s.brightest(&dense.index_to_world, high - low)),
            camera: dense.camera(place, size)?,
            index_to_world: dense.index_to_world,
            volume,
            transfer,
            shading,
        })
    }

    pub(crate) fn view(&self) -> OctreeView<'_, T> {
        self.volume.view()
    }

    pub(crate) fn scene<'s, I>(&'s self, scheme: &'s I) -> VolumeScene<'s, I> {
        VolumeScene { visible: &self.visible, scheme, shading: self.shading, clip: None }
    }

    /// RGBA of every pixel by the oracle.
    pub(crate) fn reference(&self, dense: &Dense<T>) -> Result<Vec<[f64; 4]>> {
        let lattice = DenseLattice::from_vec(dense.dims.axes(), dense.samples.clone());
        let lattice = lattice.ok_or_else(|| anyhow::anyhow!("the samples do not fill the lattice"))?;
        let points = for_oracle::transfer(self.transfer.points());
        let world_to_index = self.index_to_world.inverse();
        let [width, height] = self.camera.size();
        let pixel = |n: u32| {
            let (x, y) = (n % width, n / width);
            let ray = self.camera.index_ray(&world_to_index, x, y);
            let ray = for_oracle::ray(&ray);
            let direction = self.camera.world_ray(x, y).1;
            let shading = self.shading.map(|s| for_oracle::lit_by(&s, &self.index_to_world, direction));
            let radiance = integrate_ray(&lattice, &ray, 1.0, &points, shading.as_ref());
            let [r, g, b] = radiance.color;
            [r, g, b, radiance.alpha()]
        };
        Ok((0..width * height).into_par_iter().map(pixel).collect())
    }
}

/// The direction to the light.
pub(crate) const LIGHT: DVec3 = DVec3::new(0.3, -0.5, 0.8);

/// How shells are lit: from this direction, or along each ray.
pub(crate) fn lit(gradient_scale: f64, light: Option<DVec3>) -> VolumeShading {
    VolumeShading { ambient: 0.3, diffuse: 0.7, specular: 0.2, exponent: 20.0, gradient_scale, light }
}

/// Translucent shells around the isovalues, in a haze that begins with the first.
pub(crate) fn shells(isovalues: &[f32], [low, high]: [f32; 2], gradient: f64) -> Result<TransferFunction> {
    const COLORS: [[f32; 3]; 3] = [[0.85, 0.35, 0.12], [0.95, 0.85, 0.6], [0.25, 0.5, 0.9]];
    let half = SHELL * (high - low);
    let dense = (DEPTH * gradient / f64::from(half)) as f32;
    let mut values: Vec<f32> = isovalues.to_vec();
    values.sort_by(f32::total_cmp);
    let mut points = vec![ControlPoint { value: low, color: COLORS[0], extinction: 0.0 }];
    for (n, &value) in values.iter().enumerate() {
        let color = COLORS[n % COLORS.len()];
        let haze = if n == 0 { 0.0 } else { HAZE * dense };
        let at = |value: f32, extinction| ControlPoint { value, color, extinction };
        let before = points.last().map_or(low, |p| p.value);
        points.extend([
            at((value - half).max(before), haze),
            at(value.max(before), dense),
            at((value + half).max(before), HAZE * dense),
        ]);
    }
    points.push(ControlPoint { value: high, color: COLORS[2], extinction: HAZE * dense });
    points.dedup_by(|b, a| a.value >= b.value);
    Ok(TransferFunction::new(points)?)
}

/// Differences of a picture from the reference.
pub(crate) struct Errors {
    pub(crate) max: f64,
    pub(crate) rms: f64,
    pub(crate) over: u64,
    /// The pixel of the largest.
    pub(crate) worst: usize,
}

impl Errors {
    pub(crate) fn of(image: &Image, reference: &[[f64; 4]], epsilon: Option<f64>) -> Self {
        Self::of_pixels(image.pixels(), reference, epsilon)
    }

    fn of_pixels(pixels: &[Pixel], reference: &[[f64; 4]], epsilon: Option<f64>) -> Self {
        let (mut max, mut sum, mut over, mut worst) = (0.0_f64, 0.0, 0, 0);
        for (n, (pixel, expected)) in pixels.iter().zip(reference).enumerate() {
            let found = pixel.color.to_array();
            let channels = found.iter().zip(expected).map(|(f, e)| apart((*f).into(), *e));
            let largest = channels.clone().fold(0.0, f64::max);
            sum += channels.map(|e| e * e).sum::<f64>();
            if largest > max {
                (max, worst) = (largest, n);
            }
            over += u64::from(epsilon.is_some_and(|epsilon| breaks(largest, epsilon)));
        }
        Self { max, rms: (sum / (4.0 * reference.len().max(1) as f64)).sqrt(), over, worst }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_number_is_infinitely_far_off() {
        let mut pixels = vec![Pixel::EMPTY; 4];
        pixels[2].color.y = f32::NAN;
        let errors = Errors::of_pixels(&pixels, &[[0.0; 4]; 4], Some(1.0));
        assert_eq!((errors.max, errors.over, errors.worst), (f64::INFINITY, 1, 2));
        let errors = Errors::of_pixels(&pixels, &[[f64::NAN; 4]; 4], Some(1.0));
        assert_eq!(errors.over, 4);
    }
}
