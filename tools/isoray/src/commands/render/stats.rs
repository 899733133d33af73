//! What `--stats` tells.

use std::fmt;
use std::io::{self, Write};

use isoray_render::VolumeStatistics;
use serde::Serialize;

use crate::cli::SchemeArg;
use crate::commands::bytes;
use crate::mesh::MeshDetail;

/// Times, throughput, work and sizes of a rendered frame.
#[derive(Debug, Serialize)]
pub(crate) struct Stats {
    #[serde(flatten)]
    pub(crate) what: What,
    #[serde(flatten)]
    pub(crate) frame: FrameStats,
}

/// What was rendered.
#[derive(Debug, Serialize)]
#[serde(untagged)]
pub(crate) enum What {
    Surface(SurfaceStats),
    Volume(VolumeStats),
}

/// What isosurfaces alone have.
#[derive(Debug, Serialize)]
pub(crate) struct SurfaceStats {
    pub(crate) isovalues: Vec<f32>,
    pub(crate) hits: u64,
    /// Hits without a normal.
    pub(crate) flat_hits: u64,
    /// Packets of primary rays; those of them that were led to no surface; and rays that went one by one.
    pub(crate) packets: u64,
    pub(crate) background_packets: u64,
    pub(crate) rays_alone: u64,
    /// Rays to lights and to the sky; and those that were not needed because the surface itself is in the way.
    pub(crate) shadow_rays: u64,
    pub(crate) spared_shadow_rays: u64,
}

/// What volumes alone have.
#[derive(Debug, Serialize)]
pub(crate) struct VolumeStats {
    /// As the flag is written.
    pub(crate) scheme: String,
    /// Rays that met anything visible.
    pub(crate) lit_rays: u64,
    /// Rays that ended because what lies behind cannot matter.
    pub(crate) ended_rays: u64,
    /// Integrated.
    pub(crate) pieces_per_ray: f64,
    /// The largest bound of a pixel's error, the share of the transfer function's own apart; of a scheme that has one.
    pub(crate) largest_error_bound: Option<f64>,
}

/// What every frame has.
#[derive(Debug, Serialize)]
pub(crate) struct FrameStats {
    pub(crate) width: u32,
    pub(crate) height: u32,
    /// Seconds until the file's header was read.
    pub(crate) open_s: f64,
    /// Seconds of compressing the volume; zero for an `.ovol` file.
    pub(crate) build_s: f64,
    /// Seconds of a frame: the median over `repeat`.
    pub(crate) render_s: f64,
    /// Seconds of encoding and writing the picture.
    pub(crate) write_s: f64,
    pub(crate) repeat: u32,
    pub(crate) threads: usize,
    pub(crate) rays: u64,
    /// Million rays a second, all threads together.
    pub(crate) mrays_per_s: f64,
    pub(crate) nodes_per_ray: f64,
    /// Samples fetched.
    pub(crate) lookups_per_ray: f64,
    pub(crate) cells_per_ray: f64,
    /// Bytes of nodes and caps.
    pub(crate) structure_bytes: u64,
    pub(crate) raw_bytes: u64,
    /// Of an adaptive mesh with levels of detail.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) mesh_detail: Option<MeshDetail>,
}

impl VolumeStats {
    pub(crate) fn new(scheme: SchemeArg, counted: &VolumeStatistics) -> Self {
        Self {
            scheme: scheme.to_string(),
            lit_rays: counted.lit,
            ended_rays: counted.ended,
            // No ray: nobody asked for them to be counted.
            pieces_per_ray: counted.pieces as f64 / counted.rays.max(1) as f64,
            largest_error_bound: match scheme {
                SchemeArg::Bounded(_) => Some(counted.largest_bound),
                SchemeArg::Adaptive | SchemeArg::Fixed(_) => None,
            },
        }
    }
}

/// In a few words.
impl fmt::Display for What {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Surface(SurfaceStats { isovalues, .. }) => {
                let all: Vec<String> = isovalues.iter().map(f32::to_string).collect();
                write!(f, "isovalue{} {}", if all.len() == 1 { "" } else { "s" }, all.join(", "))
            }
            Self::Volume(volume) => write!(f, "volume, {}", volume.scheme),
        }
    }
}

impl Stats {
    pub(crate) fn print(&self, out: &mut dyn Write) -> io::Result<()> {
        let frame = &self.frame;
        writeln!(out, "open         {:>10.4} s", frame.open_s)?;
        writeln!(out, "build        {:>10.4} s", frame.build_s)?;
        let (repeat, threads) = (frame.repeat, frame.threads);
        writeln!(out, "render       {:>10.4} s  (median of {repeat}, {threads} threads)", frame.render_s)?;
        writeln!(out, "write        {:>10.4} s", frame.write_s)?;
        match &self.what {
            What::Surface(surface) => surface.print(frame.rays, out)?,
            What::Volume(volume) => volume.print(frame.rays, out)?,
        }
        writeln!(out, "throughput   {:>10.3} Mrays/s", frame.mrays_per_s)?;
        writeln!(out, "nodes/ray    {:>10.2}", frame.nodes_per_ray)?;
        writeln!(out, "lookups/ray  {:>10.2}", frame.lookups_per_ray)?;
        writeln!(out, "cells/ray    {:>10.2}", frame.cells_per_ray)?;
        if let Some(MeshDetail { patches: [before, after], cells: [all, kept] }) = frame.mesh_detail {
            // Fewer cells, but maybe more patches: large ones are cut.
            let percent = 100.0 * (all - kept) as f64 / all.max(1) as f64;
            writeln!(
                out,
                "cells        {kept:>10}    ({percent:.1} % of {all} left out; {after} patches for {before})"
            )?;
        }
        let percent = 100.0 * frame.structure_bytes as f64 / frame.raw_bytes as f64;
        writeln!(out, "structure    {:>10}    ({percent:.1} % of raw)", bytes(frame.structure_bytes))
    }
}

impl SurfaceStats {
    fn print(&self, rays: u64, out: &mut dyn Write) -> io::Result<()> {
        writeln!(out, "rays         {rays:>10}    ({} hits)", self.hits)?;
        if self.flat_hits > 0 {
            let flat = self.flat_hits;
            writeln!(out, "flat hits    {flat:>10}    (no gradient; shaded as if facing the viewer)")?;
        }
        let (packets, background) = (self.packets, self.background_packets);
        writeln!(out, "packets      {packets:>10}    ({background} of them led to no surface)")?;
        writeln!(out, "rays alone   {:>10}", self.rays_alone)?;
        if self.shadow_rays + self.spared_shadow_rays > 0 {
            let (traced, spared) = (self.shadow_rays, self.spared_shadow_rays);
            writeln!(out, "shadow rays  {traced:>10}    ({spared} more were not needed)")?;
        }
        Ok(())
    }
}

impl VolumeStats {
    fn print(&self, rays: u64, out: &mut dyn Write) -> io::Result<()> {
        let Self { lit_rays: lit, ended_rays: ended, .. } = self;
        writeln!(out, "rays         {rays:>10}    ({lit} lit, {ended} ended before they left)")?;
        writeln!(out, "scheme       {:>10}", self.scheme)?;
        if let Some(bound) = self.largest_error_bound {
            writeln!(out, "error        {bound:>10.6}    (bound of the worst pixel, of linear light)")?;
        }
        writeln!(out, "pieces/ray   {:>10.2}", self.pieces_per_ray)
    }
}
