//! Finding samples in an octree, and stepping from one to its neighbour: the ways of the papers beside ours, all over the same structure.
//!
//! What is timed ends with the sample itself, which takes the same in all of them; the first line of each group is that alone, of blocks that are known.
//!
//! Ours are [`OctreeView::locate`] and [`Path::neighbor`], by which samples are found anywhere and bricks of volumes are filled. Rays to isosurfaces mostly take neither: what
//! they found out about cubes and blocks is remembered, and a step to the next cell is a bit of a word ([`single`](super::single) has the look-ups that are left of a ray).
//! Their times are of these two; the nodes and levels in the same rows are counted in a copy, [`Method::Jump`], of which it is tested that it ends in the same blocks.

use std::hint::black_box;

use anyhow::{Result, ensure};
use isoray_benches::hashing::lookups::{by, located, neighbors, stepped, sum};
use isoray_benches::hashing::queries::{Queries, Step};
use isoray_benches::hashing::{Count, Method, Tree, sample_of};
use isoray_grid::Scalar;
#[cfg(doc)]
use isoray_octree::Path;
use isoray_octree::{Block, OctreeView};
use serde::Serialize;

use super::timer::interleave;
use crate::catalog::{Dense, DenseVisitor, Entry};

/// One way to find samples.
#[derive(Debug, Serialize)]
pub(crate) struct HashingRow {
    volume: String,
    /// A point from anywhere, or a step to a neighbour.
    what: &'static str,
    /// Where points are.
    points: &'static str,
    method: &'static str,
    ns: f64,
    /// Nodes that are read, for each.
    nodes: f64,
    /// Levels that are tried on the way up, for each.
    levels: f64,
    /// Time over that of ours.
    times_ours: f64,
}

/// Titles of the columns.
const HEADER: &str = "\nA sample anywhere, and a neighbour's, in the same octree: ns, nodes read, levels tried on the way up; time over ours.
volume               what            points      method                    |     ns   nodes  levels  × ours";

/// Points, and steps, that are looked up in a run, and in a short one; and how often in one timed run.
const POINTS: [usize; 2] = [1 << 15, 1 << 12];
const TIMES: usize = 4;

pub(crate) fn run(quick: bool, entries: &[Entry], repeat: usize) -> Result<Vec<HashingRow>> {
    println!("{HEADER}");
    let mut rows = Vec::new();
    for entry in entries {
        rows.extend(entry.visit(Hashing { entry, count: POINTS[usize::from(quick)], repeat })??);
    }
    Ok(rows)
}

struct Hashing<'a> {
    entry: &'a Entry,
    count: usize,
    repeat: usize,
}

/// A method, what it is called, and the counts of all its look-ups.
type Counted = (&'static str, Count);

impl DenseVisitor for Hashing<'_> {
    type Output = Result<Vec<HashingRow>>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        let octree = volume.octree()?;
        let view = octree.view();
        let tree = Tree::new(view);
        let mut rows = Vec::new();
        for (points, queries) in [
            ("random", Queries::random(&tree, volume.dims, self.count)),
            ("along rays", Queries::along_rays(&tree, volume.dims, self.count)),
        ] {
            ensure!(
                !queries.points.is_empty() && !queries.steps.is_empty(),
                "{}, {points}: nothing to look up",
                self.entry.name
            );
            let expected = |p: [u32; 3]| volume.samples[volume.dims.linear(p)];
            rows.extend(self.points(points, &view, &tree, &queries, expected)?);
            rows.extend(self.steps(points, &view, &tree, &queries, expected)?);
        }
        Ok(rows)
    }
}

