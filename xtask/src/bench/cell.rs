//! First-root finders: time against error.

use std::hint::black_box;
use std::path::Path;

use anyhow::{Result, ensure};
use isoray_benches::cells::{Pair, grazing, met_by_rays, packed, random};
use isoray_benches::kernels::{Answer, Roots};
use isoray_benches::views::View;
use isoray_cell::root::{
    BernsteinItp, BernsteinNewton, BernsteinSeries, FirstRoot, HermiteNewton, Neubauer, Schwarze, SplitNewton,
};
use isoray_cell::{EXCURSION_UNITS, ROOT_STEP, Real, Segment};
use isoray_grid::Scalar;
use isoray_oracle::{CellCase, CellVerdict};
use isoray_trace::Tracer;
use plotters::prelude::*;
use serde::Serialize;
use wide::{f32x4, f32x8, f32x16};

use super::chart;
use super::timer::interleave;
use crate::catalog::{Dense, DenseVisitor, Entry};

/// Pairs of a set, and how many of them are timed: those fit the second-level cache, as they do where rays are traced, and are yet too
/// many for branches to be learnt by heart.
const PAIRS: usize = 1 << 16;
const TIMED: usize = 1 << 13;
/// Pairs among which those are looked for that can be made to graze: few have an extremum.
const MOST_MET: usize = 1 << 20;
/// Pairs that stay together: as many as the most lanes.
const GROUP: usize = f32x16::LANES;
/// Roots further off than this, in cells, are plainly wrong.
const OFF: f64 = 1e-3;

/// One method on one set of pairs.
#[derive(Debug, Serialize)]
pub(crate) struct CellRow {
    pub(crate) set: String,
    pub(crate) method: &'static str,
    pub(crate) is_default: bool,
    /// Nanoseconds a pair, one at a time and in 4, 8 and 16 lanes.
    pub(crate) ns: [f64; 4],
    /// Of found roots, in units of the last place of 1.
    pub(crate) mean_error_ulps: f64,
    pub(crate) max_error_ulps: f64,
    /// Of found roots, those more than 10⁻³ of a cell off.
    pub(crate) off_share: f64,
    pub(crate) missed_per_million: f64,
    pub(crate) false_per_million: f64,
}

/// Pairs with a name.
pub(crate) struct Set {
    name: String,
    pairs: Vec<Pair>,
}

/// Those of a volume's close view, and the same made to graze.
pub(crate) struct Collect<'a>(pub(crate) &'a Entry);

impl DenseVisitor for Collect<'_> {
    type Output = Result<Vec<Set>>;

    fn visit<T: Scalar + Into<f64>>(self, volume: &Dense<T>) -> Self::Output {
        let octree = volume.octree()?;
        let structure = octree.view();
        let view = View::close(volume.dims, 512, 512);
        let isovalue = self.0.isovalues[0];
        let pairs = met_by_rays(&mut Tracer::new(&structure), &view, isovalue, MOST_MET);
        sets(&self.0.name, &pairs, 1)
    }
}

/// Random cells, and the same made to graze.
pub(crate) fn random_sets() -> Result<Vec<Set>> {
    sets("random", &random(PAIRS, 1), 2)
}

/// Some of the pairs, and some of those made to graze, by `seed`.
fn sets(name: &str, pairs: &[Pair], seed: u64) -> Result<Vec<Set>> {
    let set = |name: String, pairs: &[Pair]| {
        ensure!(pairs.len() >= GROUP, "{name}: {} cells are too few to measure", pairs.len());
        Ok(Set { name, pairs: spread(pairs, PAIRS) })
    };
    Ok(vec![set(name.to_owned(), pairs)?, set(format!("{name}, grazing"), &grazing(pairs, seed))?])
}

/// About `count` pairs from all over the picture; neighbours stay together, as lanes would be filled.
fn spread(pairs: &[Pair], count: usize) -> Vec<Pair> {
    let every = (pairs.len() / count).max(1);
    pairs.chunks_exact(GROUP).step_by(every).flatten().copied().collect()
}

/// A first-root finder, by what is done with it.
struct Method {
    errors: fn(&Set) -> CellRow,
    /// One pair at a time and in 4, 8 and 16 lanes.
    frames: [fn(&Timed); 4],
    /// What these find. Apart from them: a sum over roots takes as long as some of them.
    found: fn(&[Pair]) -> [Answer; 4],
}

