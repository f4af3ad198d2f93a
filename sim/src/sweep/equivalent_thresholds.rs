//! Higher thresholds of the detector under which a run would have been the same, to the last bit.
//!
//! A threshold `γ` reaches the rest of a run in two ways: by the alarms that it raises, and by the level below which an augmented
//! phase may end. As long as both are the same under a higher threshold, so are the residuals and `g`; a threshold is dropped
//! at the first tick at which either may differ.
//!
//! **Alarms.** At `g ≤ γ` no threshold from `γ` on raises one. At `g > γ`, a higher threshold `h` differs
//!
//! - where `g ≤ h` and the run raises an alarm, or
//! - where `g > h` and only one of the two is armed, which is so only where it would count as a rupture.
//!
//! A detector is armed after `settle_s` of contact without a crossing of its own threshold. Contact is not among the signals, and
//! need not be: it is the same for both. With `q` ticks since the last crossing and `c` ticks of contact, a detector is armed
//! where `min(q, c) ≥ S`. Two of them differ only where one has `q ≥ S` and the other has not.
//!
//! **Exits.** Under a higher threshold `g` is quiet no later. A phase that ends as soon as the minimum hold allows ends then under
//! any of them; one that lasts longer may not, and drops all thresholds of its run.

use std::ops::Range;

use crate::engine::{InstructionSet, Observer, Signals};
use crate::lane::{Lane, Mask};
use crate::metrics::Metrics;
use crate::run::{RunError, RunObserver, run_pack_observed, run_pack_sharing};
use crate::scenario::Scenario;
use crate::sensor::NoiseBank;
use crate::time::nearest_ticks;

/// A run, and thresholds under which it is the same.
#[derive(Debug, Clone)]
pub(super) struct RunWithEquivalents {
    pub(super) metrics: Metrics,
    /// Higher thresholds under which the run is the same, to the last bit; some of which that is true may be missing.
    pub(super) thresholds: Vec<f64>,
}

/// Runs scenarios side by side where they can be. For each, `higher` lists the thresholds to be tracked: above its detector's own
/// and below its cap.
pub(super) fn run_with_equivalents(
    bank: &mut NoiseBank,
    scenarios: &[Scenario],
    higher: &[Vec<f64>],
) -> Vec<Result<RunWithEquivalents, RunError>> {
    let tracked = TrackedThresholds { scenarios, higher };
    let runs = run_pack_observed(InstructionSet::widest(), bank, scenarios, &tracked).into_iter();
    runs.map(|run| run.map(|(metrics, thresholds)| RunWithEquivalents { metrics, thresholds })).collect()
}

/// [`run_with_equivalents`] with no thresholds to be tracked, and nothing spent on it.
pub(super) fn run_without_equivalents(
    bank: &mut NoiseBank,
    scenarios: &[Scenario],
) -> Vec<Result<RunWithEquivalents, RunError>> {
    let runs = run_pack_sharing(bank, scenarios).into_iter();
    runs.map(|run| run.map(|metrics| RunWithEquivalents { metrics, thresholds: vec![] })).collect()
}

/// What is to be tracked in each of some runs.
struct TrackedThresholds<'a> {
    scenarios: &'a [Scenario],
    higher: &'a [Vec<f64>],
}

impl RunObserver for TrackedThresholds<'_> {
    type OverLanes<L: Lane> = EquivalentThresholds<L>;
    type Finding = Vec<f64>;

    fn over_lanes<L: Lane>(&self, places: Range<usize>) -> EquivalentThresholds<L> {
        EquivalentThresholds::new(&self.scenarios[places.clone()], &self.higher[places])
    }

    fn finding<L: Lane>(observer: &EquivalentThresholds<L>, lane: usize) -> Vec<f64> {
        observer.thresholds(lane).collect()
    }
}

/// The observer: what is left of each lane's higher thresholds.
#[derive(Debug, Clone)]
struct EquivalentThresholds<L: Lane> {
    /// `γ` of the lane's run; infinite where nothing is left to be tracked.
    threshold: L,
    /// So many ticks of an augmented phase are the same under any threshold; infinite where nothing is left to be tracked.
    max_augmented_ticks: L,
    /// The ticks of the augmented phase under way, the first one among them; 0 where there is none.
    augmented_ticks: L,
    /// The lanes that run something of their own.
    runs: Vec<TrackedRun>,
}

