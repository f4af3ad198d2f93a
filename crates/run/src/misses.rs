//! Reasons of missed ruptures, by repeating the run with an observed detector.

use std::sync::{Arc, Mutex, PoisonError};

use super::{RunError, observe};
use trocar_core::detector::{CusumDetector, Decision, Detector, DetectorInput};
use trocar_core::time::nearest_ticks;
use trocar_engine::engine::{Observer, Signals, UserDefinedParts};
use trocar_metrics::{
    ALARM_WINDOW_S, DetectorSample, Metrics, Miss, MissReason, MissRule, RuptureMetrics, SupervisorHistory,
};
use trocar_scenario::Scenario;

const MAX_REASONS: usize = 8;

type Windows = Vec<(u64, DetectorSample)>;

/// Records the detector's state in the windows of some ruptures.
struct ObservedDetector {
    detector: CusumDetector<f64>,
    tick: u64,
    windows: Vec<(u64, u64)>,
    samples: Arc<Mutex<Windows>>,
}

impl Detector<f64> for ObservedDetector {
    fn update(&mut self, input: &DetectorInput<f64>) -> Decision<f64> {
        let (decision, sample) = DetectorSample::update(&mut self.detector, input);
        let tick = self.tick;
        self.tick += 1;
        if self.windows.iter().any(|(first, last)| (*first..=*last).contains(&tick)) {
            self.samples.lock().unwrap_or_else(PoisonError::into_inner).push((tick, sample));
        }
        decision
    }
}

/// Up to the end of a rupture's window: later events explain no miss.
struct UntilWindow {
    supervisor: SupervisorHistory,
    /// Including the examined rupture.
    to_come: usize,
    window_ticks: u64,
    last_tick: u64,
    is_done: bool,
}

impl UntilWindow {
    fn of_tick(last_tick: u64) -> Self {
        Self { supervisor: SupervisorHistory::default(), to_come: 0, window_ticks: 0, last_tick, is_done: false }
    }

    fn of_rupture(index: usize, window_ticks: u64) -> Self {
        Self { to_come: index + 1, window_ticks, ..Self::of_tick(u64::MAX) }
    }
}

impl Observer<f64> for UntilWindow {
    fn observe(&mut self, s: &Signals<f64>) {
        self.supervisor.push(s.tick, s.mode.lane(0), s.alarm, s.alarm_taken);
        if s.ruptured && self.to_come > 0 {
            self.to_come -= 1;
            if self.to_come == 0 {
                self.last_tick = s.tick + self.window_ticks;
            }
        }
        self.is_done = s.tick > self.last_tick;
    }

    fn is_done(&self) -> bool {
        self.is_done
    }
}

pub(super) fn explain_misses(scenario: &Scenario, metrics: &mut Metrics) -> Result<(), RunError> {
    if metrics.missed_ruptures == 0 {
        return Ok(());
    }
    let observed = observed(scenario, metrics)?;
    for (index, (rupture, miss)) in metrics.ruptures.iter_mut().zip(observed).enumerate() {
        rupture.miss = miss.map(|miss| confirmed(scenario, index, miss)).transpose()?;
    }
    Ok(())
}

/// The repetition of the run is the same bit for bit.
fn observed(scenario: &Scenario, metrics: &Metrics) -> Result<Vec<Option<Miss>>, RunError> {
    let tick_s = scenario.grid.tick_s();
    let rule = MissRule {
        tick_s,
        start_s: 0.0,
        window_s: ALARM_WINDOW_S,
        detector: &scenario.detector,
        refractory_s: scenario.augmentation.automaton.refractory_s,
    };
    let window = |rupture: &RuptureMetrics| {
        let tick = nearest_ticks(rupture.time_s, tick_s);
        (tick, tick + rule.window_ticks())
    };
    let is_missed =
        |rupture: &&RuptureMetrics| rupture.detection_delay_s.is_none() && window(rupture).1 < metrics.ticks;
    let samples = Arc::new(Mutex::new(vec![]));
    let detector = ObservedDetector {
        detector: CusumDetector::new(&scenario.detector, tick_s),
        tick: 0,
        windows: metrics.ruptures.iter().filter(is_missed).map(window).collect(),
        samples: Arc::clone(&samples),
    };
    let mut observer = UntilWindow::of_tick(detector.windows.iter().map(|(_, last)| *last).max().unwrap_or(0));
    let integration = |source| RunError::Engine { name: scenario.name.clone(), source };
    scenario
        .build_with(UserDefinedParts::default().detector(detector))?
        .run_wide(&mut observer)
        .map_err(integration)?;
    let samples = std::mem::take(&mut *samples.lock().unwrap_or_else(PoisonError::into_inner));
    let explain = |rupture: &RuptureMetrics| {
        let (first, last) = Some(rupture).filter(is_missed).map(window)?;
        let begin = samples.partition_point(|(at, _)| *at < first);
        let end = samples.partition_point(|(at, _)| *at <= last);
        rule.explain(first, &samples[begin..end], &observer.supervisor)
    };
    Ok(metrics.ruptures.iter().map(explain).collect())
}

/// Finds a small set of reasons whose removal raises an alarm for the rupture `index`, from 0.
///
/// A reason can hide another, so each observed reason is removed alone, then all, then those observed after that.
fn confirmed(scenario: &Scenario, index: usize, first: Miss) -> Result<Miss, RunError> {
    let without = |scenario: &Scenario, reasons: &[MissReason]| {
        let mut other = scenario.clone();
        for reason in reasons {
            reason.remove(&mut other.contact_m, &mut other.detector, &mut other.augmentation);
        }
        other
    };
    for reason in first.reasons() {
        if still_missed(&without(scenario, &[*reason]), index)?.is_none() {
            return Ok(Miss { reason: *reason, also: vec![] });
        }
    }
    let mut reasons: Vec<MissReason> = vec![];
    let mut next = first.clone();
    while reasons.len() < MAX_REASONS {
        reasons.extend(next.reasons());
        let other = without(scenario, &reasons);
        let Some(metrics) = still_missed(&other, index)? else {
            return Ok(Miss { reason: reasons[0], also: reasons[1..].to_vec() });
        };
        match observed(&other, &metrics)?.into_iter().nth(index).flatten() {
            Some(more) => next = more,
            None => break,
        }
    }
    let reasons: Vec<MissReason> = first.reasons().copied().chain([MissReason::EarlierEvent]).collect();
    Ok(match still_missed(&without(scenario, &reasons), index)? {
        None => Miss { reason: reasons[0], also: reasons[1..].to_vec() },
        Some(_) => first,
    })
}

/// `None` if the detector raises an alarm in the window.
fn still_missed(scenario: &Scenario, index: usize) -> Result<Option<Metrics>, RunError> {
    let tick_s = scenario.grid.tick_s();
    let window_ticks = nearest_ticks(ALARM_WINDOW_S, tick_s);
    let mut observer = UntilWindow::of_rupture(index, window_ticks);
    let metrics = observe(scenario, &mut observer)?;
    let has_alarm = metrics.ruptures.get(index).is_some_and(|rupture| {
        let first = nearest_ticks(rupture.time_s, tick_s);
        observer.supervisor.has_alarm(first..=first + window_ticks)
    });
    Ok((!has_alarm).then_some(metrics))
}
