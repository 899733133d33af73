//! Values of patches.

use std::ops::{Deref, Range};
use std::sync::Arc;

/// Values of a patch, which may lie with those of others: many small pieces of memory would not soon be given back.
#[derive(Clone)]
pub struct Values {
    all: Arc<Vec<f32>>,
    own: Range<usize>,
}

impl Values {
    /// Parts of `all`, one after the other, of these lengths, as far as there are as many.
    pub fn parts(all: Vec<f32>, lengths: impl IntoIterator<Item = usize>) -> impl Iterator<Item = Self> {
        let (all, mut begin) = (Arc::new(all), 0);
        lengths.into_iter().map(move |length| {
            let own = begin.min(all.len())..(begin + length).min(all.len());
            begin += length;
            Self { all: Arc::clone(&all), own }
        })
    }
}

impl From<Vec<f32>> for Values {
    fn from(all: Vec<f32>) -> Self {
        Self { own: 0..all.len(), all: Arc::new(all) }
    }
}

impl Deref for Values {
    type Target = [f32];

    fn deref(&self) -> &[f32] {
        &self.all[self.own.clone()]
    }
}

impl PartialEq for Values {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl std::fmt::Debug for Values {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        (**self).fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_one_after_the_other() {
        let parts: Vec<_> = Values::parts(vec![1.0, 2.0, 3.0], [1, 0, 2, 1]).collect();
        let expected = [vec![1.0], vec![], vec![2.0, 3.0], vec![]].map(Values::from);
        assert_eq!(parts, expected);
    }
}
