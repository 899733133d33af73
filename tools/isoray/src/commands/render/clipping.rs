//! What is cut away.

use isoray_grid::Dims;
use isoray_octree::Meta;
use isoray_render::{Clip, Plane};

use crate::cli::ClipArgs;
use crate::commands::info::world_bounds;
use crate::failure::warn;

/// What the flags keep; warns if that is nothing.
pub(super) fn clip(args: &ClipArgs, meta: &Meta) -> Clip {
    let clip = kept(args);
    if cuts_all(&clip, meta.dims, meta) {
        warn("nothing to see: all of the volume is cut away");
    }
    clip
}

/// What the flags keep.
pub(super) fn kept(args: &ClipArgs) -> Clip {
    let mut clip = Clip::default();
    if let Some([low, high]) = args.clip_box {
        clip.add_box(low, high);
    }
    clip.0.extend(args.clip_plane.iter().map(|p| Plane { normal: p.normal, offset: p.offset }));
    clip
}

/// Whether a single plane cuts away all of the box around the domain.
fn cuts_all(clip: &Clip, dims: Dims, meta: &Meta) -> bool {
    let [low, high] = world_bounds(dims, &meta.index_to_world);
    clip.0.iter().any(|plane| {
        // The corner of the box that lies farthest towards what is kept.
        let farthest = glam::DVec3::select(plane.normal.cmpge(glam::DVec3::ZERO), high, low);
        plane.normal.dot(farthest) < plane.offset
    })
}
