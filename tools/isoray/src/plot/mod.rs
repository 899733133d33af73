//! Pictures of transfer functions.

mod axis;
mod canvas;

use glam::Vec3;
use isoray_octree::Meta;
use isoray_preint::TransferFunction;
use isoray_render::encode_srgb;

use axis::Axis;
use canvas::{CHARACTER, Canvas, Color, width};

const PAPER: Color = [255, 255, 255];
const INK: Color = [40, 40, 40];
const GRID: Color = [225, 225, 225];
const HISTOGRAM: Color = [200, 203, 210];

/// Smallest and largest sides of a picture, in pixels.
pub(crate) const SIDES: [u32; 2] = [120, 8192];
/// Height at which a dot of a number is one pixel wide, and so on.
const DOT: u32 = 400;
/// Share of the values shown that lies beyond the first and the last, on either side.
const MARGIN: f64 = 0.04;
/// Share of the fill under the curve in what is seen there: the histogram shows through.
const FILL: f64 = 0.6;
/// Room for a number, in pixels.
const LABEL: [u32; 2] = [70, 32];

/// Pixels from and to, along x and y.
struct Area {
    x: [i64; 2],
    y: [i64; 2],
}

impl Area {
    /// The column of a place from 0 to 1.
    fn column(&self, place: f64) -> i64 {
        let [from, to] = self.x;
        (from as f64 + place.clamp(-1.0, 2.0) * (to - from) as f64).round() as i64
    }

    /// The row of a height from 0 to 1.
    fn row(&self, height: f64) -> i64 {
        let [from, to] = self.y;
        (to as f64 - height.clamp(-1.0, 2.0) * (to - from) as f64).round() as i64
    }
}

/// Draws the colours of a transfer function as a bar, and under it extinction (linear, from 0) over value (linear or
/// logarithmic); behind the curve the volume's histogram, with heights as the logarithm of 1 + the number of samples.
/// Three bytes a pixel.
pub(crate) fn draw(function: &TransferFunction, meta: Option<&Meta>, size: [u32; 2], log: bool) -> Vec<u8> {
    let scale = (size[1] / DOT).max(1);
    let dot = i64::from(scale);
    let [width_px, height_px] = size.map(i64::from);
    let values = values_shown(function, meta, log);
    let log = log && values[0] > 0.0;
    let across = Axis::with_margin(values, log, MARGIN);
    let densest = function.points().iter().map(|p| f64::from(p.extinction)).fold(0.0, f64::max);
    let up = Axis::new([0.0, if densest > 0.0 { 1.05 * densest } else { 1.0 }], false);

    let rows = up.ticks(size[1] / scale / LABEL[1]);
    let label = rows.iter().map(|(_, text)| width(text, scale)).max().unwrap_or(0);
    let x = [label + 12 * dot, width_px - 10 * dot];
    let bar = Area { x, y: [8 * dot, 8 * dot + height_px / 8] };
    let plot = Area { x, y: [bar.y[1] + 10 * dot, height_px - (i64::from(CHARACTER[1]) + 12) * dot] };

    let mut canvas = Canvas::new(size, PAPER);
    for (value, text) in &rows {
        let y = plot.row(up.place(*value));
        canvas.fill(plot.x[0] - 4 * dot..plot.x[1], y..y + 1, GRID);
        let left = plot.x[0] - 6 * dot - width(text, scale);
        canvas.number([left, y - i64::from(CHARACTER[1] / 2) * dot], text, scale, INK);
    }
    for (value, text) in across.ticks((size[0] / scale / LABEL[0]).max(1)) {
        let x = plot.column(across.place(value));
        canvas.fill(x..x + 1, plot.y[0]..plot.y[1] + 4 * dot, GRID);
        let left = (x - width(&text, scale) / 2).min(width_px - width(&text, scale) - dot);
        canvas.number([left, plot.y[1] + 7 * dot], &text, scale, INK);
    }
    if let Some(meta) = meta {
        histogram(&mut canvas, &plot, &across, meta);
    }
    curve(&mut canvas, [&bar, &plot], [&across, &up], function, dot);
    frame(&mut canvas, &bar);
    frame(&mut canvas, &plot);
    canvas.pixels().to_vec()
}

/// The values of the function's points and of the data; with `log` those of the points alone if not all are positive.
fn values_shown(function: &TransferFunction, meta: Option<&Meta>, log: bool) -> [f64; 2] {
    let ends = [function.points().first(), function.points().last()];
    let [low, high] = ends.map(|p| p.map_or(0.0, |p| f64::from(p.value)));
    match meta.and_then(|m| m.range) {
        Some([least, greatest]) if !log || least > 0.0 => [low.min(least), high.max(greatest)],
        _ => [low, high],
    }
}

