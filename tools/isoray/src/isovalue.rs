//! Proposing an isovalue.

/// Otsu's threshold (1979) of a histogram: the bin border that best separates the values into two classes, by
/// the variance between them. `None` if all values lie in one bin.
pub(crate) fn propose(histogram: &[u64], [low, high]: [f64; 2]) -> Option<f32> {
    let total: f64 = histogram.iter().map(|&n| n as f64).sum();
    let moment: f64 = (0..).zip(histogram).map(|(i, &n)| f64::from(i) * n as f64).sum();
    let mut best = (0.0, None);
    let (mut weight, mut sum) = (0.0, 0.0);
    for (i, &n) in (0..).zip(histogram) {
        weight += n as f64;
        sum += f64::from(i) * n as f64;
        let rest = total - weight;
        if weight == 0.0 || rest == 0.0 {
            continue;
        }
        let difference = sum / weight - (moment - sum) / rest;
        let between = weight * rest * difference * difference;
        if between > best.0 {
            best = (between, Some(i + 1));
        }
    }
    let border: i32 = best.1?;
    Some((low + (high - low) * f64::from(border) / histogram.len() as f64) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn separates_two_peaks() {
        let mut histogram = [0; 256];
        histogram[20] = 1000;
        histogram[200] = 100;
        let v = propose(&histogram, [0.0, 256.0]).unwrap();
        assert!((21.0..=200.0).contains(&v), "{v}");
    }

    #[test]
    fn one_value_has_no_surface() {
        let mut histogram = [0; 256];
        histogram[0] = 10;
        assert_eq!(propose(&histogram, [5.0, 5.0]), None);
    }
}
