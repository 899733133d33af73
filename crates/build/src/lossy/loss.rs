//! What may be lost.

/// What a volume may lose. Where several bounds are given, all of them hold.
#[derive(Clone, Debug, PartialEq)]
pub struct Loss {
    /// How far each sample may be off, in the data's units (Knoll 2006, section 3.1). Infinite: no bound but the others.
    pub tolerance: f64,
    /// How far isosurfaces may be displaced.
    pub surface: Option<SurfaceTolerance>,
    /// The least and the greatest value that matter: samples in between, ends included, and all isosurfaces of
    /// such values are kept exactly. Ends that are no `f32` are moved outwards to the nearest one if rounding to nearest would; they may be infinite.
    pub range: Option<[f64; 2]>,
}

/// How far isosurfaces may be displaced.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceTolerance {
    /// The distance in voxels (index space). With 0 the surfaces are kept exactly; more than 1 is as good as 1.
    pub displacement: f64,
    /// Which surfaces; all others may change without bound.
    pub isovalues: Isovalues,
}

/// Isovalues that matter.
#[derive(Clone, Debug, PartialEq)]
pub enum Isovalues {
    /// These.
    List(Vec<f32>),
    /// All real numbers from the first to the second, both included; the ends may be infinite.
    Range([f32; 2]),
}

/// A loss that cannot be meant.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LossError {
    /// A tolerance that is negative or not a number.
    #[error("tolerance {0}: expected a number that is not negative")]
    Tolerance(f64),
    /// A displacement that is negative, infinite or not a number.
    #[error("displacement of isosurfaces {0}: expected a finite number of voxels that is not negative")]
    Displacement(f64),
    /// No isovalues.
    #[error("isosurfaces with bounded displacement: expected at least one isovalue, found none")]
    NoIsovalues,
    /// An isovalue that is not finite.
    #[error("isovalue {0}: expected a finite number")]
    Isovalue(f32),
    /// A range whose ends are out of order or not numbers.
    #[error("range {0} to {1}: expected two numbers in ascending order")]
    Range(f64, f64),
    /// Nothing is bounded.
    #[error("an infinite tolerance: expected a range or a displacement of isosurfaces with it")]
    Unbounded,
}

impl Default for Loss {
    /// No bound at all, which [`check`](Self::check) refuses: at least one has to be given.
    fn default() -> Self {
        Self { tolerance: f64::INFINITY, surface: None, range: None }
    }
}

impl Loss {
    /// Whether the bounds make sense.
    ///
    /// # Errors
    /// The first one that does not.
    pub fn check(&self) -> Result<(), LossError> {
        if self.tolerance.is_nan() || self.tolerance < 0.0 {
            return Err(LossError::Tolerance(self.tolerance));
        }
        if let Some(surface) = &self.surface {
            surface.check()?;
        }
        if let Some(range) = self.range {
            check_range(range)?;
        }
        let is_bounded = self.tolerance.is_finite() || self.surface.is_some() || self.range.is_some();
        if is_bounded { Ok(()) } else { Err(LossError::Unbounded) }
    }
}

impl SurfaceTolerance {
    fn check(&self) -> Result<(), LossError> {
        if !self.displacement.is_finite() || self.displacement < 0.0 {
            return Err(LossError::Displacement(self.displacement));
        }
        match &self.isovalues {
            Isovalues::List(values) if values.is_empty() => Err(LossError::NoIsovalues),
            Isovalues::List(values) => match values.iter().find(|v| !v.is_finite()) {
                Some(&v) => Err(LossError::Isovalue(v)),
                None => Ok(()),
            },
            Isovalues::Range(range) => check_range(range.map(f64::from)),
        }
    }
}

fn check_range([low, high]: [f64; 2]) -> Result<(), LossError> {
    if low <= high { Ok(()) } else { Err(LossError::Range(low, high)) }
}
