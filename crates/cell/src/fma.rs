//! The workspace's one choice between fused and separate multiply-add.

use crate::Real;

/// `a·b + c`: rounded once where the build has the instruction, else twice.
///
/// Scalar code and lanes call this and nothing else, so that they agree bit for bit in one build.
/// `f32::mul_add` itself becomes a library call without the instruction, ten times as slow.
#[inline(always)]
pub fn fma<R: Real>(a: R, b: R, c: R) -> R {
    a.fma(b, c)
}
