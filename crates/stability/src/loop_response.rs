use std::f64::consts::TAU;

use super::systems::PolesAndZeros;
use super::{ClosedLoop, LinearLoop, Margins, StabilityError};
use trocar_lti::{Complex64, StepResponse};

const LOWEST_HZ: f64 = 0.1;

const FREQUENCIES: usize = 400;

const STEP_S: f64 = 1.0;
const MAX_SAMPLES: usize = 20_000;

#[derive(Debug, Clone)]
pub struct LoopResponse {
    /// Pairs (Hz, `L`).
    pub gain: Vec<(f64, Complex64)>,
    pub margins: Margins,
    /// Empty for long delays.
    pub poles: Vec<PolesAndZeros>,
    pub step: Option<StepResponse>,
    pub tick_s: f64,
}

impl LoopResponse {
    pub fn of(settings: &LinearLoop) -> Result<Self, StabilityError> {
        let closed = ClosedLoop::new(settings)?;
        let highest = 0.5 / settings.tick_s;
        let step = (highest / LOWEST_HZ).powf(1.0 / (FREQUENCIES - 1) as f64);
        let gain = (0..FREQUENCIES)
            .map(|k| {
                let hertz = if k + 1 == FREQUENCIES { highest } else { LOWEST_HZ * step.powi(k as i32) };
                (hertz, closed.loop_gain(1.0, TAU * hertz * settings.tick_s))
            })
            .collect();
        let poles = closed.poles_and_zeros()?;
        let samples = ((STEP_S / settings.tick_s) as usize + 1).min(MAX_SAMPLES);
        let step = if poles.is_empty() { None } else { Some(closed.closed_loop_system()?.step(samples)?) };
        Ok(Self { gain, margins: closed.margins()?, poles, step, tick_s: settings.tick_s })
    }

    pub fn phases_deg(&self) -> Vec<f64> {
        Self::unwrapped_deg(&self.gain)
    }

    pub fn unwrapped_deg(responses: &[(f64, Complex64)]) -> Vec<f64> {
        let mut phases: Vec<f64> = vec![];
        for (_, gain) in responses {
            let phase = gain.arg().to_degrees();
            let turns = phases.last().map_or(0.0, |before| ((before - phase) / 360.0).round());
            phases.push(phase + 360.0 * turns);
        }
        phases
    }
}
