//! Pictures of adaptive meshes.

use anyhow::{Context, Result, ensure};
use isoray_amr::{Mesh, MeshOptions, Patches};
use isoray_octree::Coarse;
use isoray_preint::Visibility;
use isoray_render::{
    ByLevel, Clip, Image, LEVEL_COLORS, VolumeScene, gradient_scale, mesh_detail, render, render_volume,
};

use super::compared::{Compared, Truths, exactly};
use super::eye::Eye;
use super::glow::{longest_way, shading};
use super::isosurfaces::{Precision, Subject};
use super::mesh::Source;
use super::mesh_cells::MeshCells;
use super::mesh_volume::MeshVolume;
use super::off;
use super::pictures::{Outcome, Pictures, SIZE, finished};
use super::scenes::{Layers, Look, Of, PictureScene, Scheme, Surfaces};
use super::subjects::{Extent, oblique};
use crate::finest::{Field, Finest};
use crate::shells::shells;

/// The bounds that are broken.
pub(crate) fn pictures(number: usize, pictures: Pictures<'_>) -> Result<Vec<String>> {
    let sources = Source::all();
    let source = sources.get(number).context("there is no such mesh")?;
    let mut failures = Vec::new();
    for scene in pictures.scenes {
        let whole = placed(source.patches(), scene.of);
        let mesh = Mesh::new(&whole, MeshOptions::default())?;
        let to_world = mesh.index_to_world();
        let eye = Eye::new(scene.from.view(mesh.dims(), &to_world), SIZE)?;
        let outcome = outcome(scene, whole, &mesh, &eye).with_context(|| scene.title())?;
        failures.extend(finished(scene, outcome, pictures.references, &to_world, &eye)?);
    }
    Ok(failures)
}

fn placed(mut patches: Patches, of: Of) -> Patches {
    if matches!(of, Of::ObliqueMesh(_)) {
        patches.index_to_world = oblique();
    }
    patches
}

fn outcome(scene: &PictureScene, whole: Patches, mesh: &Mesh, eye: &Eye) -> Result<Outcome> {
    let to_world = mesh.index_to_world();
    let moved = eye.moved(off::half_a_voxel(&to_world))?;
    match &scene.look {
        Look::Volume(look) => {
            let finest = Finest::new(&whole)?;
            let seen = Glow { scene, mesh, finest: &finest, field: &finest.field(), to_world };
            let mut outcome = seen.outcome(look, eye)?;
            for (what, look) in off::layers(look) {
                outcome.without.push((what, seen.image(&look, eye)?.0));
            }
            outcome.without.push((off::MOVED, seen.image(look, &moved)?.0));
            Ok(outcome)
        }
        Look::Surfaces(look) => {
            let mut outcome = surfaces(scene, look, &whole, mesh, eye)?;
            let image = |look: &Surfaces, eye: &Eye| -> Result<Image> {
                let coarser = coarsened(whole.clone(), look, eye)?;
                let mesh = Mesh::new(&coarser, MeshOptions::default())?;
                let drawn = Subject { dims: mesh.dims(), to_world, eye }.scene(look, scene.of, None);
                Ok(render(&mesh, to_world, &eye.camera, &drawn))
            };
            for (what, look) in off::surfaces(look) {
                outcome.without.push((what, image(&look, eye)?));
            }
            outcome.without.push((off::MOVED, image(look, &moved)?));
            Ok(outcome)
        }
    }
}

/// The patches that are drawn at levels of detail.
fn coarsened(whole: Patches, look: &Surfaces, eye: &Eye) -> Result<Patches> {
    let Some(levels) = look.levels else { return Ok(whole) };
    let is_plain = levels.blend == 0.0 && !levels.by_slices && !levels.far_shadows;
    ensure!(is_plain && levels.coarse == Coarse::Injected, "meshes have levels of one kind");
    Ok(mesh_detail(whole, eye.camera.pixel_width(), levels.ratio)?)
}

