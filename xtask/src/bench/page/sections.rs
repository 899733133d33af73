//! What the page has, in which order, and how to read it.

use anyhow::Result;
use maud::{Markup, html};
use serde_json::Value;

use super::frontier::Frontier;
use super::{knobs, table};

/// How to read the page.
pub(crate) const READING: &str = "Charts have time to the right and error upwards, both logarithmic: what is further left is faster, what is lower more accurate, and what \
    has nothing to its lower left cannot be bettered in both: it is on the frontier. The circled point is what isoray does unless told otherwise. Errors are against a \
    float64 reference that shares no code with what is measured; those of levels of detail, of loss and of far shadows against the exact picture, which is checked against it. Of lossy compression the charts have sizes in place of times. Tables have all the figures; what their columns mean stands with each.";

/// Part of the page.
pub(crate) struct Section {
    pub(crate) title: &'static str,
    about: &'static str,
    /// Where rows are in the report, and what they are.
    tables: &'static [(&'static str, &'static str)],
    /// Its charts.
    knobs: Option<fn(&Value) -> Vec<Frontier>>,
}

/// A section without charts.
const fn plain(
    title: &'static str,
    about: &'static str,
    tables: &'static [(&'static str, &'static str)],
) -> Section {
    Section { title, about, tables, knobs: None }
}

/// One with charts.
const fn charted(
    title: &'static str,
    about: &'static str,
    tables: &'static [(&'static str, &'static str)],
    knobs: fn(&Value) -> Vec<Frontier>,
) -> Section {
    Section { title, about, tables, knobs: Some(knobs) }
}

pub(crate) const ALL: &[Section] = &[
    plain(
        "Against the baseline",
        "Each kernel is a few milliseconds of one part of the renderer. Where the earlier program is at hand both run in turn, and the ratio is the median of the pairs; noise is \
         its standard error, as a share. A change counts if it is more than three times that, and more than 3 %: the same sources built twice differ by up to so much. A kernel that \
         finds something else than before fails, however fast it is.",
        &[("/comparison", "Time now over that of the baseline")],
    ),
    plain(
        "Kernels",
        "The same kernels alone. The reference is no part of isoray: it is the recursion of a paper of 2006 on its own nodes, kept for comparison, so that ratios to it carry from \
         machine to machine better than times. Spread: half the distance of the quartiles, as a share of the median.",
        &[("/kernels", "Milliseconds on one thread")],
    ),
    plain(
        "First table",
        "Volumes: raw size, the octree's (lossless, the whole file) and that of the octree of the 2006 paper, bytes; building. Views: nanoseconds a ray on one thread, normals and shading \
         included, beside the 2006 recursion and the floor: only intersecting the cells that must be. Counts are of a ray.",
        &[("/overview", "Sizes and building"), ("/overview/*/views", "Views")],
    ),
    charted(
        "Roots",
        "Where a ray first meets the surface in a cell: nanoseconds a cell at a time and in 4, 8 and 16 lanes, errors in units of the last place of 1 (a cell's edge is 1). In the chart a \
         root that is missed or invented counts as an error of a whole cell.",
        &[("/cell", "First-root finders")],
        knobs::roots,
    ),
    charted(
        "Normals",
        "Nanoseconds a normal at the first hits of a far view, and the angle to what it should be, in degrees: to the gradient of the surface that is drawn (the trilinear interpolant), and, for \
         generated volumes, to that of the field of which the samples were taken. Forward normals, the default, are the surface's own; central ones are smooth.",
        &[("/normals", "Normals")],
        knobs::normals,
    ),
    charted(
        "Integration",
        "Volume rendering by every scheme: error of the worst pixel, any channel of linear RGBA from 0 to 1. Bounded schemes promise theirs; over: pixels that break the promise, of which \
         there must be none. What an early end of rays does is shown by itself, by the mean error, since the largest is often that of one feature that all of them misplace; and what size and precision of tables do, \
         by how much the picture differs from the one without a table.",
        &[
            ("/volume/curves/*/rows", "Schemes"),
            ("/volume/spikes", "Features thinner than a piece that are missed, or seen where they are not"),
        ],
        knobs::integration,
    ),
    charted(
        "Levels of detail",
        "Pictures from coarser cells where these are up to a number of pixels wide (the ratio), against the exact picture: times exact is how many times as fast. Depths in voxels; silhouette \
         and elsewhere in % of the hits. The default is exact, and everything else is a trade that must be asked for.",
        &[
            ("/detail", "Octrees"),
            ("/amr/detail", "Adaptive meshes"),
            ("/lod", "Displacement of coarse surfaces, by kind of coarse sample"),
            ("/orbit", "Frame times round a volume"),
        ],
        knobs::detail,
    ),
    charted(
        "Lossy compression",
        "Size against the distance of isosurfaces from where they are without loss, in voxels. The default loses nothing.",
        &[("/lossy", "Sizes and displacements")],
        knobs::lossy,
    ),
    charted(
        "Shadows through coarser levels",
        "How many times as fast a frame is, and what becomes of its shading: pixels darker and lighter by more than 1/64, and the mean error in % of all that shadows change. The default is exact.",
        &[("/shadows", "Shadows of a lamp, and of the sky")],
        knobs::shadows,
    ),
    plain(
        "Skipping",
        "What a scene does not need is not done: nanoseconds of a ray, or of a point that is lit or not, with each way of skipping and with the work done. Both come to the same bits; but \
         pictures of volume rendering with and without what is hidden are within twice the bound of each other, each being within the bound of what is right, and a ray from \
         behind a surface may, of a few points, meet nothing.",
        &[
            ("/skipping", "Times: with the skip and without"),
            ("/skipping/*/counts", "Work that is counted: with the skip and without"),
        ],
    ),
    plain(
        "Point location",
        "Finding the cell of a point, and going on to its neighbour, as papers do it and as isoray does.",
        &[("/hashing", "Nanoseconds each")],
    ),
    plain(
        "Structures",
        "Octree against grid, bricks and macrocells, with the octree's data or an array. Phases: shares of a frame's time. Sweeps: sizes of bricks and macrocells. \
         Layouts: bytes of other nodes and caps. The papers' own figures of this kind stand with their tables.",
        &[
            ("/single/structures", "Single rays"),
            ("/single/phases", "Phases"),
            ("/single/sweeps", "Bricks and macrocells"),
            ("/layout", "Layouts"),
        ],
    ),
    plain(
        "Packets",
        "Nanoseconds a ray: the 2006 recursion, single rays, packets of 4², 8² and 16² masked and by slabs, and what is chosen.",
        &[("/packet", "Packets against single rays")],
    ),
    plain(
        "Scaling",
        "How time grows with size, pixels, threads and the surface, normals and shading included; exponents are of fits of powers.",
        &[
            ("/scaling/fits", "Fitted exponents"),
            ("/scaling/threads", "Threads"),
            ("/scaling/pixels", "Pixels"),
            ("/scaling/sizes", "Volume size"),
            ("/scaling/complexity", "Surfaces"),
        ],
    ),
    plain(
        "The papers' tables",
        "Figures of Parker et al. 1998, Knoll et al. 2006 and Knoll, Wald and Hansen 2009 beside ours of the same kind, with what theirs ran on. Their machines are long gone: how many times \
         as fast one way is as another can be compared, absolute rates hardly. Those of Marchesin and Colin de Verdière 2009 stand with adaptive meshes.",
        &[("/papers/*/figures", "Figures: the paper's and ours")],
    ),
    charted(
        "Adaptive meshes",
        "Making meshes; the rows of Tables 1 to 3 of Marchesin and Colin de Verdière 2009 (theirs on a GPU of 2006, ours on the processor); first hits and every scheme against the reference.",
        &[
            ("/amr/meshes", "Making"),
            ("/amr/tables", "Tables 1 to 3"),
            ("/amr/hits", "First hits"),
            ("/amr/errors", "Schemes"),
        ],
        knobs::meshes,
    ),
    plain(
        "Robustness",
        "Adversarial cases tried in this run; one failure fails it. Of doubtful ones the reference cannot tell what is right.",
        &[("/robustness", "Counts")],
    ),
];

