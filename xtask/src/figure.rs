//! `cargo xtask figure`: the single cell of Marchesin and Colin de Verdière (2009, Figure 8), by several schemes.

mod mesh;

use std::path::PathBuf;

use anyhow::{Context, Result};
use glam::{DVec3, Vec3};
use isoray_build::build;
use isoray_grid::folder_of;
use isoray_io::{Dataset, OpenOptions, PixelData, TransferOptions, read_transfer_function, write_png};
use isoray_octree::OctreeVolume;
use isoray_oracle::{FnLattice, integrate_ray};
use isoray_preint::{
    Bounded, Cuts, Integrate, LinearPieces, Linearised, Radiance, TransferFunction, Visibility,
};
use isoray_render::{Camera, Projection, View, encode_srgb};
use isoray_trace::VolumeTracer;

use crate::{for_oracle, root};

/// Flags of `cargo xtask figure`.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The picture [default: docs/pictures/single-cell.png]
    #[arg(short, long, value_name = "OUT.png")]
    output: Option<PathBuf>,
    /// Render Figures 8 and 9 on this plotfile of a Rayleigh-Taylor instability instead, into the folder of the picture
    #[arg(long, value_name = "PLOTFILE")]
    mesh: Option<PathBuf>,
}

/// Pixels along the side of a panel, and between panels.
const SIZE: u32 = 240;
const GAP: u32 = 8;
/// Panels in a row.
const COLUMNS: u32 = 4;
/// Linear RGB behind the cell.
const BACKGROUND: f32 = 0.9;

/// A panel: linear RGB of its pixels, row by row.
type Panel = Vec<Vec3>;

struct Figure {
    volume: OctreeVolume<f32>,
    transfer: TransferFunction,
    visible: Visibility,
    camera: Camera,
    /// RGBA by the oracle.
    exact: Vec<[f64; 4]>,
}

pub(crate) fn run(args: &Args) -> Result<()> {
    let output = args.output.clone().unwrap_or_else(|| root().join("docs/pictures/single-cell.png"));
    if let Some(plotfile) = &args.mesh {
        return mesh::run(plotfile, folder_of(&output));
    }
    let figure = Figure::new()?;
    let fixed = |n| figure.linearised(Cuts::Fixed(n));
    let adaptive = figure.linearised(Cuts::Adaptive { inflection: false, shading: false });
    println!("{:<16} {:>11} {:>11} {:>12}", "scheme", "max error", "rms error", "pieces/cell");
    let mut panels: Vec<Panel> =
        [1, 2, 4, 100].map(|n| figure.panel(&format!("{n} intervals"), &fixed(n))).into();
    panels.push(figure.panel("adaptive", &adaptive));
    panels.push(figure.counts(&adaptive));
    panels.push(figure.panel("bounded 1/510", &Bounded::new(&figure.transfer, 1.0 / 510.0, 1.0)));
    panels.push(
        figure.exact.iter().map(|&[r, g, b, a]| over(r as f32, g as f32, b as f32, a as f32)).collect(),
    );
    write(&panels, [SIZE, GAP, COLUMNS], &output)?;
    println!(
        "from the top left: 1, 2, 4 and 100 intervals; adaptive, and its number of intervals (red 1, green 2, blue 3); bounded; the oracle"
    );
    println!("written: {}", output.display());
    Ok(())
}

fn over(r: f32, g: f32, b: f32, a: f32) -> Vec3 {
    Vec3::new(r, g, b) + Vec3::splat(BACKGROUND * (1.0 - a))
}

impl Figure {
    fn new() -> Result<Self> {
        let folder = root().join("fixtures/single-cell");
        let dataset = Dataset::open(&folder.join("cell.nrrd"), &OpenOptions::default())?;
        let volume = build(&mut dataset.slabs::<f32>()?, dataset.index_to_world(), |_| {})
            .context("cannot build the octree")?;
        let transfer = read_transfer_function(&folder.join("shells.toml"), &TransferOptions::default())?;
        let centre = DVec3::splat(0.5);
        let view = View {
            eye: centre + DVec3::new(1.5, -2.0, 1.1),
            look_at: centre,
            up: DVec3::Z,
            projection: Projection::Perspective { fov: 38.0 },
        };
        let camera = Camera::new(&view, [SIZE; 2])?;
        let visible = Visibility::new(&transfer);
        let mut figure = Self { volume, transfer, visible, camera, exact: Vec::new() };
        figure.exact = figure.by_oracle();
        Ok(figure)
    }