fn surfaces(
    scene: &PictureScene,
    look: &Surfaces,
    whole: &Patches,
    mesh: &Mesh,
    eye: &Eye,
) -> Result<Outcome> {
    ensure!(!look.by_place, "places do not colour surfaces of meshes");
    let patches = coarsened(whole.clone(), look, eye)?;
    let coarser = Mesh::new(&patches, MeshOptions::default())?;
    let finest = Finest::new(&patches)?;
    let subject = Subject { dims: coarser.dims(), to_world: coarser.index_to_world(), eye };
    ensure!(coarser.dims() == mesh.dims(), "a coarser mesh has the lattice of the whole");
    let drawn = subject.scene(look, scene.of, None);
    let field = finest.field();
    let cells = MeshCells { finest: &finest, field: &field };
    let precision = Precision {
        scale: finest.scale(),
        rounding: finest.rounding(),
        cells: Some(&cells),
        far_shadows: false,
    };
    subject.compared(&coarser, &field, precision, &drawn, &scene.title())
}

/// A mesh as a volume.
struct Glow<'a> {
    scene: &'a PictureScene,
    mesh: &'a Mesh,
    finest: &'a Finest,
    field: &'a Field<'a>,
    to_world: glam::DAffine3,
}

impl Glow<'_> {
    /// Renders it; with the bound, and what of it the oracle is to look at.
    fn image(&self, look: &Layers, eye: &Eye) -> Result<(Image, f64, Truths)> {
        let Self { mesh, to_world, .. } = *self;
        let is_by_level = matches!(look.scheme, Scheme::ByLevel(_));
        let range = mesh.range().context("the mesh has no values")?;
        let scale = gradient_scale(mesh, to_world);
        let plain = shells(self.scene.of.isovalues(), range, scale)?;
        let transfer = if is_by_level { plain.in_white() } else { plain };
        let shading = shading(look, scale)?;
        let brightest =
            shading.map_or(1.0, |s| s.brightest(&to_world, f64::from(range[1]) - f64::from(range[0])));
        let scheme = look.scheme.with(&transfer, brightest, range, longest_way(&to_world))?;
        let bound = look.scheme.bound(true);
        let visible = Visibility::new(&transfer);
        let clip: Clip = Extent::new(mesh.dims(), &to_world).clip(look.cuts);
        let of = VolumeScene { visible: &visible, scheme: &scheme, shading, clip: Some(&clip) };
        let image = match is_by_level {
            true => render_volume(&ByLevel(mesh), to_world, &eye.camera, &of, |_, _| {}),
            false => render_volume(mesh, to_world, &eye.camera, &of, |_, _| {}),
        };
        let (finest, field, points) = (self.finest, self.field, transfer.points());
        let seen = MeshVolume { finest, field, eye, to_world, points, shading, clip: &clip };
        let levels = LEVEL_COLORS.map(|color| color.to_array().map(f64::from));
        let truths = Truths::new(image.size(), |pixel| {
            let [r, g, b, alpha] = seen.pixel(pixel, bound)?;
            if !is_by_level {
                return Some(exactly([r, g, b, alpha]));
            }
            // Of a level, which it is that gives its colour is not asked.
            let of = |channel: usize| {
                let all = || levels.iter().map(move |color| color[channel]);
                [all().fold(f64::INFINITY, f64::min), all().fold(0.0, f64::max)].map(|c| c * alpha)
            };
            Some([of(0), of(1), of(2), [alpha; 2]])
        });
        Ok((image, bound, truths))
    }

    fn outcome(&self, look: &Layers, eye: &Eye) -> Result<Outcome> {
        let (image, bound, truths) = self.image(look, eye)?;
        let (compared, shown) = Compared::volume(&image, &truths, bound, &self.scene.title())?;
        let mut broken = compared.failures();
        broken.extend(shown.map(|path| format!("the oracle's picture beside it: {}", path.display())));
        Ok(Outcome { image, compared, broken, without: Vec::new() })
    }
}
