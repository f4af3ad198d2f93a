use super::{Settings, VelocitySource};
use crate::chain::{Chain, ChainOutput, Measurement};
use crate::detector::{CusumDetector, Decision, DetectorSettings};
use crate::error::InvalidValue;
use crate::estimation::{Estimate, Rls, VelocityFilter};
use crate::lane::{Stored, store_code};

/// State of the detection; only an armed detector raises an alarm.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DetectionState {
    /// A drop of the force raises an alarm.
    Armed,
    /// Waits for its conditions, such as quiet contact; misses ruptures.
    #[default]
    Settling,
    /// More samples are missing than are bridged; misses ruptures.
    Blind,
}

impl DetectionState {
    /// In the order of the codes.
    pub const ALL: [Self; 3] = [Self::Armed, Self::Settling, Self::Blind];

    /// 0: armed, 1: settling, 2: blind.
    #[must_use]
    pub fn code(self) -> u8 {
        self as u8
    }

    /// `armed`, `settling` or `blind`.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Armed => "armed",
            Self::Settling => "settling",
            Self::Blind => "blind",
        }
    }
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Detected {
    pub(super) estimate: Estimate<f64>,
    pub(super) decision: Decision<f64>,
}

/// Interpolates up to `bridged_samples` missing samples. After a longer gap the detector starts anew; the estimate and
/// the sensor's offset are kept.
#[derive(Debug, Clone)]
pub(super) struct DetectionChain {
    chain: Chain<f64, Rls<f64>, CusumDetector<f64>>,
    filter: Option<VelocityFilter<f64>>,
    settings: DetectorSettings,
    tick_s: f64,
    bridged_samples: u64,
    /// Valid if `has_last`.
    last: Measurement<f64>,
    last_number: u64,
    has_last: bool,
    missing: u64,
    /// At the last complete sample.
    parameters: [f64; 2],
    distance: f64,
    decision: f64,
    velocity_m_per_s: f64,
    state: DetectionState,
    ticks_in_state: u32,
    bridged: u64,
    gaps: u64,
}

impl DetectionChain {
    pub(super) fn of(settings: &Settings) -> Result<Self, InvalidValue> {
        let Settings { tick_s, contact_m, velocity, detector, limits, .. } = *settings;
        let filter = match velocity {
            VelocitySource::Measured => None,
            VelocitySource::Filtered { resolution_m, acceleration_std_m_per_s2 } => {
                Some(VelocityFilter::new(tick_s, resolution_m, acceleration_std_m_per_s2)?)
            }
        };
        let chain = Chain {
            contact_m,
            estimator: Rls::new(&settings.estimator),
            detector: CusumDetector::new(&detector, tick_s),
        };
        Ok(Self {
            chain,
            filter,
            settings: detector,
            tick_s,
            bridged_samples: limits.bridged_samples,
            last: Measurement { force_n: 0.0, position_m: 0.0, velocity_m_per_s: 0.0 },
            last_number: 0,
            has_last: false,
            missing: 0,
            parameters: [0.0; 2],
            distance: 0.0,
            decision: 0.0,
            velocity_m_per_s: 0.0,
            state: DetectionState::Settling,
            ticks_in_state: 0,
            bridged: 0,
            gaps: 0,
        })
    }

    #[inline(always)]
    pub(super) fn velocity_m_per_s(&self) -> f64 {
        self.velocity_m_per_s
    }

    #[inline(always)]
    pub(super) fn state(&self) -> (DetectionState, u32) {
        (self.state, self.ticks_in_state)
    }

    pub(super) fn gaps(&self) -> (u64, u64) {
        (self.bridged, self.gaps)
    }

    pub(super) fn estimator_gain(&self) -> [f64; 3] {
        self.chain.estimator.gain()
    }

    #[inline(always)]
    pub(super) fn is_next(&self, number: u64) -> bool {
        self.has_last & (self.missing == 0) & (number == self.last_number.wrapping_add(1))
    }

    /// Only if [`Self::is_next`].
    #[inline(always)]
    pub(super) fn step(&mut self, measurement: &Measurement<f64>, number: u64) -> Detected {
        let ChainOutput { estimate, decision, .. } = self.pass(measurement);
        self.last = *measurement;
        self.last_number = number;
        self.keep(&estimate, &decision);
        let is_armed = self.chain.detector.is_armed();
        self.enter(if is_armed { DetectionState::Armed } else { DetectionState::Settling });
        Detected { estimate, decision }
    }

    pub(super) fn take(&mut self, measurement: &Measurement<f64>, number: u64, is_bad: bool) -> Detected {
        if is_bad {
            self.skip()
        } else if self.is_next(number) {
            self.step(measurement, number)
        } else {
            self.resume(measurement, number)
        }
    }

