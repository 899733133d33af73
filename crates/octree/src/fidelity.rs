//! What a volume is true to.

/// What is guaranteed of the samples of a volume that was built with loss, with the bounds given then; all that are there hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fidelity {
    /// No sample is farther than this from what it was, in the data's units; 0 of a lossless volume, infinite if there is no such bound.
    pub tolerance: f64,
    /// Some isosurfaces are near to where they were.
    pub surface: Option<SurfaceFidelity>,
    /// Samples from the first to the second value, and all isosurfaces of such values, are exactly what they were.
    pub range: Option<[f64; 2]>,
}

/// Isosurfaces that are near to where they were.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceFidelity {
    /// In voxels, along an axis of the lattice.
    pub displacement: f64,
    /// The least and the greatest of their isovalues.
    pub isovalues: [f64; 2],
    /// Whether those between the two are meant as well.
    pub is_range: bool,
}

impl Fidelity {
    /// Of a volume whose samples are what they were.
    pub const LOSSLESS: Self = Self { tolerance: 0.0, surface: None, range: None };

    /// Whether the samples are what they were.
    pub fn is_lossless(&self) -> bool {
        self.tolerance == 0.0
    }
}

/// What the coarse samples of a volume are; see DESIGN's section 3 for why the default is what it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Coarse {
    /// There are none to be used.
    None = 0,
    /// The sample at the same place: exact on linear data.
    #[default]
    Injected = 1,
    /// The mean of the children's, placed at the low corner as in Knoll's papers (2006, section 4.1; 2009, section 6.1): displaced by
    /// half a coarse voxel but for half a fine one.
    Mean = 2,
    /// The mean of 27 samples around the same place, weighted by ½ for each step along an axis: exact on linear data.
    Filtered = 3,
}

impl Coarse {
    /// Every kind, in the order of their numbers.
    pub const ALL: [Self; 4] = [Self::None, Self::Injected, Self::Mean, Self::Filtered];

    /// The kind with that number in files.
    pub fn from_number(n: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|&kind| kind as u8 == n)
    }

    /// Its name in flags and reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Injected => "injected",
            Self::Mean => "mean",
            Self::Filtered => "filtered",
        }
    }
}
