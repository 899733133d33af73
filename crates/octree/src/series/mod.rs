//! Time series: a folder of octree volumes that agree in shape.

mod prefetch;
mod shape;

use std::io;
use std::path::{Path, PathBuf};

pub use prefetch::Prefetch;
pub use shape::{Shape, ShapeDifference};

use isoray_grid::{Scalar, natural_order};

use crate::open::OpenError;
use crate::volume::{AnyVolume, OctreeVolume, VolumeVisitor};

/// How the name of a series' folder ends.
const ENDING: &str = ".ovol.d";

/// Whether `path` is called like a series: its name ends in `.ovol.d`.
pub fn is_series(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    name.len() > ENDING.len() && name.to_ascii_lowercase().ends_with(ENDING)
}

/// A time series: a folder `NAME.ovol.d` with one `.ovol` file a step, in the order of the numbers in their names.
///
/// All steps have the dimensions, type and placement of the first.
///
/// # Memory
/// A series itself holds nothing but names. A step is mapped when it is asked for, its pages become resident as they are
/// touched, and dropping it releases them all. So resident memory is bounded by the files of the steps that are held, plus 1 MiB
/// for each [`Prefetch`]. What a prefetch has read lies in the cache of the operating system, which gives it up when others
/// need the room.
///
/// ```
/// # use isoray_octree::{Coarse, Fidelity, HISTOGRAM_BINS, Meta, Node, OctreeVolume, Parts, SeriesError};
/// use isoray_octree::{PREFETCH_BUDGET, Series};
///
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("fire.ovol.d");
/// # std::fs::create_dir(&path)?;
/// # for n in [2, 10] {
/// #     let root = Node { mins: [n; 8], maxs: [n; 8], values: [n; 8], first: 0.into(), mask: 0 };
/// #     let meta = Meta {
/// #         dims: isoray_grid::Dims::new([8, 8, 8])?,
/// #         index_to_world: glam::DAffine3::IDENTITY,
/// #         range: Some([f64::from(n); 2]),
/// #         non_finite: 0,
/// #         histogram: Box::new([0; HISTOGRAM_BINS]),
/// #         fidelity: Fidelity::LOSSLESS,
/// #         coarse: Coarse::Injected,
/// #     };
/// #     let parts = Parts { levels: vec![vec![root]], caps: Vec::new() };
/// #     OctreeVolume::<u8>::from_parts(meta, parts).save(&path.join(format!("fire{n}.ovol")))?;
/// # }
/// let series = Series::open(&path)?;
/// for n in 0..series.len() {
///     let step = series.step(n)?;
///     // Read from the disk while this step is used.
///     let _next = (n + 1 < series.len()).then(|| series.prefetch(n + 1, PREFETCH_BUDGET));
///     println!("{}: {:?}", series.name(n), step.meta().range);
/// }
/// # assert_eq!((series.name(0), series.name(1)), ("fire2.ovol".into(), "fire10.ovol".into()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Series {
    path: PathBuf,
    /// At least one.
    steps: Vec<PathBuf>,
    shape: Shape,
}

/// A series that cannot be used, and why.
#[derive(Debug, thiserror::Error)]
pub enum SeriesError {
    /// Its folder cannot be listed.
    #[error("{}: cannot be read as a folder of octree volumes", .path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// What the operating system says.
        #[source]
        source: io::Error,
    },
    /// No file in the folder is called like a step.
    #[error("{}: a series without steps: expected .ovol files, found none", .0.display())]
    Empty(PathBuf),
    /// There is no such step.
    #[error("{}: expected a step from 0 to {}, found {step}", .path.display(), .count - 1)]
    NoStep {
        /// The series.
        path: PathBuf,
        /// What was asked for.
        step: usize,
        /// Number of steps that there are.
        count: usize,
    },
    /// The file of a step cannot be opened.
    #[error(transparent)]
    Step(#[from] OpenError),
    /// A step differs from the first.
    #[error("{}: does not fit the first step, {}: {difference}", .path.display(), .first.display())]
    Differs {
        /// The file of the step.
        path: PathBuf,
        /// The file of the first step.
        first: PathBuf,
        /// In what.
        difference: ShapeDifference,
    },
}

