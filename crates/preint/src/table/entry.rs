//! The numbers in a table.

/// A number from 0 to 1 in a table: `f32`, or `u16` in steps of 1/65535.
pub trait Entry: Copy + Default + std::fmt::Debug + sealed::Sealed {
    /// What [`widen`](Self::widen) gives is in these units.
    const UNIT: f32;
    /// The nearest entry.
    fn encode(x: f64) -> Self;
    /// As a number in units of [`UNIT`](Self::UNIT).
    fn widen(self) -> f32;
}

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for u16 {}
}

impl Entry for f32 {
    const UNIT: f32 = 1.0;
    #[inline(always)]
    fn encode(x: f64) -> Self {
        x as Self
    }
    #[inline(always)]
    fn widen(self) -> f32 {
        self
    }
}

impl Entry for u16 {
    const UNIT: f32 = 1.0 / 65535.0;
    #[inline(always)]
    fn encode(x: f64) -> Self {
        // Positive: truncating after adding a half rounds to nearest, and the conversion saturates.
        (x * 65535.0 + 0.5) as Self
    }
    #[inline(always)]
    fn widen(self) -> f32 {
        self.into()
    }
}
