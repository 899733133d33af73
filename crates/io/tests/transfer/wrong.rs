//! Files and options that are wrong: one line, with the place.

use isoray_io::transfer::Remap;
use isoray_io::{TransferOptions, read_transfer_function};

use crate::read_as;

fn fails(name: &str, text: impl AsRef<[u8]>, options: &TransferOptions, end: &str) {
    let text = text.as_ref();
    let shown = String::from_utf8_lossy(text);
    let error = read_as(name, text, options).expect_err(&shown).to_string();
    let place = error.find(&format!("/{name}:")).unwrap_or_else(|| panic!("{shown}: no name in {error}"));
    assert_eq!(&error[place + 1..], format!("{name}:{end}"), "{shown}");
}

/// A point with these keys beside a value and a colour.
fn point(rest: &str) -> String {
    format!("[[points]]\nvalue = 1\ncolor = '#ffffff'\n{rest}")
}

#[test]
fn toml() {
    let base = "[[points]]\nvalue = 1\ncolor = '#ffffff'\nextinction = 0\n";
    let cases = [
        (
            point("extinction = -1"),
            "4:14: points[0].extinction: expected an extinction of at least 0, and at most 1e30, found -1",
        ),
        (
            point("extinction = nan"),
            "4:14: points[0].extinction: expected an extinction of at least 0, and at most 1e30, found NaN",
        ),
        (point("opacity = 1.5"), "4:11: points[0].opacity: expected an opacity from 0 to 1, found 1.5"),
        (point(""), "2:9: points[0].extinction: expected an extinction or an opacity, found neither"),
        (
            point("extinction = 0\nopacity = 0"),
            "5:11: points[0].opacity: expected either an extinction or an opacity, found both",
        ),
        (
            format!("{base}{}", base.replace("= 1", "= 0.5")),
            "6:9: points[1].value: expected a value of at least 1, that of the point before, found 0.5",
        ),
        (
            base.repeat(3),
            "10:9: points[2].value: expected at most two points of one value, found a third of value 1",
        ),
        (
            base.replace("= 1", "= inf"),
            "2:9: points[0].value: expected a number between -1e30 and 1e30, found inf",
        ),
        (
            base.replace("'#ffffff'", "'#fffff'"),
            "3:9: points[0].color: expected [red, green, blue] or \"#rrggbb\", found '#fffff'",
        ),
        (
            base.replace("'#ffffff'", "[1, 2]"),
            "3:9: points[0].color: expected [red, green, blue] or \"#rrggbb\", found [1, 2]",
        ),
        (
            base.replace("'#ffffff'", "[1, 2, 0]"),
            "3:9: points[0].color: expected components from 0 to 1, found 2",
        ),
        (
            format!("color_space = 'linear'\n{}", base.replace("'#ffffff'", "[1, -2, 0]")),
            "4:9: points[0].color: expected components of at least 0, found -2",
        ),
        (
            base.replace("color = '#ffffff'\n", ""),
            "2:9: points[0].color: expected a colour at each point, or a colormap for all, found neither",
        ),
        (
            format!("colormap = 'gray'\n{base}"),
            "4:9: points[0].color: expected no colour beside a colormap, found '#ffffff'",
        ),
        (
            format!("unit_distance = 0\n{base}"),
            "1:17: unit_distance: expected a length between 1e-20 and 1e20, found 0",
        ),
        ("points = []".to_owned(), "1:10: points: expected from 1 to 16384 points, found 0"),
    ];
    for (text, end) in cases {
        fails("a.toml", text, &TransferOptions::default(), end);
    }
}

#[test]
fn toml_that_its_parser_refuses() {
    let cases = [
        ("points = 3", "1:10: expected a transfer function in TOML, found: ", "sequence"),
        (
            "color_space = 'srgb'",
            "1:1: expected a transfer function in TOML, found: ",
            "missing field `points`",
        ),
        (
            "[[points]]\nextinction = 1",
            "1:1: expected a transfer function in TOML, found: ",
            "missing field `value`",
        ),
        ("[[points]]\nvalue = 'x'", "2:9: expected a transfer function in TOML, found: ", "string"),
        (
            "[[points]]\nvalue = 1\nextincton = 2",
            "3:1: expected a transfer function in TOML, found: ",
            "`extincton`, expected one of `value`",
        ),
        ("colour = 1\npoints = []", "1:1: expected a transfer function in TOML, found: ", "`colour`"),
        (
            "color_space = 'hsv'\npoints = []",
            "1:15: expected a transfer function in TOML, found: ",
            "`hsv`, expected `srgb` or `linear`",
        ),
        ("value = = 1", "1:9: expected a transfer function in TOML, found: ", ""),
        ("P5 4 4 255\n", "1:", ""),
    ];
    for (text, begin, part) in cases {
        let error = read_as("a.toml", text, &TransferOptions::default()).expect_err(text).to_string();
        let rest = error.split_once("/a.toml:").unwrap().1;
        assert!(rest.starts_with(begin) && rest.contains(part) && !rest.contains('\n'), "{text}: {rest}");
    }
    let map = "colormap = 'jet'\npoints = [{ value = 0, extinction = 0 }]";
    let error = read_as("a.toml", map, &TransferOptions::default()).unwrap_err().to_string();
    assert!(error.contains(":1:12: colormap: expected one of viridis, ") && error.ends_with("found 'jet'"));
}

