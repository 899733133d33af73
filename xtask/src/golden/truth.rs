//! What a pixel of isosurfaces shows according to the oracle: depth, normal and colour, by formulas of its own.

mod light;

use glam::{DAffine3, DVec3};
use isoray_oracle::{GRAZING_VOXELS, Lattice, OracleHit, OracleRay, central_gradient, judge, judge_all};
use isoray_render::{ColorField, Normals, Plane, Scene};

use super::eye::Eye;
use super::isosurfaces::Cells;
use super::shadow::is_smooth;
use light::Lit;

/// A scene over the oracle's lattice.
pub(crate) struct Truth<'a, L> {
    pub(crate) lattice: &'a L,
    /// Units of the lattice along one of index space: a power of two, so that rays are scaled exactly.
    pub(crate) scale: f32,
    /// How far apart values of the lattice and of the renderer may be.
    pub(crate) rounding: f64,
    pub(crate) index_to_world: DAffine3,
    pub(crate) eye: &'a Eye,
    pub(crate) scene: &'a Scene<'a>,
    /// What the lattice is made of, if that is not its own cells.
    pub(crate) cells: Option<&'a dyn Cells>,
    /// Whether rays to lights begin a cell of their level from where it is coarse; see `crates/packet/src/far_shadows.rs`.
    pub(crate) far_shadows: bool,
}

/// What a pixel shows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seen {
    /// World distance and unit normal of the first surface or cap, if there is one.
    pub(crate) first: Option<(f64, DVec3)>,
    /// Linear RGB, premultiplied: the least and the most, which differ by how much of the lights and of the sky may reach the surface.
    pub(crate) color: [DVec3; 2],
    /// Whether it is told which of the lights do.
    pub(crate) is_told: bool,
    /// Whether all normals are those of gradients that do not nearly vanish.
    pub(crate) is_steady: bool,
    pub(crate) alpha: f64,
}

/// Why there is no answer: rounding may change it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Doubtful;

/// A distance, in voxels, within which crossings of different surfaces, or of a surface and a cut, may be seen in either order: each of those that are compared may be
/// moved by up to [`GRAZING_VOXELS`] by rounding.
const CLOSE: f64 = 2.0 * GRAZING_VOXELS;

/// A surface or a cap on a ray.
#[derive(Clone, Copy, Debug)]
struct Layer {
    t: f64,
    /// Which surface.
    surface: usize,
    /// The crossing; `None` for a cap.
    hit: Option<OracleHit>,
    /// In world space, of length 1, or 0.
    normal: DVec3,
}

/// The part of a ray that is kept.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kept {
    /// Parameters; infinite where no plane ends it.
    pub(crate) ends: [f64; 2],
    planes: [Option<Plane>; 2],
}