    fn linearised(&self, cuts: Cuts) -> Linearised<LinearPieces> {
        Linearised { cuts, pieces: LinearPieces::new(&self.transfer), terminate: 0.0 }
    }

    fn by_oracle(&self) -> Vec<[f64; 4]> {
        let view = self.volume.view();
        let lattice = FnLattice::new([2; 3], |p| view.sample(p).into());
        let points = for_oracle::transfer(self.transfer.points());
        let pixel = |n: u32| {
            let ray = for_oracle::ray(&self.ray(n));
            let radiance = integrate_ray(&lattice, &ray, 1.0, &points, None);
            let [r, g, b] = radiance.color;
            [r, g, b, radiance.alpha()]
        };
        (0..SIZE * SIZE).map(pixel).collect()
    }

    fn ray(&self, pixel: u32) -> isoray_trace::Ray {
        let world_to_index = self.volume.meta().index_to_world.inverse();
        self.camera.index_ray(&world_to_index, pixel % SIZE, pixel / SIZE)
    }

    fn radiances(&self, scheme: &impl Integrate) -> Vec<Radiance> {
        let view = self.volume.view();
        let mut tracer = VolumeTracer::new(&view, &self.visible);
        (0..SIZE * SIZE).map(|n| tracer.integrate(&self.ray(n), 1.0, scheme, None, &mut ())).collect()
    }

    /// The picture by a scheme, whose errors are printed.
    fn panel(&self, name: &str, scheme: &impl Integrate) -> Panel {
        let radiances = self.radiances(scheme);
        let (mut most, mut sum, mut pieces, mut cells) = (0.0_f64, 0.0, 0, 0);
        for (radiance, exact) in radiances.iter().zip(&self.exact) {
            let [r, g, b] = radiance.color;
            for (found, exact) in [r, g, b, radiance.alpha()].iter().zip(exact) {
                most = most.max((found - exact).abs());
                sum += (found - exact).powi(2);
            }
            pieces += radiance.pieces;
            cells += u32::from(radiance.pieces > 0);
        }
        let rms = (sum / (4 * radiances.len()) as f64).sqrt();
        println!(
            "{name:<16} {most:>11.2e} {rms:>11.2e} {:>12.2}",
            f64::from(pieces) / f64::from(cells.max(1))
        );
        let color = |r: &Radiance| {
            let [red, green, blue] = r.color.map(|c| c as f32);
            over(red, green, blue, r.alpha() as f32)
        };
        radiances.iter().map(color).collect()
    }

    /// How many pieces there are at each pixel.
    fn counts(&self, scheme: &impl Integrate) -> Panel {
        const COLORS: [Vec3; 4] = [Vec3::splat(BACKGROUND), Vec3::X, Vec3::Y, Vec3::Z];
        self.radiances(scheme).iter().map(|r| COLORS[(r.pieces as usize).min(3)]).collect()
    }
}

/// All panels in one picture: square ones of edge `size`, `gap` pixels apart, in rows of `columns`.
fn write(panels: &[Panel], [size, gap, columns]: [u32; 3], output: &std::path::Path) -> Result<()> {
    let rows = (panels.len() as u32).div_ceil(columns);
    let (width, height) = (columns * (size + gap) - gap, rows * (size + gap) - gap);
    let mut bytes = vec![255; (3 * width * height) as usize];
    for (n, panel) in (0..).zip(panels) {
        let [x0, y0] = [n % columns * (size + gap), n / columns * (size + gap)];
        for (pixel, color) in (0..).zip(panel) {
            let at = 3 * ((y0 + pixel / size) * width + x0 + pixel % size) as usize;
            bytes[at..at + 3].copy_from_slice(&encode_srgb(*color));
        }
    }
    Ok(write_png(output, width, height, PixelData::Rgb8(&bytes))?)
}
