//! Cases that differ only in the detector's threshold share a run if it is identical for them
//! ([`run_with_equivalents`](super::equivalent_thresholds::run_with_equivalents)).

use std::collections::{BTreeSet, HashMap};
use std::ops::Range;
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::columns::Column;
use super::design::SamplingScheme;
use super::part::Outcome;
use super::plan::Plan;

/// Beyond it, all stored results are removed.
const MAX_KEPT: usize = 1 << 20;

#[derive(Debug, Clone)]
pub(super) struct Row {
    pub(super) outcome: Outcome,
    pub(super) values: Vec<Option<f64>>,
}

#[derive(Debug)]
pub(super) struct SharedRuns {
    thresholds: Vec<f64>,
    /// Distance of cases with consecutive thresholds.
    stride: u64,
    cases: Range<u64>,
    known: Mutex<Known>,
}

#[derive(Debug, Default)]
struct Known {
    groups: HashMap<u64, Group>,
    /// Groups with missing results that no thread is computing.
    open: BTreeSet<u64>,
}

#[derive(Debug)]
struct Group {
    /// Index in `rows`, by threshold.
    places: Vec<Option<u32>>,
    rows: Vec<Row>,
    /// Cases that have not been read.
    unread: usize,
}

impl SharedRuns {
    /// `None` if all cases differ otherwise.
    pub(super) fn of(plan: &Plan, cases: Range<u64>) -> Option<Self> {
        let design = &plan.design;
        let at = design.axes.iter().position(|axis| axis.key.path == "detector.threshold")?;
        // A derived cap differs, too.
        let is_usable = design.scheme == SamplingScheme::Grid && plan.gives("detector.cap");
        if !is_usable || design.columns.iter().any(Column::is_of_loop) {
            return None;
        }
        let thresholds = design.axes[at].numbers();
        let faster: u64 = design.axes[at + 1..].iter().map(|axis| axis.count().unwrap_or(1)).product();
        let stride = faster * design.seeds;
        (thresholds.len() > 1).then(|| Self { thresholds, stride, cases, known: Mutex::default() })
    }

    pub(super) fn span(&self) -> u64 {
        self.stride * self.thresholds.len() as u64
    }

    /// First case of the group, and index of the threshold.
    fn place(&self, case: u64) -> (u64, usize) {
        let at = (case / self.stride) % self.thresholds.len() as u64;
        (case - at * self.stride, at as usize)
    }

    fn places(&self, first: u64) -> impl Iterator<Item = usize> {
        (0..self.thresholds.len()).filter(move |&at| self.cases.contains(&(first + at as u64 * self.stride)))
    }

    fn known(&self) -> MutexGuard<'_, Known> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }

    #[cfg(test)]
    pub(super) fn is_empty(&self) -> bool {
        self.known().groups.is_empty()
    }

    pub(super) fn take(&self, case: u64) -> Option<Row> {
        let (first, at) = self.place(case);
        let mut known = self.known();
        let group = known.groups.get_mut(&first)?;
        let row = group.rows[group.places[at]? as usize].clone();
        group.unread = group.unread.saturating_sub(1);
        if group.unread == 0 {
            known.groups.remove(&first);
        }
        Some(row)
    }

    pub(super) fn higher(&self, case: u64, cap: f64) -> Vec<f64> {
        let (first, at) = self.place(case);
        let mut known = self.known();
        known.open.remove(&first);
        let group = known.groups.get(&first);
        let is_known = |other: usize| group.is_some_and(|group| group.places[other].is_some());
        let unknown = self.places(first).filter(|&other| !is_known(other)).map(|other| self.thresholds[other]);
        unknown.filter(|&threshold| threshold > self.thresholds[at] && threshold < cap).collect()
    }

    pub(super) fn ahead(&self) -> Option<u64> {
        let mut known = self.known();
        let first = known.open.pop_first()?;
        let group = known.groups.get(&first)?;
        let unknown = |at: &usize| group.places[*at].is_none();
        let by_threshold = |one: &usize, other: &usize| self.thresholds[*one].total_cmp(&self.thresholds[*other]);
        let lowest = self.places(first).filter(unknown).min_by(by_threshold)?;
        Some(first + lowest as u64 * self.stride)
    }

    pub(super) fn keep(&self, case: u64, row: Row, equivalent: &[f64]) {
        let (first, of_case) = self.place(case);
        let count = self.thresholds.len();
        let mut known = self.known();
        if known.groups.len() * count >= MAX_KEPT {
            *known = Known::default();
        }
        let nothing = || Group { places: vec![None; count], rows: vec![], unread: self.places(first).count() };
        let group = known.groups.entry(first).or_insert_with(nothing);
        let place = group.rows.len() as u32;
        group.rows.push(row);
        for at in 0..count {
            if group.places[at].is_none() && (at == of_case || equivalent.contains(&self.thresholds[at])) {
                group.places[at] = Some(place);
            }
        }
        if self.places(first).any(|at| group.places[at].is_none()) {
            known.open.insert(first);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Thresholds 3, 1, 2 over five seeds: cases 0, 5 and 10 are a group.
    fn shared() -> SharedRuns {
        SharedRuns { thresholds: vec![3.0, 1.0, 2.0], stride: 5, cases: 0..u64::MAX, known: Mutex::default() }
    }

    fn row(value: f64) -> Row {
        Row { outcome: Outcome::Completed, values: vec![Some(value)] }
    }

    fn value(row: Option<Row>) -> Option<f64> {
        row?.values[0]
    }

    #[test]
    fn a_result_is_known_for_all_equivalent_thresholds() {
        let shared = shared();
        assert!(shared.take(2).is_none());
        assert_eq!(shared.higher(7, 9.0), [3.0, 2.0]);
        assert_eq!(shared.higher(7, 2.5), [2.0], "below the cap");
        shared.keep(7, row(0.5), &[3.0]);
        assert_eq!(
            (value(shared.take(7)), value(shared.take(2)), value(shared.take(12))),
            (Some(0.5), Some(0.5), None)
        );
        assert_eq!(value(shared.take(3)), None, "another seed");
        shared.keep(12, row(0.7), &[]);
        assert_eq!(value(shared.take(12)), Some(0.7));
        assert!(shared.is_empty(), "results are removed after reading");
    }

    #[test]
    fn missing_results_are_run_ahead_from_the_lowest_threshold() {
        let shared = shared();
        assert_eq!(shared.ahead(), None);
        shared.keep(1, row(0.1), &[]);
        assert_eq!(shared.ahead(), Some(6));
        assert_eq!(shared.ahead(), None, "the group is in progress");
        assert_eq!(shared.higher(6, 3.0), [2.0]);
        shared.keep(6, row(0.2), &[2.0]);
        assert_eq!((shared.ahead(), value(shared.take(11))), (None, Some(0.2)));
    }

    #[test]
    fn thresholds_of_other_parts_are_not_tracked() {
        let shared = SharedRuns { cases: 4..10, ..shared() };
        assert_eq!(shared.higher(6, 9.0), [0.0; 0]);
        shared.keep(6, row(0.1), &[]);
        assert_eq!((shared.ahead(), value(shared.take(6))), (None, Some(0.1)));
        assert!(shared.is_empty());
    }

    #[test]
    fn the_number_of_stored_results_is_bounded() {
        let shared = shared();
        (0..MAX_KEPT as u64).for_each(|group| shared.keep(group * 15, row(0.0), &[]));
        assert!(shared.known().groups.len() * 3 <= MAX_KEPT + 3);
    }
}
