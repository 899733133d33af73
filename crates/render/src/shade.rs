//! The light that a point sends to the viewer.

use glam::{DAffine3, DVec3, Vec3};
use isoray_packet::{TracePackets, Traversal};
use isoray_trace::{Counters, DepartingRay, Hit, Trace};

use crate::scene::{Light, Scene};
use crate::sky;

/// A point on a surface, or on a cap.
pub(crate) struct Point<'h> {
    /// In world space.
    pub(crate) position: DVec3,
    /// From it to where the ray came from; a unit vector.
    pub(crate) to_viewer: DVec3,
    /// Unit normal, of either sign; zero if the surface has none.
    pub(crate) normal: Vec3,
    /// Of the surface, linear RGB.
    pub(crate) color: Vec3,
    /// The hit, and of which surface; `None` for a cap, which nothing that is kept can shadow.
    pub(crate) hit: Option<(&'h Hit, usize)>,
    /// Of the pixel, by which samples differ.
    pub(crate) pixel: [u32; 2],
}

impl Point<'_> {
    /// The normal, turned to the viewer; a surface without one faces the viewer.
    fn facing(&self) -> Vec3 {
        let to_viewer = self.to_viewer.as_vec3();
        if self.normal == Vec3::ZERO {
            to_viewer
        } else if self.normal.dot(to_viewer) < 0.0 {
            -self.normal
        } else {
            self.normal
        }
    }

    /// Direction and distance of a light, and whether it can be hidden.
    fn toward(&self, light: &Light) -> (DVec3, f64, bool) {
        match *light {
            Light::Headlight => (self.to_viewer, f64::INFINITY, false),
            Light::Point(at) => {
                let way = at - self.position;
                (way.normalize_or_zero(), way.length(), true)
            }
            Light::Direction(direction) => (direction.normalize_or_zero(), f64::INFINITY, true),
        }
    }
}

/// How it is found out whether a light is hidden from a point.
pub(crate) enum Shadows<'q> {
    /// When it is asked for.
    Traced,
    /// It is known, by light, of a number of points.
    Known(&'q [PointShadows]),
}

/// What is known of the points of a packet and one light.
#[derive(Clone, Debug, Default)]
pub(crate) struct PointShadows {
    /// By point: the share of light that reaches it; where it takes a ray to tell, until then all of it.
    shares: Vec<f32>,
    /// These rays, and the points that they start from.
    rays: Vec<DepartingRay>,
    from: Vec<u32>,
    occluded: Vec<bool>,
}

impl PointShadows {
    pub(crate) fn clear(&mut self) {
        self.shares.clear();
        self.rays.clear();
        self.from.clear();
    }

    fn add(&mut self, share: Result<DepartingRay, f32>) {
        if let Ok(ray) = share {
            self.rays.push(ray);
            self.from.push(self.shares.len() as u32);
        }
        self.shares.push(share.err().unwrap_or(1.0));
    }

    /// Traces what is left to be traced.
    pub(crate) fn trace(
        &mut self,
        tracer: &mut impl TracePackets,
        isovalue: f32,
        traversal: Traversal,
        counters: &mut impl Counters,
    ) {
        self.occluded.clear();
        self.occluded.resize(self.rays.len(), false);
        tracer.occluded_all(&self.rays, isovalue, traversal, &mut self.occluded, counters);
        let hidden = self.from.iter().zip(&self.occluded).filter(|(_, is_occluded)| **is_occluded);
        hidden.for_each(|(&n, _)| self.shares[n as usize] = 0.0);
    }
}

/// Finds out what light reaches points.
pub(crate) struct Shader<'s, R, C> {
    pub(crate) scene: &'s Scene<'s>,
    pub(crate) isovalues: &'s [f32],
    pub(crate) world_to_index: &'s DAffine3,
    pub(crate) tracer: &'s mut R,
    pub(crate) counters: &'s mut C,
    pub(crate) shadows: Shadows<'s>,
}

