//! A mesh of one level against the structured volume of the same samples: hits and colours.

use anyhow::{Context, Result};
use isoray_amr::{Centering, Mesh, MeshOptions, Patch, Patches};
use isoray_grid::{Dims, Scalar};
use isoray_preint::{Bounded, Visibility};
use isoray_render::{Image, Scene, VolumeScene, gradient_scale, render, render_volume};

use super::scenes::EPSILON;
use super::selection::Selection;
use crate::catalog::{Dense, DenseVisitor, Entry, Place};
use crate::for_oracle::{breaks, colors_apart, is_hit};
use crate::shells::shells;

/// Titles of the columns.
pub(crate) const HEADER: &str = "a mesh of one level beside the octree volume              isovalue |     hits   unlike depths off |         ε  most apart";

/// A part of the volume.
pub(crate) struct SingleLevel<'a> {
    pub(crate) entry: &'a Entry,
    pub(crate) selection: &'a Selection,
}

/// Pixels along each side.
const SIZE: u32 = 96;

/// Samples along each axis, where there are as many: no whole number of blocks of 4³.
const MOST: [u32; 3] = [43, 38, 41];

const EPSILONS: [f64; 2] = [EPSILON, 1e-5];

impl DenseVisitor for SingleLevel<'_> {
    type Output = Result<Vec<String>>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        let part = upper(volume)?;
        let mesh = mesh(&part)?;
        let octree = part.octree()?;
        let view = octree.view();
        let range = mesh.range().context("the mesh has no values")?;
        let transfer = shells(&self.entry.isovalues, range, gradient_scale(&mesh, part.index_to_world))?;
        let visible = Visibility::new(&transfer);
        let mut failures = Vec::new();
        for place in Place::ALL {
            let camera = part.camera(place, SIZE)?;
            let name = format!("{}, {}", self.entry.name, place.name());
            if !self.selection.wants(&name) {
                continue;
            }
            for &isovalue in &self.entry.isovalues {
                let scene = Scene::of(isovalue);
                let found = render(&mesh, mesh.index_to_world(), &camera, &scene);
                let expected = render(&view, part.index_to_world, &camera, &scene);
                let ([hits, unlike, off], first) = hits(&found, &expected);
                println!("{name:<54} {isovalue:>11} | {hits:>8} {unlike:>8} {off:>10} |");
                if unlike + off > 0 {
                    let at = first.map(|n| [n as u32 % SIZE, n as u32 / SIZE]).unwrap_or_default();
                    failures.push(format!(
                        "{name}: {unlike} hits and {off} depths unlike the octree's, the first at {at:?}"
                    ));
                }
            }
            for epsilon in EPSILONS {
                let scheme = Bounded::new(&transfer, epsilon, 1.0);
                let scene = VolumeScene { visible: &visible, scheme: &scheme, shading: None, clip: None };
                let found = render_volume(&mesh, mesh.index_to_world(), &camera, &scene, |_, _| {});
                let expected = render_volume(&view, part.index_to_world, &camera, &scene, |_, _| {});
                let apart = apart(&found, &expected);
                println!("{name:<66} | {:>28} | {epsilon:>9.2e} {apart:>11.2e}", "");
                // Each is within its bound of the truth.
                if breaks(apart, 2.0 * epsilon) {
                    failures.push(format!("{name}: colours {apart:e} apart, with bounds of {epsilon:e}"));
                }
            }
        }
        Ok(failures)
    }
}

/// The samples around the upright axis, towards the upper end, where the bundled scan has enamel.
fn upper<T: Scalar>(volume: &Dense<T>) -> Result<Dense<T>> {
    let of = volume.dims.axes();
    let dims = Dims::new(std::array::from_fn(|a| MOST[a].min(of[a])))?;
    let left: [u32; 3] = std::array::from_fn(|a| of[a] - dims.axes()[a]);
    let low = [left[0] / 2, left[1] / 2, left[2] * 9 / 10];
    let [nx, ny, nz] = dims.axes();
    let mut samples = Vec::with_capacity(dims.samples());
    for z in 0..nz {
        for y in 0..ny {
            for x in 0..nx {
                let [x, y, z] = [low[0] + x, low[1] + y, low[2] + z].map(|c| c as usize);
                samples.push(volume.samples[x + of[0] as usize * (y + of[1] as usize * z)]);
            }
        }
    }
    Ok(Dense { dims, samples, index_to_world: volume.index_to_world })
}

/// One patch with values at vertices.
fn mesh<T: Scalar>(part: &Dense<T>) -> Result<Mesh> {
    let cells = part.dims.axes().map(|n| n - 1);
    let values = part.samples.iter().map(|sample| sample.to_f32()).collect::<Vec<_>>().into();
    let patches = Patches {
        centering: Centering::Vertices,
        ratios: Vec::new(),
        index_to_world: part.index_to_world,
        domain: ([0; 3], cells),
        patches: vec![Patch { level: 0, low: [0; 3], cells, values }],
    };
    Ok(Mesh::new(&patches, MeshOptions::default())?)
}

/// Hits; pixels at which only one hits; depths that differ by more than a unit in the last place. And the first pixel of either kind.
fn hits(found: &Image, expected: &Image) -> ([u64; 3], Option<usize>) {
    let mut counts = [0; 3];
    let mut first = None;
    for (n, (found, expected)) in found.pixels().iter().zip(expected.pixels()).enumerate() {
        let [is_found, is_expected] = [found, expected].map(is_hit);
        counts[0] += u64::from(is_expected);
        counts[1] += u64::from(is_found != is_expected);
        let near = expected.depth.next_down()..=expected.depth.next_up();
        counts[2] += u64::from(is_found && is_expected && !near.contains(&found.depth));
        first = first.or((counts[1] + counts[2] > 0).then_some(n));
    }
    (counts, first)
}

fn apart(a: &Image, b: &Image) -> f64 {
    let pairs = a.pixels().iter().zip(b.pixels());
    pairs.fold(0.0, |m, (a, b)| m.max(colors_apart(a.color.to_array(), b.color.to_array())))
}
