//! Table 1 of 2006, and of 2009, and what section 5.1 says of sizes and of building.

use std::time::Instant;

use anyhow::Result;
use isoray_benches::knoll2006::PaperOctree;
use isoray_grid::{Branching, BrickedVolume, DenseVolume, GridVolume, Scalar};

use super::{FIRE, PaperRow, Setting, Step, figure, print, print_titles, row};
use crate::bench::papers::PARKER_BRICKS;
use crate::bench::timer::median;
use crate::catalog::{Dense, DenseVisitor, Entry};

/// Table 1 of 2009 is that of 2006 with two lines more.
const BOTH: &[&str] = &["2006, Table 1", "2009, Table 1"];
const LATER: &[&str] = &["2009, Table 1"];
/// % of the samples, of the time steps of `LLNL`; of the fire at steps 70 and 152, and of all its steps together; of the head.
const LLNL: [f64; 3] = [8.5, 25.0, 30.0];
const HEPTANE: [f64; 3] = [14.0, 33.0, 16.0];
const HEAD: f64 = 84.0;
/// Of the last of `LLNL`, if only values in a range count.
const CLAMPED: ([f64; 2], f64) = ([64.0, 127.0], 22.0);
/// Of the femur, and if only its bone counts, values from 100 to 163.
const FEMUR: [f64; 2] = [101.0, 5.5];
/// The last step of the fire, and some of its 153 in place of all.
const LAST_STEP: f64 = 152.0;
const SERIES: [f64; 7] = [0.0, 25.0, 50.0, 75.0, 100.0, 125.0, 150.0];
/// Millions of voxels a second on one thread of an Opteron of 2.16 GHz: 8 s for 302³, 45 minutes for 2048² × 1920.
const BUILD: [f64; 2] = [27.5 / 8.0, 8053.0 / 2700.0];
/// Times a build is repeated.
const BUILDS: usize = 3;

/// A line of the tables.
struct Size {
    places: &'static [&'static str],
    step: Step,
    /// Other steps that are counted with it.
    others: Vec<Entry>,
    /// What stands in for them all.
    volume: String,
    /// Only values in it count: others are as good as the nearest of these.
    range: Option<[f64; 2]>,
    variant: String,
    percent: f64,
    build: f64,
}

pub(super) fn run<'a>(
    setting: Setting<'_>,
    llnl: impl Iterator<Item = &'a Step>,
    fire_edge: u32,
) -> Result<Vec<PaperRow>> {
    let mut sizes = Vec::from(fire(setting, fire_edge));
    sizes.extend(instability(llnl));
    let head = setting.real("CT head").unwrap_or_else(Entry::fixture);
    sizes.push(Size::full("CThead", head.clone(), HEAD, f64::NAN));
    sizes.extend(femur(setting));
    print_titles("values", &["whole file, %", "nodes of 2006, %", "build, Mvoxels/s, 1 thread"]);
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let mut rows = Vec::new();
    for size in sizes.iter().filter(|size| size.entries().all(|entry| setting.has(entry))) {
        let measured = one.install(|| size.measured())?;
        rows.extend(size.rows(&measured));
    }
    print_titles("structure over the array", &["more than the samples, %"]);
    if setting.has(&head) {
        let head = Step { scene: "CThead", entry: head };
        rows.extend(head.entry.visit(Overhead(&head))??);
    }
    Ok(rows)
}

/// Of the fire the last step is there; mixing layers stand in for the others, and for that too where it is not.
fn fire(setting: Setting<'_>, edge: u32) -> [Size; 3] {
    let mixing = |step: f64| Entry::mixing(edge, step / LAST_STEP, FIRE);
    let last = setting.heptane().unwrap_or_else(|| mixing(LAST_STEP));
    let [early, late, all] = HEPTANE;
    let [first, others @ ..] = SERIES.map(mixing);
    [
        Size::full("HEP 70", mixing(70.0), early, BUILD[0]),
        Size::full("HEP 152", last, late, BUILD[0]),
        Size {
            others: Vec::from(others),
            volume: format!("mixing {edge}, {} steps", SERIES.len()),
            ..Size::full("HEP 0-152", first, all, f64::NAN)
        },
    ]
}

/// All values of each step, and of the last those of a range.
fn instability<'a>(llnl: impl Iterator<Item = &'a Step>) -> Vec<Size> {
    let full = |(step, percent): (&Step, f64)| Size::full(step.scene, step.entry.clone(), percent, BUILD[1]);
    let mut sizes: Vec<Size> = llnl.zip(LLNL).map(full).collect();
    let ([low, high], percent) = CLAMPED;
    if let Some(Size { step, .. }) = sizes.last() {
        let last = Size {
            range: Some(CLAMPED.0),
            variant: format!("{low} to {high}"),
            ..Size::full(step.scene, step.entry.clone(), percent, f64::NAN)
        };
        sizes.push(last);
    }
    sizes
}

