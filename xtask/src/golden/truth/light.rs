//! The light that a point of a surface sends to the viewer.

use std::f64::consts::TAU;

use glam::DVec3;
use isoray_oracle::{Lattice, OracleHit};
use isoray_render::{LEVEL_COLORS, Light, Scene, Surface};

use super::{Layer, Truth, kept};
use crate::for_oracle::DEGREES_99;
use crate::golden::shadow::Departure;

/// Of every so-manieth pixel along x and y it is looked how much of the sky is seen, in so many rings of as many directions.
const SKY_STEP: u32 = 3;
const SKY_RINGS: u32 = 8;
/// By how much that share may differ from the renderer's.
const SKY_ERROR: f64 = 0.2;

/// Linear RGB: the least and the most that it can be.
pub(super) struct Lit {
    pub(super) least: DVec3,
    pub(super) most: DVec3,
    /// Whether it is told which lights reach the point. How much of the sky does is no part of that.
    pub(super) is_told: bool,
}

/// What reaches a point.
#[derive(Clone, Copy, Debug, Default)]
struct Reaching {
    diffuse: f64,
    specular: f64,
}

impl<L: Lattice> Truth<'_, L> {
    /// The light that a layer sends to the viewer.
    pub(super) fn shaded(&self, layer: &Layer, position: DVec3, to_viewer: DVec3, pixel: [u32; 2]) -> Lit {
        let scene = self.scene;
        let facing = match layer.normal {
            DVec3::ZERO => to_viewer,
            normal => normal * normal.dot(to_viewer).signum(),
        };
        let mut sums = [Reaching::default(); 2];
        let mut is_told = true;
        for light in &scene.lights {
            let (to_light, distance) = match *light {
                Light::Headlight => (to_viewer, f64::INFINITY),
                Light::Point(at) => ((at - position).normalize(), (at - position).length()),
                Light::Direction(direction) => (direction.normalize(), f64::INFINITY),
            };
            let cosine = facing.dot(to_light);
            let half = (to_light + to_viewer).normalize();
            let highlight = facing.dot(half).max(0.0).powf(scene.exponent.into());
            let shares = self.shares(layer, light, position, (to_light, distance, cosine));
            is_told &= shares[0] == shares[1];
            for (sum, share) in sums.iter_mut().zip(shares) {
                sum.diffuse += share * cosine.max(0.0) / scene.lights.len() as f64;
                sum.specular += share * highlight / scene.lights.len() as f64;
            }
        }
        let colors = self.colors(layer, position);
        is_told &= colors[0] == colors[1];
        let ambient = f64::from(scene.ambient);
        let sky = self.sky(layer, position, facing, pixel);
        let [least, most] = [0, 1].map(|n| {
            colors[n] * (ambient * sky[n] + (1.0 - ambient) * sums[n].diffuse)
                + f64::from(scene.specular) * sums[n].specular
        });
        Lit { least, most, is_told }
    }

    /// Share of a light that reaches a point: the least and the most. Without shadows it is all of a light before the surface.
    fn shares(
        &self,
        layer: &Layer,
        light: &Light,
        position: DVec3,
        (to_light, distance, cosine): (DVec3, f64, f64),
    ) -> [f64; 2] {
        let can_be_hidden = self.scene.shadows && !matches!(light, Light::Headlight);
        // A normal that is off by as much as is allowed may be turned from the light, or to it.
        if (can_be_hidden || self.scene.specular > 0.0) && cosine.abs() < DEGREES_99.to_radians() {
            return [0.0, 1.0];
        }
        if cosine <= 0.0 {
            return [0.0; 2];
        }
        let (true, Some(hit)) = (can_be_hidden, layer.hit) else { return [1.0; 2] };
        // The light lies before a face on which the point lies, by a rounding beyond it.
        let Some(kept) = kept(&self.scene.clip.0, position, to_light) else { return [1.0; 2] };
        match self.reaching(layer.surface, &hit, to_light, distance.min(kept.ends[1])) {
            Some(share) => [share; 2],
            None => [0.0, 1.0],
        }
    }

    /// Share of the sky that is seen, the least and the most: of some pixels by other directions than the renderer's, of the others nothing is said.
    fn sky(&self, layer: &Layer, position: DVec3, facing: DVec3, pixel: [u32; 2]) -> [f64; 2] {
        let (true, Some(hit)) = (self.scene.sky_samples > 0, layer.hit) else { return [1.0; 2] };
        if pixel.iter().any(|c| !c.is_multiple_of(SKY_STEP)) {
            return [0.0, 1.0];
        }
        let (across, up) = facing.any_orthonormal_pair();
        let (mut seen, mut untold) = (0.0, 0.0);
        for n in 0..SKY_RINGS * SKY_RINGS {
            // Points of a disc, each of an equal part of it: by the cosine to the normal.
            let square = (f64::from(n / SKY_RINGS) + 0.5) / f64::from(SKY_RINGS);
            let turn = TAU * (f64::from(n % SKY_RINGS) + 0.5) / f64::from(SKY_RINGS);
            let [x, y] = [turn.cos(), turn.sin()].map(|c| c * square.sqrt());
            let direction = across * x + up * y + facing * (1.0 - square).sqrt();
            let end = kept(&self.scene.clip.0, position, direction).map_or(0.0, |kept| kept.ends[1]);
            match self.reaching(layer.surface, &hit, direction, end) {
                Some(share) => seen += share,
                None => untold += 1.0,
            }
        }
        let all = f64::from(SKY_RINGS * SKY_RINGS);
        [seen / all - SKY_ERROR, (seen + untold) / all + SKY_ERROR].map(|share| share.clamp(0.0, 1.0))
    }

    /// Share of a light that surfaces let through; `None` where that cannot be told.
    fn reaching(&self, surface: usize, hit: &OracleHit, to_light: DVec3, distance: f64) -> Option<f64> {
        let direction = self.index_to_world.inverse().transform_vector3(to_light) * f64::from(self.scale);
        let departure = Departure {
            position: hit.position,
            local: [0, 1, 2].map(|a| hit.position[a] - f64::from(hit.cell[a])),
            gradient: hit.gradient,
            largest: self.largest_corner(hit, surface),
            to_light: direction.normalize().as_vec3().to_array(),
            t_max: (distance * direction.length()) as f32,
        };
        let slope = departure.slope();
        let viewer_is_inside = !hit.entering;
        // The light is on the other side of the surface itself.
        let is_behind = (slope > 0.0) != viewer_is_inside;
        let level = match self.cells.filter(|_| self.far_shadows) {
            Some(cells) => cells.level_at(hit.position)?,
            None => 0,
        };
        if level > 0 {
            let [Surface { isovalue, opacity: 1.0, .. }] = self.scene.surfaces[..] else { return None };
            let begin = f32::from(1u16 << level) * self.scale;
            let is_hidden = departure.is_hidden_from(self.lattice, isovalue, begin, viewer_is_inside)?;
            return Some(if is_behind || is_hidden { 0.0 } else { 1.0 });
        }
        let mut transmittance = 1.0;
        for of in &self.scene.surfaces {
            let hits = departure.hits(self.lattice, of.isovalue)?;
            transmittance *= (1.0 - f64::from(of.opacity)).powi(hits.len() as i32);
        }
        Some(if is_behind { 0.0 } else { transmittance })
    }

    /// Of the surface; the least and the most, where the level is not told that gives it.
    fn colors(&self, layer: &Layer, position: DVec3) -> [DVec3; 2] {
        let Scene { colors, level_colors, .. } = self.scene;
        let p = self.index_to_world.inverse().transform_point3(position);
        if *level_colors && layer.hit.is_some() {
            let all = LEVEL_COLORS.map(|color| color.as_dvec3());
            let level = self.cells.and_then(|cells| cells.level_at((p * f64::from(self.scale)).to_array()));
            return match level {
                Some(level) => [all[level as usize % all.len()]; 2],
                None => [
                    all.into_iter().fold(DVec3::MAX, DVec3::min),
                    all.into_iter().fold(DVec3::MIN, DVec3::max),
                ],
            };
        }
        let color = match colors {
            Some(colors) => {
                let cell = p.max(DVec3::ZERO).floor();
                colors.color(cell.to_array().map(|c| c as u32), (p - cell).as_vec3().to_array()).as_dvec3()
            }
            None => self.scene.surfaces[layer.surface].color.as_dvec3(),
        };
        [color; 2]
    }
}
