use core::f64::consts::TAU;

use trocar_core::settings::ActsFor;

use super::{AnyTissue, Reaction, StillTissue, Tissue, TissueSettings};
use trocar_core::error::InvalidValue;
use trocar_core::lane::Lane;

/// A recording's force includes the motion.
const MOVES: ActsFor = match TissueSettings::WORDS {
    [_recording, models @ ..] => ActsFor::new(TissueSettings::KEY.path, models),
    [] => ActsFor::new(TissueSettings::KEY.path, &[]),
};

trocar_core::settings! {
    /// 15 breaths and 70 beats a minute (chosen here).
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct OrganMotion in "tissue." {
        /// Distance by which breathing moves the tissue away from the needle and back; with 0 there is no such motion.
        breathing_amplitude_m: f64 [NON_NEGATIVE] for (MOVES) = 0.0,
        /// Period of breathing.
        breathing_period_s: f64 [POSITIVE] for (MOVES) = 4.0,
        /// Distance by which the heartbeat moves the tissue away from the needle and back; with 0 there is no such
        /// motion.
        heartbeat_amplitude_m: f64 [NON_NEGATIVE] for (MOVES) = 0.0,
        /// Period of the heartbeat.
        heartbeat_period_s: f64 [POSITIVE] for (MOVES) = 0.857,
    }
}

impl OrganMotion {
    pub fn moves(&self) -> bool {
        self.breathing_amplitude_m > 0.0 || self.heartbeat_amplitude_m > 0.0
    }

    pub fn applied_to<L: Lane>(&self, tissue: StillTissue<L>, tick_s: f64) -> Result<AnyTissue<L>, InvalidValue> {
        self.validate()?;
        if !self.moves() {
            return Ok(AnyTissue::Still(tissue));
        }
        let breathing = Cycle::new(self.breathing_amplitude_m, self.breathing_period_s, tick_s);
        let heartbeat = Cycle::new(self.heartbeat_amplitude_m, self.heartbeat_period_s, tick_s);
        Ok(AnyTissue::Moving(Box::new(Moving { tissue, breathing, heartbeat })))
    }
}

/// A rotation advances the phase, without transcendental functions.
#[derive(Debug, Clone, Copy)]
struct Cycle<L> {
    amplitude: L,
    rate: L,
    step_cos: L,
    step_sin: L,
    cos: L,
    sin: L,
}

impl<L: Lane> Cycle<L> {
    fn new(amplitude_m: f64, period_s: f64, tick_s: f64) -> Self {
        let step = TAU * tick_s / period_s;
        Self {
            amplitude: L::splat(amplitude_m),
            rate: L::splat(amplitude_m * TAU / period_s),
            step_cos: L::splat(libm::cos(step)),
            step_sin: L::splat(libm::sin(step)),
            cos: L::splat(1.0),
            sin: L::zero(),
        }
    }

    /// `(1 - cos φ)/2` and `sin φ`.
    #[inline(always)]
    fn share_and_sine(&self) -> (L, L) {
        (L::splat(0.5) * (L::splat(1.0) - self.cos), self.sin)
    }

    fn stop(&mut self) {
        (self.rate, self.step_cos, self.step_sin) = (L::zero(), L::splat(1.0), L::zero());
    }

    #[inline(always)]
    fn advance(&mut self) {
        (self.cos, self.sin) =
            (self.cos * self.step_cos - self.sin * self.step_sin, self.sin * self.step_cos + self.cos * self.step_sin);
    }
}

/// Moves the tissue away from the needle by
///
/// ```text
/// s = A_b ((1 - cos φ)/2)² + A_h (1 - cos ψ)/2
/// ```
/// Breathing follows Lujan et al. (1999): `cos⁴`, at rest after exhalation. The heartbeat's sine and the direction are
/// chosen here.
#[derive(Debug, Clone)]
pub struct Moving<L: Lane> {
    tissue: StillTissue<L>,
    breathing: Cycle<L>,
    heartbeat: Cycle<L>,
}

impl<L: Lane> AnyTissue<L> {
    pub fn stop_organs(&mut self) {
        if let Self::Moving(moving) = self {
            moving.breathing.stop();
            moving.heartbeat.stop();
        }
    }
}

