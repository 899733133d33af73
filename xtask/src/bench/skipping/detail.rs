//! Levels of detail where none are asked for.

use anyhow::{Context, Result, ensure};
use isoray_grid::Scalar;
use isoray_octree::lod::DetailView;
use isoray_octree::{Coarse, OctreeVolume};
use isoray_render::{Scene, Traversal, render_counted};
use isoray_trace::Work;

use super::{Per, Setting, SkippingRow};
use crate::bench::picture::{Pictures, hits};
use crate::bench::timer::interleave_kept;
use crate::catalog::{Dense, Place};

pub(super) fn measure<T: Scalar + Into<f64>>(
    setting: Setting<'_>,
    volume: &Dense<T>,
    octree: &OctreeVolume<T>,
) -> Result<Vec<SkippingRow>> {
    let size = setting.size(96, 256);
    let pictures = Pictures::new(octree);
    let camera = volume.camera(Place::Far, size)?;
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().context("cannot start a thread")?;
    let mut rows = Vec::new();
    for (name, traversal) in [("surface far", Traversal::Single), ("surface far, packets", Traversal::Auto)] {
        let scene = Scene { traversal, ..Scene::of(setting.entry.isovalues[0]) };
        // Ratio 0: the finest level everywhere.
        let detail = || pictures.detail(&camera, 0.0);
        let view = octree.view();
        let levels = DetailView::new(&view, Coarse::Injected, detail());
        let (exact, with) = render_counted(&view, volume.index_to_world, &camera, &scene);
        let (found, without) = render_counted(&levels, volume.index_to_world, &camera, &scene);
        ensure!(hits(&exact) > 0, "{}, {name}: no ray hits", setting.entry.name);
        ensure!(found == exact, "{}: levels of detail at ratio 0 show another picture", setting.entry.name);
        let (times, timed) = one.install(|| {
            interleave_kept(
                setting.repeat,
                &mut [&mut || pictures.exact(&camera, &scene), &mut || {
                    pictures.at_levels(&camera, &scene, detail())
                }],
            )
        });
        ensure!(
            timed.iter().all(|image| *image == exact),
            "{}, {name}: another picture when timed",
            setting.entry.name
        );
        let rays = f64::from(size).powi(2);
        let per_ray = |count: fn(&Work) -> u64| [with, without].map(|of| count(&of.work) as f64 / rays);
        // Asking for the level, which is what is left out, is not counted: these are the same, but for a few nodes that packets enter.
        let counts = [("nodes", per_ray(|w| w.nodes)), ("look-ups", per_ray(|w| w.lookups))];
        let ns = [times[0], times[1]].map(|seconds| seconds * 1e9 / rays);
        rows.push(setting.row([name, "levels of detail not asked for"], Per::Ray, ns, &counts));
    }
    Ok(rows)
}
