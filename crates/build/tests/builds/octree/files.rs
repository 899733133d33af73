//! `.ovol` files of sound volumes.

use isoray_grid::Scalar;
use isoray_octree::{AnyVolume, OctreeVolume};

use super::volumes::{Content, Sample, dense, for_all_volumes, octree};

pub(crate) fn bytes<T: Scalar>(volume: &OctreeVolume<T>) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.ovol");
    volume.save(&path).unwrap();
    std::fs::read(&path).unwrap()
}

#[test]
fn a_file_gives_back_everything() {
    fn check<T: Sample>(size: [u32; 3], content: Content)
    where
        AnyVolume: From<OctreeVolume<T>>,
    {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.ovol");
        let samples = dense::<T>(size, content);
        let volume = octree(size, &samples);
        volume.save(&path).unwrap();
        assert_eq!(std::fs::metadata(&path).unwrap().len(), volume.file_bytes() as u64);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "nothing but the file is left");
        let any = AnyVolume::open(&path).unwrap();
        any.verify(&path).unwrap();
        assert_eq!(any.scalar(), T::TYPE);
        let opened = T::from_any(any).unwrap();
        assert_eq!(opened.meta(), volume.meta());
        assert_eq!(opened.statistics(), volume.statistics());
        assert_eq!(opened.structure_bytes(), volume.structure_bytes());
        let found = opened.view().to_dense();
        assert!(found.iter().zip(&samples).all(|(a, b)| a.same_bits(*b)), "{size:?} {content:?}");
        assert_eq!(bytes(&opened), bytes(&volume), "a copy of a copy is the same file");
    }
    for_all_volumes!(check);
}

#[test]
fn bytes_do_not_depend_on_the_number_of_threads() {
    fn check<T: Sample>(size: [u32; 3], content: Content)
    where
        AnyVolume: From<OctreeVolume<T>>,
    {
        let samples = dense::<T>(size, content);
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| bytes(&octree(size, &samples)))
        };
        let one = with(1);
        assert!(one == with(2) && one == with(5), "{size:?} {content:?}");
    }
    for content in [Content::Noise, Content::Blocks, Content::Specks] {
        check::<u8>([70, 41, 37], content);
        check::<f32>([70, 41, 37], content);
        check::<i16>([129, 3, 20], content);
    }
    for_all_volumes!(check);
}

#[test]
fn a_file_that_cannot_be_written_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let volume = octree([4; 3], &dense::<u8>([4; 3], Content::Noise));
    let no_folder = folder.path().join("missing").join("a.ovol");
    let error = volume.save(&no_folder).unwrap_err();
    assert!(error.to_string().contains("missing"), "{error}");
    let is_folder = folder.path().join("folder.ovol");
    std::fs::create_dir(&is_folder).unwrap();
    volume.save(&is_folder).unwrap_err();
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "only the folder");
}