#[test]
fn presets() {
    let rgb = |numbers: &str| format!("[{{\"RGBPoints\": [{numbers}]}}]");
    let with = |rest: &str| format!("[{{\"RGBPoints\": [0, 0, 0, 0, 1, 1, 1, 1], {rest}}}]");
    let value = "expected a value of at least 0.5, that of the point before, found 0.25";
    let cases = [
        (rgb("0, 0,0,0, 0.5, 0,0,0, 0.5, 1,1,1, 0.25, 1,1,1"), format!(" RGBPoints[12]: {value}")),
        (with("\"Points\": [0.5, 0, 0.5, 0, 0.25, 0, 0.5, 0]"), format!(" Points[4]: {value}")),
        (rgb("0, 0, 0, 0, 1"), " RGBPoints: expected 4 numbers for each of at least one point, found 5 numbers".into()),
        (rgb(""), " RGBPoints: expected 4 numbers for each of at least one point, found 0 numbers".into()),
        (rgb("0, 0, 0, \"1\""), " RGBPoints[3]: expected a number, found '1'".into()),
        (rgb("0, 0, null, 1"), " RGBPoints[2]: expected a number, found null".into()),
        (rgb("0, 0, 255, 1"), " RGBPoints[2]: expected a green from 0 to 1, found 255".into()),
        (rgb("0,0,0,0,0,0,0,0,0,0,0,0"), " RGBPoints[8]: expected at most two points of one value, found a third of value 0".into()),
        (rgb("1e31, 0, 0, 0"), " RGBPoints[0]: expected a number between -1e30 and 1e30, found 10000000000000000000000000000000".into()),
        (with("\"Points\": [0, 1.5, 0.5, 0]"), " Points[1]: expected an opacity from 0 to 1, found 1.5".into()),
        (with("\"Points\": [0, 1, -0.5, 0]"), " Points[2]: expected a midpoint from 0 to 1, found -0.5".into()),
        (with("\"Points\": [0, 1, 0.5, 2]"), " Points[3]: expected a sharpness from 0 to 1, found 2".into()),
        (with("\"Points\": {}"), " Points: expected an array of numbers, found an object".into()),
        (with("\"ColorSpace\": \"HSV\""), " ColorSpace: expected one of RGB, Lab, CIELAB, Diverging and Step (others are not supported), found 'HSV'".into()),
        (with("\"ColorSpace\": 3"), " ColorSpace: expected one of RGB, Lab, CIELAB, Diverging and Step (others are not supported), found 3".into()),
        ("[{}]".into(), " RGBPoints: expected the colours of the preset, [value, red, green, blue, …], found no such key".into()),
        ("[{\"IndexedColors\": [0, 0, 0]}]".into(), " RGBPoints: expected the colours of the preset, [value, red, green, blue, …], found only IndexedColors, which are for categories".into()),
        ("[]".into(), " preset: expected a preset, {\"RGBPoints\": […], …}, or an array of presets, found an empty array".into()),
        ("[3]".into(), " [0]: expected a preset, {\"RGBPoints\": […], …}, or an array of presets, found 3".into()),
        ("3".into(), " preset: expected a preset, {\"RGBPoints\": […], …}, or an array of presets, found 3".into()),
        ("[\n {\"Name\": }]".into(), "2:11: expected a ParaView preset in JSON, found: expected value".into()),
        ("[{\"RGBPoints\": [1e999]}]".into(), "1:21: expected a ParaView preset in JSON, found: number out of range".into()),
        ("hello".into(), "1:1: expected a ParaView preset in JSON, found: expected value".into()),
    ];
    for (text, end) in cases {
        fails("a.json", text, &TransferOptions::default(), &end);
    }
    let many = "0,0,0,0,".repeat(20_000);
    let end = " RGBPoints: expected at most 16384 points, found 20001";
    fails("a.json", rgb(&format!("{many}0,0,0,0")), &TransferOptions::default(), end);
}

#[test]
fn no_transfer_functions_at_all() {
    let default = TransferOptions::default();
    for name in ["a.toml", "a.json", "a"] {
        fails(name, "", &default, " expected a transfer function, found an empty file");
        fails(name, " \n\u{feff}".trim(), &default, " expected a transfer function, found an empty file");
        let end = " expected a transfer function as text (TOML, or a ParaView preset in JSON), found none: byte 2 is not UTF-8";
        fails(name, b"\n\n\xff\x00", &default, end);
        let end = " expected a transfer function of at most 8388608 bytes, found a longer file";
        fails(name, vec![b' '; (8 << 20) + 1], &default, end);
    }
    let gone = read_transfer_function("nowhere/a.toml".as_ref(), &default).unwrap_err();
    assert_eq!(gone.to_string(), "nowhere/a.toml: cannot open");
    let folder = tempfile::tempdir().unwrap();
    assert!(read_transfer_function(folder.path(), &default).is_err());
}

#[test]
fn options() {
    let preset = "[{\"RGBPoints\": [0, 0, 0, 0, 1, 1, 1, 1]}]";
    let remap = |range, log| TransferOptions { remap: Remap { range, log }, ..TransferOptions::default() };
    let range = " expected a range of two numbers between -1e30 and 1e30, the smaller one first, found";
    fails("a.json", preset, &remap(Some([2.0, 1.0]), false), &format!("{range} 2 to 1"));
    fails("a.json", preset, &remap(Some([1.0, f32::NAN]), false), &format!("{range} 1 to NaN"));
    let log = " expected positive values to map by their logarithm, found the range";
    fails("a.json", preset, &remap(Some([0.0, 1.0]), true), &format!("{log} 0 to 1"));
    fails("a.json", preset, &remap(None, true), &format!("{log} 0 to 1"));
    let data = TransferOptions { data_range: Some([-5.0, 5.0]), ..remap(None, true) };
    fails("a.json", preset, &data, &format!("{log} -5 to 5"));
    let unit = TransferOptions { unit_distance: 0.0, ..TransferOptions::default() };
    fails("a.json", preset, &unit, " expected a unit distance between 1e-20 and 1e20, found 0");
}