/// The default first, the closed form last.
const METHODS: [Method; 7] = [
    Method::of::<BernsteinSeries>(),
    Method::of::<BernsteinNewton>(),
    Method::of::<BernsteinItp>(),
    Method::of::<HermiteNewton>(),
    Method::of::<SplitNewton>(),
    Method::of::<Neubauer>(),
    Method::of::<Schwarze>(),
];

impl Method {
    const fn of<F: FirstRoot>() -> Self {
        Self {
            errors: errors::<F>,
            frames: [
                |timed| frame::<F, _>(&timed.one),
                |timed| frame::<F, _>(&timed.four),
                |timed| frame::<F, _>(&timed.eight),
                |timed| frame::<F, _>(&timed.sixteen),
            ],
            found: |pairs| {
                [
                    Roots::<f32>::of(pairs).find_by::<F>(),
                    Roots::<f32x4>::of(pairs).find_by::<F>(),
                    Roots::<f32x8>::of(pairs).find_by::<F>(),
                    Roots::<f32x16>::of(pairs).find_by::<F>(),
                ]
            },
        }
    }
}

/// Pairs in lanes.
type Packed<R> = Vec<([R; 8], Segment<R>)>;

/// The same pairs at every width.
struct Timed {
    one: Packed<f32>,
    four: Packed<f32x4>,
    eight: Packed<f32x8>,
    sixteen: Packed<f32x16>,
}

/// Runs every method on a set.
pub(crate) fn measure(set: &Set, repeat: usize) -> Result<Vec<CellRow>> {
    let mut rows: Vec<CellRow> = METHODS.iter().map(|method| (method.errors)(set)).collect();
    let pairs = &spread(&set.pairs, TIMED);
    let timed =
        Timed { one: packed(pairs), four: packed(pairs), eight: packed(pairs), sixteen: packed(pairs) };
    let mut frames: Vec<_> =
        METHODS.iter().flat_map(|method| &method.frames).map(|frame| || frame(&timed)).collect();
    let mut variants: Vec<&mut dyn FnMut()> = frames.iter_mut().map(|frame| frame as _).collect();
    let times = interleave(repeat, &mut variants);
    for ((row, times), method) in rows.iter_mut().zip(times.chunks_exact(4)).zip(&METHODS) {
        // Lanes do what one does, bit for bit.
        let found = (method.found)(pairs);
        ensure!(
            found.iter().all(|lanes| *lanes == found[0]),
            "{}, {}: expected the same roots one at a time and in 4, 8 and 16 lanes, found {found:?}",
            set.name,
            row.method
        );
        row.ns = std::array::from_fn(|n| times[n] * 1e9 / (FRAMES * pairs.len()) as f64);
        println!("{}", line(row));
    }
    let (default, closed_form) = (&rows[0], &rows[rows.len() - 1]);
    let [one, four, eight, sixteen] = default.ns;
    println!(
        "{:<28} 4, 8 and 16 lanes {:.1}, {:.1} and {:.1} times as fast as one; one {:.1} times the closed form\n",
        set.name,
        one / four,
        one / eight,
        one / sixteen,
        closed_form.ns[0] / one
    );
    ensure!(
        default.missed_per_million == 0.0 && default.false_per_million == 0.0,
        "{}: the default misses {} and invents {} roots in a million",
        set.name,
        default.missed_per_million,
        default.false_per_million
    );
    Ok(rows)
}

/// Times that the pairs are gone through, for a time long enough to measure.
const FRAMES: usize = 8;

fn frame<F: FirstRoot, R: Real>(packed: &Packed<R>) {
    for _ in 0..FRAMES {
        for (corners, segment) in packed {
            black_box(F::first_root(corners, segment));
        }
    }
}

/// The scalar form against the oracle.
fn errors<F: FirstRoot>(set: &Set) -> CellRow {
    let (mut found, mut missed, mut invented, mut off) = (0u64, 0u64, 0u64, 0u64);
    let (mut sum, mut most) = (0.0, 0.0_f64);
    for Pair { corners, segment } in &set.pairs {
        let case = CellCase { samples: *corners, isovalue: 0.0, entry: segment.entry, exit: segment.exit };
        let root = F::first_root(corners, segment).get();
        match case.judge(root, EXCURSION_UNITS, 2.0 * ROOT_STEP) {
            CellVerdict::Found(error) | CellVerdict::Misplaced(error) => {
                found += 1;
                sum += error;
                most = most.max(error);
                off += u64::from(error > OFF);
            }
            CellVerdict::Missed => missed += 1,
            CellVerdict::False => invented += 1,
            CellVerdict::Nothing | CellVerdict::Undecided => {}
        }
    }
    let in_ulps = |error: f64| error / f64::from(f32::EPSILON);
    let per_million = |n: u64| n as f64 * 1e6 / set.pairs.len() as f64;
    CellRow {
        set: set.name.clone(),
        method: F::NAME,
        is_default: F::NAME == BernsteinSeries::NAME,
        ns: [f64::NAN; 4],
        mean_error_ulps: in_ulps(sum / found.max(1) as f64),
        max_error_ulps: in_ulps(most),
        off_share: off as f64 / found.max(1) as f64,
        missed_per_million: per_million(missed),
        false_per_million: per_million(invented),
    }
}

