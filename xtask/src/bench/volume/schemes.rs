//! The schemes that are compared.

use anyhow::Result;
use isoray_preint::{
    Bounded, CubicPieces, Cuts, Entry, ExactDepth, Integrate, IntegratePiece, Lighting, LinearPieces,
    Linearised, PreintegrationTable, Radiance, Segments, TableAxes, TransferFunction,
};

/// Any scheme.
pub(crate) struct Scheme {
    pub(crate) name: String,
    /// What it belongs to, in a chart.
    pub(crate) family: &'static str,
    /// Its bound, if it has one.
    pub(crate) epsilon: Option<f64>,
    inner: Box<dyn Integrate>,
}

impl Integrate for Scheme {
    fn integrate(&self, segments: &Segments, lighting: Option<&Lighting>, into: &mut Radiance) {
        self.inner.integrate(segments, lighting, into);
    }
}

/// Bounds tried.
const EPSILONS: [f64; 10] =
    [1.0 / 4.0, 1.0 / 32.0, 1.0 / 64.0, 1.0 / 128.0, 1.0 / 255.0, 1.0 / 510.0, 1e-3, 3e-4, 1e-4, 1e-5];

/// The ones that [`all`] has in a short run.
const QUICK: [&str; 10] = [
    "bounded 1/510",
    "fixed 1, linear",
    "fixed 2, linear",
    "adaptive, linear",
    "adaptive, f32 table 128²×32",
    "adaptive, f32 table 256²×32",
    "adaptive, u16 table 256²×32",
    "adaptive, cubic",
    "adaptive, cubic, ends at 1e-1",
    "adaptive, cubic, ends at 1e-4",
];

/// The family of schemes that differ in their tables only, and the scheme that does the same without one.
pub(super) const TABLES: &str = "adaptive, table";
pub(super) const WITHOUT_TABLE: &str = "adaptive, linear";

/// Transmittance at which rays of schemes without a bound end.
const TERMINATE: f64 = 1e-3;

pub(crate) fn bounded(transfer: &TransferFunction, epsilon: f64, brightest: f32) -> Scheme {
    let reciprocal = 1.0 / epsilon;
    let is_whole = epsilon > 1e-3 && (reciprocal - reciprocal.round()).abs() < 1e-6;
    let name = if is_whole { format!("bounded 1/{reciprocal:.0}") } else { format!("bounded {epsilon:.0e}") };
    let inner = Box::new(Bounded::new(transfer, epsilon, brightest));
    Scheme { name, family: "bounded", epsilon: Some(epsilon), inner }
}

fn linearised<P: IntegratePiece + 'static>(
    cuts: Cuts,
    pieces: P,
    what: &str,
    family: &'static str,
) -> Scheme {
    let name = match cuts {
        Cuts::Fixed(n) => format!("fixed {n}, {what}"),
        Cuts::Adaptive { inflection: false, .. } => format!("adaptive, {what}"),
        Cuts::Adaptive { inflection: true, .. } => format!("adaptive with inflection, {what}"),
    };
    let inner = Box::new(Linearised { cuts, pieces, terminate: TERMINATE });
    Scheme { name, family, epsilon: None, inner }
}

/// So many pieces a cell; one is the cheapest there is.
pub(crate) fn fixed(transfer: &TransferFunction, pieces: u32) -> Scheme {
    linearised(Cuts::Fixed(pieces), LinearPieces::new(transfer), "linear", "fixed, linear")
}

/// The split of the paper, with rays that end where so much is left to pass.
fn ending(transfer: &TransferFunction, terminate: f64) -> Scheme {
    let inner = Box::new(Linearised { cuts: ADAPTIVE, pieces: CubicPieces::new(transfer), terminate });
    let name = format!("adaptive, cubic, ends at {terminate:.0e}");
    Scheme { name, family: "adaptive, cubic, ends at 10⁻¹ to 10⁻⁶", epsilon: None, inner }
}

/// The split of the paper.
const ADAPTIVE: Cuts = Cuts::Adaptive { inflection: false, shading: true };

/// All that are compared, for pieces of up to `longest` and values in `range`.
pub(crate) fn all(
    transfer: &TransferFunction,
    brightest: f32,
    range: [f32; 2],
    longest: f32,
    quick: bool,
) -> Result<Vec<Scheme>> {
    let adaptive = |inflection| Cuts::Adaptive { inflection, shading: true };
    let mut all: Vec<Scheme> = EPSILONS.map(|e| bounded(transfer, e, brightest)).into();
    for n in [1, 2, 3, 4, 5, 6, 7, 8, 16, 100] {
        all.push(fixed(transfer, n));
    }
    for n in [1, 2, 4, 8] {
        all.push(linearised(Cuts::Fixed(n), CubicPieces::new(transfer), "cubic", "fixed, cubic"));
    }
    for inflection in [false, true] {
        all.push(linearised(adaptive(inflection), LinearPieces::new(transfer), "linear", "adaptive, linear"));
        all.push(linearised(adaptive(inflection), CubicPieces::new(transfer), "cubic", "adaptive, cubic"));
    }
    all.extend([1e-1, 1e-2, 1e-4, 1e-6].map(|terminate| ending(transfer, terminate)));
    for [values, lengths] in [[64, 16], [128, 32], [256, 32], [256, 64]] {
        let axes = TableAxes { values, lengths, ..TableAxes::new(range, longest) };
        with_table::<f32>(
            &mut all,
            transfer,
            axes,
            &format!("f32 table {values}²×{lengths}"),
            values == 256 && lengths == 32,
        )?;
        if [values, lengths] == [256, 32] {
            with_table::<u16>(&mut all, transfer, axes, "u16 table 256²×32", true)?;
        }
    }
    if quick {
        all.retain(|s| QUICK.contains(&s.name.as_str()));
    }
    Ok(all)
}

fn with_table<E: Entry + Send + Sync + 'static>(
    all: &mut Vec<Scheme>,
    transfer: &TransferFunction,
    axes: TableAxes,
    what: &str,
    with_fixed: bool,
) -> Result<()> {
    let table = || PreintegrationTable::<E>::new(transfer, axes);
    all.push(linearised(Cuts::Adaptive { inflection: false, shading: true }, table()?, what, TABLES));
    if with_fixed {
        let exact = ExactDepth { pieces: table()?, depth: CubicPieces::new(transfer) };
        let what = format!("depth of the cubic, {what}");
        all.push(linearised(ADAPTIVE, exact, &what, "adaptive, cubic"));
    }
    if with_fixed {
        for n in [1, 2, 4, 8] {
            all.push(linearised(Cuts::Fixed(n), table()?, what, "fixed, table"));
        }
    }
    Ok(())
}
