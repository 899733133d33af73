//! What all charts have in common.

use std::error::Error;
use std::path::Path;

use anyhow::{Context, Result};
use plotters::coord::Shift;
use plotters::coord::ranged1d::ValueFormatter;
use plotters::prelude::*;

/// A chart that is being drawn.
pub(crate) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Writes what `draw` draws as an SVG.
pub(crate) fn save(file: &Path, draw: impl Fn(&Area) -> Result<(), Box<dyn Error>>) -> Result<()> {
    let all = || -> Result<(), Box<dyn Error>> {
        let area = SVGBackend::new(file, (900, 560)).into_drawing_area();
        area.fill(&WHITE)?;
        draw(&area)?;
        area.present()?;
        Ok(())
    };
    all()
        .map_err(|error| anyhow::anyhow!("{error}"))
        .with_context(|| format!("{}: cannot be written", file.display()))?;
    println!("written: {}", file.display());
    Ok(())
}

/// Draws the legend.
pub(crate) fn legend<'a, X, Y>(
    chart: &mut ChartContext<'a, SVGBackend<'a>, Cartesian2d<X, Y>>,
) -> Result<(), Box<dyn Error>>
where
    X: Ranged<ValueType = f64> + ValueFormatter<f64>,
    Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .background_style(WHITE)
        .border_style(BLACK)
        .draw()?;
    Ok(())
}
