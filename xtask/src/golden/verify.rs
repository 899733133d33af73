//! A rendered view against the oracle, ray by ray.

use anyhow::Result;
use glam::{DAffine3, DVec3};
use isoray_grid::Scalar;
use isoray_octree::OctreeVolume;
use isoray_oracle::{DenseLattice, Verdict, central_gradient, error_in_ulps, judge};
use isoray_render::{
    Camera, Image, Normals, Scene, Slicing, SurfaceSource, Traversal, render as render_frame,
};
use isoray_trace::Ray;
use rayon::prelude::*;

use super::picture::Picture;
use super::reference::normals_picture;
use super::report::{Error, Tally};
use super::unlike::unlike;
use crate::for_oracle;

/// The two pictures of a scene.
pub(crate) struct Rendered {
    pub(crate) forward: Image,
    pub(crate) central: Image,
}

/// Renders with either kind of normals.
pub(crate) fn render<T: Scalar>(octree: &OctreeVolume<T>, camera: &Camera, isovalue: f32) -> Rendered {
    let placement = octree.meta().index_to_world;
    let view = octree.view();
    let with = |normals| render_frame(&view, placement, camera, &Scene { normals, ..Scene::of(isovalue) });
    Rendered { forward: with(Normals::Forward), central: with(Normals::Central) }
}

/// The ways of rays by which the picture of a scene is not `expected`, bit for bit.
pub(crate) fn differing_traversals<S: SurfaceSource>(
    source: &S,
    index_to_world: DAffine3,
    camera: &Camera,
    scene: &Scene<'_>,
    expected: &Image,
    title: &str,
) -> Result<Vec<String>> {
    let coherent = Traversal::Coherent(Slicing::default());
    let ways = [
        (Traversal::Single, 8),
        (Traversal::Masked, 4),
        (Traversal::Masked, 8),
        (Traversal::Masked, 16),
        (coherent, 8),
        (coherent, 16),
    ];
    let mut differing = Vec::new();
    for (traversal, packet_edge) in ways {
        let scene = Scene { traversal, packet_edge, ..scene.clone() };
        let found = render_frame(source, index_to_world, camera, &scene);
        let how = format!("{traversal:?}, packets of {packet_edge}²");
        differing.extend(unlike(&found, expected, &how, title)?);
    }
    Ok(differing)
}

/// Compares every pixel with the oracle's answer to the very ray that was traced.
pub(crate) fn against_oracle<T: Scalar + Into<f64>>(
    octree: &OctreeVolume<T>,
    lattice: &DenseLattice<T>,
    camera: &Camera,
    isovalue: f32,
    rendered: &Rendered,
) -> Tally {
    let world_to_index = octree.meta().index_to_world.inverse();
    let [width, height] = camera.size();
    let row = |y: u32| {
        let mut tally = Tally::default();
        for x in 0..width {
            let ray = camera.index_ray(&world_to_index, x, y);
            let verdict = judge(lattice, &for_oracle::ray(&ray), isovalue);
            tally.add(pixel(lattice, &world_to_index, rendered, [x, y], &ray, &verdict), [x, y]);
        }
        tally
    };
    (0..height).into_par_iter().map(row).reduce(Tally::default, Tally::join)
}

/// Normals, as colours: the oracle's, and those that were rendered.
pub(crate) fn pictures<T: Scalar + Into<f64>>(
    octree: &OctreeVolume<T>,
    lattice: &DenseLattice<T>,
    camera: &Camera,
    isovalue: f32,
    found: &Image,
) -> [Picture; 2] {
    let world_to_index = octree.meta().index_to_world.inverse();
    let width = camera.size()[0];
    let expected = |n: usize| {
        let ray = camera.index_ray(&world_to_index, n as u32 % width, n as u32 / width);
        let hit = judge(lattice, &for_oracle::ray(&ray), isovalue).hit?;
        let normal = world_to_index.matrix3.transpose() * DVec3::from_array(hit.gradient);
        Some(normal.normalize_or_zero().as_vec3())
    };
    let found = |n: usize| {
        let pixel = found.pixels()[n];
        for_oracle::is_hit(&pixel).then_some(pixel.normal)
    };
    [normals_picture(camera.size(), expected), normals_picture(camera.size(), found)]
}

fn pixel<T: Scalar + Into<f64>>(
    lattice: &DenseLattice<T>,
    world_to_index: &DAffine3,
    rendered: &Rendered,
    [x, y]: [u32; 2],
    ray: &Ray,
    verdict: &Verdict,
) -> Error {
    let found = rendered.forward.pixel(x, y);
    if verdict.grazing {
        return Error::Grazing { hit: for_oracle::is_hit(&found) };
    }
    match (for_oracle::is_hit(&found), verdict.hit) {
        (false, None) => Error::None,
        (true, None) => Error::False,
        (false, Some(_)) => Error::Missed,
        (true, Some(hit)) => {
            let speed = DVec3::from_array(ray.direction.map(f64::from)).length();
            let to_world = world_to_index.matrix3.transpose();
            let angle = |found: glam::Vec3, gradient: [f64; 3]| {
                let exact = (to_world * DVec3::from_array(gradient)).normalize_or_zero();
                for_oracle::degrees(found.as_dvec3(), exact)
            };
            Error::Hit {
                ulps: error_in_ulps(found.depth, hit.t),
                voxels: for_oracle::apart(found.depth.into(), hit.t) * speed,
                forward: angle(found.normal, hit.gradient),
                central: angle(
                    rendered.central.pixel(x, y).normal,
                    central_gradient(lattice, hit.position, hit.cell),
                ),
            }
        }
    }
}
