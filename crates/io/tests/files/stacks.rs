//! TIFF stacks: files of many pages, folders and lists of slices.

use glam::DVec3;
use isoray_grid::ScalarType;
use isoray_io::{Dataset, Endian, OpenOptions, ReadError, SampleType};

use crate::damaged::fails;
use crate::make::{DIMS, body, read, write};
use crate::round_trips::{ENDIANS, check, open, open_component, spacing};
use crate::tiff_file::{COMPRESSIONS, Page, pages, tiff};

#[test]
fn all_types() {
    let dir = tempfile::tempdir().unwrap();
    for sample in SampleType::ALL {
        for endian in ENDIANS {
            for big in [false, true] {
                let bytes = tiff(&pages(sample, endian, 1), endian, big);
                let dataset = open(&write(dir.path(), "a.tif", &[&bytes]));
                check(&dataset, sample.scalar(), 0);
                assert_eq!((dataset.format(), spacing(&dataset)), ("TIFF", DVec3::ONE));
            }
        }
    }
}

#[test]
fn compressions_strips_and_tiles() {
    let dir = tempfile::tempdir().unwrap();
    for compression in COMPRESSIONS {
        for (rows, tile) in [(4, None), (1, None), (3, None), (4, Some(16))] {
            for endian in ENDIANS {
                let change = |page| Page { compression, rows, tile, ..page };
                let pages: Vec<_> = pages(SampleType::U16, endian, 3).into_iter().map(change).collect();
                let path = write(dir.path(), "a.tiff", &[&tiff(&pages, endian, false)]);
                (0..3).for_each(|component| {
                    check(&open_component(&path, component), ScalarType::U16, component)
                });
                fails(&path, "file has 3 components");
            }
        }
    }
}

#[test]
fn smaller_copies_are_passed_over() {
    let dir = tempfile::tempdir().unwrap();
    let full = pages(SampleType::U8, Endian::Little, 1);
    let small = Page { size: [2, 2], samples: vec![1; 4], kind: 1, rows: 2, ..full[0].clone() };
    let mixed: Vec<Page> = full.iter().flat_map(|page| [small.clone(), page.clone()]).collect();
    check(&open(&write(dir.path(), "s.tif", &[&tiff(&mixed, Endian::Little, false)])), ScalarType::U8, 0);
    let path = write(dir.path(), "s.tif", &[&tiff(&[small], Endian::Little, false)]);
    assert!(matches!(fails(&path, "found neither"), ReadError::NoSlices { .. }));
}

#[test]
fn folders_and_lists_of_slices() {
    let dir = tempfile::tempdir().unwrap();
    let pages = pages(SampleType::F32, Endian::Big, 1);
    let slice = |page: &Page| tiff(std::slice::from_ref(page), Endian::Big, false);
    let names = ["slice10.TIF", "slice2.tif", "slice9.tiff"];
    let mut paths = Vec::new();
    for (name, page) in names.iter().zip([2, 0, 1]) {
        paths.push(write(dir.path(), name, &[&slice(&pages[page])]));
    }
    write(dir.path(), "notes.txt", &[b"not a slice"]);
    write(dir.path(), "._slice1.tif", &[b"not a slice"]);
    let dataset = open(dir.path());
    check(&dataset, ScalarType::F32, 0);
    assert_eq!(dataset.path(), dir.path());
    assert!(dataset.mapped::<f32>().is_none());

    let options = OpenOptions::default();
    let list = [1, 2, 0].map(|i| paths[i].clone());
    check(&Dataset::open_slices(&list, &options).unwrap(), ScalarType::F32, 0);
    check(
        &Dataset::open_slices(&[write(dir.path(), "all", &[&tiff(&pages, Endian::Big, true)])], &options)
            .unwrap(),
        ScalarType::F32,
        0,
    );
    assert!(matches!(Dataset::open_slices(&[], &options), Err(ReadError::NoSlices { .. })));
    let named = OpenOptions { field: Some("a".to_owned()), ..Default::default() };
    assert!(matches!(Dataset::open(dir.path(), &named), Err(ReadError::NoFields { .. })));
    let raw = OpenOptions { raw: crate::damaged::raw(DIMS, 0).raw, ..Default::default() };
    assert!(matches!(Dataset::open(dir.path(), &raw), Err(ReadError::NotRaw { .. })));

    // A slice that changes after it was opened.
    let late = open(dir.path());
    write(
        dir.path(),
        "slice9.tiff",
        &[&slice(&Page { samples: vec![0; 40], size: [5, 2], ..pages[0].clone() })],
    );
    let error = read(&late, 1).unwrap_err();
    let source = std::error::Error::source(&error).unwrap().to_string();
    assert!(
        source.contains("slice9.tiff: page 0: expected 5x4 f32 with 1 components, found 5x2"),
        "{source}"
    );

    let error = Dataset::open(dir.path(), &options).unwrap_err().to_string();
    let expected =
        "slice9.tiff: page 0: expected 5x4 f32 with 1 components like the first page, found 5x2 f32";
    assert!(error.contains(expected), "{error}");
    write(dir.path(), "slice9.tiff", &[&tiff(&pages, Endian::Big, false)]);
    let error = Dataset::open(dir.path(), &options).unwrap_err().to_string();
    assert!(error.ends_with("slice9.tiff: slice: expected one page, found '3 pages'"), "{error}");

    let empty = tempfile::tempdir().unwrap();
    assert!(matches!(Dataset::open(empty.path(), &options), Err(ReadError::NoSlices { .. })));
}

