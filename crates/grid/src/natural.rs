//! The order of numbered names.

use std::cmp::Ordering;
use std::path::Path;

/// Compares the file names of two paths as people count: runs of digits as numbers, all else as text, so that `a2` comes
/// before `a10`; where that does not tell them apart, the whole paths.
pub fn natural_order(a: &Path, b: &Path) -> Ordering {
    let name = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    natural(&name(a), &name(b)).then_with(|| a.cmp(b))
}

fn natural(mut a: &str, mut b: &str) -> Ordering {
    while !a.is_empty() && !b.is_empty() {
        let ([a_run, a_rest], [b_run, b_rest]) = (run(a), run(b));
        let order = match [a_run, b_run].map(|r| r.starts_with(|c: char| c.is_ascii_digit())) {
            // Numbers of any length: without leading zeros the longer one is larger.
            [true, true] => {
                let [x, y] = [a_run, b_run].map(|r| r.trim_start_matches('0'));
                x.len().cmp(&y.len()).then_with(|| x.cmp(y))
            }
            _ => a_run.cmp(b_run),
        };
        if order.is_ne() {
            return order;
        }
        (a, b) = (a_rest, b_rest);
    }
    a.len().cmp(&b.len())
}

/// The digits, or what is none, that `text` begins with, and the rest.
fn run(text: &str) -> [&str; 2] {
    let digits = text.starts_with(|c: char| c.is_ascii_digit());
    let (run, rest) = text.split_at(text.find(|c: char| c.is_ascii_digit() != digits).unwrap_or(text.len()));
    [run, rest]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_in_order() {
        let sorted =
            ["", "a", "a2b", "a02c", "a10b", "a10b1", "a10b007", "a00000000000000000000000000011", "b"];
        for (i, a) in sorted.iter().enumerate() {
            for (j, b) in sorted.iter().enumerate() {
                assert_eq!(natural(a, b), i.cmp(&j), "{a} {b}");
            }
        }
        assert_eq!(natural("a01", "a1"), Ordering::Equal);
        assert!(natural_order("z/a2".as_ref(), "b/a10".as_ref()).is_lt());
        assert!(natural_order("a01".as_ref(), "a1".as_ref()).is_lt(), "never equal unless they are");
    }
}
