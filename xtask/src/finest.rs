//! Adaptive meshes as the oracle takes them: leaves, and the field on the finest lattice, made of the patches alone.

use std::collections::HashSet;

use anyhow::{Result, ensure};
use glam::DAffine3;
use isoray_amr::{Centering, Patch, Patches};
use isoray_oracle::{
    AmrCells, AmrField, AmrLeaf, Border, GRAZING_VOXELS, Lattice, OracleHit, OracleRay, OracleShading,
    first_hit, integrate_ray, judge,
};
use isoray_preint::ControlPoint;
use isoray_render::{Camera, VolumeShading};
use isoray_trace::Ray;

use crate::for_oracle;

/// The leaves of a mesh; those with a value that is not finite are left out.
pub(crate) struct Finest {
    leaves: Leaves,
    /// Units of the lattice along the edge of a finest cell: two where anything is left out, so that a gap of one cell has a point of its own.
    scale: u32,
    /// Of the values, in magnitude.
    largest: f64,
}

enum Leaves {
    Averages(AmrCells<f64>),
    Corners(AmrCells<[f64; 8]>),
}

/// What is seen of a mesh.
pub(crate) struct Seen<'s> {
    pub(crate) camera: &'s Camera,
    pub(crate) index_to_world: DAffine3,
    pub(crate) points: &'s [ControlPoint],
    pub(crate) shading: Option<VolumeShading>,
}

/// The field of a mesh; borders are linear.
pub(crate) enum Field<'m> {
    Averages(AmrField<'m, f64>),
    Corners(AmrField<'m, [f64; 8]>),
}

/// Roundings to 32 bits between a value and that of a vertex of the renderer's, as in the tests of rays through meshes.
const ROUNDINGS: f64 = 8.0;

impl Finest {
    /// # Errors
    /// Patches that do not fill their domain, once each place.
    pub(crate) fn new(patches: &Patches) -> Result<Self> {
        let has_gaps = patches.patches.iter().any(|p| p.values.iter().any(|v| !v.is_finite()));
        let scale = if has_gaps { 2 } else { 1 };
        let leaves = match patches.centering {
            Centering::Cells => Leaves::Averages(cells(patches, scale, |patch, [x, y, z]| {
                let [nx, ny, _] = patch.cells.map(|n| n as usize);
                let value = patch.values[x + nx * (y + ny * z)];
                value.is_finite().then_some(value.into())
            })?),
            Centering::Vertices => Leaves::Corners(cells(patches, scale, |patch, at| {
                let [nx, ny, _] = patch.cells.map(|n| n as usize + 1);
                let value = |c: usize| {
                    let [x, y, z] = [0, 1, 2].map(|a| at[a] + (c >> a & 1));
                    f64::from(patch.values[x + nx * (y + ny * z)])
                };
                let values: [f64; 8] = std::array::from_fn(value);
                values.iter().all(|v| v.is_finite()).then_some(values)
            })?),
        };
        let values = patches.patches.iter().flat_map(|patch| patch.values.iter()).filter(|v| v.is_finite());
        let largest = values.fold(0.0, |m: f64, v| m.max(f64::from(v.abs())));
        Ok(Self { leaves, scale, largest })
    }

    pub(crate) fn field(&self) -> Field<'_> {
        match &self.leaves {
            Leaves::Averages(cells) => Field::Averages(AmrField::of_averages(cells, Border::Linear)),
            Leaves::Corners(cells) => Field::Corners(AmrField::of_corners(cells)),
        }
    }

    /// The edge of the cube around a unit cell of the lattice, a leaf or a part of one, in which the field is the interpolant of its corners.
    pub(crate) fn cube(&self, cell: [u32; 3]) -> Option<u32> {
        match &self.leaves {
            Leaves::Averages(cells) => cells.cube(cell),
            Leaves::Corners(cells) => cells.cube(cell),
        }
    }

    /// Units of the lattice along the edge of a finest cell.
    pub(crate) fn scale(&self) -> f32 {
        self.scale as f32
    }

    /// A ray that counts the finest cells, on the lattice: exactly.
    pub(crate) fn ray(&self, ray: &Ray) -> OracleRay {
        let scaled = |v: [f32; 3]| v.map(|c| c * self.scale as f32);
        let ray = for_oracle::ray(ray);
        OracleRay { origin: scaled(ray.origin), direction: scaled(ray.direction), ..ray }
    }

    /// The first hit of a ray; `None` if it grazes, or rounding the values moves it by more than [`GRAZING_VOXELS`].
    pub(crate) fn hit(&self, field: &Field<'_>, ray: &Ray, isovalue: f32) -> Option<Option<OracleHit>> {
        let of_lattice = self.ray(ray);
        let verdict = judge(field, &of_lattice, isovalue);
        let speed = of_lattice.direction.iter().map(|d| f64::from(*d).powi(2)).sum::<f64>().sqrt();
        let is_steady = |other: Option<OracleHit>| match (verdict.hit, other) {
            (None, None) => true,
            (Some(a), Some(b)) => (a.t - b.t).abs() * speed <= GRAZING_VOXELS,
            _ => false,
        };
        let by = [-self.rounding(), self.rounding()];
        let moved = by.map(|by| first_hit(field, &of_lattice, f64::from(isovalue) + by));
        (!verdict.grazing && moved.into_iter().all(is_steady)).then_some(verdict.hit)
    }

    /// RGBA of a pixel, of the field with all values moved `by` so much.
    pub(crate) fn pixel(&self, field: &Field<'_>, seen: &Seen<'_>, [x, y]: [u32; 2], by: f64) -> [f64; 4] {
        let world_to_index = seen.index_to_world.inverse();
        let ray = self.ray(&seen.camera.index_ray(&world_to_index, x, y));
        let mut points = for_oracle::transfer(seen.points);
        points.0.iter_mut().for_each(|point| point.value -= by);
        let direction = seen.camera.world_ray(x, y).1;
        let shading = seen.shading.map(|shading| {
            let of = for_oracle::shading(&shading.lighting(&world_to_index, direction));
            // The gradient is that in units of the lattice.
            let scaled = |v: [f64; 3]| v.map(|c| c * f64::from(self.scale));
            OracleShading { light: scaled(of.light), half: scaled(of.half), ..of }
        });
        let radiance = integrate_ray(field, &ray, 1.0, &points, shading.as_ref());
        let [r, g, b] = radiance.color;
        [r, g, b, radiance.alpha()]
    }

    /// How far apart the field and a renderer's may be, whose vertices have 32 bits.
    pub(crate) fn rounding(&self) -> f64 {
        ROUNDINGS * f64::from(f32::EPSILON) / 2.0 * self.largest
    }
}