impl<L: Lattice> Truth<'_, L> {
    /// What a pixel shows.
    pub(crate) fn pixel(&self, [x, y]: [u32; 2]) -> Result<Seen, Doubtful> {
        let ray = self.eye.camera.index_ray(&self.index_to_world.inverse(), x, y);
        let (eye, direction) = self.eye.ray([x, y]);
        let nothing =
            Seen { first: None, color: [DVec3::ZERO; 2], is_told: true, is_steady: true, alpha: 0.0 };
        let Some(kept) = kept(&self.scene.clip.0, eye, direction) else { return Ok(nothing) };
        let scaled = |v: [f32; 3]| v.map(|c| c * self.scale);
        let mut ray = OracleRay {
            origin: scaled(ray.origin),
            direction: scaled(ray.direction),
            t_min: ray.t_min,
            t_max: ray.t_max,
        };
        if !self.scene.clip.0.is_empty() {
            [ray.t_min, ray.t_max] = [kept.ends[0].max(0.0) as f32, kept.ends[1] as f32];
        }
        let mut layers = self.crossings(&ray)?;
        if self.scene.cap {
            for n in [0, 1] {
                let (t, plane) = (kept.ends[n], kept.planes[n]);
                if let (Some(plane), true) = (plane, t > 0.0)
                    && let Some(layer) = self.cap(eye + direction * t, t, &plane)?
                {
                    layers.push(layer);
                }
            }
            layers.sort_by(|a, b| a.t.total_cmp(&b.t));
        }
        Ok(self.composited(&layers, eye, direction, [x, y]))
    }

    /// Units of the lattice along a ray to one of the world.
    pub(crate) fn speed(&self, [x, y]: [u32; 2]) -> f64 {
        let ray = self.eye.camera.index_ray(&self.index_to_world.inverse(), x, y);
        f64::from(self.scale) * DVec3::from_array(ray.direction.map(f64::from)).length()
    }

    /// Crossings of all surfaces, in order, up to the first opaque one.
    fn crossings(&self, ray: &OracleRay) -> Result<Vec<Layer>, Doubtful> {
        let speed = ray.direction.iter().map(|d| f64::from(*d).powi(2)).sum::<f64>().sqrt();
        let close = CLOSE / speed;
        let mut layers = Vec::new();
        for (surface, of) in self.scene.surfaces.iter().enumerate() {
            let hits = self.hits(ray, of.isovalue, of.opacity >= 1.0, speed)?;
            for hit in hits {
                let gradient = match (self.scene.normals, self.cells) {
                    (Normals::Forward, _) => hit.gradient,
                    (Normals::Central, None) => central_gradient(self.lattice, hit.position, hit.cell),
                    (Normals::Central, Some(cells)) => cells.central_gradient(&hit).ok_or(Doubtful)?,
                };
                layers.push(Layer { t: hit.t, surface, hit: Some(hit), normal: self.normal(gradient) });
            }
        }
        layers.sort_by(|a, b| a.t.total_cmp(&b.t));
        let ends = [ray.t_min, ray.t_max].map(f64::from);
        let is_cut = |t: f64| !self.scene.clip.0.is_empty() && ends.iter().any(|end| (t - end).abs() < close);
        let are_close = |pair: &[Layer]| pair[1].t - pair[0].t < close && pair[0].surface != pair[1].surface;
        match layers.windows(2).any(are_close) || layers.iter().any(|layer| is_cut(layer.t)) {
            true => Err(Doubtful),
            false => Ok(layers),
        }
    }

    /// Crossings of one surface: the first, or all.
    fn hits(
        &self,
        ray: &OracleRay,
        v: f32,
        first_only: bool,
        speed: f64,
    ) -> Result<Vec<OracleHit>, Doubtful> {
        let judged = |v: f32| match first_only {
            true => {
                let verdict = judge(self.lattice, ray, v);
                (verdict.hit.into_iter().collect(), verdict.grazing)
            }
            false => {
                let verdict = judge_all(self.lattice, ray, v);
                (verdict.hits, verdict.grazing)
            }
        };
        let (hits, mut is_doubtful): (Vec<OracleHit>, bool) = judged(v);
        if self.rounding > 0.0 && !is_doubtful {
            is_doubtful = [-self.rounding, self.rounding].into_iter().any(|by| {
                let others = judged((f64::from(v) + by) as f32).0;
                let mut pairs = hits.iter().zip(&others);
                others.len() != hits.len() || pairs.any(|(a, b)| (a.t - b.t).abs() * speed > CLOSE / 2.0)
            });
        }
        if is_doubtful { Err(Doubtful) } else { Ok(hits) }
    }

    /// The cap of a cut, if the field is inside of a surface there.
    fn cap(&self, position: DVec3, t: f64, plane: &Plane) -> Result<Option<Layer>, Doubtful> {
        let p = self.index_to_world.inverse().transform_point3(position) * f64::from(self.scale);
        let last = DVec3::from_array(self.lattice.dims().map(|n| f64::from(n - 1)));
        let within = p.min(last - p).min_element();
        if within.abs() < CLOSE {
            return Err(Doubtful);
        }
        if within < 0.0 {
            return Ok(None);
        }
        let low = p.floor();
        let local = (p - low).to_array();
        let corners: [f64; 8] = std::array::from_fn(|n| {
            let corner = low.to_array().map(|c| c as u32);
            self.lattice.sample([0, 1, 2].map(|a| corner[a] + (n >> a & 1) as u32))
        });
        if corners.iter().any(|c| !c.is_finite()) {
            return Ok(None);
        }
        let weight = |n: usize| -> f64 {
            (0..3).map(|a| if n >> a & 1 == 1 { local[a] } else { 1.0 - local[a] }).product()
        };
        let value: f64 = (0..8).map(|n| weight(n) * corners[n]).sum();
        let steps = corners.iter().map(|c| (c - value).abs()).fold(0.0, f64::max);
        let surfaces = self.scene.surfaces.iter();
        if surfaces.clone().any(|s| (f64::from(s.isovalue) - value).abs() <= CLOSE * steps) {
            return Err(Doubtful);
        }
        let inside = surfaces.enumerate().filter(|(_, s)| f64::from(s.isovalue) <= value);
        let innermost = inside.max_by(|a, b| a.1.isovalue.total_cmp(&b.1.isovalue));
        Ok(innermost.map(|(surface, _)| Layer { t, surface, hit: None, normal: plane.normal.normalize() }))
    }

    /// Front to back.
    fn composited(&self, layers: &[Layer], eye: DVec3, direction: DVec3, pixel: [u32; 2]) -> Seen {
        let (mut color, mut is_told, mut is_steady) = ([DVec3::ZERO; 2], true, true);
        let mut transmittance = 1.0;
        for layer in layers {
            if transmittance <= 0.0 {
                break;
            }
            let opacity = f64::from(self.scene.surfaces[layer.surface].opacity);
            let Lit { least, most, is_told: is_lit } =
                self.shaded(layer, eye + direction * layer.t, -direction, pixel);
            color = [color[0] + transmittance * opacity * least, color[1] + transmittance * opacity * most];
            is_told &= is_lit;
            is_steady &=
                layer.hit.is_none_or(|hit| is_smooth(hit.gradient, self.largest_corner(&hit, layer.surface)));
            transmittance *= 1.0 - opacity;
        }
        let first = layers.first().map(|layer| (layer.t, layer.normal));
        Seen { first, color, is_told, is_steady, alpha: 1.0 - transmittance }
    }

    /// Difference from the isovalue, in magnitude, of the corners of a hit's cell.
    fn largest_corner(&self, hit: &OracleHit, surface: usize) -> f64 {
        let corner = |n: usize| [0, 1, 2].map(|a| hit.cell[a] + (n >> a & 1) as u32);
        let isovalue = f64::from(self.scene.surfaces[surface].isovalue);
        (0..8).map(|n| (self.lattice.sample(corner(n)) - isovalue).abs()).fold(0.0, f64::max)
    }

    fn normal(&self, gradient: [f64; 3]) -> DVec3 {
        let to_world = self.index_to_world.inverse().matrix3.transpose();
        (to_world * DVec3::from_array(gradient)).normalize_or_zero()
    }
}

/// The part of a line that planes keep.
pub(crate) fn kept(planes: &[Plane], origin: DVec3, direction: DVec3) -> Option<Kept> {
    let mut kept = Kept { ends: [f64::NEG_INFINITY, f64::INFINITY], planes: [None; 2] };
    for plane in planes {
        let [at, speed] = [plane.offset - plane.normal.dot(origin), plane.normal.dot(direction)];
        let t = at / speed;
        let end = usize::from(speed < 0.0);
        let is_nearer = if end == 0 { t > kept.ends[0] } else { t < kept.ends[1] };
        if speed == 0.0 {
            if at > 0.0 {
                return None;
            }
        } else if is_nearer {
            kept.ends[end] = t;
            kept.planes[end] = Some(*plane);
        }
    }
    (kept.ends[0] < kept.ends[1]).then_some(kept)
}

/// A colour that tells the place: what colours surfaces in a scene of these checks.
pub(crate) struct ByPlace(pub(crate) [u32; 3]);

impl ColorField for ByPlace {
    fn color(&self, cell: [u32; 3], local: [f32; 3]) -> glam::Vec3 {
        glam::Vec3::from_array([0, 1, 2].map(|a| (cell[a] as f32 + local[a]) / self.0[a] as f32))
    }
}
