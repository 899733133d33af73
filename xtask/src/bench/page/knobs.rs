//! Charts of time against error, of the rows of a report.

use serde_json::Value;

use super::frontier::{Frontier, Point};
use super::sections::rows;

/// A cell's edge in units of the last place of 1.
const CELL_ULPS: f64 = 8_388_608.0;
/// The scheme of volume rendering that is the default.
const SCHEME: &str = "bounded 1/510";

fn number(row: &Value, member: &str) -> f64 {
    row[member].as_f64().unwrap_or(f64::NAN)
}

fn text(row: &Value, member: &str) -> String {
    match &row[member] {
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

/// The rows that agree in what `name` makes of them, in their order.
fn groups(rows: Vec<Value>, name: impl Fn(&Value) -> String) -> Vec<(String, Vec<Value>)> {
    let mut groups: Vec<(String, Vec<Value>)> = Vec::new();
    for row in rows {
        let name = name(&row);
        match groups.iter_mut().find(|group| group.0 == name) {
            Some((_, rows)) => rows.push(row),
            None => groups.push((name, vec![row])),
        }
    }
    groups
}

/// A chart for each group; points without a time or an error are left out.
fn charts(
    groups: Vec<(String, Vec<Value>)>,
    axes: [&'static str; 2],
    point: impl Fn(&Value) -> Point,
    exact: Option<Point>,
) -> Vec<Frontier> {
    let chart = |(title, rows): (String, Vec<Value>)| {
        let points = exact.iter().cloned().chain(rows.iter().map(&point));
        let points: Vec<Point> =
            points.filter(|p| p.time > 0.0 && p.time.is_finite() && p.error.is_finite()).collect();
        (points.len() > 1).then_some(Frontier { title, axes, points })
    };
    groups.into_iter().filter_map(chart).collect()
}

fn lit(row: &Value) -> &'static str {
    if row["is_shaded"] == true { "lit" } else { "unlit" }
}

pub(super) fn roots(report: &Value) -> Vec<Frontier> {
    let point = |row: &Value| {
        let wrong = (number(row, "missed_per_million") + number(row, "false_per_million")) * 1e-6;
        Point {
            label: text(row, "method"),
            family: text(row, "method"),
            time: row["ns"][3].as_f64().unwrap_or(f64::NAN),
            error: number(row, "mean_error_ulps") + wrong * CELL_ULPS,
            is_default: row["is_default"] == true,
        }
    };
    let groups = groups(rows(report, "/cell"), |row| format!("First root in cells of {}", text(row, "set")));
    charts(groups, ["ns a cell, 16 lanes", "mean error, ulp of 1"], point, None)
}

pub(super) fn normals(report: &Value) -> Vec<Frontier> {
    let errors = [
        ("surface_mean", "of the surface drawn", ["ns a normal", "mean angle to the surface's, degrees"]),
        ("field_mean", "of the field sampled", ["ns a normal", "mean angle to the field's, degrees"]),
    ];
    let of = |(member, of, axes): (&'static str, &str, [&'static str; 2])| {
        let title = |row: &Value| format!("{} at {}: normals {of}", text(row, "volume"), row["isovalue"]);
        let point = |row: &Value| Point {
            label: text(row, "normals"),
            family: text(row, "normals"),
            time: number(row, "ns_per_hit"),
            error: number(row, member),
            is_default: row["is_default"] == true,
        };
        charts(groups(rows(report, "/normals"), title), axes, point, None)
    };
    errors.into_iter().flat_map(of).collect()
}

/// By a scheme of volume rendering.
fn scheme(row: &Value, time: f64, error: f64) -> Point {
    let label = text(row, "scheme");
    Point { family: text(row, "family"), time, error, is_default: label == SCHEME, label }
}

pub(super) fn integration(report: &Value) -> Vec<Frontier> {
    let named =
        |what: &'static str| move |row: &Value| format!("{}, {}: {what}", text(row, "volume"), lit(row));
    let all = rows(report, "/volume/curves/*/rows");
    let point = |row: &Value| scheme(row, number(row, "ns_per_ray"), number(row, "max_error"));
    let mut charts = charts(
        groups(all.clone(), named("every scheme")),
        ["ns a ray, one thread", "largest error of a pixel"],
        point,
        None,
    );
    // What these schemes do else is the same for all, and so is the largest error, that of a feature they all misplace.
    let knobs = [
        (
            "where rays end",
            "adaptive, cubic",
            TERMINATION.as_slice(),
            ["rms_error", "error of pixels, root mean square"],
        ),
        (
            "size and precision of tables",
            "adaptive, f32 table 256²×32",
            TABLES.as_slice(),
            ["table_rms", "what the table changes, root mean square"],
        ),
    ];
    for (what, default, schemes, [member, error]) in knobs {
        let mut of = all.clone();
        of.retain(|row| schemes.iter().any(|part| is_of(&text(row, "scheme"), part)));
        let point = |row: &Value| {
            let label = text(row, "scheme");
            let [time, error] = ["ns_per_ray", member].map(|member| number(row, member));
            Point { family: what.to_owned(), time, error, is_default: label == default, label }
        };
        let axes = ["ns a ray, one thread", error];
        charts.extend(self::charts(groups(of, named(what)), axes, point, None));
    }
    charts
}

/// Schemes that differ in the transmittance at which rays end: first the one that ends at 10⁻³, as they all do unless told otherwise.
const TERMINATION: [&str; 2] = ["adaptive, cubic", "adaptive, cubic, ends at "];
/// Those that differ in their tables. The one that [`TableAxes::new`](isoray_preint::TableAxes::new) makes has 256²×32 entries.
const TABLES: [&str; 2] = ["adaptive, f32 table ", "adaptive, u16 table "];

/// Whether this is the scheme of that name or, where the name ends in a space, begins with it.
fn is_of(scheme: &str, name: &str) -> bool {
    scheme == name || name.ends_with(' ') && scheme.starts_with(name)
}

pub(super) fn meshes(report: &Value) -> Vec<Frontier> {
    let title = |row: &Value| format!("{}, {}: every scheme", text(row, "mesh"), lit(row));
    let point = |row: &Value| scheme(row, number(row, "ms"), number(row, "largest_error"));
    charts(
        groups(rows(report, "/amr/errors"), title),
        ["ms a frame, all threads", "largest error of a pixel"],
        point,
        None,
    )
}

/// The exact picture: as much time as it takes itself, and no error.
fn exact() -> Option<Point> {
    Some(Point {
        label: "exact".to_owned(),
        family: "exact".to_owned(),
        time: 1.0,
        error: 0.0,
        is_default: true,
    })
}

pub(super) fn detail(report: &Value) -> Vec<Frontier> {
    let errors: [(&str, [&'static str; 2]); 3] = [
        ("depth_rms_voxels", ["time, exact is 1", "depth, root mean square, voxels"]),
        ("silhouette_percent", ["time, exact is 1", "silhouette, % of the hits"]),
        ("color_rms", ["time, exact is 1", "linear colour, root mean square"]),
    ];
    let mut all = Vec::new();
    for (member, axes) in errors {
        let title = |row: &Value| {
            format!(
                "{} at {}, {}, {}²: {}",
                text(row, "volume"),
                row["isovalue"],
                text(row, "view"),
                row["size"],
                axes[1]
            )
        };
        let point = |row: &Value| Point {
            label: format!("{} at ratio {}", text(row, "variant"), row["ratio"]),
            family: text(row, "variant"),
            time: 1.0 / number(row, "times_exact"),
            error: number(row, member),
            is_default: false,
        };
        all.extend(charts(groups(rows(report, "/detail"), title), axes, point, exact()));
    }
    let title = |row: &Value| {
        format!("{}, {}, {}²: level of detail", text(row, "mesh"), text(row, "what"), row["size"])
    };
    let point = |row: &Value| Point {
        label: format!("ratio {}", row["ratio"]),
        family: "cut at a ratio".to_owned(),
        time: number(row, "frame_ms"),
        error: number(row, "rms_error"),
        is_default: row["ratio"] == 0.0,
    };
    all.extend(charts(
        groups(rows(report, "/amr/detail"), title),
        ["ms a frame", "linear RGBA, root mean square"],
        point,
        None,
    ));
    all
}

pub(super) fn shadows(report: &Value) -> Vec<Frontier> {
    let title = |row: &Value| {
        format!(
            "{} at {}, {}: {}",
            text(row, "volume"),
            row["isovalue"],
            text(row, "view"),
            text(row, "what")
        )
    };
    let point = |row: &Value| Point {
        label: format!("ratio {}", row["ratio"]),
        family: "coarser at a ratio".to_owned(),
        time: 1.0 / number(row, "times_exact_frame"),
        error: number(row, "mean_error_percent"),
        is_default: false,
    };
    let axes = ["time of a frame, exact is 1", "mean error, % of what shadows change"];
    charts(groups(rows(report, "/shadows"), title), axes, point, exact())
}

pub(super) fn lossy(report: &Value) -> Vec<Frontier> {
    let title = |row: &Value| format!("{}: size against displacement", text(row, "volume"));
    let point = |row: &Value| Point {
        label: format!("{} {}", text(row, "bound"), row["amount"]),
        family: text(row, "bound"),
        time: number(row, "percent"),
        error: number(row, "max"),
        is_default: row["bound"] == "(no loss)",
    };
    charts(
        groups(rows(report, "/lossy"), title),
        ["size, % of the raw samples", "largest displacement, voxels"],
        point,
        None,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missed_roots_are_no_way_onto_the_frontier() {
        let row = |method: &str, ns: f64, error: f64, missed: f64, is_default: bool| {
            serde_json::json!({ "set": "s", "method": method, "ns": [1.0, 1.0, 1.0, ns], "mean_error_ulps": error,
                "missed_per_million": missed, "false_per_million": 0.0, "is_default": is_default })
        };
        let report = |missed| serde_json::json!({ "cell": [row("ours", 2.0, 0.1, 0.0, true), row("theirs", 1.0, 0.1, missed, false)] });
        assert!(roots(&report(0.0))[0].dominating().is_some());
        assert!(roots(&report(1.0))[0].dominating().is_none());
    }

    #[test]
    fn the_exact_picture_is_the_default_of_levels_of_detail() {
        let row = serde_json::json!({ "volume": "v", "isovalue": 1.0, "view": "far", "size": 64, "ratio": 2.0, "variant": "mean",
            "times_exact": 2.0, "depth_rms_voxels": 0.5, "silhouette_percent": 1.0, "color_rms": 0.01 });
        let charts = detail(&serde_json::json!({ "detail": [row] }));
        assert_eq!(charts.len(), 3);
        assert!(charts.iter().all(|chart| chart.is_exact() && chart.dominating().is_none()));
        assert_eq!(charts[0].points[1].time, 0.5);
    }
}