    fn skip(&mut self) -> Detected {
        self.missing = self.missing.saturating_add(1);
        if self.missing <= self.bridged_samples {
            self.enter(self.state);
            return self.without_residual();
        }
        if self.state != DetectionState::Blind {
            self.gaps += 1;
            (self.distance, self.decision) = (0.0, 0.0);
        }
        self.enter(DetectionState::Blind);
        self.without_residual()
    }

    fn resume(&mut self, measurement: &Measurement<f64>, number: u64) -> Detected {
        let was_blind = self.missing > self.bridged_samples;
        self.missing = 0;
        if !self.has_last {
            self.has_last = true;
            return self.step(measurement, number);
        }
        let lost = number.saturating_sub(self.last_number).saturating_sub(1);
        if was_blind || number <= self.last_number || lost > self.bridged_samples {
            self.gaps += u64::from(!was_blind);
            return self.restart(measurement, number);
        }
        let from = self.last;
        let steps = (lost + 1) as f64;
        let mut alarm = None;
        for step in 1..=lost {
            let ChainOutput { decision, .. } = self.pass(&from.between(measurement, step as f64 / steps));
            alarm = alarm.or(decision.alarm.then_some(decision));
        }
        self.bridged += lost;
        let detected = self.step(measurement, number);
        // The decision that raised the alarm is the one to report.
        Detected { decision: alarm.unwrap_or(detected.decision), ..detected }
    }

    fn restart(&mut self, measurement: &Measurement<f64>, number: u64) -> Detected {
        self.velocity_m_per_s = match &mut self.filter {
            Some(filter) => filter.resume(measurement.position_m),
            None => measurement.velocity_m_per_s,
        };
        self.chain.detector.restart(&self.settings, self.tick_s);
        self.chain.resume(&Measurement { velocity_m_per_s: self.velocity_m_per_s, ..*measurement });
        (self.distance, self.decision) = (0.0, 0.0);
        (self.last, self.last_number) = (*measurement, number);
        self.enter(DetectionState::Settling);
        self.without_residual()
    }

    #[inline(always)]
    fn pass(&mut self, measurement: &Measurement<f64>) -> ChainOutput<f64> {
        self.velocity_m_per_s = match &mut self.filter {
            Some(filter) => filter.update(measurement.position_m),
            None => measurement.velocity_m_per_s,
        };
        self.chain.step(&Measurement { velocity_m_per_s: self.velocity_m_per_s, ..*measurement })
    }

    #[inline(always)]
    fn keep(&mut self, estimate: &Estimate<f64>, decision: &Decision<f64>) {
        self.parameters = [estimate.stiffness_n_per_m, estimate.damping_n_s_per_m];
        (self.distance, self.decision) = (decision.distance, decision.decision);
    }

    #[inline(always)]
    fn enter(&mut self, state: DetectionState) {
        self.ticks_in_state = if state == self.state { self.ticks_in_state.saturating_add(1) } else { 0 };
        self.state = state;
    }

    fn without_residual(&self) -> Detected {
        let [stiffness_n_per_m, damping_n_s_per_m] = self.parameters;
        Detected {
            estimate: Estimate {
                predicted_force_n: 0.0,
                residual_n: 0.0,
                correction: [0.0; 2],
                stiffness_n_per_m,
                damping_n_s_per_m,
                extra_parameter: 0.0,
            },
            decision: Decision { distance: self.distance, decision: self.decision, alarm: false },
        }
    }
}

impl Stored for DetectionState {
    fn numbers(&mut self, with: &mut dyn FnMut(&mut u64)) {
        store_code(self, Self::ALL, Self::code, Self::Blind, with);
    }
}

impl Stored for DetectionChain {
    fn numbers(&mut self, with: &mut dyn FnMut(&mut u64)) {
        let Self {
            chain,
            filter,
            settings: _,
            tick_s: _,
            bridged_samples: _,
            last,
            last_number,
            has_last,
            missing,
            parameters,
            distance,
            decision,
            velocity_m_per_s,
            state,
            ticks_in_state,
            bridged,
            gaps,
        } = self;
        chain.numbers(with);
        filter.numbers(with);
        for number in [&mut last.force_n, &mut last.position_m, &mut last.velocity_m_per_s] {
            number.numbers(with);
        }
        for count in [last_number, missing, bridged, gaps] {
            count.numbers(with);
        }
        has_last.numbers(with);
        parameters.numbers(with);
        for number in [distance, decision, velocity_m_per_s] {
            number.numbers(with);
        }
        state.numbers(with);
        ticks_in_state.numbers(with);
    }
}
