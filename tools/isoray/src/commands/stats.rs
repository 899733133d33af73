//! What `--stats` tells.

use std::io::{self, Write};

use serde::Serialize;

use super::bytes;

/// Times, throughput, work and sizes of a rendered frame.
#[derive(Debug, Serialize)]
pub(crate) struct Stats {
    pub(crate) isovalue: f32,
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
    pub(crate) hits: u64,
    /// Hits without a normal.
    pub(crate) flat_hits: u64,
    /// Million rays a second, all threads together.
    pub(crate) mrays_per_s: f64,
    pub(crate) nodes_per_ray: f64,
    /// Samples fetched.
    pub(crate) lookups_per_ray: f64,
    pub(crate) cells_per_ray: f64,
    /// Bytes of nodes and caps.
    pub(crate) structure_bytes: u64,
    pub(crate) raw_bytes: u64,
    pub(crate) traversal: &'static str,
}

impl Stats {
    pub(crate) fn print(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(out, "open         {:>10.4} s", self.open_s)?;
        writeln!(out, "build        {:>10.4} s", self.build_s)?;
        writeln!(
            out,
            "render       {:>10.4} s  (median of {}, {} threads)",
            self.render_s, self.repeat, self.threads
        )?;
        writeln!(out, "write        {:>10.4} s", self.write_s)?;
        writeln!(out, "rays         {:>10}    ({} hits)", self.rays, self.hits)?;
        if self.flat_hits > 0 {
            writeln!(
                out,
                "flat hits    {:>10}    (no gradient; shaded as if facing the viewer)",
                self.flat_hits
            )?;
        }
        writeln!(out, "throughput   {:>10.3} Mrays/s", self.mrays_per_s)?;
        writeln!(out, "nodes/ray    {:>10.2}", self.nodes_per_ray)?;
        writeln!(out, "lookups/ray  {:>10.2}", self.lookups_per_ray)?;
        writeln!(out, "cells/ray    {:>10.2}", self.cells_per_ray)?;
        let percent = 100.0 * self.structure_bytes as f64 / self.raw_bytes as f64;
        writeln!(out, "structure    {:>10}    ({percent:.1} % of raw)", bytes(self.structure_bytes))?;
        writeln!(out, "traversal    {:>10}", self.traversal)
    }
}
