//! Published VTK files, compared with what VTK 9.5 reads; skipped, loudly, where they are not at hand.

use std::path::PathBuf;

use glam::DVec3;
use isoray_io::{Dataset, OpenOptions};

use crate::make::read;

/// A file: dimensions, world position of the first sample, spacing along z, and [`checksum`].
pub(crate) type Known = (&'static str, [u32; 3], [f64; 3], f64, u32);

/// Those of `amr` have values at cells.
#[rustfmt::skip]
pub(crate) const KNOWN: [Known; 32] = [
    ("series/fingers/fingers_005.vti", [64, 64, 64], [0.0, 0.0, 0.0], 1.0, 0x74267179),
    ("series/fingers/fingers_015.vti", [64, 64, 64], [0.0, 0.0, 0.0], 1.0, 0x660b9161),
    ("series/fingers/fingers_025.vti", [64, 64, 64], [0.0, 0.0, 0.0], 1.0, 0x6856fb66),
    ("series/fingers/fingers_035.vti", [64, 64, 64], [0.0, 0.0, 0.0], 1.0, 0x3d227d59),
    ("series/fingers/fingers_045.vti", [64, 64, 64], [0.0, 0.0, 0.0], 1.0, 0xe9d01839),
    ("series/fingers/fingers_055.vti", [64, 64, 64], [0.0, 0.0, 0.0], 1.0, 0x12273830),
    ("series/fingers/fingers_065.vti", [64, 64, 64], [0.0, 0.0, 0.0], 1.0, 0x0f99bd01),
    ("series/fingers/fingers_075.vti", [64, 64, 64], [0.0, 0.0, 0.0], 1.0, 0xed3c3e71),
    ("series/fingers/fingers_085.vti", [64, 64, 64], [0.0, 0.0, 0.0], 1.0, 0xe1156b27),
    ("series/fingers/fingers_095.vti", [64, 64, 64], [0.0, 0.0, 0.0], 1.0, 0x9b777247),
    ("series/isabel/isabel_02.vti", [125, 125, 25], [0.0, 0.0, 0.0], 4.0408163266, 0x828548a2),
    ("series/isabel/isabel_03.vti", [125, 125, 25], [0.0, 0.0, 0.0], 4.0408163266, 0x22729803),
    ("series/isabel/isabel_04.vti", [125, 125, 25], [0.0, 0.0, 0.0], 4.0408163266, 0x12b41d6f),
    ("series/isabel/isabel_05.vti", [125, 125, 25], [0.0, 0.0, 0.0], 4.0408163266, 0xd32ba044),
    ("series/isabel/isabel_30.vti", [125, 125, 25], [0.0, 0.0, 0.0], 4.0408163266, 0x0476aef1),
    ("series/isabel/isabel_48.vti", [125, 125, 25], [0.0, 0.0, 0.0], 4.0408163266, 0xa6106501),
    ("amr/chombo3d/chombo3d_0.vti", [8, 8, 8], [0.5, 0.5, 0.5], 1.0, 0xdf720ef1),
    ("amr/chombo3d/chombo3d_1.vti", [16, 16, 16], [0.25, 0.25, 0.25], 0.5, 0x23f1d488),
    ("amr/chombo3d/chombo3d_10.vti", [4, 4, 4], [4.125, 3.125, 4.125], 0.25, 0x6a788344),
    ("amr/chombo3d/chombo3d_11.vti", [4, 4, 4], [4.125, 4.125, 3.125], 0.25, 0x77b3bcdc),
    ("amr/chombo3d/chombo3d_12.vti", [4, 4, 4], [4.125, 4.125, 4.125], 0.25, 0x6d768324),
    ("amr/chombo3d/chombo3d_13.vti", [4, 4, 4], [5.125, 2.125, 2.125], 0.25, 0x61418d95),
    ("amr/chombo3d/chombo3d_14.vti", [4, 8, 8], [5.125, 3.125, 3.125], 0.25, 0xc305181d),
    ("amr/chombo3d/chombo3d_15.vti", [8, 4, 4], [6.125, 2.125, 2.125], 0.25, 0x9cf819c2),
    ("amr/chombo3d/chombo3d_2.vti", [12, 16, 16], [0.125, 2.125, 2.125], 0.25, 0xa48c10ee),
    ("amr/chombo3d/chombo3d_3.vti", [4, 8, 8], [2.125, 0.125, 0.125], 0.25, 0x533b299f),
    ("amr/chombo3d/chombo3d_4.vti", [8, 8, 8], [3.125, 0.125, 0.125], 0.25, 0x8ce49c42),
    ("amr/chombo3d/chombo3d_5.vti", [4, 8, 8], [3.125, 2.125, 2.125], 0.25, 0x4829ed8b),
    ("amr/chombo3d/chombo3d_6.vti", [4, 8, 8], [3.125, 2.125, 4.125], 0.25, 0x7ee16eff),
    ("amr/chombo3d/chombo3d_7.vti", [4, 8, 8], [3.125, 4.125, 2.125], 0.25, 0xdba5b163),
    ("amr/chombo3d/chombo3d_8.vti", [4, 8, 8], [3.125, 4.125, 4.125], 0.25, 0xe14ddbe2),
    ("amr/chombo3d/chombo3d_9.vti", [4, 4, 4], [4.125, 3.125, 3.125], 0.25, 0x8004f995),
];

/// The exclusive or of the bits of all samples, each times its number, from 1.
pub(crate) fn checksum(samples: &[f32]) -> u32 {
    let terms = samples.iter().zip(1u32..).map(|(sample, number)| sample.to_bits().wrapping_mul(number));
    terms.fold(0, |sum, term| sum ^ term)
}

#[test]
fn published_files() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    for (file, dims, origin, spacing, expected) in KNOWN {
        let path = folder.join(file);
        if !path.is_file() {
            println!("SKIPPED: {} is not there", path.display());
            continue;
        }
        let dataset = Dataset::open(&path, &OpenOptions::default()).unwrap();
        assert_eq!(dataset.dims().axes(), dims, "{file}");
        assert_eq!(dataset.index_to_world().transform_point3(DVec3::ZERO), DVec3::from(origin), "{file}");
        assert_eq!(dataset.index_to_world().transform_vector3(DVec3::Z), DVec3::Z * spacing, "{file}");
        assert_eq!(dataset.warnings(), []);
        assert_eq!(checksum(&read(&dataset, 7).unwrap().0), expected, "{file}");
    }
}