impl Hashing<'_> {
    fn points<T: Scalar>(
        &self,
        points: &'static str,
        view: &OctreeView<'_, T>,
        tree: &Tree<'_, T>,
        queries: &Queries<'_, T>,
        expected: impl Fn([u32; 3]) -> T,
    ) -> Result<Vec<HashingRow>> {
        let at = &queries.points[..];
        let blocks: Vec<Block<'_, T>> = at.iter().map(|&p| view.locate(p)).collect();
        let known = || sum(at.iter().zip(&blocks).map(|(&p, block)| sample_of(block, p)));
        let [top_down, codes, masks] = METHODS.map(|(method, _)| move || by(tree, method, at));
        let [inlined, ours] = [true, false].map(|is_inlined| move || located(view, at, is_inlined));
        let mut counts = vec![("the sample alone", Count::default())];
        for (method, name) in
            METHODS.into_iter().chain([(Method::Jump, "ours, inlined"), (Method::Jump, "ours")])
        {
            let mut count = Count::default();
            for &p in at {
                let found = tree.sample(method, p, &mut count);
                ensure!(found.same_bits(expected(p)), "{name}: found {found:?} at {p:?}");
            }
            counts.push((name, count));
        }
        let runs: [&dyn Fn() -> u64; 6] = [&known, &top_down, &codes, &masks, &inlined, &ours];
        let answer = sum(at.iter().map(|&p| expected(p)));
        self.rows(["point", points], at.len(), &counts, &runs, answer)
    }

    fn steps<T: Scalar>(
        &self,
        points: &'static str,
        view: &OctreeView<'_, T>,
        tree: &Tree<'_, T>,
        queries: &Queries<'_, T>,
        expected: impl Fn([u32; 3]) -> T,
    ) -> Result<Vec<HashingRow>> {
        let steps = &queries.steps[..];
        let blocks: Vec<Block<'_, T>> = steps.iter().map(|step| view.locate(step.to)).collect();
        let known = || sum(steps.iter().zip(&blocks).map(|(step, block)| sample_of(block, step.to)));
        let [top_down, codes, masks] = METHODS.map(|(method, _)| move || stepped(tree, method, queries));
        let ours = || neighbors(view, queries);
        let mut counts = vec![("the sample alone", Count::default())];
        for (method, name) in METHODS.into_iter().chain([(Method::Jump, "ours")]) {
            let mut count = Count::default();
            for &Step { trail, from, to } in steps {
                let found = tree.neighbor(method, &queries.trails[trail as usize], [from, to], &mut count);
                ensure!(found.same_bits(expected(to)), "{name}: found {found:?} at {to:?} from {from:?}");
            }
            counts.push((name, count));
        }
        let runs: [&dyn Fn() -> u64; 5] = [&known, &top_down, &codes, &masks, &ours];
        let answer = sum(steps.iter().map(|step| expected(step.to)));
        self.rows(["neighbour", points], steps.len(), &counts, &runs, answer)
    }

    /// Times what has been counted; the last are ours.
    fn rows(
        &self,
        [what, points]: [&'static str; 2],
        count: usize,
        counts: &[Counted],
        runs: &[&dyn Fn() -> u64],
        answer: u64,
    ) -> Result<Vec<HashingRow>> {
        let mut found = vec![Vec::new(); runs.len()];
        let mut timed: Vec<_> = runs
            .iter()
            .zip(&mut found)
            .map(|(run, found)| move || found.extend((0..TIMES).map(|_| black_box(run)())))
            .collect();
        let mut variants: Vec<&mut dyn FnMut()> = timed.iter_mut().map(|run| run as _).collect();
        let seconds = interleave(self.repeat, &mut variants);
        drop(timed);
        for ((name, _), found) in counts.iter().zip(&found) {
            ensure!(
                found.iter().all(|&sum| sum == answer),
                "{what}, {points}, {name}: other samples when timed"
            );
        }
        let each = |seconds: f64| seconds * 1e9 / (TIMES * count) as f64;
        let ours = seconds.last().copied().unwrap_or(f64::NAN);
        let rows = counts.iter().zip(seconds).map(|(&(method, counted), seconds)| {
            let row = HashingRow {
                volume: self.entry.name.clone(),
                what,
                points,
                method,
                ns: each(seconds),
                nodes: counted.nodes as f64 / count as f64,
                levels: counted.levels as f64 / count as f64,
                times_ours: seconds / ours,
            };
            println!(
                "{:<20} {what:<15} {points:<11} {method:<25} | {:>6.1} {:>7.2} {:>7.2} {:>7.2}",
                row.volume, row.ns, row.nodes, row.levels, row.times_ours
            );
            row
        });
        Ok(rows.collect())
    }
}

/// The ways of the papers.
const METHODS: [(Method, &str); 3] = [
    (Method::TopDown, "top-down, by centres"),
    (Method::FriskenPerry, "Frisken-Perry 2002"),
    (Method::Knoll2006, "Knoll 2006, B.1 and B.2"),
];
