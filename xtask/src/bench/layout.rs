//! Sizes in other layouts of nodes and caps.

use anyhow::{Result, ensure};
use glam::DAffine3;
use isoray_benches::knoll2006::PaperOctree;
use isoray_benches::layouts::{NodeKind, Payload, Tally};
use isoray_grid::{Dims, Scalar, SlabSource};
use isoray_octree::cap_reach;
use isoray_synth::{LayersError, Mixing, MixingParams, Noise};
use serde::Serialize;

use crate::catalog::{Dense, DenseVisitor, Entry};

/// Edges of caps, and whether they have an apron.
const CAPS: [(u32, bool); 6] = [(2, false), (4, false), (8, false), (2, true), (4, true), (8, true)];

/// What one volume takes in one layout.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct LayoutRow {
    volume: String,
    #[serde(rename = "type")]
    scalar: &'static str,
    /// Samples along the edge of a cap, without apron.
    cap_edge: u32,
    apron: bool,
    node: &'static str,
    payload: &'static str,
    node_bytes: u64,
    cap_bytes: u64,
    /// Of the raw samples.
    percent: f64,
}

pub(crate) fn run(quick: bool, entries: &[Entry], only: Option<&str>) -> Result<Vec<LayoutRow>> {
    println!(
        "\nSizes in % of raw, nodes and caps: mask nodes by the caps' edge, with apron (+), and what is stored in them; then"
    );
    println!(
        "4³ caps of the range's bits with other nodes, and the paper's layout. Nodes whose hot fields (ranges) and"
    );
    println!("cold ones (values, links) lie apart take not a byte more or less.\n");
    print!("{:<20} {:>4}", "volume", "type");
    for (edge, has_apron) in CAPS {
        print!(" | {:<31}", format!("{edge}³{}: raw, 2^n, range, own", if has_apron { "+" } else { "" }));
    }
    println!(" | links  offsets no val. | 2006");
    let mut rows = Vec::new();
    for entry in entries {
        rows.extend(entry.visit(Measure(&entry.name))??);
    }
    let sizes: &[u32] = if quick { &[64] } else { &[256, 512] };
    for &n in sizes {
        let mixing = |n| Ok(Mixing::new(Dims::new([n; 3])?, MixingParams::default())?);
        rows.extend(generated::<u8, _>(&format!("mixing {n}"), only, n, || mixing(n))?);
    }
    let n = if quick { 32 } else { 128 };
    let noise = || Ok(Noise::new(Dims::new([n; 3])?, 0));
    rows.extend(generated::<u8, _>(&format!("noise {n}"), only, n, noise)?);
    rows.extend(generated::<u16, _>(&format!("noise {n}"), only, n, noise)?);
    Ok(rows)
}

fn generated<T: Scalar + Into<f64>, S: SlabSource<T, Error = LayersError>>(
    name: &str,
    only: Option<&str>,
    n: u32,
    source: impl Fn() -> Result<S>,
) -> Result<Vec<LayoutRow>> {
    if only.is_some_and(|only| !name.contains(only)) {
        return Ok(Vec::new());
    }
    let dims = Dims::new([n; 3])?;
    let mut samples = vec![T::default(); dims.samples()];
    source()?.read_layers(0, &mut samples)?;
    Measure(name).visit(&Dense { dims, samples, index_to_world: DAffine3::IDENTITY })
}

struct Measure<'a>(&'a str);

impl DenseVisitor for Measure<'_> {
    type Output = Result<Vec<LayoutRow>>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        let Self(name) = self;
        let raw = size_of_val(volume.samples.as_slice()) as u64;
        let mut rows = Vec::new();
        for (edge, has_apron) in CAPS {
            let tally = Tally::of(volume.dims, &volume.samples, edge, has_apron);
            if !has_apron {
                check(name, volume, edge, &tally)?;
            }
            for (node, payload) in NodeKind::ALL.iter().flat_map(|&n| Payload::ALL.map(|p| (n, p))) {
                let (node_bytes, cap_bytes) = (tally.node_bytes(node), tally.cap_bytes(payload));
                rows.push(LayoutRow {
                    volume: name.to_owned(),
                    scalar: T::TYPE.name(),
                    cap_edge: edge,
                    apron: has_apron,
                    node: node.name(),
                    payload: payload.name(),
                    node_bytes,
                    cap_bytes,
                    percent: 100.0 * (node_bytes + cap_bytes) as f64 / raw as f64,
                });
            }
        }
        let paper = PaperOctree::build(volume.dims, &volume.samples).bytes() as f64 / raw as f64;
        print(&rows, 100.0 * paper);
        Ok(rows)
    }
}

/// What exists must be as large as it is counted.
fn check<T: Scalar>(name: &str, volume: &Dense<T>, edge: u32, tally: &Tally) -> Result<()> {
    let (counted, exists) = match edge {
        2 => {
            let paper = PaperOctree::build(volume.dims, &volume.samples);
            (tally.node_bytes(NodeKind::Offsets) + tally.whole_cap_bytes(), paper.bytes())
        }
        4 => {
            let payload = if T::IS_INTEGER { Payload::Range } else { Payload::Raw };
            let bytes = tally.node_bytes(NodeKind::Mask) + tally.cap_bytes(payload);
            (bytes + cap_reach::<T>() as u64, volume.octree()?.structure_bytes())
        }
        _ => return Ok(()),
    };
    ensure!(counted == exists as u64, "{name}, caps of {edge}³: counted {counted} bytes, found {exists}");
    Ok(())
}

fn print(rows: &[LayoutRow], paper: f64) {
    let percent = |edge: u32, apron: bool, node: NodeKind, payload: Payload| {
        let is_it = |r: &&LayoutRow| {
            r.cap_edge == edge && r.apron == apron && r.node == node.name() && r.payload == payload.name()
        };
        rows.iter().find(is_it).map_or(f64::NAN, |r| r.percent)
    };
    let Some(LayoutRow { volume, scalar, .. }) = rows.first() else { return };
    print!("{volume:<20} {scalar:>4}");
    for (edge, apron) in CAPS {
        print!(" |");
        for payload in Payload::ALL {
            print!(" {:>7.2}", percent(edge, apron, NodeKind::Mask, payload));
        }
    }
    print!(" |");
    for node in [NodeKind::Links, NodeKind::Offsets, NodeKind::MaskWithoutValues] {
        print!(" {:>7.2}", percent(4, false, node, Payload::Range));
    }
    println!(" | {paper:>6.2}");
}
