//! Damaged `.ovol` files: refused where a checksum can tell, and survived where none does.

use std::path::{Path, PathBuf};

use isoray_grid::Scalar;
use isoray_octree::{AnyVolume, OctreeVolume, OpenProblem, VolumeVisitor};
use isoray_trace::{Ray, Tracer, central_gradient};
use proptest::prelude::*;

use super::volumes::{Content, Sample, dense, octree};

/// Length of the header, where the section table begins.
const HEADER: usize = 2304;
/// Length of an entry of the section table.
const ENTRY: usize = 32;
/// Position of the header's checksum.
const CHECKSUM: usize = 164;
/// Largest volume that is decoded whole.
const SMALL: usize = 1 << 20;

/// A sound file: its bytes, and a place to put damaged copies.
struct Subject {
    bytes: Vec<u8>,
    path: PathBuf,
    _folder: tempfile::TempDir,
}

impl Subject {
    fn new<T: Sample>(size: [u32; 3], content: Content) -> Self
    where
        AnyVolume: From<OctreeVolume<T>>,
    {
        let bytes = super::files::bytes(&octree(size, &dense::<T>(size, content)));
        let folder = tempfile::tempdir().unwrap();
        Self { bytes, path: folder.path().join("damaged.ovol"), _folder: folder }
    }

    fn all() -> [Self; 3] {
        let size = [13, 9, 10];
        [
            Self::new::<u8>(size, Content::Blocks),
            Self::new::<u16>(size, Content::Ramp),
            Self::new::<f32>(size, Content::Specks),
        ]
    }

    fn sections(&self) -> usize {
        u32::from_le_bytes(self.bytes[28..32].try_into().unwrap()) as usize
    }

    /// End of the section table.
    fn table_end(&self) -> usize {
        HEADER + ENTRY * self.sections()
    }

    /// Opens a file of these bytes.
    fn open(&self, bytes: &[u8]) -> Result<AnyVolume, OpenProblem> {
        std::fs::write(&self.path, bytes).unwrap();
        let result = AnyVolume::open(&self.path);
        result.map_err(|e| {
            assert_eq!(e.path, self.path);
            assert!(e.to_string().starts_with(&*self.path.to_string_lossy()), "{e}");
            e.problem
        })
    }

    /// Opens the file with the byte at `at` changed by `flip`.
    fn open_flipped(&self, at: usize, flip: u8) -> Result<AnyVolume, OpenProblem> {
        let mut bytes = self.bytes.clone();
        bytes[at] ^= flip;
        self.open(&bytes)
    }

    /// Makes the checksums of `bytes` those of its contents, as far as its sections lie within it.
    fn repair(&self, bytes: &mut [u8]) {
        let number = |bytes: &[u8], at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap());
        for entry in (HEADER..self.table_end()).step_by(ENTRY) {
            let [offset, length] = [number(bytes, entry + 8), number(bytes, entry + 16)];
            let section = offset.checked_add(length).and_then(|end| bytes.get(offset as usize..end as usize));
            if let Some(checksum) = section.map(crc32fast::hash) {
                bytes[entry + 24..entry + 28].copy_from_slice(&checksum.to_le_bytes());
            }
        }
        bytes[CHECKSUM..CHECKSUM + 4].fill(0);
        let checksum = crc32fast::hash(&bytes[..self.table_end()]);
        bytes[CHECKSUM..CHECKSUM + 4].copy_from_slice(&checksum.to_le_bytes());
    }
}

/// Uses a volume in every way, to see that each ends; gives the number of hits and samples.
struct Use<'a> {
    path: &'a Path,
    isovalues: &'a [f32],
    rays: u32,
}

impl<'a> Use<'a> {
    fn new(path: &'a Path, isovalues: &'a [f32], rays: u32) -> Self {
        Self { path, isovalues, rays }
    }
}

impl VolumeVisitor for Use<'_> {
    type Output = usize;

    fn visit<T: Scalar>(self, volume: &OctreeVolume<T>) -> usize {
        let view = volume.view();
        let last = view.dims().axes().map(|n| n - 1);
        let mut used = volume.statistics().len();
        for corner in 0..8 {
            view.sample(std::array::from_fn(|a| if corner >> a & 1 == 1 { last[a] } else { last[a] / 3 }));
            used += 1;
        }
        if view.dims().samples() <= SMALL {
            assert_eq!(view.to_dense().len(), view.dims().samples());
            let mut counted = 0;
            view.for_each_leaf(|leaf| counted += u64::from(leaf.extent.iter().product::<u32>()));
            assert!(counted <= view.dims().samples() as u64);
        }
        used += rays(&view, self.isovalues, self.rays);
        assert!(self.path.is_file());
        used
    }
}