/// The higher thresholds of one run.
#[derive(Debug, Clone)]
struct TrackedRun {
    /// `S`.
    settle_ticks: u64,
    /// Whether only a residual below 0 counts as a rupture.
    drop_only: bool,
    /// The tick after the last crossing of the run's own threshold; 0 before the first.
    quiet_from: u64,
    higher: Vec<HigherThreshold>,
}

#[derive(Debug, Clone, Copy)]
struct HigherThreshold {
    threshold: f64,
    /// As in [`TrackedRun`].
    quiet_from: u64,
}

impl<L: Lane> EquivalentThresholds<L> {
    /// Of scenarios, the first in lane 0, each with its higher thresholds.
    fn new(scenarios: &[Scenario], higher: &[Vec<f64>]) -> Self {
        let is_tracked = |lane: usize| higher.get(lane).is_some_and(|higher| !higher.is_empty());
        let tracked = |lane: usize, number: &dyn Fn(&Scenario) -> f64| {
            if is_tracked(lane) { number(&scenarios[lane]) } else { f64::INFINITY }
        };
        // The mode changes on a tick after the one on which the phase began, at the earliest.
        let max_augmented_ticks = |scenario: &Scenario| {
            nearest_ticks(scenario.augmentation.automaton.min_hold_s, scenario.grid.tick_s()).max(1) as f64
        };
        let run = |(scenario, higher): (&Scenario, &Vec<f64>)| {
            let arming = &scenario.detector.arming;
            let at_rest = |&threshold: &f64| HigherThreshold { threshold, quiet_from: 0 };
            TrackedRun {
                settle_ticks: nearest_ticks(arming.settle_s, scenario.grid.tick_s()),
                drop_only: arming.drop_only,
                quiet_from: 0,
                higher: higher.iter().map(at_rest).collect(),
            }
        };
        Self {
            threshold: L::from_lanes(|lane| tracked(lane, &|scenario| scenario.detector.cusum.threshold)),
            max_augmented_ticks: L::from_lanes(|lane| tracked(lane, &max_augmented_ticks)),
            augmented_ticks: L::zero(),
            runs: scenarios.iter().zip(higher).map(run).collect(),
        }
    }

    /// Those of lane `lane` under which its run has been the same.
    fn thresholds(&self, lane: usize) -> impl Iterator<Item = f64> {
        self.runs[lane].higher.iter().map(|higher| higher.threshold)
    }

    /// Takes a tick at which some `g` is above its threshold or some mode is not teleoperation.
    #[inline(always)]
    fn observe_event(&mut self, s: &Signals<L>, above: L::Mask, beside: L::Mask) {
        let is_augmented = beside & s.mode.lt(L::splat(1.5));
        self.augmented_ticks = L::select(is_augmented, self.augmented_ticks + L::splat(1.0), L::zero());
        let is_delayed = self.augmented_ticks.gt(self.max_augmented_ticks);
        if !(above | is_delayed).any() {
            return;
        }
        for (lane, run) in self.runs.iter_mut().enumerate() {
            if is_delayed.lane(lane) {
                run.higher.clear();
            } else if above.lane(lane) {
                run.cross(s.tick, s.decision.lane(lane), s.alarm.lane(lane), s.residual_n.lane(lane));
            }
            if run.higher.is_empty() {
                self.threshold.set_lane(lane, f64::INFINITY);
                self.max_augmented_ticks.set_lane(lane, f64::INFINITY);
            }
        }
    }
}

impl<L: Lane> Observer<L> for EquivalentThresholds<L> {
    /// Side by side, as nearly all cases of a sweep run.
    #[inline(always)]
    fn is_common() -> bool {
        L::WIDTH > 1
    }

    #[inline(always)]
    fn observe(&mut self, s: &Signals<L>) {
        let above = s.decision.gt(self.threshold);
        let beside = s.mode.gt(L::splat(0.5));
        if (above | beside).any() {
            self.observe_event(s, above, beside);
        }
    }
}

impl TrackedRun {
    /// Drops the thresholds that may differ at a tick at which `g` is above the run's own.
    fn cross(&mut self, tick: u64, decision: f64, alarm: bool, residual_n: f64) {
        let settled = |quiet_from: u64| tick - quiet_from >= self.settle_ticks;
        let own_settled = settled(self.quiet_from);
        let can_be_rupture = !self.drop_only || residual_n < 0.0;
        self.higher.retain_mut(|higher| {
            if decision > higher.threshold {
                let has_settled = settled(higher.quiet_from);
                higher.quiet_from = tick + 1;
                has_settled == own_settled || !can_be_rupture
            } else {
                !alarm
            }
        });
        self.quiet_from = tick + 1;
    }
}

#[cfg(test)]
mod tests;
