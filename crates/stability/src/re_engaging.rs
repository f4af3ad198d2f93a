use nalgebra::{DMatrix, DVector};

use crate::switching::modes::Modes;
use crate::{Phases, StabilityError, SwitchingSettings};
use trocar_core::augmentation::{RampSettings, Reengage, cross_fade};

const DURATION_S: f64 = 3.0;

const STIFFNESSES: usize = 9;

/// Maxima over the stiffnesses. At the release, hand and needle rest and the force is 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EventBound {
    pub reengage: Reengage,
    pub reference_jump_m: f64,
    pub slave_motion_m: f64,
    pub slave_speed_m_per_s: f64,
    pub force_n: f64,
    pub force_step_n: f64,
}

impl EventBound {
    /// `gap_m` is between the slave's reference and the hand, scaled to the slave.
    pub fn of_each_policy(settings: &SwitchingSettings, gap_m: f64) -> Result<Vec<Self>, StabilityError> {
        let speed = match settings.augmentation.reengage {
            Reengage::Ramp(ramp) => ramp.catch_up_speed_m_per_s,
            Reengage::RampUntilLoad(ramp) => ramp.approach_speed_m_per_s,
            Reengage::Fade(_) | Reengage::WhenStill(_) | Reengage::Clutch | Reengage::Snap => {
                RampSettings::default().catch_up_speed_m_per_s
            }
        };
        let ramp = Reengage::Ramp(RampSettings { catch_up_speed_m_per_s: speed });
        let policies = [ramp, Reengage::Clutch, Reengage::Snap];
        policies.into_iter().map(|reengage| Self::of(settings, reengage, speed, gap_m)).collect()
    }

    fn of(
        settings: &SwitchingSettings,
        reengage: Reengage,
        speed_m_per_s: f64,
        gap_m: f64,
    ) -> Result<Self, StabilityError> {
        let mut all = Self {
            reengage,
            reference_jump_m: 0.0,
            slave_motion_m: 0.0,
            slave_speed_m_per_s: 0.0,
            force_n: 0.0,
            force_step_n: 0.0,
        };
        let (softest, stiffest) = settings.stiffness_n_per_m;
        for k in 0..STIFFNESSES {
            let stiffness = softest + (stiffest - softest) * k as f64 / (STIFFNESSES - 1) as f64;
            let here = SwitchingSettings {
                stiffness_n_per_m: (stiffness, stiffness),
                loses_contact: false,
                ..settings.clone()
            };
            let modes = Modes::new(&here)?;
            all.release(&modes, settings.phases(), settings.of_loop.tick_s, speed_m_per_s, gap_m);
        }
        Ok(all)
    }

    fn release(&mut self, modes: &Modes, phases: Phases, tick_s: f64, speed_m_per_s: f64, gap_m: f64) {
        let at = modes.master_states();
        let apart = modes.apart(0);
        let n = apart.nrows();
        let (of_reference, of_force, of_desired) = (modes.of_reference(), modes.of_force(), modes.of_desired());
        let (hand, slave, felt) = (modes.hand(0), modes.slave(), modes.force(0));
        let read = |row: &DMatrix<f64>, state: &DVector<f64>| (row * state)[(0, 0)];
        let sent = modes.without_delay().hand(0);
        let scale = sent.iter().copied().fold(0.0, f64::max);
        let desired_m = gap_m / scale;
        let mut state = DVector::zeros(n);
        (state[0], state[2]) = (desired_m, desired_m);
        state.rows_mut(modes.states() - modes.delay(), modes.delay()).fill(scale * desired_m);
        let mut gap = if self.reengage == Reengage::Snap { 0.0 } else { -gap_m };
        let closing = if matches!(self.reengage, Reengage::Ramp(_)) { speed_m_per_s * tick_s } else { 0.0 };
        let mut before = 0.0;
        for tick in 0..(DURATION_S / tick_s) as u64 {
            let weight = cross_fade(((tick + 1) as f64 / phases.blend as f64).min(1.0));
            if tick > 0 {
                gap -= gap.clamp(-closing, closing);
            }
            let reference = read(&hand, &state) + gap;
            if tick == 0 {
                self.reference_jump_m = self.reference_jump_m.max(reference.abs());
            }
            let fed_back = weight * read(&felt, &state);
            self.force_n = self.force_n.max(fed_back.abs());
            self.force_step_n = self.force_step_n.max((fed_back - before).abs());
            before = fed_back;
            state = &apart * &state + &of_reference * reference + &of_force * fed_back + &of_desired * desired_m;
            self.slave_motion_m = self.slave_motion_m.max(read(&slave, &state).abs());
            self.slave_speed_m_per_s = self.slave_speed_m_per_s.max(state[at + 1].abs());
        }
    }
}
