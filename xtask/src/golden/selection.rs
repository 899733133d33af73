//! Which checks are wanted, by the names that they print.

use std::sync::atomic::{AtomicUsize, Ordering};

use anyhow::{Result, ensure};

use crate::catalog::{Entry, Place};

/// Those whose printed name contains a text, or all.
#[derive(Debug, Default)]
pub(crate) struct Selection {
    only: Option<String>,
    /// How many were wanted so far.
    count: AtomicUsize,
}

impl Selection {
    pub(crate) fn new(only: Option<String>) -> Self {
        Self { only, count: AtomicUsize::new(0) }
    }

    /// Whether not all is wanted.
    pub(crate) fn is_part(&self) -> bool {
        self.only.is_some()
    }

    /// Whether a check is wanted, which is then counted.
    pub(crate) fn wants(&self, name: &str) -> bool {
        let is_wanted = self.contains(name);
        self.count.fetch_add(is_wanted.into(), Ordering::Relaxed);
        is_wanted
    }

    /// Whether any check of a volume may be wanted: else it need not be read.
    pub(crate) fn may_want(&self, entry: &Entry) -> bool {
        let values = entry.isovalues.iter().flat_map(|&value| [value, value - 0.5]);
        let places = || Place::ALL.into_iter().map(Place::name);
        let mut at = values.flat_map(|value| places().map(move |place| (value, place)));
        at.any(|(value, place)| self.contains(&format!("{} at {value}, {place}", entry.name)))
            || places().any(|place| self.contains(&format!("{}, {place}, shaded", entry.name)))
    }

    /// # Errors
    /// If nothing was wanted.
    pub(crate) fn ensure_any(&self) -> Result<()> {
        let only = self.only.as_deref().unwrap_or_default();
        ensure!(self.count.load(Ordering::Relaxed) > 0, "no check has a name with {only:?} in it");
        Ok(())
    }

    fn contains(&self, name: &str) -> bool {
        self.only.as_ref().is_none_or(|only| name.contains(only.as_str()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_that_are_printed_and_one_must_be_wanted() {
        let selection = Selection::new(Some("600, far".to_owned()));
        assert!(selection.may_want(&Entry::fixture()) && !selection.may_want(&Entry::turbulence(64)));
        assert!(!selection.wants("tooth (fixture) at 600, close") && selection.ensure_any().is_err());
        assert!(selection.wants("tooth (fixture) at 600, far") && selection.ensure_any().is_ok());
        assert!(!Selection::default().is_part() && Selection::default().wants("anything"));
    }
}
