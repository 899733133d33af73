//! Figures 8 and 9 of Marchesin and Colin de Verdière (2009) on an adaptive mesh: schemes close up, and the extrema of the shading.

use std::path::Path;

use anyhow::{Context, Result};
use glam::{DVec3, Vec3};
use isoray_amr::{Mesh, MeshOptions};
use isoray_io::{AmrDataset, TransferOptions, read_transfer_function};
use isoray_preint::{Bounded, Cuts, Integrate, LinearPieces, Linearised, TransferFunction, Visibility};
use isoray_render::{
    Camera, Image, Projection, View, VolumeScene, VolumeShading, gradient_scale, render_volume,
};
use rayon::prelude::*;

use crate::finest::{Finest, Seen};
use crate::root;

/// Pixels along the side of a panel, and between panels.
const SIZE: u32 = 160;
const GAP: u32 = 4;
/// Panels in a row.
const COLUMNS: u32 = 3;
/// Linear RGB behind the mesh.
const BACKGROUND: Vec3 = Vec3::splat(0.03);
/// Transmittance at which rays of schemes without a bound end.
const TERMINATE: f64 = 1e-3;
/// What differences are multiplied by in their panel.
const DIFFERENCE: f32 = 8.0;
/// Pixels, one of so many along either axis, that are held against the oracle.
const COMPARED: u32 = 2;

struct Figure<'m> {
    mesh: &'m Mesh,
    finest: &'m Finest,
    transfer: &'m TransferFunction,
    camera: Camera,
    shading: Option<VolumeShading>,
    /// By row, of the pixels that are compared.
    exact: Vec<[f64; 4]>,
}

/// Both figures, of the plotfile of a Rayleigh-Taylor instability.
pub(super) fn run(plotfile: &Path, folder: &Path) -> Result<()> {
    let patches = AmrDataset::open(plotfile)?.read(Some("density"))?;
    let mesh = Mesh::new(&patches, MeshOptions::default())?;
    let finest = Finest::new(&patches)?;
    let file = root().join("fixtures/transfer/rayleigh-taylor.toml");
    let transfer = read_transfer_function(&file, &TransferOptions::default())?;
    let of = (&mesh, &finest, &transfer);
    println!("{:<36} {:>11} {:>11}", "close up, unlit", "max error", "rms error");
    let figure = Figure::new(of, (DVec3::new(0.9, -0.35, 0.75), DVec3::new(0.25, 0.25, 0.435), 5.0), None)?;
    let mut panels = Vec::new();
    for n in [1, 2, 4, 100] {
        panels.push(figure.panel(&format!("{n} intervals"), &figure.linearised(Cuts::Fixed(n))));
    }
    let adaptive = |shading| Cuts::Adaptive { inflection: false, shading };
    panels.push(figure.panel("adaptive", &figure.linearised(adaptive(false))));
    panels.push(figure.panel("bounded 1/510", &Bounded::new(&transfer, 1.0 / 510.0, 1.0)));
    write(&panels.iter().map(colors).collect::<Vec<_>>(), &folder.join("mesh-schemes.png"))?;
    println!("{:<36} {:>11} {:>11}", "all of it, lit", "max error", "rms error");
    let shading = VolumeShading {
        ambient: 0.6,
        diffuse: 0.9,
        specular: 0.3,
        exponent: 32.0,
        gradient_scale: gradient_scale(&mesh, mesh.index_to_world()),
        light: Some(DVec3::new(0.3, -0.5, 0.8)),
    };
    let view = (DVec3::new(1.5, -1.1, 0.9), DVec3::new(0.25, 0.25, 0.45), 20.0);
    let figure = Figure::new(of, view, Some(shading))?;
    let with = figure.panel("adaptive", &figure.linearised(adaptive(true)));
    let without = figure.panel("adaptive without extrema of shading", &figure.linearised(adaptive(false)));
    let apart: Vec<Vec3> =
        colors(&with).iter().zip(colors(&without)).map(|(a, b)| DIFFERENCE * (*a - b).abs()).collect();
    write(&[colors(&with), colors(&without), apart], &folder.join("mesh-shading.png"))
}

impl<'m> Figure<'m> {
    fn new(
        (mesh, finest, transfer): (&'m Mesh, &'m Finest, &'m TransferFunction),
        (eye, look_at, fov): (DVec3, DVec3, f64),
        shading: Option<VolumeShading>,
    ) -> Result<Self> {
        let view = View { eye, look_at, up: DVec3::Z, projection: Projection::Perspective { fov } };
        let camera = Camera::new(&view, [SIZE; 2])?;
        let mut figure = Self { mesh, finest, transfer, camera, shading, exact: Vec::new() };
        figure.exact = figure.by_oracle();
        Ok(figure)
    }

    fn by_oracle(&self) -> Vec<[f64; 4]> {
        let seen = Seen {
            camera: &self.camera,
            index_to_world: self.mesh.index_to_world(),
            points: self.transfer.points(),
            shading: self.shading,
        };
        let field = self.finest.field();
        compared().into_par_iter().map(|pixel| self.finest.pixel(&field, &seen, pixel, 0.0)).collect()
    }

    fn linearised(&self, cuts: Cuts) -> Linearised<LinearPieces> {
        Linearised { cuts, pieces: LinearPieces::new(self.transfer), terminate: TERMINATE }
    }

    /// The picture by a scheme, whose errors are printed.
    fn panel(&self, name: &str, scheme: &impl Integrate) -> Image {
        let visible = Visibility::new(self.transfer);
        let scene = VolumeScene { visible: &visible, scheme, shading: self.shading, clip: None };
        let image = render_volume(self.mesh, self.mesh.index_to_world(), &self.camera, &scene, |_, _| {});
        let (mut most, mut sum) = (0.0_f64, 0.0);
        for (&exact, [x, y]) in self.exact.iter().zip(compared()) {
            let found = image.pixel(x, y).color.to_array();
            for (found, exact) in found.into_iter().zip(exact) {
                let error = f64::from(found) - exact;
                most = most.max(error.abs());
                sum += error * error;
            }
        }
        let rms = (sum / (4 * self.exact.len()) as f64).sqrt();
        println!("{name:<36} {most:>11.2e} {rms:>11.2e}");
        image
    }
}

fn compared() -> Vec<[u32; 2]> {
    let along = SIZE / COMPARED;
    (0..along * along).map(|n| [n % along * COMPARED, n / along * COMPARED]).collect()
}

/// Linear RGB.
fn colors(image: &Image) -> Vec<Vec3> {
    image.pixels().iter().map(|p| p.color.truncate() + BACKGROUND * (1.0 - p.color.w)).collect()
}

/// All panels in one picture.
fn write(panels: &[Vec<Vec3>], output: &Path) -> Result<()> {
    super::write(panels, [SIZE, GAP, COLUMNS], output).context("cannot write the figure")?;
    println!("written: {}", output.display());
    Ok(())
}
