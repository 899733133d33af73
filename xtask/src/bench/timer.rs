//! Timing on a noisy machine.

use std::hint::black_box;
use std::time::Instant;

/// Runs the variants in turn, `repeat` times after one run that does not count, and gives the median seconds of each.
///
/// Interleaved, so that all see the same machine when its speed drifts; ratios of one call hold, absolute times less so. Every repetition
/// runs at another depth of the stack: where that lies beside what it is used with, by chance, can cost a tenth of the time.
pub(crate) fn interleave(repeat: usize, variants: &mut [&mut dyn FnMut()]) -> Vec<f64> {
    interleave_all(repeat, variants).into_iter().map(median).collect()
}

/// As [`interleave`], with the seconds of each repetition.
pub(crate) fn interleave_all(repeat: usize, variants: &mut [&mut dyn FnMut()]) -> Vec<Vec<f64>> {
    timed(repeat, variants).0
}

/// As [`interleave`], with what each variant came to in the end, so that it can be told whether what was timed is what should be. What it came to before is dropped while no time is
/// taken.
pub(crate) fn interleave_kept<R>(
    repeat: usize,
    variants: &mut [&mut dyn FnMut() -> R],
) -> (Vec<f64>, Vec<R>) {
    let (times, kept) = timed(repeat, variants);
    (times.into_iter().map(median).collect(), kept)
}

fn timed<R>(repeat: usize, variants: &mut [&mut dyn FnMut() -> R]) -> (Vec<Vec<f64>>, Vec<R>) {
    let mut times = vec![Vec::with_capacity(repeat); variants.len()];
    let mut kept: Vec<Option<R>> = variants.iter().map(|_| None).collect();
    for round in 0..=repeat {
        for ((variant, times), kept) in variants.iter_mut().zip(&mut times).zip(&mut kept) {
            drop(kept.take());
            let begin = Instant::now();
            let result = deeper(round, variant);
            let seconds = begin.elapsed().as_secs_f64();
            *kept = Some(black_box(result));
            if round > 0 {
                times.push(seconds);
            }
        }
    }
    (times, kept.into_iter().flatten().collect())
}

/// Calls `variant` at some depth of the stack.
#[inline(never)]
fn deeper<R>(depth: usize, variant: &mut dyn FnMut() -> R) -> R {
    let room = black_box([0u8; 320]);
    let result = match depth {
        0 => variant(),
        _ => deeper(depth - 1, variant),
    };
    black_box(&room);
    result
}

/// The median; NaN of nothing.
pub(crate) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    match values.len() {
        0 => f64::NAN,
        n if n % 2 == 1 => values[middle],
        _ => 0.5 * (values[middle - 1] + values[middle]),
    }
}

/// The least of the values that at least this share of them do not exceed (nearest rank); NaN of nothing.
pub(crate) fn quantile(mut values: Vec<f64>, share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let rank = (share * values.len() as f64).ceil() as usize;
    values.get(rank.saturating_sub(1)).copied().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_variant_runs_in_turn() {
        let order = std::cell::RefCell::new(String::new());
        let times =
            interleave(2, &mut [&mut || order.borrow_mut().push('a'), &mut || order.borrow_mut().push('b')]);
        assert_eq!(order.into_inner(), "ababab");
        assert_eq!(times.len(), 2);
    }

    #[test]
    fn what_came_last_is_kept() {
        let (mut a, mut b) = (0, 10);
        let (times, kept) = interleave_kept(
            3,
            &mut [
                &mut || {
                    a += 1;
                    a
                },
                &mut || {
                    b += 1;
                    b
                },
            ],
        );
        assert_eq!((times.len(), kept), (2, vec![4, 14]));
    }

    #[test]
    fn medians() {
        assert_eq!(median(vec![3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(vec![4.0, 1.0]), 2.5);
    }

    #[test]
    fn quantiles() {
        let values: Vec<f64> = (1..=200).rev().map(f64::from).collect();
        assert_eq!(quantile(values.clone(), 0.99), 198.0);
        assert_eq!(quantile(values, 1.0), 200.0);
        assert_eq!(quantile(vec![2.0, 1.0], 0.99), 2.0);
        assert!(quantile(Vec::new(), 0.5).is_nan());
    }
}