impl Section {
    pub(crate) fn anchor(&self) -> String {
        self.title.chars().map(|c| if c.is_alphanumeric() { c.to_ascii_lowercase() } else { '-' }).collect()
    }

    pub(crate) fn is_in(&self, report: &Value) -> bool {
        self.tables.iter().any(|(place, _)| !rows(report, place).is_empty())
    }

    pub(crate) fn frontiers(&self, report: &Value) -> Vec<Frontier> {
        self.knobs.map_or_else(Vec::new, |knobs| knobs(report))
    }

    pub(crate) fn show(&self, report: &Value) -> Result<Markup> {
        Ok(html! {
            h2 id=(self.anchor()) { (self.title) }
            p.about { (self.about) }
            @for frontier in self.frontiers(report) { (frontier.show()) }
            @for (place, what) in self.tables {
                @let rows = rows(report, place);
                @if !rows.is_empty() {
                    // Long ones are closed at first.
                    details open[rows.len() <= LONG] { summary { (what) " (" (rows.len()) " rows)" } (table::show(&rows)) }
                }
            }
        })
    }
}

/// Rows of a table that is seen at once.
const LONG: usize = 20;

/// The rows at a place; `*` stands for all of a list, whose members that are not lists themselves go before theirs.
pub(crate) fn rows(report: &Value, place: &str) -> Vec<Value> {
    let Some((outer, inner)) = place.split_once("/*/") else {
        return report.pointer(place).and_then(Value::as_array).cloned().unwrap_or_default();
    };
    let mut all = Vec::new();
    for row in rows(report, outer) {
        let Some(members) = row.as_object() else { continue };
        let own: Vec<_> =
            members.iter().filter(|(_, value)| !value.is_array() && !value.is_object()).collect();
        for inner in row[inner].as_array().into_iter().flatten() {
            let mut joined = serde_json::Map::new();
            joined.extend(own.iter().map(|(name, value)| ((*name).clone(), (*value).clone())));
            joined.extend(
                inner.as_object().into_iter().flatten().map(|(name, value)| (name.clone(), value.clone())),
            );
            all.push(joined.into());
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_rows_have_what_is_said_of_all() {
        let report = serde_json::json!({ "a": [{ "volume": "v", "n": 3, "views": [{ "view": "far" }, { "view": "close" }] }] });
        let rows = rows(&report, "/a/*/views");
        assert_eq!(rows.len(), 2);
        assert_eq!(rows[1], serde_json::json!({ "volume": "v", "n": 3, "view": "close" }));
        assert!(super::rows(&report, "/b").is_empty());
    }

    #[test]
    fn anchors_differ() {
        let mut anchors: Vec<_> = ALL.iter().map(Section::anchor).collect();
        anchors.sort();
        anchors.dedup();
        assert_eq!(anchors.len(), ALL.len());
    }
}
