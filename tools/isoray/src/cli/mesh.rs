//! Flags of adaptive meshes.

use clap::Args;

/// What `isoray render` can be told about adaptive meshes.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Adaptive meshes")]
pub(crate) struct MeshArgs {
    /// Colour surfaces or the volume by the size of the cells, or parts of cells, that they are in, the finest first; the
    /// opacity of a volume stays what the transfer function says
    #[arg(long)]
    pub(crate) show_levels: bool,
    /// Draw the outlines of the patches of all levels in the same colours: behind surfaces where these are nearer, and
    /// translucent over a volume. Of octrees, those of the boxes that cells of one size make
    #[arg(long)]
    pub(crate) show_patches: bool,
}
