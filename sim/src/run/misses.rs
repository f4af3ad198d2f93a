//! The reasons of missed ruptures: the run once more, with an observed detector.

use std::sync::{Arc, Mutex, PoisonError};

use super::RunError;
use crate::detection::{CusumDetector, Decision, Detector, Evidence};
use crate::engine::{Observer, OwnParts, Signals};
use crate::metrics::{DetectorSample, Metrics, MissRule, SupervisorHistory};
use crate::scenario::Scenario;
use crate::time::nearest_ticks;

/// The samples of the windows of some ruptures, with their ticks.
type Windows = Vec<(u64, DetectorSample)>;

/// The scenario's detector, which records its state in the windows of some ruptures.
struct ObservedDetector {
    detector: CusumDetector<f64>,
    tick: u64,
    /// First and last tick of each window, in order.
    windows: Vec<(u64, u64)>,
    samples: Arc<Mutex<Windows>>,
}

impl Detector<f64> for ObservedDetector {
    fn update(&mut self, evidence: &Evidence<f64>) -> Decision<f64> {
        let conditions = self.detector.conditions(evidence);
        let decision = self.detector.update(evidence);
        let tick = self.tick;
        self.tick += 1;
        if self.windows.iter().any(|(first, last)| (*first..=*last).contains(&tick)) {
            let sample = DetectorSample {
                decision: decision.decision,
                conditions,
                depth_m: evidence.depth_m,
                velocity_m_per_s: evidence.velocity_m_per_s,
            };
            self.samples.lock().unwrap_or_else(PoisonError::into_inner).push((tick, sample));
        }
        decision
    }
}

impl Observer<f64> for SupervisorHistory {
    fn observe(&mut self, s: &Signals<f64>) {
        self.push(s.tick, s.mode, s.alarm, s.alarm_taken);
    }
}

/// Adds to each missed rupture of a run why it was missed. A run repeats bit for bit, so the second one has the same
/// ruptures and alarms.
///
/// # Errors
/// As [`run`](super::run()).
pub(super) fn explain_misses(scenario: &Scenario, metrics: &mut Metrics) -> Result<(), RunError> {
    if metrics.missed_ruptures == 0 {
        return Ok(());
    }
    let rule = MissRule { grid: scenario.grid, detector: &scenario.detector, augmentation: &scenario.augmentation };
    let tick_of = |time_s: f64| nearest_ticks(time_s, scenario.grid.tick_s());
    let windows: Vec<(u64, u64)> = metrics
        .ruptures
        .iter()
        .filter(|rupture| rupture.detection_delay_s.is_none())
        .map(|rupture| (tick_of(rupture.time_s), tick_of(rupture.time_s) + rule.window_ticks()))
        .collect();
    let samples = Arc::new(Mutex::new(vec![]));
    let detector = ObservedDetector {
        detector: CusumDetector::new(&scenario.detector, scenario.grid.tick_s()),
        tick: 0,
        windows,
        samples: Arc::clone(&samples),
    };
    let mut supervisor = SupervisorHistory::default();
    let integration = |source| RunError::Integration { name: scenario.name.clone(), source };
    scenario.build_with(OwnParts::default().detector(detector))?.run(&mut supervisor).map_err(integration)?;
    let samples = std::mem::take(&mut *samples.lock().unwrap_or_else(PoisonError::into_inner));
    for rupture in metrics.ruptures.iter_mut().filter(|rupture| rupture.detection_delay_s.is_none()) {
        let tick = tick_of(rupture.time_s);
        let (first, last) = (tick, tick + rule.window_ticks());
        if last >= metrics.ticks {
            continue;
        }
        let begin = samples.partition_point(|(at, _)| *at < first);
        let end = samples.partition_point(|(at, _)| *at <= last);
        rupture.miss = rule.explain(tick, &samples[begin..end], &supervisor);
    }
    Ok(())
}
