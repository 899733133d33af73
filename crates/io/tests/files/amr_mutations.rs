//! Damaged meshes: whatever the bytes, reading ends with patches or a typed error.

use std::cell::RefCell;
use std::path::{Path, PathBuf};

use isoray_amr::Centering;
use isoray_io::{AmrDataset, ReadError};
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;

use crate::damage::apply;
use crate::make::write;
use crate::make_amr::{Hexahedra, Plotfile, write_vtk};
use crate::mutations::change;

/// A mesh on disk, its file that is damaged, and the bytes of that.
type Seed = (PathBuf, PathBuf, Vec<u8>);

fn seeds(dir: &Path) -> Vec<Seed> {
    let ghosts = Plotfile { ghosts: [1; 3], ..Plotfile::default() };
    let bare = Plotfile { version: 2, centering: Centering::Vertices, ..Plotfile::default() };
    let mut seeds = Vec::new();
    for (number, plotfile) in [Plotfile::default(), ghosts, bare].into_iter().enumerate() {
        let folder = plotfile.write(dir, &format!("plt{number}"));
        for file in ["Header", "Level_1/Cell_H", "Level_1/Cell_D_00000"] {
            seeds.push((folder.clone(), folder.join(file)));
        }
    }
    for (old, centering) in [(false, Centering::Vertices), (true, Centering::Cells)] {
        let path = write_vtk(dir, &format!("boxes{old}"), old, centering);
        seeds.push((path.clone(), dir.join(format!("boxes{old}/1_1.vti"))));
        seeds.push((path.clone(), path));
    }
    for (ascii, version) in [(true, 2), (true, 5), (false, 2), (false, 5)] {
        let bytes = Hexahedra { version, ..Hexahedra::new(ascii) }.bytes();
        let path = write(dir, &format!("octree{ascii}{version}.vtk"), &[&bytes]);
        seeds.push((path.clone(), path));
    }
    let bytes = |path: &PathBuf| std::fs::read(path).unwrap();
    seeds.into_iter().map(|(mesh, file)| (mesh, file.clone(), bytes(&file))).collect()
}

/// Opens and reads all fields.
fn consume(path: &Path) -> Result<(), ReadError> {
    let _ = AmrDataset::recognises(path);
    let dataset = AmrDataset::open(path)?;
    assert!(dataset.index_to_world().inverse().is_finite());
    for field in dataset.fields() {
        let patches = dataset.read(Some(&field.name))?;
        for patch in patches.patches {
            let [x, y, z] = patch.value_dims(patches.centering).map(|n| n as usize);
            assert_eq!(patch.values.len(), x * y * z);
            assert!(patch.level as usize <= patches.ratios.len());
        }
    }
    dataset.read(None).map(drop)
}

thread_local! {
    /// One folder for all cases.
    static SEEDS: RefCell<(tempfile::TempDir, Vec<Seed>)> = {
        let dir = tempfile::tempdir().unwrap();
        let seeds = seeds(dir.path());
        RefCell::new((dir, seeds))
    };
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 3000,
        failure_persistence: Some(Box::new(FileFailurePersistence::Off)),
        ..ProptestConfig::default()
    })]

    #[test]
    fn reading_ends_with_patches_or_an_error_that_names_the_mesh(
        which in 0..17usize,
        changes in prop::collection::vec(change(), 1..4),
        far in 0..4usize,
    ) {
        let result = SEEDS.with_borrow(|(_, seeds)| {
            let (mesh, file, original) = &seeds[which];
            let mut bytes = original.clone();
            // Not only the beginning of a long file.
            let from = far * bytes.len() / 4;
            let mut end = bytes.split_off(from);
            for change in changes {
                apply(&mut end, change);
            }
            bytes.extend(end);
            std::fs::write(file, &bytes).unwrap();
            let result = consume(mesh);
            std::fs::write(file, original).unwrap();
            result.map_err(|error| (error.to_string(), mesh.file_stem().unwrap().to_owned()))
        });
        if let Err((error, name)) = result {
            prop_assert!(error.contains(name.to_str().unwrap()), "{error}");
        }
    }
}

#[test]
fn seeds_are_valid() {
    let dir = tempfile::tempdir().unwrap();
    let seeds = seeds(dir.path());
    assert_eq!(seeds.len(), 17);
    for (mesh, _, _) in seeds {
        // All can be read; that no field is chosen at the end is the only complaint.
        let error = consume(&mesh).unwrap_err();
        assert!(matches!(error, ReadError::ChooseField { .. }), "{error}");
    }
}
