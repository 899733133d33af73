//! Damaged files: whatever the bytes, reading ends with a transfer function or an error of one line.

use isoray_io::transfer::Remap;
use isoray_io::{TransferOptions, read_transfer_function};
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;

use crate::damage::{Change, apply};
use crate::fixture;

/// Valid files to damage.
fn seeds() -> Vec<Vec<u8>> {
    let lab = r#"{"ColorSpace":"Lab","RGBPoints":[-2,0.1,0,1,0,1,1,1,0,1,0,0,7,0,0,0],"Points":[1,0,0.3,0.5,4,1,0.9,1,9,0.5,0.5,0]}"#;
    let inline =
        "colormap = 'turbo'\nnormalized = true\npoints = [{value=1,opacity=0.5},{value=2,extinction=1e3}]";
    let files = ["tooth.toml", "cool-to-warm.json"].map(|name| std::fs::read(fixture(name)).unwrap());
    files.into_iter().chain([lab, inline].map(|text| text.as_bytes().to_vec())).collect()
}

fn change() -> impl Strategy<Value = Change> {
    let at = 0..1500usize;
    prop_oneof![
        (at.clone(), any::<u8>()).prop_map(|(a, b)| Change::Set(a, b)),
        (at.clone(), b'-'..=b'9').prop_map(|(a, b)| Change::Digit(a, b)),
        (at.clone(), "[-0-9 .e\\[\\]{},\"'=\n#]{1,8}").prop_map(|(a, b)| Change::Insert(a, b.into_bytes())),
        (at.clone(), "nan|inf|1e999|-1e30|1e-320|true|null")
            .prop_map(|(a, b)| Change::Insert(a, b.into_bytes())),
        (at.clone(), 1..40usize).prop_map(|(a, n)| Change::Remove(a, n)),
        at.prop_map(Change::Cut),
    ]
}

fn options() -> impl Strategy<Value = TransferOptions> {
    let number = prop_oneof![-10.0f32..10.0, any::<f32>()];
    let range = move || prop::option::of([number.clone(), number.clone()]);
    (prop_oneof![0.1..10.0, any::<f64>()], range(), range(), any::<bool>()).prop_map(
        |(unit_distance, data_range, range, log)| TransferOptions {
            unit_distance,
            data_range,
            remap: Remap { range, log },
        },
    )
}

thread_local! {
    /// One folder for all cases.
    static FOLDER: tempfile::TempDir = tempfile::tempdir().unwrap();
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 2000,
        failure_persistence: Some(Box::new(FileFailurePersistence::Off)),
        ..ProptestConfig::default()
    })]

    #[test]
    fn reading_ends_with_a_function_or_one_line(
        which in 0..4usize,
        changes in prop::collection::vec(change(), 0..4),
        options in options(),
        sane in any::<bool>(),
    ) {
        let mut bytes = seeds().swap_remove(which);
        for change in changes {
            apply(&mut bytes, change);
        }
        let path = FOLDER.with(|folder| folder.path().join("m.tf"));
        std::fs::write(&path, &bytes).unwrap();
        let options = if sane { TransferOptions::default() } else { options };
        if let Err(error) = read_transfer_function(&path, &options) {
            let text = error.to_string();
            prop_assert!(text.contains("m.tf:") && !text.contains('\n'), "{text}");
        }
    }

    #[test]
    fn any_text_at_all(bytes in prop::collection::vec(any::<u8>(), 0..60), text in "\\PC{0,60}") {
        let path = FOLDER.with(|folder| folder.path().join("n.tf"));
        for content in [&bytes[..], text.as_bytes()] {
            std::fs::write(&path, content).unwrap();
            prop_assert!(read_transfer_function(&path, &TransferOptions::default()).is_err());
        }
    }
}

#[test]
fn seeds_are_valid() {
    let folder = tempfile::tempdir().unwrap();
    for seed in seeds() {
        let path = folder.path().join("s.tf");
        std::fs::write(&path, &seed).unwrap();
        read_transfer_function(&path, &TransferOptions::default()).unwrap();
    }
}
