//! The report as a page: self-contained, with charts as inline SVG and pictures inline.

mod frontier;
mod knobs;
mod pictures;
mod sections;
mod table;

use std::path::Path;

use anyhow::Result;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use serde_json::Value;

use super::report::write;
use frontier::Frontier;
use sections::Section;
pub(crate) use sections::rows;

/// Writes the page of a report beside its JSON.
pub(crate) fn save(json: &Path, report: &Value) -> Result<()> {
    write(&json.with_extension("html"), page(report)?.into_string().as_bytes())
}

const STYLE: &str = "
body { font: 15px/1.45 system-ui, sans-serif; max-width: 1100px; margin: 2em auto; padding: 0 1em; color: #222; }
h1, h2, h3 { line-height: 1.2; } h2 { border-top: 1px solid #ccc; padding-top: 1em; margin-top: 2em; }
table { border-collapse: collapse; font-size: 13px; margin: 0.6em 0; }
th, td { padding: 2px 9px; text-align: left; border-bottom: 1px solid #eee; } td.n, th.n { text-align: right; }
th { border-bottom: 1px solid #888; vertical-align: bottom; }
.scroll { overflow-x: auto; } svg { max-width: 100%; height: auto; }
.alarm { color: #b00020; font-weight: 600; } .good { color: #1b6b2f; }
.pictures img { width: 31%; image-rendering: pixelated; margin-right: 1%; }
p.about { max-width: 75ch; } nav a { margin-right: 1em; white-space: nowrap; }";

fn page(report: &Value) -> Result<Markup> {
    let sections: Vec<&Section> = sections::ALL.iter().filter(|section| section.is_in(report)).collect();
    let frontiers: Vec<Frontier> = sections.iter().flat_map(|section| section.frontiers(report)).collect();
    let machine = &report["machine"];
    let build: Vec<&str> =
        machine["build"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    Ok(html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                title { "isoray, measured" }
                style { (PreEscaped(STYLE)) }
            }
            body {
                h1 { "isoray, measured" }
                p {
                    (machine["cpu"].as_str().unwrap_or_default()) ", " (machine["threads"]) " threads; built for "
                    (build.join(", ")) ". Every time is the median of " (report["repeat"])
                    " runs, in turn with the runs that it is compared with: ratios hold, absolute times drift with the machine."
                }
                p.about { (sections::READING) }
                (summary(report, &frontiers))
                nav { @for section in &sections { a href={ "#" (section.anchor()) } { (section.title) } } }
                (pictures::show()?)
                @for section in &sections { (section.show(report)?) }
            }
        }
    })
}

/// What a hurried reader needs: what has changed, and whether every default is on its frontier.
fn summary(report: &Value, frontiers: &[Frontier]) -> Markup {
    let compared = report["comparison"].as_array().map_or(&[][..], Vec::as_slice);
    let is_bad = |row: &&Value| ["slower", "different_answer"].map(Value::from).contains(&row["verdict"]);
    let bad = compared.iter().filter(is_bad).count();
    let off: Vec<_> =
        frontiers.iter().filter_map(|frontier| Some((frontier, frontier.dominating()?))).collect();
    let contested = frontiers.iter().filter(|frontier| frontier.is_contested()).count();
    let exact = frontiers.iter().filter(|frontier| frontier.is_exact()).count();
    html! {
        @if !compared.is_empty() {
            @if bad == 0 { p.good { "No kernel is slower than in the baseline, and none finds anything else." } }
            @else { p.alarm { (bad) " kernels are slower than in the baseline or find something else: see below." } }
        }
        @if contested > 0 && off.is_empty() {
            p.good { "Every default that has an error is on its frontier: nothing else that was measured is both faster and as accurate (" (contested) " charts)." }
        }
        @if exact > 0 { p { "In " (exact) " charts the default has no error at all, and others show what may be gained by some." } }
        @for (frontier, point) in &off {
            p.alarm { "Not on its frontier: the default in “" (frontier.title) "”; " (point.label) " is both faster and at least as accurate." }
        }
    }
}
