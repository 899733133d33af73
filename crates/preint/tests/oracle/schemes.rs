//! Schemes without a bound, against the float64 reference.

use isoray_oracle::{OracleShading, SplitMix64, adversarial_cell, integrate_stretch};
use isoray_preint::{
    ControlPoint, CubicPieces, Cuts, ExactDepth, Integrate, IntegratePiece, Lighting, LinearPieces,
    Linearised, PreintegrationTable, Radiance, Segments, TableAxes, TransferFunction,
};

use crate::common::{self, Stretch};

const ADAPTIVE: Cuts = Cuts::Adaptive { inflection: false, shading: false };

/// A cell with values from 0 to 1, a segment through it, and a transfer function over that range.
struct Case {
    stretch: Stretch,
    transfer: TransferFunction,
}

impl Case {
    fn new(seed: u64) -> Self {
        let mut random = SplitMix64::new(seed);
        let cell = if random.coin() { adversarial_cell(seed) } else { [(); 8].map(|()| random.unit()) };
        let [low, high] = [f64::min, f64::max].map(|of| cell.into_iter().reduce(of).unwrap());
        let width = (high - low).max(f64::MIN_POSITIVE);
        let count = 2 + random.below(6);
        let points = (0..count).map(|n| ControlPoint {
            value: (f64::from(n) / f64::from(count - 1)) as f32,
            color: std::array::from_fn(|_| random.unit() as f32),
            extinction: if random.below(3) == 0 { 0.0 } else { (random.unit() * 4.0) as f32 },
        });
        let points = points.collect();
        let stretch = Stretch {
            corners: cell.map(|c| ((c - low) / width) as f32),
            entry: [0.0, random.unit() as f32, random.unit() as f32],
            exit: [1.0, random.unit() as f32, random.unit() as f32],
            length: (random.unit() * 2.0) as f32,
        };
        Self { stretch, transfer: TransferFunction::new(points).unwrap() }
    }

    fn by(&self, scheme: &impl Integrate, lighting: Option<&Lighting>) -> [f64; 4] {
        let mut segments = Segments::default();
        let Stretch { corners, entry, exit, length } = self.stretch;
        segments.push(&corners, entry, exit, length);
        let mut radiance = Radiance::default();
        scheme.integrate(&segments, lighting, &mut radiance);
        let [r, g, b] = radiance.color;
        [r, g, b, radiance.alpha()]
    }

    fn linearised<P: IntegratePiece>(&self, cuts: Cuts, pieces: P) -> [f64; 4] {
        self.by(&Linearised { cuts, pieces, terminate: 0.0 }, None)
    }

    fn exact(&self, shading: Option<&OracleShading>) -> [f64; 4] {
        let points = common::points(self.transfer.points());
        let radiance = integrate_stretch(&self.stretch.exact(), &points, shading);
        let [r, g, b] = radiance.color;
        [r, g, b, radiance.alpha()]
    }
}

fn difference(a: [f64; 4], b: [f64; 4]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn many_pieces_come_to_the_integral() {
    for seed in 0..200 {
        let case = Case::new(seed);
        let exact = case.exact(None);
        // The linear form is off by at most an eighth of the second derivative, 6 at most, of a 1000th squared; extinction changes by up to 28.
        let linear = case.linearised(Cuts::Fixed(1000), LinearPieces::new(&case.transfer));
        assert!(difference(linear, exact) < 6e-5, "seed {seed}: {linear:?} for {exact:?}");
        let cubic = case.linearised(Cuts::Fixed(100), CubicPieces::new(&case.transfer));
        assert!(difference(cubic, exact) < 2e-6, "seed {seed}: {cubic:?} for {exact:?}");
    }
}

#[test]
fn the_opacity_of_a_cubic_is_exact_in_one_piece() {
    for seed in 0..2000 {
        let case = Case::new(seed);
        let depth = CubicPieces::new(&case.transfer);
        let pieces = ExactDepth { pieces: LinearPieces::new(&case.transfer), depth };
        let ([.., found], [.., exact]) = (case.linearised(ADAPTIVE, pieces), case.exact(None));
        assert!((found - exact).abs() < 1e-5, "seed {seed}: {found} for {exact}");
        for cuts in
            [Cuts::Fixed(1), Cuts::Fixed(3), ADAPTIVE, Cuts::Adaptive { inflection: true, shading: true }]
        {
            let [.., found] = case.linearised(cuts, CubicPieces::new(&case.transfer));
            let [.., exact] = case.exact(None);
            // What single precision leaves of the coefficients, times how steep the extinction is.
            assert!((found - exact).abs() < 1e-5, "seed {seed}, {cuts:?}: {found} for {exact}");
        }
    }
}

#[test]
fn adaptive_cuts_miss_no_value() {
    let mut missed = [0; 2];
    for seed in 0..3000 {
        let mut case = Case::new(seed);
        let at = SplitMix64::new(seed ^ 77).range(0.0, 1.0) as f32;
        let point = |value: f32, extinction: f32| ControlPoint { value, color: [1.0; 3], extinction };
        let spike = vec![point(at - 5e-4, 0.0), point(at, 1e3), point(at + 5e-4, 0.0)];
        case.transfer = TransferFunction::new(spike).unwrap();
        if case.exact(None)[3] < 1e-4 {
            continue;
        }
        for (cuts, missed) in [Cuts::Fixed(1), ADAPTIVE].into_iter().zip(&mut missed) {
            *missed += u32::from(case.linearised(cuts, LinearPieces::new(&case.transfer))[3] == 0.0);
        }
    }
    assert!(missed[0] > 10 && missed[1] == 0, "{missed:?}");
}

#[test]
fn tables_are_close_to_what_they_tabulate() {
    let mut sum = 0.0;
    for seed in 0..8 {
        let case = Case::new(seed);
        let axes = TableAxes::new([0.0, 1.0], 2.0);
        let table = PreintegrationTable::<u16>::new(&case.transfer, axes).unwrap();
        let looked_up = case.linearised(ADAPTIVE, table);
        let computed = case.linearised(ADAPTIVE, LinearPieces::new(&case.transfer));
        assert!(difference(looked_up, computed) < 0.02, "seed {seed}: {looked_up:?} for {computed:?}");
        sum += difference(looked_up, computed);
    }
    assert!(sum > 0.0, "a table interpolates");
}

#[test]
fn shading_is_interpolated_between_cuts() {
    let lighting = Lighting {
        ambient: 0.2,
        diffuse: 0.9,
        specular: 0.5,
        exponent: 8.0,
        light: [0.3, -0.2, 0.4],
        half: [0.2, 0.1, 0.5],
    };
    let shading = common::shading(&lighting);
    for seed in 0..100 {
        let case = Case::new(seed);
        let exact = case.exact(Some(&shading));
        let scheme =
            Linearised { cuts: Cuts::Fixed(500), pieces: LinearPieces::new(&case.transfer), terminate: 0.0 };
        let found = case.by(&scheme, Some(&lighting));
        assert!(difference(found, exact) < 1e-3, "seed {seed}: {found:?} for {exact:?}");
    }
}
