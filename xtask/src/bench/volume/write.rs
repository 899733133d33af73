//! Tables and charts.

use std::path::Path;

use anyhow::Result;
use plotters::prelude::*;

use super::VolumeSuite;
use super::curves::Curve;
use super::spikes::SpikeRow;
use crate::bench::chart;
use crate::root;

pub(crate) fn print_spikes(rows: &[SpikeRow]) {
    println!(
        "\nA spike 10⁻³ of the range wide, in random cells: segments on which it is missed, or seen where it is not."
    );
    for SpikeRow { scheme, meeting, missed, invented } in rows {
        println!("{scheme:<16} {missed:>7} of {meeting} missed, {invented:>6} invented");
    }
}

pub(crate) fn print_curve(curve: &Curve) {
    let shaded = if curve.is_shaded { "shaded" } else { "unshaded" };
    println!("\n{}, {shaded}, {}²: ns a ray on one thread", curve.volume, curve.size);
    println!(
        "{:<40} {:>9} {:>10} {:>10} {:>7} {:>9}",
        "scheme", "ns/ray", "max error", "rms error", "over ε", "pieces/ray"
    );
    for row in &curve.rows {
        println!(
            "{:<40} {:>9.0} {:>10.2e} {:>10.2e} {:>7} {:>9.1}",
            row.scheme, row.ns_per_ray, row.max_error, row.rms_error, row.over, row.pieces_per_ray
        );
    }
}

/// Replaces the charts of the documentation.
pub(crate) fn documentation(suite: &VolumeSuite) -> Result<()> {
    for curve in &suite.curves {
        let shaded = if curve.is_shaded { "-shaded" } else { "" };
        let name: String = curve.volume.chars().filter(|c| c.is_ascii_alphanumeric()).collect();
        let file = root().join(format!("docs/pictures/volume-{}{shaded}.svg", name.to_lowercase()));
        chart(curve, &file)?;
    }
    Ok(())
}

/// Time against the largest error, a line each family.
fn chart(curve: &Curve, file: &Path) -> Result<()> {
    let shaded = if curve.is_shaded { ", shaded" } else { "" };
    let span = |values: &dyn Fn(&super::curves::Row) -> f64| {
        let values = curve.rows.iter().map(values).filter(|v| *v > 0.0);
        values.fold((f64::MAX, 0.0_f64), |(a, b), v| (a.min(v), b.max(v)))
    };
    let (fastest, slowest) = span(&|r| r.ns_per_ray / 1e3);
    let (least, most) = span(&|r| r.max_error);
    let mut families: Vec<&str> = Vec::new();
    for row in &curve.rows {
        if !families.contains(&row.family) {
            families.push(row.family);
        }
    }
    chart::save(file, |area| {
        let mut chart = ChartBuilder::on(area)
            .caption(
                format!("{}{shaded}: time against the largest error of a pixel", curve.volume),
                ("sans-serif", 18),
            )
            .margin(12)
            .x_label_area_size(44)
            .y_label_area_size(70)
            .build_cartesian_2d(
                (0.8 * fastest..1.3 * slowest).log_scale(),
                (0.5 * least..20.0 * most).log_scale(),
            )?;
        chart
            .configure_mesh()
            .x_desc("µs a ray, one thread")
            .y_desc("largest error of an RGBA channel")
            .draw()?;
        for (n, family) in families.iter().enumerate() {
            let colour = Palette99::pick(n).to_rgba();
            let mut points: Vec<(f64, f64)> = curve
                .rows
                .iter()
                .filter(|r| r.family == *family && r.max_error > 0.0)
                .map(|r| (r.ns_per_ray / 1e3, r.max_error))
                .collect();
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            let width = if *family == "bounded" { 3 } else { 1 };
            chart
                .draw_series(LineSeries::new(points.clone(), colour.stroke_width(width)))?
                .label(*family)
                .legend(move |(x, y)| Circle::new((x + 6, y), 5, colour.filled()));
            chart.draw_series(points.into_iter().map(|p| Circle::new(p, 4, colour.filled())))?;
        }
        chart::legend(&mut chart)
    })
}