/// Traces a grid of rays from outside, slanted and along an axis; gives the number of hits.
fn rays<T: Scalar>(view: &isoray_octree::OctreeView<'_, T>, isovalues: &[f32], count: u32) -> usize {
    let last = view.dims().axes().map(|n| (n - 1) as f32);
    let mut tracer = Tracer::new(view);
    let mut hits = 0;
    for &isovalue in isovalues {
        for n in 0..count * count {
            let [u, v] = [n % count, n / count].map(|c| (c as f32 + 0.5) / count as f32);
            let slanted = Ray {
                origin: [-1.0, -2.0, -1.5],
                direction: [last[0] * u + 1.0, last[1] * v + 2.0, last[2] * (1.0 - u) + 1.5],
                t_min: 0.0,
                t_max: f32::INFINITY,
            };
            let straight = Ray {
                origin: [last[0] * u, last[1] * v, last[2] + 5.0],
                direction: [0.0, 0.0, -1.0],
                ..slanted
            };
            for ray in [slanted, straight] {
                let hit = tracer.first_hit(&ray, isovalue);
                assert_eq!(tracer.any_hit(&ray, isovalue), hit.is_some());
                if let Some(hit) = hit {
                    central_gradient(view, &hit);
                    hits += 1;
                }
            }
        }
    }
    hits
}

#[test]
fn every_flipped_byte_of_header_and_table_is_refused() {
    for subject in Subject::all() {
        for at in 0..subject.table_end() {
            for flip in [0x01, 0x10, 0x80, 0xff] {
                let problem = subject.open_flipped(at, flip).err();
                let is_right = match at {
                    0..8 => matches!(problem, Some(OpenProblem::Magic)),
                    8..12 => matches!(problem, Some(OpenProblem::Version(_))),
                    28..32 => matches!(
                        problem,
                        Some(OpenProblem::TruncatedHeader { .. } | OpenProblem::Checksum { .. })
                    ),
                    _ => matches!(problem, Some(OpenProblem::Checksum { .. })),
                };
                assert!(is_right, "byte {at} ^ {flip:#x}: {problem:?}");
            }
        }
    }
}

#[test]
fn every_truncation_and_any_appendix_is_refused() {
    for subject in Subject::all() {
        for length in 0..subject.bytes.len() {
            let problem = subject.open(&subject.bytes[..length]).err();
            let is_right = match problem {
                Some(OpenProblem::Magic) => length < 8,
                Some(OpenProblem::TruncatedHeader { found, .. }) => found == length,
                Some(OpenProblem::Length { found, .. }) => found == length as u64,
                _ => false,
            };
            assert!(is_right, "{length} bytes: {problem:?}");
        }
        for appendix in [1, 3, 64, 5000] {
            let bytes = [subject.bytes.as_slice(), &vec![0; appendix]].concat();
            let problem = subject.open(&bytes).err();
            assert!(matches!(problem, Some(OpenProblem::Length { .. })), "{problem:?}");
        }
    }
}

#[test]
fn every_flipped_byte_of_the_body_is_refused_by_verify_and_survived_by_all_else() {
    for subject in Subject::all() {
        for at in subject.table_end()..subject.bytes.len() {
            for flip in [0x01, 0xff] {
                let volume = subject.open_flipped(at, flip).expect("opening does not look at the body");
                let error = volume.verify(&subject.path).expect_err("verify does");
                assert!(
                    matches!(error.problem, OpenProblem::Checksum { .. } | OpenProblem::Field(_)),
                    "byte {at}: {error}"
                );
                let path = &subject.path;
                assert!(volume.visit(Use::new(path, &[30.5], 3)) > 0);
            }
        }
    }
}

#[test]
fn a_sound_header_that_lies_about_the_samples_is_refused_by_verify() {
    for subject in Subject::all() {
        // The value range, the count of non-finite samples and two bins.
        for at in [128, 136, 144, 168, 168 + 8 * 255] {
            let mut bytes = subject.bytes.clone();
            bytes[at] ^= 1;
            subject.repair(&mut bytes);
            let refused = match subject.open(&bytes) {
                Ok(volume) => volume.verify(&subject.path).unwrap_err().problem,
                Err(problem) => problem,
            };
            assert!(
                matches!(refused, OpenProblem::Statistics(_) | OpenProblem::Field(_)),
                "byte {at}: {refused:?}"
            );
        }
    }
}

/// Places and their new bytes: everywhere in the body, or the links and masks of nodes alone.
fn overwrites() -> impl Strategy<Value = Vec<(proptest::sample::Index, [u8; 4])>> {
    proptest::collection::vec((any::<proptest::sample::Index>(), any::<[u8; 4]>()), 1..200)
}

