//! What a pixel of isosurfaces shows according to the oracle: depth, normal and colour, by formulas of its own.

use glam::{DAffine3, DVec3};
use isoray_oracle::{Lattice, OracleHit, OracleRay, central_gradient, judge, judge_all};
use isoray_render::{Camera, ColorField, Light, Normals, Plane, Scene};

use super::shadow::Departure;

/// A scene over the oracle's lattice.
pub(crate) struct Truth<'a, L> {
    pub(crate) lattice: &'a L,
    /// Units of the lattice along one of index space: a power of two, so that rays are scaled exactly.
    pub(crate) scale: f32,
    /// How far apart values of the lattice and of the renderer may be.
    pub(crate) rounding: f64,
    pub(crate) index_to_world: DAffine3,
    pub(crate) camera: &'a Camera,
    pub(crate) scene: &'a Scene<'a>,
    /// Whether what the scene says of colours and shadows is all there is to say.
    pub(crate) has_colors: bool,
}

/// What a pixel shows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seen {
    /// World distance and unit normal of the first surface or cap, if there is one.
    pub(crate) first: Option<(f64, DVec3)>,
    /// Linear RGB, premultiplied: the least and the most, which differ by how much of the sky may be seen. `None`: it cannot be told.
    pub(crate) color: Option<[DVec3; 2]>,
    pub(crate) alpha: f64,
}

/// Why there is no answer: rounding may change it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Doubtful;

/// A distance, in voxels, within which crossings of different surfaces, or of a surface and a cut, may be seen in either order.
const CLOSE: f64 = 2e-3;

