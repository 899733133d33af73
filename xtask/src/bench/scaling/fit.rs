//! How one quantity grows with another.

use serde::Serialize;

/// A power law through measured points: the line through their logarithms with the least squares.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Fit {
    /// Of what, by what.
    pub(super) what: &'static str,
    pub(super) volume: String,
    pub(super) view: &'static str,
    pub(super) points: usize,
    /// `p` of `y ~ x^p`.
    pub(super) exponent: f64,
    /// The share of the variance of ln y that the law explains.
    pub(super) r_squared: f64,
}

impl Fit {
    /// Through points `[x, y]`, all positive; `None` of fewer than three, of which any two lie on some line.
    pub(super) fn new(
        [what, view]: [&'static str; 2],
        volume: &str,
        points: impl IntoIterator<Item = [f64; 2]>,
    ) -> Option<Self> {
        let points: Vec<[f64; 2]> = points.into_iter().map(|p| p.map(f64::ln)).collect();
        let [exponent, r_squared] = line(&points);
        let fit = Self { what, volume: volume.to_owned(), view, points: points.len(), exponent, r_squared };
        (points.len() > 2).then_some(fit)
    }

    pub(super) fn print(&self) {
        println!(
            "{}: {} grows with exponent {:.3}, R² {:.4} of {} points, {}",
            self.volume, self.what, self.exponent, self.r_squared, self.points, self.view
        );
    }
}

/// The slope of the line with the least squares, and the share of the variance that it explains; NaN both if no point differs from the first along x.
fn line(points: &[[f64; 2]]) -> [f64; 2] {
    let mean = |of: &dyn Fn(&[f64; 2]) -> f64| points.iter().map(of).sum::<f64>() / points.len() as f64;
    let [x, y] = [mean(&|p| p[0]), mean(&|p| p[1])];
    let [xx, xy, yy] =
        [mean(&|p| (p[0] - x).powi(2)), mean(&|p| (p[0] - x) * (p[1] - y)), mean(&|p| (p[1] - y).powi(2))];
    if points.iter().all(|p| p[0] == points[0][0]) {
        return [f64::NAN; 2];
    }
    [xy / xx, if yy == 0.0 { 1.0 } else { xy * xy / (xx * yy) }]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_law_is_found() {
        let law = |x: f64| [x, 3.0 * x.powf(-0.75)];
        let fit = Fit::new(["time by threads", "close"], "none", [1.0, 2.0, 5.0, 16.0].map(law)).unwrap();
        assert!((fit.exponent + 0.75).abs() < 1e-12 && (fit.r_squared - 1.0).abs() < 1e-12);
    }

    #[test]
    fn what_is_no_power_law_is_told() {
        // Up and down again: no slope explains anything.
        let [slope, explained] = line(&[[0.0, 0.0], [1.0, 1.0], [2.0, 0.0]]);
        assert!(slope.abs() < 1e-12 && explained < 1e-12);
        assert_eq!(line(&[[0.0, 1.0], [1.0, 1.0]]), [0.0, 1.0]);
        for points in [&[][..], &[[1.0, 2.0]], &[[1.0, 2.0], [1.0, 3.0]]] {
            assert!(line(points).iter().all(|n| n.is_nan()), "{points:?}");
        }
    }

    #[test]
    fn two_points_are_no_law() {
        let fit = |n: usize| Fit::new(["", ""], "", (1..=n).map(|x| [x as f64, 2.0]));
        assert!(fit(2).is_none() && fit(3).is_some_and(|fit| fit.exponent == 0.0));
    }
}