/// The sections of nodes with the size of a node.
fn node_positions(subject: &Subject) -> Vec<usize> {
    let scalar = [1, 1, 2, 2, 4][subject.bytes[12] as usize - 1];
    let node = 24 * scalar + 5;
    let number = |at: usize| u64::from_le_bytes(subject.bytes[at..at + 8].try_into().unwrap()) as usize;
    let entries = (HEADER + ENTRY..subject.table_end()).step_by(ENTRY);
    entries
        .flat_map(|entry| {
            let (offset, length) = (number(entry + 8), number(entry + 16));
            (offset..offset + length).step_by(node)
        })
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_body_with_right_checksums_is_survived(which in 0..3_usize, writes in overwrites()) {
        let subject = &Subject::all()[which];
        let mut bytes = subject.bytes.clone();
        let body = subject.table_end()..bytes.len() - 3;
        for (index, value) in writes {
            let at = body.start + index.index(body.len());
            bytes[at..at + 4].copy_from_slice(&value);
        }
        subject.repair(&mut bytes);
        let volume = subject.open(&bytes).expect("the header is sound");
        // Overwritten values can be right by chance; what counts is that it ends.
        let verified = volume.verify(&subject.path);
        prop_assert!(verified.is_ok() || verified.is_err_and(|e| e.path == subject.path));
        let path = &subject.path;
        prop_assert!(volume.visit(Use::new(path, &[0.0, 30.5, 1e4], 6)) > 0);
    }

    #[test]
    fn links_that_lead_anywhere_are_survived(
        which in 0..3_usize,
        near in any::<bool>(),
        writes in overwrites(),
    ) {
        let subject = &Subject::all()[which];
        let nodes = node_positions(subject);
        let scalar = [1, 1, 2, 2, 4][subject.bytes[12] as usize - 1];
        let mut bytes = subject.bytes.clone();
        for (index, [mask, link @ ..]) in writes {
            let at = *index.get(&nodes) + 24 * scalar;
            let link = u32::from_le_bytes([link[0], link[1], link[2], mask]);
            // Links within the arrays share subtrees; others lead nowhere.
            bytes[at..at + 4].copy_from_slice(&(if near { link % 8 } else { link }).to_le_bytes());
            bytes[at + 4] = mask;
        }
        // Every range holds the isovalue.
        for at in nodes {
            let [low, high] = [[0; 4], 50.0_f32.to_le_bytes()];
            for n in 0..8 {
                bytes[at + n * scalar..at + (n + 1) * scalar].copy_from_slice(&low[..scalar]);
                let high = if scalar == 4 { high } else { [0xff; 4] };
                bytes[at + (8 + n) * scalar..at + (9 + n) * scalar].copy_from_slice(&high[..scalar]);
            }
        }
        subject.repair(&mut bytes);
        let volume = subject.open(&bytes).expect("the header is sound");
        prop_assert!(volume.verify(&subject.path).is_err(), "its ranges are wrong");
        let path = &subject.path;
        prop_assert!(volume.visit(Use::new(path, &[30.5], 8)) > 0);
    }

    #[test]
    fn any_header_with_right_checksums_is_survived(
        which in 0..3_usize,
        writes in proptest::collection::vec((any::<proptest::sample::Index>(), any::<u64>(), 0..4_u32), 1..4),
    ) {
        let subject = &Subject::all()[which];
        let mut bytes = subject.bytes.clone();
        for (index, value, shape) in writes {
            let at = index.index(subject.table_end() - 8);
            // Small, huge, aligned: what lengths and counts are made of.
            let value = match shape {
                0 => value % 64,
                1 => u64::MAX - value % 64,
                2 => (value % 4096) * 64,
                _ => value,
            };
            bytes[at..at + 8].copy_from_slice(&value.to_le_bytes());
        }
        bytes[..12].copy_from_slice(&subject.bytes[..12]);
        bytes[28..32].copy_from_slice(&subject.bytes[28..32]);
        subject.repair(&mut bytes);
        if let Ok(volume) = subject.open(&bytes) {
            let verified = volume.verify(&subject.path);
            prop_assert!(verified.is_ok() || verified.is_err_and(|e| e.path == subject.path));
            let path = &subject.path;
            prop_assert!(volume.visit(Use::new(path, &[30.5], 2)) > 0);
        }
    }

    #[test]
    fn any_dimensions_in_the_header_are_survived(which in 0..3_usize, axes in any::<[u32; 3]>(), bits in 0..22_u32) {
        let subject = &Subject::all()[which];
        let mut bytes = subject.bytes.clone();
        for (a, n) in axes.into_iter().enumerate() {
            bytes[16 + 4 * a..20 + 4 * a].copy_from_slice(&(n % ((1 << bits) + 1)).to_le_bytes());
        }
        subject.repair(&mut bytes);
        if let Ok(volume) = subject.open(&bytes) {
            let path = &subject.path;
            prop_assert!(volume.visit(Use::new(path, &[30.5], 2)) > 0);
            let is_as_before = bytes[16..28] == subject.bytes[16..28];
            prop_assert_eq!(volume.verify(path).is_ok(), is_as_before);
        }
    }
}