#[test]
fn distances_of_imagej() {
    let dir = tempfile::tempdir().unwrap();
    let resolution = Some([[4, 1], [5, 2]]);
    let calibrated = "ImageJ=1.54f\nimages=3\nslices=3\nunit=micron\nspacing=2.5\nloop=false\n";
    let cases = [
        (calibrated, resolution, DVec3::new(0.25, 0.4, 2.5)),
        ("ImageJ=1.54f\nimages=3\nslices=3\nunit=mm\n", resolution, DVec3::new(0.25, 0.4, 1.0)),
        ("ImageJ=1.54f\nimages=3\nslices=3\nspacing=3\n", resolution, DVec3::new(1.0, 1.0, 3.0)),
        ("ImageJ=1.54f\nimages=3\nunit=mm\nspacing=nan", Some([[0, 1], [1, 0]]), DVec3::ONE),
        ("", resolution, DVec3::ONE),
        ("by hand", resolution, DVec3::ONE),
    ];
    for (description, resolution, expected) in cases {
        let mut pages = pages(SampleType::U8, Endian::Little, 1);
        (pages[0].description, pages[0].resolution) = (description, resolution);
        let dataset = open(&write(dir.path(), "r.tif", &[&tiff(&pages, Endian::Little, false)]));
        assert_eq!(spacing(&dataset), expected, "{description}");
    }
}

#[test]
fn large_imagej_stacks_have_one_page() {
    let dir = tempfile::tempdir().unwrap();
    let (sample, endian) = (SampleType::I16, Endian::Big);
    let mut first = pages(sample, endian, 1).remove(0);
    first.description = "ImageJ=1.54f\nimages=3\nslices=3\nspacing=2\n";
    let mut bytes = tiff(std::slice::from_ref(&first), endian, false);
    // The strip is moved to the end, where all layers lie.
    let at = bytes.windows(first.samples.len()).position(|w| w == first.samples).unwrap() as u32;
    let field = bytes.windows(4).rposition(|w| w == at.to_be_bytes()).unwrap();
    let end = (bytes.len() as u32).to_be_bytes();
    bytes[field..field + 4].copy_from_slice(&end);
    bytes.extend(body(sample, endian, 1, true));
    let dataset = open(&write(dir.path(), "l.tif", &[&bytes]));
    check(&dataset, ScalarType::I16, 0);
    assert_eq!(spacing(&dataset), DVec3::new(1.0, 1.0, 2.0));
    bytes.truncate(bytes.len() - 1);
    fails(&write(dir.path(), "l.tif", &[&bytes]), "expected 120 bytes of samples, found 119");
    first.compression = 8;
    let path = write(dir.path(), "l.tif", &[&tiff(&[first], endian, false)]);
    fails(&path, "one page and no compression, found '3 images, 1 pages'");
}

#[test]
fn pages_that_are_wrong() {
    let dir = tempfile::tempdir().unwrap();
    let path = |pages: &[Page]| write(dir.path(), "w.tif", &[&tiff(pages, Endian::Little, false)]);
    let valid = pages(SampleType::U16, Endian::Little, 1);
    let changed = |change: fn(&mut Page)| {
        let mut pages = valid.clone();
        change(&mut pages[1]);
        path(&pages)
    };
    let other = changed(|page| (page.size, page.samples) = ([4, 5], page.samples.clone()));
    assert!(matches!(fails(&other, "page 1: expected 5x4 u16"), ReadError::Page { page: 1, .. }));
    fails(&changed(|page| page.sample = SampleType::I16), "found 5x4 i16 with 1 components");
    fails(&changed(|page| page.compression = 7), "none, LZW, deflate or PackBits, found 'ModernJPEG'");
    fails(
        &changed(|page| (page.size, page.rows) = ([5, 400_000], 400_000)),
        "expected 4000000 bytes of samples of a page, found room for at most 40",
    );
    for description in ["ImageJ=1\nchannels=2\n", "ImageJ=1\nframes=7\n", "<OME><Pixels SizeC=\"2\"/></OME>"]
    {
        let mut pages = valid.clone();
        pages[0].description = description;
        fails(&path(&pages), "a stack of more axes is not supported; expected one channel and one time step");
    }
    fails(&write(dir.path(), "w.tif", &[b"II\x2a\0\x08\0\0\0"]), "a TIFF page that can be read");
    fails(&write(dir.path(), "w.tif", &[b"no TIFF"]), "a TIFF page that can be read");
}