fn histogram(canvas: &mut Canvas, plot: &Area, across: &Axis, meta: &Meta) {
    let Some([low, high]) = meta.range else { return };
    let most = meta.histogram.iter().copied().max().unwrap_or(0) as f64;
    let border = |bin: usize| low + (high - low) * bin as f64 / meta.histogram.len() as f64;
    for (bin, &n) in meta.histogram.iter().enumerate().filter(|(_, n)| **n > 0) {
        let [from, to] = [bin, bin + 1].map(|b| plot.column(across.place(border(b))));
        let x = from.max(plot.x[0])..to.max(from + 1).min(plot.x[1]);
        let height = (1.0 + n as f64).ln() / (1.0 + most).ln();
        canvas.fill(x, plot.row(0.95 * height)..plot.y[1], HISTOGRAM);
    }
}

/// The bar, the colours under the curve, and the curve.
fn curve(
    canvas: &mut Canvas,
    [bar, plot]: [&Area; 2],
    [across, up]: [&Axis; 2],
    tf: &TransferFunction,
    dot: i64,
) {
    let [from, to] = plot.x;
    let value = |x: i64| across.value((x - from) as f64 / (to - from).max(1) as f64) as f32;
    for x in from..to {
        let color = encode_srgb(Vec3::from_array(tf.at(0.5 * (value(x) + value(x + 1))).color));
        canvas.fill(x..x + 1, bar.y[0]..bar.y[1], color);
        let [_, most] = extremes(tf, [value(x), value(x + 1)]).map(|e| plot.row(up.place(f64::from(e))));
        canvas.mix(x..x + 1, most..plot.y[1], color, FILL);
    }
    // After all of the fill, which would cover its sides.
    for x in from..to {
        let [least, most] = extremes(tf, [value(x), value(x + 1)]).map(|e| plot.row(up.place(f64::from(e))));
        canvas.fill(x..x + dot, most - dot..least + 1, INK);
    }
}

/// The least and the greatest extinction of the values of a column of pixels: none of its peaks is lost.
fn extremes(function: &TransferFunction, [low, high]: [f32; 2]) -> [f32; 2] {
    let points = function.points();
    let [begin, end] = [low, high].map(|v| points.partition_point(|p| p.value < v));
    let inside = points[begin..end.max(begin)].iter().map(|p| p.extinction);
    let ends = [low, high].map(|v| function.at(v).extinction);
    inside.chain(ends).fold([f32::INFINITY, 0.0], |[least, most], e| [least.min(e), most.max(e)])
}

fn frame(canvas: &mut Canvas, area: &Area) {
    let Area { x: [left, right], y: [top, bottom] } = *area;
    for y in [top - 1, bottom] {
        canvas.fill(left - 1..right + 1, y..y + 1, INK);
    }
    for x in [left - 1, right] {
        canvas.fill(x..x + 1, top - 1..bottom + 1, INK);
    }
}

#[cfg(test)]
mod tests {
    use isoray_preint::ControlPoint;

    use super::*;

    #[test]
    fn colours_and_a_spike_are_seen() {
        let point = |value, color, extinction| ControlPoint { value, color, extinction };
        let spike = vec![
            point(0.0, [1.0, 0.0, 0.0], 0.0),
            point(0.49999, [1.0, 0.0, 0.0], 0.0),
            point(0.5, [0.0, 0.0, 1.0], 9.0),
            point(0.50001, [0.0, 0.0, 1.0], 0.0),
            point(1.0, [0.0, 0.0, 1.0], 0.0),
        ];
        let function = TransferFunction::new(spike).unwrap();
        let [width, height] = [300, 200];
        let pixels = draw(&function, None, [width, height], false);
        assert_eq!(pixels.len(), (3 * width * height) as usize);
        let is = |color: Color| pixels.chunks(3).filter(|p| *p == color).count();
        assert!(is([255, 0, 0]) > 1000 && is([0, 0, 255]) > 1000);
        // The spike is as high as the plot.
        let ink = |row: u32| {
            pixels[(3 * row * width) as usize..][..3 * width as usize].chunks(3).filter(|p| *p == INK).count()
        };
        assert_eq!(ink(80), 3, "the frame's sides and the spike");
    }

    #[test]
    fn a_single_point_and_the_smallest_picture() {
        let point = ControlPoint { value: -3e29, color: [5.0; 3], extinction: 0.0 };
        let function = TransferFunction::new(vec![point]).unwrap();
        for size in [[SIDES[0]; 2], [SIDES[0], 2000]] {
            assert!(draw(&function, None, size, true).contains(&255));
        }
    }
}