/// Titles of the columns.
pub(crate) const HEADER: &str = "First root in a cell: ns a pair, one at a time and in lanes; errors in ulp of 1.\nset                          method                                                       ns   x4   x8  x16 | mean err.   max err.  off % | missed/M  false/M";

fn line(row: &CellRow) -> String {
    let [one, four, eight, sixteen] = row.ns;
    format!(
        "{:<28} {:<56} {one:>6.1} {four:>4.1} {eight:>4.1} {sixteen:>4.1} | {:>9.2} {:>10.0} {:>6.2} | {:>8.0} {:>8.0}",
        row.set,
        row.method,
        row.mean_error_ulps,
        row.max_error_ulps,
        100.0 * row.off_share,
        row.missed_per_million,
        row.false_per_million
    )
}

/// The rows as a table for the documentation.
pub(crate) fn markdown(rows: &[CellRow], machine: &str) -> String {
    let mut text = format!(
        "Measured on {machine} by `cargo xtask bench cell --docs`; ns a pair, errors in units of the last place of 1.\n\n\
         | pairs | method | scalar | 4 lanes | 8 lanes | 16 lanes | mean error | max. error | > 10⁻³ off | missed, in a million | false |\n\
         |---|---|---|---|---|---|---|---|---|---|---|\n"
    );
    for row in rows {
        let [one, four, eight, sixteen] = row.ns;
        let name = if row.is_default { format!("**{}**", row.method) } else { row.method.to_owned() };
        text += &format!(
            "| {} | {name} | {one:.1} | {four:.1} | {eight:.1} | {sixteen:.1} | {:.2} | {:.0} | {:.2} % | {:.0} | {:.0} |\n",
            row.set,
            row.mean_error_ulps,
            row.max_error_ulps,
            100.0 * row.off_share,
            row.missed_per_million,
            row.false_per_million
        );
    }
    text
}

/// Time against mean error, every method at one lane and at 16, for the rows of one set.
pub(crate) fn chart(rows: &[&CellRow], file: &Path) -> Result<()> {
    let set = rows.first().map_or("", |row| &row.set);
    let times = rows.iter().flat_map(|row| [row.ns[0], row.ns[3]]);
    let (fastest, slowest) = times.fold((f64::MAX, 0.0_f64), |(a, b), t| (a.min(t), b.max(t)));
    let errors = rows.iter().map(|row| row.mean_error_ulps);
    let (least, most) = errors.fold((f64::MAX, 0.0_f64), |(a, b), e| (a.min(e), b.max(e)));
    chart::save(file, |area| {
        let mut chart = ChartBuilder::on(area)
            .caption(
                format!("First root in cells of {set}: one pair at a time (circles), 16 lanes (crosses)"),
                ("sans-serif", 18),
            )
            .margin(12)
            .x_label_area_size(44)
            .y_label_area_size(70)
            .build_cartesian_2d(
                (0.7 * fastest..1.5 * slowest).log_scale(),
                // Room for the legend above.
                (0.5 * least..1000.0 * most).log_scale(),
            )?;
        chart.configure_mesh().x_desc("ns a pair").y_desc("mean error, ulp of 1").draw()?;
        for (n, row) in rows.iter().enumerate() {
            let colour = Palette99::pick(n).filled();
            let name =
                if row.is_default { format!("{} (default)", row.method) } else { row.method.to_owned() };
            let [one, .., sixteen] = row.ns;
            chart
                .draw_series([Circle::new((one, row.mean_error_ulps), 6, colour)])?
                .label(name)
                .legend(move |(x, y)| Circle::new((x + 6, y), 5, colour));
            chart.draw_series([Cross::new((sixteen, row.mean_error_ulps), 6, colour)])?;
        }
        chart::legend(&mut chart)
    })
}
