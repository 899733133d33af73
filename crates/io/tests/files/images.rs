//! Images: what is written is read back, and failures leave nothing behind.

use exr::prelude::{FlatSamples, read_first_flat_layer_from_file};
use isoray_io::{ExrChannel, PixelData, WriteError, write_exr, write_png};

/// Names in `folder`.
fn names(folder: &std::path::Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect()
}

#[test]
fn png_round_trip() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.png");
    let bytes: Vec<u8> = (0..24).collect();
    write_png(&path, 4, 2, PixelData::Rgb8(&bytes)).unwrap();
    assert_eq!(image::open(&path).unwrap().into_rgb8().into_raw(), bytes);
    // A second image replaces the first.
    write_png(&path, 3, 2, PixelData::Rgba8(&bytes)).unwrap();
    let found = image::open(&path).unwrap().into_rgba8();
    assert_eq!((found.dimensions(), found.into_raw()), ((3, 2), bytes));
    assert_eq!(names(dir.path()), ["a.png"]);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // A file made in the usual way shows the mask.
        std::fs::write(dir.path().join("b"), b"").unwrap();
        let mode = |name| std::fs::metadata(dir.path().join(name)).unwrap().permissions().mode();
        assert_eq!(mode("a.png"), mode("b"));
    }
}

#[test]
fn exr_round_trip() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.exr");
    let planes: Vec<Vec<f32>> =
        (0..8).map(|c| (0..35).map(|p| (c * 100 + p) as f32 / 7.0).collect()).collect();
    let mut planes = planes;
    planes[4][3] = f32::INFINITY;
    planes[4][5] = -0.0;
    let labels = ["R", "G", "B", "A", "Z", "N.X", "N.Y", "N.Z"];
    let channels: Vec<_> =
        labels.iter().zip(&planes).map(|(&name, data)| ExrChannel { name, data }).collect();
    write_exr(&path, 7, 5, &channels).unwrap();

    let found = read_first_flat_layer_from_file(&path).unwrap().layer_data;
    assert_eq!((found.size.width(), found.size.height()), (7, 5));
    assert_eq!(found.channel_data.list.len(), 8);
    for channel in found.channel_data.list {
        let name = channel.name.to_string();
        let expected = &planes[labels.iter().position(|&l| l == name).unwrap()];
        let FlatSamples::F32(values) = channel.sample_data else { panic!("{name} is not 32-bit float") };
        assert!(values.iter().zip(expected).all(|(f, e)| f.to_bits() == e.to_bits()), "{name}");
    }
    assert_eq!(names(dir.path()), ["a.exr"]);

    // The same input gives the same bytes.
    let again = dir.path().join("b.exr");
    write_exr(&again, 7, 5, &channels).unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), std::fs::read(&again).unwrap());
}

#[test]
fn refuses_wrong_lengths_sizes_and_names() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a");
    let data = [0f32; 4];
    let channel = |name| ExrChannel { name, data: &data };
    let error = write_png(&path, 2, 2, PixelData::Rgb8(&[0; 11])).unwrap_err();
    assert!(error.to_string().ends_with("RGB: expected 12 values, found 11"), "{error}");
    let error = write_png(&path, 0, 2, PixelData::Rgb8(&[])).unwrap_err();
    assert!(error.to_string().ends_with("found 0x2"), "{error}");
    let error = write_exr(&path, 3, 2, &[channel("R")]).unwrap_err();
    assert!(error.to_string().ends_with("R: expected 6 values, found 4"), "{error}");
    for channels in [vec![], vec![channel("R"), channel("R")], vec![channel("")], vec![channel("ä")]] {
        let error = write_exr(&path, 2, 2, &channels).unwrap_err();
        assert!(matches!(error, WriteError::Channels { .. }), "{error}");
    }
    assert_eq!(names(dir.path()), [""; 0]);
}

#[test]
fn failures_leave_nothing_behind() {
    let dir = tempfile::tempdir().unwrap();
    let missing = dir.path().join("none").join("a.png");
    let error = write_png(&missing, 1, 1, PixelData::Rgb8(&[0; 3])).unwrap_err();
    assert!(matches!(error, WriteError::Folder { .. }), "{error}");

    std::fs::create_dir(dir.path().join("a.png")).unwrap();
    let error = write_png(&dir.path().join("a.png"), 1, 1, PixelData::Rgb8(&[0; 3])).unwrap_err();
    assert!(matches!(error, WriteError::Rename { .. }), "{error}");
    assert_eq!(names(dir.path()), ["a.png"]);
}