/// Bytes that [`Series::prefetch`] should read at most, unless there is a reason to choose others: 1 GiB, in the cache of the
/// operating system.
pub const PREFETCH_BUDGET: u64 = 1 << 30;

impl Series {
    /// Lists the folder and reads the header of its first step.
    ///
    /// Files of other kinds are passed over, and so are hidden ones.
    ///
    /// # Errors
    /// A folder that cannot be listed or has no step; a first step that cannot be opened.
    pub fn open(path: &Path) -> Result<Self, SeriesError> {
        let steps =
            Self::files_in(path).map_err(|source| SeriesError::Folder { path: path.to_owned(), source })?;
        let first = steps.first().ok_or_else(|| SeriesError::Empty(path.to_owned()))?;
        let shape = Shape::of(&AnyVolume::open(first)?);
        Ok(Self { path: path.to_owned(), steps, shape })
    }

    /// The files in `folder` that are steps by their names, in order; there may be none.
    ///
    /// # Errors
    /// What the operating system says of listing the folder.
    pub fn files_in(folder: &Path) -> io::Result<Vec<PathBuf>> {
        let mut steps = Vec::new();
        for entry in std::fs::read_dir(folder)? {
            let path = entry?.path();
            let is_hidden = path.file_name().is_some_and(|n| n.to_string_lossy().starts_with('.'));
            let is_ovol = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("ovol"));
            if is_ovol && !is_hidden && path.is_file() {
                steps.push(path);
            }
        }
        steps.sort_by(|a, b| natural_order(a, b));
        Ok(steps)
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Number of steps, at least one.
    #[expect(clippy::len_without_is_empty, reason = "a series is never empty")]
    pub fn len(&self) -> usize {
        self.steps.len()
    }

    /// The files of the steps, in order.
    pub fn files(&self) -> &[PathBuf] {
        &self.steps
    }

    /// The name of a step's file; empty if there is no such step.
    pub fn name(&self, step: usize) -> String {
        let name = self.steps.get(step).and_then(|path| path.file_name());
        name.unwrap_or_default().to_string_lossy().into_owned()
    }

    /// That of the first step, which all have.
    pub fn shape(&self) -> &Shape {
        &self.shape
    }

    /// Opens a step, as [`AnyVolume::open`] does; nothing but its header is read until it is used.
    ///
    /// # Errors
    /// A step that does not exist, cannot be opened, or differs from the first in dimensions, type or placement.
    pub fn step(&self, step: usize) -> Result<AnyVolume, SeriesError> {
        let Some(path) = self.steps.get(step) else {
            return Err(SeriesError::NoStep { path: self.path.clone(), step, count: self.len() });
        };
        let volume = AnyVolume::open(path)?;
        match self.shape.difference(&Shape::of(&volume)) {
            None => Ok(volume),
            Some(difference) => {
                let (path, first) = (path.clone(), self.steps[0].clone());
                Err(SeriesError::Differs { path, first, difference })
            }
        }
    }

    /// Opens every step and closes it again, which reads the headers alone.
    ///
    /// # Errors
    /// The first that [`step`](Self::step) reports.
    pub fn check_headers(&self) -> Result<(), SeriesError> {
        (0..self.len()).try_for_each(|n| self.step(n).map(drop))
    }

    /// Reads a step from the disk in the background, `budget` bytes of it at most, so that whoever opens it later does not wait for
    /// the disk: the nodes first, which every ray needs, then the caps.
    ///
    /// Nothing is kept but in the cache of the operating system. A step that cannot be read is no error here; it will be one when
    /// it is opened.
    pub fn prefetch(&self, step: usize, budget: u64) -> Prefetch {
        let path = self.steps.get(step).cloned();
        Prefetch::spawn(move |stop| {
            let Some(path) = path else { return 0 };
            let Ok(volume) = AnyVolume::open(&path) else { return 0 };
            let caps = volume.visit(CapsLength);
            drop(volume);
            prefetch::read(&path, caps, budget, stop)
        })
    }
}

/// Bytes of the caps, behind which, in a file, are the nodes.
struct CapsLength;

impl VolumeVisitor for CapsLength {
    type Output = u64;
    fn visit<T: Scalar>(self, volume: &OctreeVolume<T>) -> u64 {
        volume.view().caps.len() as u64
    }
}

#[cfg(test)]
mod tests;