/// In place of the femur, whole and bone alone, a head: its bone is what the last of its isovalues is the surface of.
fn femur(setting: Setting<'_>) -> [Size; 2] {
    let entry = setting.real("Visible Human head").unwrap_or_else(Entry::fixture);
    let bone = f64::from(entry.isovalues[entry.isovalues.len() - 1]);
    let [full, clamped] = FEMUR;
    let size = |percent| Size { places: LATER, ..Size::full("femur", entry.clone(), percent, f64::NAN) };
    [
        size(full),
        Size {
            range: Some([bone, f64::INFINITY]),
            variant: format!("100 to 163; ours: {bone} and more"),
            ..size(clamped)
        },
    ]
}

impl Size {
    /// With all values of one volume.
    fn full(scene: &'static str, entry: Entry, percent: f64, build: f64) -> Self {
        Self {
            places: BOTH,
            volume: entry.name.clone(),
            step: Step { scene, entry },
            others: Vec::new(),
            range: None,
            variant: "full".to_owned(),
            percent,
            build,
        }
    }

    fn entries(&self) -> impl Iterator<Item = &Entry> {
        std::iter::once(&self.step.entry).chain(&self.others)
    }

    fn measured(&self) -> Result<Measured> {
        let mut all = Measured::default();
        for entry in self.entries() {
            let Measured { voxels, raw, file, nodes, seconds } =
                entry.visit(Build { range: self.range })??;
            all.voxels += voxels;
            all.raw += raw;
            all.file += file;
            all.nodes += nodes;
            all.seconds += seconds;
        }
        Ok(all)
    }

    /// The same under every place where it stands.
    fn rows(&self, measured: &Measured) -> Vec<PaperRow> {
        let percent = |bytes: usize| 100.0 * bytes as f64 / measured.raw as f64;
        let rows = self.places.iter().map(|&place| PaperRow {
            volume: self.volume.clone(),
            variant: self.variant.clone(),
            figures: vec![
                figure("whole file, %", self.percent, percent(measured.file)),
                figure("nodes of 2006, %", self.percent, percent(measured.nodes)),
                figure("build, Mvoxels/s", self.build, measured.voxels as f64 / 1e6 / measured.seconds),
            ],
            ..row(place, &self.step, "", 0)
        });
        let rows: Vec<PaperRow> = rows.collect();
        rows.iter().for_each(print);
        rows
    }
}

/// Bytes, and the time of building.
#[derive(Default)]
struct Measured {
    voxels: usize,
    /// The samples alone.
    raw: usize,
    file: usize,
    nodes: usize,
    seconds: f64,
}

struct Build {
    range: Option<[f64; 2]>,
}

impl DenseVisitor for Build {
    type Output = Result<Measured>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        let clamped = self.range.map(|range| clamped(volume, range));
        let volume = clamped.as_ref().unwrap_or(volume);
        let mut octree = volume.octree()?;
        let mut seconds = Vec::new();
        for _ in 0..BUILDS {
            let begin = Instant::now();
            octree = volume.octree()?;
            seconds.push(begin.elapsed().as_secs_f64());
        }
        Ok(Measured {
            voxels: volume.dims.samples(),
            raw: octree.raw_bytes(),
            file: octree.file_bytes(),
            nodes: PaperOctree::build(volume.dims, &volume.samples).bytes(),
            seconds: median(seconds),
        })
    }
}

/// With values outside of a range moved to the nearest in it that is there.
fn clamped<T: Scalar + Into<f64>>(volume: &Dense<T>, [low, high]: [f64; 2]) -> Dense<T> {
    let inside = volume.samples.iter().copied().filter(|&s| (low..=high).contains(&s.into()));
    let ends = inside.fold(None, |ends: Option<[T; 2]>, s| {
        let [least, most] = ends.unwrap_or([s; 2]);
        Some([if s < least { s } else { least }, if s > most { s } else { most }])
    });
    let clamp = |s: T| match ends {
        Some([least, _]) if s < least => least,
        Some([_, most]) if s > most => most,
        _ => s,
    };
    let samples = volume.samples.iter().map(|&s| clamp(s)).collect();
    Dense { samples, ..*volume }
}

/// What bricks and macrocells add to an array.
struct Overhead<'a>(&'a Step);

impl DenseVisitor for Overhead<'_> {
    type Output = Result<Vec<PaperRow>>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        let mut dense = DenseVolume::new(volume.dims, &volume.samples)?;
        let raw = size_of_val(&volume.samples[..]) as f64;
        let bricks = BrickedVolume::new(&mut dense, PARKER_BRICKS)?;
        let three = GridVolume::new(dense);
        let five = GridVolume::with_branching(dense, &Branching::new(&[4, 2, 2, 2, 2])?);
        let measured = [
            ("bricks", 15.0, bricks.bytes() as f64 - raw),
            ("macrocells of five levels", 4.5, five.macrocells().bytes() as f64),
            // Of 1998, section 2.
            ("macrocells of three levels", 0.5, three.macrocells().bytes() as f64),
        ];
        let of = |(variant, paper, bytes): (&str, f64, f64)| {
            let figures = vec![figure("more than the samples, %", paper, 100.0 * bytes / raw)];
            let row = PaperRow { variant: variant.to_owned(), figures, ..row("2006, 5.1", self.0, "", 0) };
            print(&row);
            row
        };
        Ok(measured.into_iter().map(of).collect())
    }
}
