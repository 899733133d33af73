//! Pictures of adaptive meshes.

use anyhow::{Context, Result};
use isoray_amr::{Mesh, MeshOptions};
use isoray_preint::Visibility;
use isoray_render::{ByLevel, Camera, VolumeScene, gradient_scale, render_volume};

use super::compared::Compared;
use super::mesh::Source;
use super::pictures::{Outcome, Pictures, Precision, SIZE, Subject, against_reference};
use super::scenes::{Layers, Look, Of};
use crate::finest::{Field, Finest, Seen};
use crate::shells::shells;

/// Every so-manieth pixel along x and y is compared with the oracle.
const STEP: u32 = 2;

/// Share of a bound that the rounding of values may move the truth by, of a pixel that is held against that bound.
const DOUBTFUL: f64 = 1.0 / 16.0;

/// The bounds that are broken.
pub(crate) fn pictures(number: usize, pictures: Pictures<'_>) -> Result<Vec<String>> {
    let sources = Source::all();
    let patches = sources.get(number).context("there is no such mesh")?.patches();
    let mesh = Mesh::new(&patches, MeshOptions::default())?;
    let finest = Finest::new(&patches)?;
    let field = finest.field();
    let mut failures = Vec::new();
    for scene in pictures.scenes {
        let to_world = mesh.index_to_world();
        let camera = Camera::new(&scene.from.view(mesh.dims(), &to_world), [SIZE; 2])?;
        let (image, compared, mut broken) = match &scene.look {
            Look::Volume(look) => by_level(look, &mesh, (&finest, &field), &camera)?,
            Look::Surfaces(look) => {
                let subject = Subject { dims: mesh.dims(), to_world, camera: &camera };
                let drawn = subject.scene(look, scene.of, None);
                let values =
                    Precision { scale: finest.scale(), rounding: finest.rounding(), has_colors: true };
                subject.compared(&mesh, &field, values, &drawn, &scene.title())?
            }
        };
        broken.extend(against_reference(scene, &image, compared.as_ref(), pictures.references)?);
        failures.extend(broken.into_iter().map(|what| format!("{}: {what}", scene.title())));
    }
    Ok(failures)
}

/// A volume coloured by the mesh's levels, of which the oracle knows how opaque it is.
fn by_level(
    look: &Layers,
    mesh: &Mesh,
    (finest, field): (&Finest, &Field<'_>),
    camera: &Camera,
) -> Result<Outcome> {
    let to_world = mesh.index_to_world();
    let range = mesh.range().context("the mesh has no values")?;
    let transfer = shells(Of::Mesh(0).isovalues(), range, gradient_scale(mesh, to_world))?.in_white();
    let (scheme, bound) = look.scheme.with(&transfer, 1.0, range, 1.0)?;
    let visible = Visibility::new(&transfer);
    let scene = VolumeScene { visible: &visible, scheme: &scheme, shading: None, clip: None };
    let image = render_volume(&ByLevel(mesh), to_world, camera, &scene, |_, _| {});
    let seen = Seen { camera, index_to_world: to_world, points: transfer.points(), shading: None };
    let truth = |pixel: [u32; 2]| {
        let alpha = |by: f64| finest.pixel(field, &seen, pixel, by)[3];
        let [alpha, above, below] = [0.0, finest.rounding(), -finest.rounding()].map(alpha);
        let is_doubtful = (alpha - above).abs().max((alpha - below).abs()) > DOUBTFUL * bound;
        (!is_doubtful).then_some([None, None, None, Some(alpha)])
    };
    let compared = Compared::volume(&image, STEP, Some(bound), truth);
    let broken = compared.failures();
    Ok((image, Some(compared), broken))
}
