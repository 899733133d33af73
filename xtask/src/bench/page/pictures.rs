//! What the figures are of: pictures of the bundled volume, and what is wrong with those that are not exact.

use anyhow::{Context, Result};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use isoray_grid::Scalar;
use isoray_io::{PixelData, write_png};
use isoray_render::{Image, Scene, render_volume};
use maud::{Markup, html};

use crate::bench::picture::Pictures;
use crate::bench::volume::schemes;
use crate::catalog::{Dense, DenseVisitor, Entry, Place};
use crate::shells::Subject;

const SIZE: u32 = 192;
/// By which differences are multiplied.
const AMPLIFIED: f32 = 8.0;

/// A picture, another way to make it, and their difference.
struct Triple {
    about: &'static str,
    images: [Image; 2],
}

pub(super) fn show() -> Result<Markup> {
    let triples = Entry::fixture().visit(Triples)??;
    let shown = triples.iter().map(Triple::show).collect::<Result<Vec<_>>>()?;
    Ok(html! {
        h2 { "What is drawn" }
        p.about { "The bundled scan of a tooth: exactly, by a way that is not, and eight times the difference." }
        @for triple in shown { (triple) }
    })
}

struct Triples;

impl DenseVisitor for Triples {
    type Output = Result<Vec<Triple>>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        let entry = Entry::fixture();
        let octree = volume.octree()?;
        let pictures = Pictures::new(&octree);
        let camera = volume.camera(Place::Far, SIZE)?;
        let scene = Scene::of(entry.isovalues[0]);
        let surface = [0.0, 4.0].map(|ratio| pictures.frame(&camera, &scene, ratio).0);
        let subject = Subject::new(&entry, volume, true, Place::Far, SIZE)?;
        let by = |scheme: &schemes::Scheme| {
            render_volume(
                &subject.view(),
                subject.index_to_world,
                &subject.camera,
                &subject.scene(scheme),
                |_, _| {},
            )
        };
        let bounded = schemes::bounded(&subject.transfer, 1.0 / 510.0, subject.brightest);
        let one = schemes::fixed(&subject.transfer, 1);
        Ok(vec![
            Triple { about: "An isosurface, and at levels of detail of up to 4 pixels", images: surface },
            Triple {
                about: "A volume within half a step of eight bits, and by one interval a cell",
                images: [by(&bounded), by(&one)],
            },
        ])
    }
}

impl Triple {
    fn show(&self) -> Result<Markup> {
        let [exact, other] = &self.images;
        let encode = |image: &Image| inline(&image.to_rgb8(glam::Vec3::ONE));
        let apart = exact.pixels().iter().zip(other.pixels()).flat_map(|(a, b)| {
            let apart = (a.color - b.color).abs() * AMPLIFIED;
            [apart.x, apart.y, apart.z].map(|c| (255.0 * c.min(1.0)).round() as u8)
        });
        let sources = [encode(exact)?, encode(other)?, inline(&apart.collect::<Vec<_>>())?];
        Ok(html! {
            p { (self.about) }
            div.pictures { @for source in sources { img alt=(self.about) src=(source); } }
        })
    }
}

/// A PNG of [`SIZE`]², as a page has it within itself.
fn inline(rgb: &[u8]) -> Result<String> {
    let file = tempfile::Builder::new().suffix(".png").tempfile()?;
    write_png(file.path(), SIZE, SIZE, PixelData::Rgb8(rgb))?;
    let bytes = std::fs::read(file.path()).context("a picture that was just written")?;
    Ok(format!("data:image/png;base64,{}", STANDARD.encode(bytes)))
}
