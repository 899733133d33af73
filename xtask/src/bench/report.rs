//! The JSON report; later suites add members beside `overview`.

use std::fs;
use std::io::Write;
use std::path::Path;

use anyhow::{Context, Result};
use isoray_grid::{OutputFile, folder_of};
use serde::Serialize;
use serde_json::Value;

use super::amr::AmrSuite;
use super::baseline::ComparisonRow;
use super::cell::CellRow;
use super::detail::DetailRow;
use super::hashing::HashingRow;
use super::kernels::KernelRow;
use super::layout::LayoutRow;
use super::lod::LodRow;
use super::lossy::LossyRow;
use super::normals::NormalRow;
use super::orbit::OrbitRow;
use super::packet::PacketRow;
use super::page::rows;
use super::papers::PaperRow;
use super::robustness::RobustnessRow;
use super::scaling::ScalingSuite;
use super::shadows::ShadowRow;
use super::single::SingleSuite;
use super::skipping::SkippingRow;
use super::volume::VolumeSuite;

/// Version of the schema: raised when a member changes its meaning or goes, not when one is added.
const SCHEMA: u32 = 3;

/// One run of `cargo xtask bench`.
#[derive(Debug, Serialize)]
pub(crate) struct Report {
    schema: u32,
    machine: Machine,
    /// Timed repetitions of which a time is the median.
    repeat: usize,
    pub(crate) overview: Vec<VolumeRow>,
    pub(crate) cell: Vec<CellRow>,
    pub(crate) normals: Vec<NormalRow>,
    pub(crate) volume: VolumeSuite,
    pub(crate) lossy: Vec<LossyRow>,
    pub(crate) lod: Vec<LodRow>,
    pub(crate) layout: Vec<LayoutRow>,
    pub(crate) single: SingleSuite,
    pub(crate) packet: Vec<PacketRow>,
    pub(crate) detail: Vec<DetailRow>,
    pub(crate) shadows: Vec<ShadowRow>,
    pub(crate) orbit: Vec<OrbitRow>,
    pub(crate) papers: Vec<PaperRow>,
    pub(crate) amr: AmrSuite,
    pub(crate) hashing: Vec<HashingRow>,
    pub(crate) skipping: Vec<SkippingRow>,
    pub(crate) scaling: ScalingSuite,
    pub(crate) robustness: Vec<RobustnessRow>,
    pub(crate) kernels: Vec<KernelRow>,
    /// With a baseline.
    pub(crate) comparison: Vec<ComparisonRow>,
}

/// What it ran on.
#[derive(Debug, Serialize)]
struct Machine {
    cpu: String,
    threads: usize,
    /// Instruction sets the build uses.
    build: Vec<&'static str>,
}

/// Size, build and throughput of one volume.
#[derive(Debug, Serialize)]
pub(crate) struct VolumeRow {
    pub(crate) volume: String,
    pub(crate) dims: [u32; 3],
    #[serde(rename = "type")]
    pub(crate) scalar: &'static str,
    pub(crate) raw_bytes: u64,
    /// The whole `.ovol` file.
    pub(crate) octree_bytes: u64,
    /// The nodes and caps of Knoll 2006.
    pub(crate) knoll2006_bytes: u64,
    pub(crate) build_s: f64,
    pub(crate) voxels_per_s: f64,
    pub(crate) views: Vec<ViewRow>,
}

/// One view of one isosurface, on one thread.
#[derive(Debug, Serialize)]
pub(crate) struct ViewRow {
    pub(crate) isovalue: f32,
    pub(crate) view: &'static str,
    /// Pixels along each side.
    pub(crate) size: u32,
    pub(crate) hits: u64,
    pub(crate) nodes_per_ray: f64,
    pub(crate) lookups_per_ray: f64,
    pub(crate) cells_per_ray: f64,
    pub(crate) single_ns_per_ray: f64,
    pub(crate) knoll2006_ns_per_ray: f64,
    /// Only intersecting the cells that must be intersected, from a packed list, and shading.
    pub(crate) floor_ns_per_ray: f64,
}

impl Report {
    pub(crate) fn new(repeat: usize) -> Self {
        let features = [
            ("sse4.2", cfg!(target_feature = "sse4.2")),
            ("avx2", cfg!(target_feature = "avx2")),
            ("fma", cfg!(target_feature = "fma")),
            ("avx512f", cfg!(target_feature = "avx512f")),
        ];
        let cpu = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let model = cpu.lines().find_map(|l| l.strip_prefix("model name")).and_then(|l| l.split(':').nth(1));
        let machine = Machine {
            cpu: model.unwrap_or(std::env::consts::ARCH).trim().to_owned(),
            threads: rayon::current_num_threads(),
            build: features.iter().filter(|f| f.1).map(|f| f.0).collect(),
        };
        Self {
            schema: SCHEMA,
            machine,
            repeat,
            overview: Vec::new(),
            cell: Vec::new(),
            normals: Vec::new(),
            volume: VolumeSuite::default(),
            lossy: Vec::new(),
            lod: Vec::new(),
            layout: Vec::new(),
            single: SingleSuite::default(),
            packet: Vec::new(),
            detail: Vec::new(),
            shadows: Vec::new(),
            orbit: Vec::new(),
            papers: Vec::new(),
            amr: AmrSuite::default(),
            hashing: Vec::new(),
            skipping: Vec::new(),
            scaling: ScalingSuite::default(),
            robustness: Vec::new(),
            kernels: Vec::new(),
            comparison: Vec::new(),
        }
    }

    /// The processor and what the build uses of it.
    pub(crate) fn machine(&self) -> String {
        format!("{} ({})", self.machine.cpu, self.machine.build.join(", "))
    }

    pub(crate) fn save(&self, path: &Path) -> Result<()> {
        let folder = folder_of(path);
        fs::create_dir_all(folder).with_context(|| format!("{}: cannot be made", folder.display()))?;
        write(path, &serde_json::to_vec_pretty(self)?)
    }
}

/// Writes a file, whole or not at all, and says so.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    let write = || {
        let mut output = OutputFile::create(path)?;
        output.file().write_all(bytes)?;
        output.commit()
    };
    write().with_context(|| format!("{}: cannot be written", path.display()))?;
    println!("written: {}", path.display());
    Ok(())
}

/// Whether a report has anything but what it was made on.
pub(crate) fn has_rows(report: &Value) -> bool {
    fn has_rows(value: &Value) -> bool {
        match value {
            Value::Array(rows) => !rows.is_empty(),
            Value::Object(members) => members.values().any(has_rows),
            _ => false,
        }
    }
    report.as_object().into_iter().flatten().any(|(name, value)| name != "machine" && has_rows(value))
}

/// Whether a report has anything of volumes or meshes that suites choose by name.
pub(crate) fn has_volumes(report: &Value) -> bool {
    const PLACES: [&str; 13] = [
        "/normals",
        "/volume/curves",
        "/lossy",
        "/lod",
        "/layout",
        "/detail",
        "/shadows",
        "/papers",
        "/amr/meshes",
        "/amr/errors",
        "/scaling/sizes",
        "/scaling/pixels",
        "/scaling/complexity",
    ];
    PLACES.iter().any(|place| !rows(report, place).is_empty())
}
