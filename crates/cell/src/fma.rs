//! The workspace's one choice between fused and separate multiply-add.

/// `a·b + c`: rounded once where the build has the instruction, else twice.
///
/// Scalar code and lanes call this and nothing else, so that they agree bit for bit in one build.
/// `f32::mul_add` itself becomes a library call without the instruction, ten times as slow.
#[inline(always)]
pub fn fma(a: f32, b: f32, c: f32) -> f32 {
    if cfg!(any(target_feature = "fma", target_arch = "aarch64")) {
        #[expect(clippy::disallowed_methods, reason = "the one place that knows the instruction exists")]
        a.mul_add(b, c)
    } else {
        a * b + c
    }
}