/// Cosine between a surface and a light below which it is doubtful whether there is a highlight.
const HIGHLIGHT: f64 = 1e-2;

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
        let ray = self.camera.index_ray(&self.index_to_world.inverse(), x, y);
        let (eye, direction) = self.camera.world_ray(x, y);
        let nothing = Seen { first: None, color: Some([DVec3::ZERO; 2]), alpha: 0.0 };
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
        Ok(self.composited(&layers, eye, direction))
    }

    /// Units of the lattice along a ray to one of the world.
    pub(crate) fn speed(&self, [x, y]: [u32; 2]) -> f64 {
        let ray = self.camera.index_ray(&self.index_to_world.inverse(), x, y);
        f64::from(self.scale) * DVec3::from_array(ray.direction.map(f64::from)).length()
    }

    /// Crossings of all surfaces, in order, up to the first opaque one.
    fn crossings(&self, ray: &OracleRay) -> Result<Vec<Layer>, Doubtful> {
        let speed = ray.direction.iter().map(|d| f64::from(*d).powi(2)).sum::<f64>().sqrt();
        let close = CLOSE / speed;
        let mut layers = Vec::new();
        for (surface, of) in self.scene.surfaces.iter().enumerate() {
            let hits = self.hits(ray, of.isovalue, of.opacity >= 1.0, speed)?;
            layers.extend(hits.iter().map(|hit| {
                let gradient = match self.scene.normals {
                    Normals::Forward => hit.gradient,
                    Normals::Central => central_gradient(self.lattice, hit.position, hit.cell),
                };
                Layer { t: hit.t, surface, hit: Some(*hit), normal: self.normal(gradient) }
            }));
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
    fn composited(&self, layers: &[Layer], eye: DVec3, direction: DVec3) -> Seen {
        let mut color = Some([DVec3::ZERO; 2]);
        let mut transmittance = 1.0;
        for layer in layers {
            if transmittance <= 0.0 {
                break;
            }
            let opacity = f64::from(self.scene.surfaces[layer.surface].opacity);
            let shaded = self.shaded(layer, eye + direction * layer.t, -direction);
            color = color
                .zip(shaded)
                .map(|(sum, shaded)| [0, 1].map(|n| sum[n] + transmittance * opacity * shaded[n]));
            transmittance *= 1.0 - opacity;
        }
        let first = layers.first().map(|layer| (layer.t, layer.normal));
        Seen { first, color, alpha: 1.0 - transmittance }
    }

    fn normal(&self, gradient: [f64; 3]) -> DVec3 {
        let to_world = self.index_to_world.inverse().matrix3.transpose();
        (to_world * DVec3::from_array(gradient)).normalize_or_zero()
    }

    /// The light that a layer sends to the viewer, with none and with all of the sky, if its shadows can be told.
    fn shaded(&self, layer: &Layer, position: DVec3, to_viewer: DVec3) -> Option<[DVec3; 2]> {
        let scene = self.scene;
        if !self.has_colors {
            return None;
        }
        let facing = match layer.normal {
            DVec3::ZERO => to_viewer,
            normal => normal * normal.dot(to_viewer).signum(),
        };
        let (mut diffuse, mut specular) = (0.0, 0.0);
        let share = 1.0 / scene.lights.len() as f64;
        for light in &scene.lights {
            let (to_light, distance) = match *light {
                Light::Headlight => (to_viewer, f64::INFINITY),
                Light::Point(at) => ((at - position).normalize(), (at - position).length()),
                Light::Direction(direction) => (direction.normalize(), f64::INFINITY),
            };
            let cosine = facing.dot(to_light);
            let can_be_hidden = scene.shadows && !matches!(light, Light::Headlight);
            if (can_be_hidden || scene.specular > 0.0) && cosine.abs() < HIGHLIGHT {
                return None;
            }
            if cosine <= 0.0 {
                continue;
            }
            let reaching = match (can_be_hidden, layer.hit) {
                (true, Some(hit)) => match kept(&scene.clip.0, position, to_light) {
                    Some(kept) => {
                        share * self.reaching(layer.surface, &hit, to_light, distance.min(kept.ends[1]))?
                    }
                    None => share,
                },
                _ => share,
            };
            diffuse += reaching * cosine;
            let half = (to_light + to_viewer).normalize();
            specular += reaching * facing.dot(half).max(0.0).powf(scene.exponent.into());
        }
        let color = self.color(layer, position);
        let ambient = f64::from(scene.ambient);
        let lit = color * (1.0 - ambient) * diffuse + f64::from(scene.specular) * specular;
        let least = if scene.sky_samples > 0 { 0.0 } else { ambient };
        Some([lit + color * least, lit + color * ambient])
    }

    /// Share of a light that reaches a point of a surface.
    fn reaching(&self, surface: usize, hit: &OracleHit, to_light: DVec3, distance: f64) -> Option<f64> {
        let direction = self.index_to_world.inverse().transform_vector3(to_light) * f64::from(self.scale);
        let corner = |n: usize| [0, 1, 2].map(|a| hit.cell[a] + (n >> a & 1) as u32);
        let isovalue = f64::from(self.scene.surfaces[surface].isovalue);
        let largest = (0..8).map(|n| (self.lattice.sample(corner(n)) - isovalue).abs()).fold(0.0, f64::max);
        let departure = Departure {
            position: hit.position,
            local: [0, 1, 2].map(|a| hit.position[a] - f64::from(hit.cell[a])),
            gradient: hit.gradient,
            largest,
            to_light: direction.normalize().as_vec3().to_array(),
            t_max: (distance * direction.length()) as f32,
        };
        let slope = departure.slope();
        let viewer_is_inside = !hit.entering;
        let mut transmittance = 1.0;
        for of in &self.scene.surfaces {
            let hits = departure.hits(self.lattice, of.isovalue)?;
            transmittance *= (1.0 - f64::from(of.opacity)).powi(hits.len() as i32);
        }
        // The light is on the other side of the surface itself.
        let is_behind = (slope > 0.0) != viewer_is_inside;
        Some(if is_behind { 0.0 } else { transmittance })
    }

    fn color(&self, layer: &Layer, position: DVec3) -> DVec3 {
        match self.scene.colors {
            Some(colors) => {
                let p = self.index_to_world.inverse().transform_point3(position);
                let cell = p.max(DVec3::ZERO).floor();
                colors.color(cell.to_array().map(|c| c as u32), (p - cell).as_vec3().to_array()).as_dvec3()
            }
            None => self.scene.surfaces[layer.surface].color.as_dvec3(),
        }
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
