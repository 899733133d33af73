//! Published and simulated meshes, compared with what scripts of their own read; skipped, loudly, where they are not at hand.

use std::path::{Path, PathBuf};

use glam::DVec3;
use isoray_amr::{Centering, Patches};
use isoray_io::{AmrDataset, ReadError};

use crate::real_vtk::{KNOWN, checksum};

/// The folder or file, if it is there.
fn real(name: &str) -> Option<PathBuf> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/amr").join(name);
    if path.exists() {
        return Some(path);
    }
    println!("SKIPPED: {} is not there", path.display());
    None
}

fn boxes_and_cells(dataset: &AmrDataset) -> Vec<(usize, u64)> {
    dataset.levels().iter().map(|l| (l.boxes, l.cells)).collect()
}

fn check(patches: &Patches, range: [f32; 2], sum: u32) {
    let values: Vec<f32> = patches.patches.iter().flat_map(|p| p.values.iter().copied()).collect();
    let found = values.iter().fold([f32::INFINITY, f32::NEG_INFINITY], |[a, b], &v| [a.min(v), b.max(v)]);
    assert_eq!(found, range);
    assert_eq!(checksum(&values), sum);
}

/// Plotfile, field, boxes and cells of each level, range, and [`checksum`].
type Plotfile = (&'static str, &'static str, &'static [(usize, u64)], [f32; 2], u32);

#[rustfmt::skip]
const PLOTFILES: [Plotfile; 5] = [
    ("amrex_rt/plt00525", "density", &[(1, 8192), (2, 40960), (19, 134656)], [0.49543515, 2.0226493], 0xa3f3048a),
    ("amrex_rt/plt00525", "Temp", &[(1, 8192), (2, 40960), (19, 134656)], [6.607348e-7, 3.4738869e-6], 0x846204f6),
    ("amrex_rt/plt00846", "density", &[(1, 8192), (2, 57344), (16, 307200)], [0.4843102, 2.09155], 0xf47c34f8),
    ("plt_eb_3d", "density", &[(1, 32768), (1, 131072)], [0.0, 1.1813713], 0xd8780000),
    ("plt_eb_3d", "volFrac", &[(1, 32768), (1, 131072)], [0.0, 1.0], 0x8b240000),
];

#[test]
fn plotfiles() {
    for (name, field, levels, range, sum) in PLOTFILES {
        let Some(path) = real(name) else { continue };
        let dataset = AmrDataset::open(&path).unwrap();
        assert_eq!(boxes_and_cells(&dataset), levels, "{name}");
        let patches = dataset.read(Some(field)).unwrap();
        assert_eq!(patches.centering, Centering::Cells);
        assert!(patches.ratios.iter().all(|&r| r == 2) && patches.ratios.len() + 1 == levels.len());
        check(&patches, range, sum);
        let (low, cells) = patches.domain;
        let corner = |i: [f64; 3]| patches.index_to_world.transform_point3(DVec3::from(i));
        let (expected_cells, from, to) = if name == "plt_eb_3d" {
            ([64, 32, 16], [-0.02, 0.0, 0.0], [0.06, 0.04, 0.02])
        } else {
            ([16, 16, 32], [0.0; 3], [0.5, 0.5, 1.0])
        };
        assert_eq!((low, cells), ([0; 3], expected_cells));
        assert_eq!(corner([0.0; 3]), DVec3::from(from));
        assert!((corner(cells.map(f64::from)) - DVec3::from(to)).length() < 1e-15);
        assert!(matches!(dataset.read(Some("nothing")), Err(ReadError::NoSuchField { .. })));
    }
}

#[test]
fn chombo() {
    let Some(path) = real("chombo3d/chombo3d.vtm") else { return };
    assert!(AmrDataset::recognises(&path));
    let dataset = AmrDataset::open(&path).unwrap();
    assert_eq!(boxes_and_cells(&dataset), [(1, 512), (1, 4096), (14, 5568)]);
    let patches = dataset.read(None).unwrap();
    assert_eq!((patches.centering, &patches.ratios[..]), (Centering::Cells, &[2, 2][..]));
    assert_eq!(patches.domain, ([0; 3], [8; 3]));
    assert_eq!(patches.patches.len(), 16);
    for (number, patch) in patches.patches.iter().enumerate() {
        let file = format!("amr/chombo3d/chombo3d_{number}.vti");
        let (_, dims, first, spacing, sum) = KNOWN.into_iter().find(|known| known.0 == file).unwrap();
        assert_eq!((patch.cells, checksum(&patch.values)), (dims, sum), "{file}");
        // The first is the centre of the lowest cell.
        let low = DVec3::from(patch.low.map(f64::from)) + 0.5;
        let place = patches.index_to_world.transform_point3(low / f64::from(1 << patch.level));
        assert_eq!((place, spacing), (DVec3::from(first), 1.0 / f64::from(1 << patch.level)), "{file}");
    }
}

#[test]
fn gerris() {
    let Some(path) = real("gerris_thermal/thermal-1.50.vtk") else { return };
    assert!(AmrDataset::recognises(&path));
    let dataset = AmrDataset::open(&path).unwrap();
    let levels = [324, 977, 2137, 7408, 73792];
    assert_eq!(boxes_and_cells(&dataset), levels.map(|n| (n, n as u64)));
    let names: Vec<_> = dataset.fields().iter().map(|f| f.name.as_str()).collect();
    assert_eq!(names, ["T", "U", "V", "W", "P"]);
    for (field, range, sum) in
        [("T", [-0.0015208, 0.8725], 0x0c40a8f0), ("P", [-0.136569, 0.0561991], 0x8ba581dd)]
    {
        let patches = dataset.read(Some(field)).unwrap();
        assert_eq!((patches.centering, &patches.ratios[..]), (Centering::Vertices, &[2; 4][..]));
        assert_eq!(patches.domain, ([0; 3], [8; 3]));
        let map = patches.index_to_world;
        assert_eq!(map.transform_point3(DVec3::ZERO), DVec3::splat(-0.5));
        assert_eq!(map.transform_point3(DVec3::splat(8.0)), DVec3::splat(0.5));
        check(&patches, range, sum);
        // The leaves fill the cube: no cell is in two, and all volumes add up.
        let volume: u64 = patches.patches.iter().map(|p| 8u64.pow(4 - p.level)).sum();
        let mut cells: Vec<_> = patches.patches.iter().map(|p| (p.level, p.low)).collect();
        cells.sort_unstable();
        cells.dedup();
        assert_eq!((volume, cells.len()), (128 * 128 * 128, patches.patches.len()));
    }
}

#[test]
fn formats_to_come() {
    let names = [
        ("enzo_DD0010", "Enzo"),
        ("enzo_DD0010/moving7_0010", "Enzo"),
        ("enzo_DD0010/moving7_0010.hierarchy", "Enzo"),
        ("ramses_output_00004", "RAMSES"),
        ("ramses_output_00004/info_00004.txt", "RAMSES"),
    ];
    for (name, format) in names {
        let Some(path) = real(name) else { continue };
        assert!(AmrDataset::recognises(&path));
        let error = AmrDataset::open(&path).unwrap_err();
        assert!(matches!(error, ReadError::NotYet { .. }) && error.to_string().contains(format), "{error}");
    }
}

#[test]
fn volumes_are_no_meshes() {
    let names =
        ["volumes", "volumes/cthead/cthead.mhd", "series/isabel/isabel_02.vti", "volumes/tooth/tooth.nhdr"];
    for name in names {
        let Some(path) = real(&format!("../{name}")) else { continue };
        assert!(!AmrDataset::recognises(Path::new(&path)), "{name}");
    }
}
