//! Time against error: what else is both faster and more accurate than the default?

use std::error::Error;

use maud::{Markup, PreEscaped, html};
use plotters::prelude::*;

use super::table::short;

/// One way to do the same.
#[derive(Clone, Debug)]
pub(crate) struct Point {
    pub(crate) label: String,
    /// What it belongs to: one colour.
    pub(crate) family: String,
    pub(crate) time: f64,
    pub(crate) error: f64,
    pub(crate) is_default: bool,
}

/// All that was measured of one knob on one scene.
#[derive(Clone, Debug)]
pub(crate) struct Frontier {
    pub(crate) title: String,
    /// Of time and of error, with their units.
    pub(crate) axes: [&'static str; 2],
    pub(crate) points: Vec<Point>,
}

/// Times that differ by less are taken for the same: medians of runs in turn repeat within some per cent.
const NOISE: f64 = 0.05;

impl Frontier {
    fn default_point(&self) -> Option<&Point> {
        self.points.iter().find(|point| point.is_default)
    }

    /// Whether there is a default that others can better: nothing is more accurate than what is exact.
    pub(crate) fn is_contested(&self) -> bool {
        self.default_point().is_some_and(|default| default.error > 0.0)
    }

    /// Whether the default is exact, which others may be by chance.
    pub(crate) fn is_exact(&self) -> bool {
        self.default_point().is_some_and(|default| default.error == 0.0)
    }

    /// The fastest of those that are faster than the default and at least as accurate. A default without any error is exact everywhere; that another happens to be so on one scene
    /// does not better it.
    pub(crate) fn dominating(&self) -> Option<&Point> {
        let default = self.default_point().filter(|_| self.is_contested())?;
        let better =
            |point: &&Point| point.time < (1.0 - NOISE) * default.time && point.error <= default.error;
        self.points.iter().filter(better).min_by(|a, b| a.time.total_cmp(&b.time))
    }

    /// The chart and what it says.
    pub(crate) fn show(&self) -> Markup {
        let drawn = self.draw();
        html! {
            @match drawn {
                Ok(svg) => (PreEscaped(svg)),
                Err(error) => p.alarm { (self.title) ": cannot be drawn: " (error) },
            }
            @match (self.default_point(), self.dominating()) {
                (Some(default), Some(point)) => p.alarm {
                    "The default (" (default.label) ": " (short(default.time)) ", " (short(default.error)) ") is not on the frontier: " (point.label)
                    " takes " (short(point.time)) " at an error of " (short(point.error)) "."
                },
                (Some(default), None) if self.is_exact() => p { "The default, " (default.label) ", has no error here: the chart shows what may be gained by some." },
                (Some(default), None) => p.good { "The default, " (default.label) ", is on the frontier." },
                (None, _) => {},
            }
        }
    }

    fn draw(&self) -> Result<String, Box<dyn Error>> {
        let mut svg = String::new();
        let area = SVGBackend::with_string(&mut svg, (860, 430)).into_drawing_area();
        area.fill(&WHITE)?;
        let errors: Vec<f64> =
            self.points.iter().map(|point| point.error).filter(|&error| error > 0.0).collect();
        let least = errors.iter().copied().fold(f64::INFINITY, f64::min);
        // What is exact has no place on a logarithmic axis: it is drawn at the bottom.
        let floor = if least.is_finite() { 0.3 * least } else { 1e-9 };
        let most = errors.iter().copied().fold(floor, f64::max);
        let [fastest, slowest] = self
            .points
            .iter()
            .fold([f64::INFINITY, 0.0], |[a, b], p| [f64::min(a, p.time), f64::max(b, p.time)]);
        let mut chart = ChartBuilder::on(&area)
            .caption(&self.title, ("sans-serif", 17))
            .margin(10)
            .x_label_area_size(40)
            .y_label_area_size(70)
            .build_cartesian_2d(
                (0.8 * fastest..1.3 * slowest).log_scale(),
                (0.7 * floor..30.0 * most).log_scale(),
            )?;
        chart.configure_mesh().x_desc(self.axes[0]).y_desc(self.axes[1]).draw()?;
        let mut families: Vec<&str> = Vec::new();
        for point in &self.points {
            if !families.contains(&point.family.as_str()) {
                families.push(&point.family);
            }
        }
        for (n, family) in families.into_iter().enumerate() {
            let color = Palette99::pick(n).to_rgba();
            let mut places: Vec<(f64, f64)> = self
                .points
                .iter()
                .filter(|p| p.family == family)
                .map(|p| (p.time, p.error.max(floor)))
                .collect();
            places.sort_by(|a, b| a.0.total_cmp(&b.0));
            chart
                .draw_series(LineSeries::new(places.clone(), color.stroke_width(1)))?
                .label(family)
                .legend(move |(x, y)| Circle::new((x + 6, y), 5, color.filled()));
            chart.draw_series(places.into_iter().map(|place| Circle::new(place, 4, color.filled())))?;
        }
        if let Some(default) = self.default_point() {
            let place = (default.time, default.error.max(floor));
            chart
                .draw_series([Circle::new(place, 9, BLACK.stroke_width(2))])?
                .label("default")
                .legend(|(x, y)| Circle::new((x + 6, y), 6, BLACK.stroke_width(2)));
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .background_style(WHITE.mix(0.8))
            .border_style(BLACK)
            .draw()?;
        area.present()?;
        drop(chart);
        drop(area);
        Ok(svg)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frontier(default: [f64; 2], other: [f64; 2]) -> Frontier {
        let point = |[time, error]: [f64; 2], is_default| Point {
            label: "p".into(),
            family: "f".into(),
            time,
            error,
            is_default,
        };
        Frontier {
            title: "t".into(),
            axes: ["ns", "error"],
            points: vec![point(default, true), point(other, false)],
        }
    }

    #[test]
    fn the_default_is_off_the_frontier_only_if_another_is_better_in_both() {
        assert!(frontier([10.0, 1.0], [9.0, 1.0]).dominating().is_some());
        assert!(frontier([10.0, 1.0], [9.0, 1.1]).dominating().is_none());
        assert!(frontier([10.0, 1.0], [11.0, 0.0]).dominating().is_none());
        assert!(frontier([10.0, 1.0], [9.9, 0.5]).dominating().is_none(), "within the noise");
        assert!(frontier([10.0, 0.0], [5.0, 0.0]).dominating().is_none(), "exact by chance");
    }

    #[test]
    fn exact_points_can_be_drawn() {
        let text = frontier([10.0, 0.0], [5.0, 0.1]).show().into_string();
        assert!(text.starts_with("<svg") && text.contains("has no error here"), "{text}");
    }

    #[test]
    fn nothing_betters_what_is_exact() {
        let exact = frontier([10.0, 0.0], [5.0, 0.1]);
        assert!(exact.is_exact() && !exact.is_contested());
        let other = frontier([10.0, 0.2], [5.0, 0.3]);
        assert!(!other.is_exact() && other.is_contested());
        assert!(other.show().into_string().contains("is on the frontier"));
    }
}