impl<L: Lane> Tissue<L> for Moving<L> {
    #[inline(never)]
    fn react(&mut self, tick: u64, position_m: L, velocity_m_per_s: L) -> Reaction<L> {
        let ((breath, breath_sine), (beat, beat_sine)) =
            (self.breathing.share_and_sine(), self.heartbeat.share_and_sine());
        let displacement_m = self.breathing.amplitude * breath * breath + self.heartbeat.amplitude * beat;
        let half = L::splat(0.5);
        let speed_m_per_s = self.breathing.rate * breath * breath_sine + self.heartbeat.rate * half * beat_sine;
        self.breathing.advance();
        self.heartbeat.advance();
        self.tissue.react(tick, position_m - displacement_m, velocity_m_per_s - speed_m_per_s)
    }

    #[inline(always)]
    fn shaft_force_n(&self) -> L {
        self.tissue.shaft_force_n()
    }
}

trocar_core::lane::gather!(Cycle { amplitude, rate, step_cos, step_sin, cos, sin });
trocar_core::lane::gather!(Moving { tissue, breathing, heartbeat });

#[cfg(test)]
mod tests {
    use super::super::{KelvinVoigt, KelvinVoigtSettings};
    use super::*;

    #[test]
    fn a_needle_at_rest_in_a_moving_spring_receives_the_motion_as_force() {
        let settings = KelvinVoigtSettings { stiffness_n_per_m: 1000.0, damping_n_s_per_m: 1.0, ..Default::default() };
        let spring = StillTissue::<f64>::KelvinVoigt(KelvinVoigt::new(&settings).expect("valid"));
        let motion = OrganMotion {
            breathing_amplitude_m: 4e-3,
            breathing_period_s: 3.0,
            heartbeat_amplitude_m: 3e-4,
            heartbeat_period_s: 0.8,
        };
        let tick_s = 1e-3;
        let mut tissue = motion.applied_to(spring, tick_s).expect("valid");
        for tick in 0..60_000_u64 {
            let time_s = tick_s * tick as f64;
            let phases = [TAU * time_s / 3.0, TAU * time_s / 0.8];
            let breath = (phases[0] / 2.0).sin().powi(4);
            let displacement = 4e-3 * breath + 3e-4 * (phases[1] / 2.0).sin().powi(2);
            let of_breathing = 4e-3 * TAU / 3.0 * 2.0 * (phases[0] / 2.0).sin().powi(3) * (phases[0] / 2.0).cos();
            let speed = of_breathing + 3e-4 * TAU / 0.8 * 0.5 * phases[1].sin();
            let force = tissue.react(tick, 0.01, 0.0).force_n;
            let expected = 1000.0 * (0.01 - displacement) - speed;
            assert!((force - expected).abs() < 1e-9, "{tick}: {force} instead of {expected}");
        }
    }

    #[test]
    fn without_amplitudes_the_tissue_is_unchanged() {
        let spring = StillTissue::<f64>::KelvinVoigt(KelvinVoigt::new(&KelvinVoigtSettings::DEFAULT).expect("valid"));
        let tissue = OrganMotion::DEFAULT.applied_to(spring, 1e-3).expect("valid");
        assert!(matches!(tissue, AnyTissue::Still(StillTissue::KelvinVoigt(_))));
    }

    #[test]
    fn stopped_organs_keep_their_displacement() {
        let settings = KelvinVoigtSettings { stiffness_n_per_m: 1000.0, damping_n_s_per_m: 1.0, ..Default::default() };
        let spring = StillTissue::<f64>::from(KelvinVoigt::new(&settings).expect("valid"));
        let motion = OrganMotion { breathing_amplitude_m: 4e-3, heartbeat_amplitude_m: 3e-4, ..OrganMotion::DEFAULT };
        let mut tissue = motion.applied_to(spring, 1e-3).expect("valid");
        let mut force = |tick| tissue.react(tick, 0.01, 0.0).force_n;
        (0..700).for_each(|tick| {
            force(tick);
        });
        let moving = force(700);
        tissue.stop_organs();
        let (first, later) = (tissue.react(701, 0.01, 0.0).force_n, tissue.react(2000, 0.01, 0.0).force_n);
        assert!((first - later).abs() < 1e-12 && (first - moving).abs() > 1e-6, "{moving} {first} {later}");
    }

    #[test]
    fn either_amplitude_moves_the_tissue() {
        let moves = |breathing_amplitude_m, heartbeat_amplitude_m| {
            OrganMotion { breathing_amplitude_m, heartbeat_amplitude_m, ..OrganMotion::DEFAULT }.moves()
        };
        assert_eq!([moves(0.0, 0.0), moves(1e-3, 0.0), moves(0.0, 1e-3)], [false, true, true]);
    }
}
