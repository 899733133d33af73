//! Table 1, and what section 5.1 says of sizes and of building.

use std::time::Instant;

use anyhow::Result;
use isoray_benches::knoll2006::PaperOctree;
use isoray_grid::{Branching, BrickedVolume, DenseVolume, GridVolume, Scalar};

use super::{PaperRow, Setting, Step, figure, print, print_titles, row};
use crate::bench::papers::PARKER_BRICKS;
use crate::bench::timer::median;
use crate::catalog::{Dense, DenseVisitor, Entry};

/// % of the samples, of the time steps of `LLNL`; of the fire at step 152; of the head.
const LLNL: [f64; 3] = [8.5, 25.0, 30.0];
const HEPTANE: f64 = 33.0;
const HEAD: f64 = 84.0;
/// Of the last of `LLNL`, if only values in a range count.
const CLAMPED: ([f64; 2], f64) = ([64.0, 127.0], 22.0);
/// Millions of voxels a second on one thread of an Opteron of 2.16 GHz: 8 s for 302³, 45 minutes for 2048² × 1920.
const BUILD: [f64; 2] = [27.5 / 8.0, 8053.0 / 2700.0];
/// Times a build is repeated.
const BUILDS: usize = 3;

struct Size<'a> {
    step: &'a Step,
    /// Only values in it count: others are as good as the nearest of these.
    range: Option<[f64; 2]>,
    percent: f64,
    build: f64,
}

pub(super) fn run<'a>(setting: Setting<'_>, llnl: impl Iterator<Item = &'a Step>) -> Result<Vec<PaperRow>> {
    let head = setting.real("CT head").unwrap_or_else(Entry::fixture);
    let head = Step { scene: "CThead", entry: head };
    let fire = setting.heptane().map(|entry| Step { scene: "HEP 152", entry });
    let size = |step, percent, build| Size { step, range: None, percent, build };
    let mut sizes: Vec<Size<'_>> = fire.iter().map(|step| size(step, HEPTANE, BUILD[0])).collect();
    sizes.extend(llnl.zip(LLNL).map(|(step, percent)| size(step, percent, BUILD[1])));
    if let Some(last) = sizes.last().map(|last| last.step) {
        sizes.push(Size { range: Some(CLAMPED.0), ..size(last, CLAMPED.1, f64::NAN) });
    }
    sizes.push(size(&head, HEAD, f64::NAN));
    print_titles("values", &["whole file, %", "nodes of 2006, %", "build, Mvoxels/s, 1 thread"]);
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let mut rows = Vec::new();
    for size in sizes.iter().filter(|size| setting.has(&size.step.entry)) {
        rows.push(one.install(|| size.step.entry.visit(size))??);
    }
    print_titles("structure over the array", &["more than the samples, %"]);
    if setting.has(&head.entry) {
        rows.extend(head.entry.visit(Overhead(&head))??);
    }
    Ok(rows)
}

impl DenseVisitor for &Size<'_> {
    type Output = Result<PaperRow>;

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
        let percent = |bytes: usize| 100.0 * bytes as f64 / octree.raw_bytes() as f64;
        let paper = PaperOctree::build(volume.dims, &volume.samples);
        let figures = vec![
            figure("whole file, %", self.percent, percent(octree.file_bytes())),
            figure("nodes of 2006, %", self.percent, percent(paper.bytes())),
            figure("build, Mvoxels/s", self.build, volume.dims.samples() as f64 / 1e6 / median(seconds)),
        ];
        let variant = self.range.map_or("full".to_owned(), |[low, high]| format!("{low} to {high}"));
        let row = PaperRow { variant, figures, ..row("2006, Table 1", self.step, "", 0) };
        print(&row);
        Ok(row)
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