impl Lattice for Field<'_> {
    fn dims(&self) -> [u32; 3] {
        match self {
            Self::Averages(field) => field.dims(),
            Self::Corners(field) => field.dims(),
        }
    }

    fn sample(&self, p: [u32; 3]) -> f64 {
        match self {
            Self::Averages(field) => field.sample(p),
            Self::Corners(field) => field.sample(p),
        }
    }
}

/// The cells of patches that no finer patch covers, each once, with a finite `value` of the cell at some place in its patch.
fn cells<T>(
    patches: &Patches,
    scale: u32,
    value: impl Fn(&Patch, [usize; 3]) -> Option<T>,
) -> Result<AmrCells<T>> {
    let (origin, extent) = patches.domain;
    let mut leaves = Vec::new();
    // Cells of the level at hand that it has, or finer ones.
    let mut covered: HashSet<[u32; 3]> = HashSet::new();
    let (mut edge, mut volume) = (scale, 0u64);
    for level in (0..=patches.ratios.len()).rev() {
        // Cells of this level along one of level 0.
        let along: u32 = patches.ratios[..level].iter().product();
        for patch in patches.patches.iter().filter(|patch| patch.level as usize == level) {
            let [nx, ny, nz] = patch.cells.map(|n| n as usize);
            for at in (0..nx * ny * nz).map(|n| [n % nx, n / nx % ny, n / (nx * ny)]) {
                let place: [i64; 3] = std::array::from_fn(|a| {
                    i64::from(patch.low[a]) - i64::from(origin[a]) * i64::from(along) + at[a] as i64
                });
                let place = [u32::try_from(place[0])?, u32::try_from(place[1])?, u32::try_from(place[2])?];
                if covered.insert(place) {
                    volume += u64::from(edge).pow(3);
                    if let Some(value) = value(patch, at) {
                        leaves.push(AmrLeaf { low: place.map(|c| c * edge), edge, value });
                    }
                }
            }
        }
        if let Some(&ratio) = level.checked_sub(1).and_then(|coarser| patches.ratios.get(coarser)) {
            covered = covered.into_iter().map(|place| place.map(|c| c / ratio)).collect();
            edge *= ratio;
        }
    }
    let dims = extent.map(|n| n * edge);
    let whole: u64 = dims.iter().map(|&n| u64::from(n)).product();
    ensure!(volume == whole, "the patches fill {volume} of {whole} units");
    Ok(AmrCells::new(dims, leaves)?)
}