impl<R: Trace, C: Counters> Shader<'_, R, C> {
    /// Lambert's law, two-sided: the normal is turned to the viewer. A surface without a normal faces the viewer. `number` is that of the point among those of which shadows are known.
    pub(crate) fn shade(&mut self, point: &Point<'_>, number: usize) -> Vec3 {
        let scene = self.scene;
        let to_viewer = point.to_viewer.as_vec3();
        let facing = point.facing();
        let share = 1.0 / scene.lights.len().max(1) as f32;
        let (mut diffuse, mut specular) = (0.0, 0.0);
        for (n, light) in scene.lights.iter().enumerate() {
            let (to_light, distance, can_be_hidden) = point.toward(light);
            let direction = to_light.as_vec3();
            let lit = facing.dot(direction);
            // Where no light can come, none is looked for. Also false for what is not a number.
            if lit > 0.0 {
                let reaching = match can_be_hidden && scene.shadows {
                    true => match self.shadows {
                        Shadows::Traced => self.transmittance(point, to_light, distance),
                        Shadows::Known(shadows) => shadows[n].shares[number],
                    },
                    false => 1.0,
                };
                diffuse += share * reaching * lit;
                if scene.specular > 0.0 {
                    let half = (direction + to_viewer).normalize_or_zero();
                    specular += share * reaching * facing.dot(half).max(0.0).powf(scene.exponent);
                }
            } else if can_be_hidden && scene.shadows && matches!(self.shadows, Shadows::Traced) {
                self.counters.shadow(false);
            }
        }
        let sky = if scene.sky_samples > 0 { self.sky(point, facing) } else { 1.0 };
        point.color * (scene.ambient * sky + (1.0 - scene.ambient) * diffuse)
            + Vec3::splat(scene.specular * specular)
    }

    /// Share of the sky that the point sees, weighted by the cosine to the normal.
    fn sky(&mut self, point: &Point<'_>, facing: Vec3) -> f32 {
        let samples = self.scene.sky_samples;
        let seen: f32 = (0..samples)
            .map(|n| sky::direction(n, samples, point.pixel, facing.as_dvec3()))
            .map(|direction| self.transmittance(point, direction, f64::INFINITY))
            .sum();
        seen / samples as f32
    }

    /// Adds what is known of a point's lights, one after the other.
    pub(crate) fn collect(&mut self, point: &Point<'_>, shadows: &mut [PointShadows]) {
        let facing = point.facing();
        for (light, shadows) in self.scene.lights.iter().zip(shadows) {
            let (to_light, distance, can_be_hidden) = point.toward(light);
            let is_lit = facing.dot(to_light.as_vec3()) > 0.0;
            let share = match can_be_hidden && is_lit {
                true => self.shadow_ray(point, to_light, distance),
                false => Err(1.0),
            };
            if can_be_hidden {
                self.counters.shadow(share.is_ok());
            }
            shadows.add(share);
        }
    }

    /// Share of light from a direction and distance that surfaces let through.
    fn transmittance(&mut self, point: &Point<'_>, to_light: DVec3, distance: f64) -> f32 {
        let share = self.shadow_ray(point, to_light, distance);
        self.counters.shadow(share.is_ok());
        share.map_or_else(|share| share, |ray| self.along(&ray))
    }

    /// The ray that tells it; or the share itself, where none is needed.
    fn shadow_ray(&self, point: &Point<'_>, to_light: DVec3, distance: f64) -> Result<DepartingRay, f32> {
        let Some((hit, surface)) = point.hit else { return Err(1.0) };
        let direction = self.world_to_index.transform_vector3(to_light).as_vec3().to_array();
        // Light on the other side of the surface itself.
        if hit.faces_away(direction) {
            return Err(0.0);
        }
        let end = match self.scene.clip.kept(point.position, to_light) {
            Some(kept) => kept.end.min(distance),
            // The point lies on a face, by a rounding beyond it, and the light before it.
            None => return Err(1.0),
        };
        let mut ray = hit.departing_ray(direction, end as f32, !hit.is_entering);
        ray.surface = surface;
        Ok(ray)
    }

    /// Share of the light along a ray that surfaces let through.
    fn along(&mut self, ray: &DepartingRay) -> f32 {
        if let [only] = self.scene.surfaces[..]
            && only.opacity >= 1.0
        {
            let is_occluded = self.tracer.occluded(ray, only.isovalue, self.counters);
            return if is_occluded { 0.0 } else { 1.0 };
        }
        let mut transmittance = 1.0;
        let _ = self.tracer.departing_crossings(
            ray,
            self.isovalues,
            &mut |crossing| {
                transmittance *= 1.0 - self.scene.surfaces[crossing.surface].opacity;
                match transmittance > 0.0 {
                    true => std::ops::ControlFlow::Continue(()),
                    false => std::ops::ControlFlow::Break(()),
                }
            },
            self.counters,
        );
        transmittance
    }
}
