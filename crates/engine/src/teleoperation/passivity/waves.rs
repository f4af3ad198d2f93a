use super::budget::{Budget, DEMAND, ENERGY};
use super::{Arrived, BuiltInScheme, PAYLOAD, PassivityScheme, Payload, SchemeContext, SchemeEnergies, SlavePort};
use crate::teleoperation::{BudgetSettings, CatchUpSettings, DampingSettings, PassivitySettings};
use trocar_core::lane::Lane;
use trocar_core::settings::Key;

trocar_core::settings! {
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct WavesSettings in "passivity." {
        /// Wave impedance b (wave-variables); below 2 m / T with the master's mass m and the tick T.
        wave_impedance_n_s_per_m: f64 [POSITIVE] = 90.0,
        /// Time constant with which the slave returns to the hand's position (wave-variables).
        drift_time_s: f64 [POSITIVE] = 0.2,
    }
}

/// Without a delay the returning wave would alternate from tick to tick. A low-pass filter of a wave is passive
/// (Niemeyer and Slotine 2004); this one acts above 30 Hz.
const FILTER_S: f64 = 5e-3;

const FORCE_MARGIN: f64 = 1.2;

/// Lets the force on a hand in free motion decay.
const RELEASE_S: f64 = 0.15;

/// In a payload: wave over the last tick.
const WAVE: usize = 1;
/// In a payload: running energy of the wave.
const WAVE_ENERGY: usize = 2;

/// The waves `u = (b v + F) / √(2b)` forward and `v = (b v - F) / √(2b)` back, which a delay cannot amplify (Niemeyer
/// and Slotine 1991):
///
/// ```text
/// master  F_ed = b Δx_h / T - √(2b) v_arrived / T   u = (b Δx_h + F_ed T) / √(2b)
/// slave   Δx_ref = √(2/b) u_arrived - f_e T / b     v = (b Δx_ref - f_e T) / √(2b)
/// promise E_m - E_s >= -2 budget_j    at every tick
/// ```
/// The waves are passive at `(f_e, x_ref)`; a [`Budget`] accounts for the needle's lag, augmentation, jitter and loss. Energy pays
/// for holding a missing sample (Hirche and Buss 2004, 2012); a position sent besides corrects drift (Chawda and
/// O'Malley 2015).
///
/// The force is at most 1.2 times the recent tissue force: a hand in free motion would feel `b v` otherwise.
#[derive(Debug, Clone)]
pub struct Waves<L> {
    budget: Budget<L>,
    is_immediate: bool,
    impedance: L,
    tick: L,
    inverse_tick: L,
    position_scale: L,
    inverse_scale: L,
    /// `√(2b)`, `1 / √(2b)`, `√(2/b)` and `1 / b`.
    gain_out: L,
    inverse_gain_out: L,
    gain_in: L,
    inverse_impedance: L,
    drift_share: L,
    max_drift: L,
    forward: SupervisedWave<L>,
    back: SupervisedWave<L>,
    forward_energy: L,
    back_wave: L,
    back_energy: L,
    moved: L,
    filter_share: L,
    returned: L,
    recent_n: L,
    kept_share: L,
    force_margin: L,
    reference: L,
    target: L,
    force_n: L,
    hand: L,
}

#[derive(Debug, Clone)]
struct SupervisedWave<L> {
    half_inverse_tick: L,
    budget: L,
    held: L,
    spent: L,
}

impl<L: Lane> SupervisedWave<L> {
    fn peer_restarts(&mut self) {
        (self.held, self.spent) = (L::zero(), L::zero());
    }

    #[inline(always)]
    fn receive(&mut self, arrived: &Arrived<L>) -> L {
        let zero = L::zero();
        self.held = L::select(arrived.is_fresh, arrived.payload[WAVE], self.held);
        let cost = self.held * self.held * self.half_inverse_tick;
        let left = (arrived.payload[WAVE_ENERGY] + self.budget - self.spent).max(zero);
        let is_short = cost.gt(left);
        let share = (left / L::select(is_short, cost, L::splat(1.0))).sqrt();
        let wave = L::select(is_short, self.held * share, self.held);
        self.spent = self.spent + wave * wave * self.half_inverse_tick;
        wave
    }
}

impl<L: Lane> PassivityScheme<L> for Waves<L> {
    #[inline(always)]
    fn master_sends(&mut self, displacement_m: L) -> Payload<L> {
        let mut payload = [L::zero(); PAYLOAD];
        self.moved = displacement_m;
        let wave =
            (self.impedance * displacement_m + self.budget.sides.force.force_n * self.tick) * self.inverse_gain_out;
        self.forward_energy = self.forward_energy + wave * wave * self.forward.half_inverse_tick;
        (payload[ENERGY], payload[DEMAND]) = self.budget.master_sends(displacement_m);
        (payload[WAVE], payload[WAVE_ENERGY]) = (wave, self.forward_energy);
        payload
    }

    #[inline(always)]
    fn receive_position(&mut self, position_m: L, arrived: &Arrived<L>, port: &SlavePort<L>) -> L {
        self.budget.slave_receives(&arrived.payload, port);
        self.hand = position_m * self.position_scale;
        self.target = position_m;
        if self.is_immediate {
            return position_m;
        }
        let wave = self.forward.receive(arrived);
        let drift = ((position_m - self.reference) * self.drift_share).clamp(-self.max_drift, self.max_drift);
        // A lag behind a pushing hand is the stretch of the link, not drift.
        let is_stretch = drift.gt(L::zero()) & port.force_n.gt(L::zero());
        let drift = L::select(is_stretch, L::zero(), drift);
        self.force_n = port.force_n;
        let pushed = self.inverse_impedance * port.force_n * self.tick;
        let free = self.reference + (self.gain_in * wave - pushed) + drift;
        // A force that only the hand still feels would drive the slave beyond it.
        let (deepest, shallowest) = (position_m.max(self.reference), position_m.min(self.reference));
        let zero = L::zero();
        let not_deeper = L::select(port.force_n.gt(zero), free.min(deepest), free);
        self.target = L::select(port.force_n.lt(zero), free.max(shallowest), not_deeper);
        self.target
    }

    #[inline(always)]
    fn limit_reference(&mut self, commanded_m: L, port: &SlavePort<L>) -> L {
        // Without the hand's motion during an event, for which the operator does not pay in advance.
        let hand_m = commanded_m + (self.hand - self.target * self.position_scale);
        let reference_m = self.budget.sides.limit_reference(commanded_m, hand_m, port);
        // The waves exclude the supervisor's change, so the freeze is felt through the force law.
        let reference = self.target - (commanded_m - reference_m) * self.inverse_scale;
        let moved = self.impedance * (reference - self.reference);
        self.back_wave = (moved - self.force_n * self.tick) * self.inverse_gain_out;
        self.back_energy = self.back_energy + self.back_wave * self.back_wave * self.back.half_inverse_tick;
        self.reference = reference;
        reference_m
    }

    #[inline(always)]
    fn slave_sends(&mut self) -> Payload<L> {
        let mut payload = [L::zero(); PAYLOAD];
        (payload[ENERGY], payload[DEMAND]) = self.budget.slave_sends();
        (payload[WAVE], payload[WAVE_ENERGY]) = (self.back_wave, self.back_energy);
        payload
    }

    #[inline(always)]
    fn receive_force(&mut self, force_n: L, arrived: &Arrived<L>, _velocity_m_per_s: L) -> L {
        self.budget.master_receives(force_n, &arrived.payload);
        if self.is_immediate {
            return force_n;
        }
        self.returned = self.returned + self.filter_share * (self.back.receive(arrived) - self.returned);
        self.recent_n = force_n.abs().max(self.kept_share * self.recent_n);
        let force_n = (self.impedance * self.moved - self.gain_out * self.returned) * self.inverse_tick;
        let max_n = self.force_margin * self.recent_n;
        force_n.clamp(-max_n, max_n)
    }

    #[inline(always)]
    fn limit_force(&mut self, force_n: L, velocity_m_per_s: L) -> L {
        self.budget.limit_force(force_n, velocity_m_per_s)
    }

    fn peer_restarts(&mut self) {
        self.budget.sides.peer_restarts();
        (self.forward_energy, self.back_energy) = (L::zero(), L::zero());
        self.forward.peer_restarts();
        self.back.peer_restarts();
    }

    fn energies(&self) -> SchemeEnergies<L> {
        self.budget.sides.energies()
    }
}

impl<L: Lane> BuiltInScheme<L> for Waves<L> {
    const CARRIES_POSITIONS: bool = false;
    const KEYS: &'static [&'static [Key]] =
        &[BudgetSettings::KEYS, WavesSettings::KEYS, DampingSettings::KEYS, CatchUpSettings::KEYS];

    fn held_dampings(settings: &PassivitySettings) -> [Option<(&'static str, f64)>; 2] {
        let impedance = ("passivity.wave_impedance_n_s_per_m", settings.waves.wave_impedance_n_s_per_m);
        [Some(impedance), Some(settings.damping.with_key())]
    }

    fn build(settings: &PassivitySettings, context: &SchemeContext<L>) -> Self {
        let (b, tick_s, zero) = (settings.waves.wave_impedance_n_s_per_m, context.tick_s, L::zero());
        let catch_up = settings.catch_up.catch_up_speed_m_per_s;
        let wave = SupervisedWave {
            half_inverse_tick: L::splat(0.5 / tick_s),
            budget: L::splat(settings.budget.budget_j),
            held: zero,
            spent: zero,
        };
        // A wave is as fast as the hand; the drift has its own limit.
        let speed = if context.is_immediate { catch_up } else { f64::INFINITY };
        Self {
            budget: Budget::new(settings, context, speed).without_energy_under_way(),
            is_immediate: context.is_immediate,
            impedance: L::splat(b),
            tick: L::splat(tick_s),
            inverse_tick: L::splat(1.0 / tick_s),
            position_scale: L::splat(context.position_scale),
            inverse_scale: L::splat(1.0 / context.position_scale),
            gain_out: L::splat((2.0 * b).sqrt()),
            inverse_gain_out: L::splat(1.0 / (2.0 * b).sqrt()),
            gain_in: L::splat((2.0 / b).sqrt()),
            inverse_impedance: L::splat(1.0 / b),
            drift_share: L::splat((tick_s / settings.waves.drift_time_s).min(1.0)),
            max_drift: L::splat(catch_up * tick_s),
            forward: wave.clone(),
            back: wave,
            forward_energy: zero,
            back_wave: zero,
            back_energy: zero,
            moved: zero,
            filter_share: L::splat(tick_s / (tick_s + FILTER_S)),
            returned: zero,
            recent_n: zero,
            kept_share: L::splat(1.0 - tick_s / (tick_s + RELEASE_S)),
            force_margin: L::splat(FORCE_MARGIN),
            reference: context.start_m,
            target: context.start_m,
            force_n: zero,
            hand: context.reference_m,
        }
    }
}

trocar_core::lane::gather!(SupervisedWave { half_inverse_tick, budget, held, spent });
trocar_core::lane::gather!(Waves {
    budget,
    impedance,
    tick,
    inverse_tick,
    position_scale,
    inverse_scale,
    gain_out,
    inverse_gain_out,
    gain_in,
    inverse_impedance,
    drift_share,
    max_drift,
    forward,
    back,
    forward_energy,
    back_wave,
    back_energy,
    moved,
    filter_share,
    returned,
    recent_n,
    kept_share,
    force_margin,
    reference,
    target,
    force_n,
    hand,
} same { is_immediate });

#[cfg(test)]
mod tests {
    use super::*;

    const B: f64 = 90.0;
    const TICK_S: f64 = 1e-3;

    fn waves() -> Waves<f64> {
        waves_at(0.0)
    }

    /// Both machines at a position in m.
    fn waves_at(position_m: f64) -> Waves<f64> {
        let context =
            SchemeContext { start_m: position_m, reference_m: position_m, ..SchemeContext::<f64>::for_tests() };
        Waves::build(&PassivitySettings::DEFAULT, &context)
    }

    fn port(force_n: f64) -> SlavePort<f64> {
        SlavePort { force_n, cost_j_per_m: force_n, work_j: 0.0, position_m: 0.0, velocity_m_per_s: 0.0 }
    }

    /// A received wave with more energy than it takes.
    fn arrived(wave: f64) -> Arrived<f64> {
        let mut payload = [0.0; PAYLOAD];
        (payload[WAVE], payload[WAVE_ENERGY]) = (wave, 1.0);
        Arrived { payload, is_fresh: true }
    }

    #[test]
    fn the_master_sends_the_forward_wave_and_its_energy() {
        let mut waves = waves();
        waves.budget.sides.force.force_n = 2.0;
        // u = (b Δx + F T) / √(2b), u² / 2T.
        let expected = (B * 2e-5 + 2.0 * TICK_S) / (2.0 * B).sqrt();
        let payload = waves.master_sends(2e-5);
        assert!((payload[WAVE] - expected).abs() < 1e-15, "{payload:?}");
        assert!((payload[WAVE_ENERGY] - 0.5 * expected * expected / TICK_S).abs() < 1e-15, "{payload:?}");
        let next = waves.master_sends(2e-5);
        assert!((next[WAVE_ENERGY] - 2.0 * payload[WAVE_ENERGY]).abs() < 1e-15, "a running total");
    }

    #[test]
    fn the_slave_moves_by_the_wave_minus_the_effect_of_the_force_and_sends_the_rest_back() {
        let mut waves = waves_at(0.02);
        // Δx = √(2/b) u - f T / b. A pushing slave behind the hand does not drift to the hand.
        let (wave, force) = (1e-3, 1.5);
        let moved = (2.0 / B).sqrt() * wave - force * TICK_S / B;
        let target = waves.receive_position(0.03, &arrived(wave), &port(force));
        assert!((target - (0.02 + moved)).abs() < 1e-15, "{target}");
        let paid = SlavePort { position_m: target, ..port(force) };
        assert_eq!(waves.limit_reference(target, &paid), target);
        let back = (B * moved - force * TICK_S) / (2.0 * B).sqrt();
        let payload = waves.slave_sends();
        assert!((payload[WAVE] - back).abs() < 1e-15, "{payload:?}");
        assert!((payload[WAVE_ENERGY] - 0.5 * back * back / TICK_S).abs() < 1e-15, "{payload:?}");
        // u² - v² = 2 T F Δx: the waves carry the work.
        let power = 2.0 * TICK_S * force * moved;
        assert!((wave * wave - back * back - power).abs() < 1e-15, "{power}");
    }

    #[test]
    fn without_a_force_the_slave_drifts_to_the_hand_at_a_bounded_speed() {
        let drift = |position_m: f64| {
            let mut waves = waves_at(0.02);
            waves.receive_position(position_m, &arrived(0.0), &port(0.0)) - 0.02
        };
        // The gap over 0.2 s, at most 30 mm/s.
        assert!((drift(0.021) - 1e-3 / 200.0).abs() < 1e-15, "{}", drift(0.021));
        assert!((drift(0.019) + 1e-3 / 200.0).abs() < 1e-15);
        assert!((drift(0.05) - 3e-5).abs() < 1e-15 && (drift(0.0) + 3e-5).abs() < 1e-15);
    }

    #[test]
    fn a_pushing_needle_goes_no_deeper_than_the_hand_and_a_pulling_one_no_shallower() {
        let target = |hand_m: f64, wave: f64, force_n: f64| {
            let mut waves = waves_at(0.02);
            waves.receive_position(hand_m, &arrived(wave), &port(force_n))
        };
        assert_eq!(target(0.0201, 0.01, 0.5), 0.0201);
        assert_eq!(target(0.015, 0.01, 0.5), 0.02, "ahead of the hand it stays");
        assert_eq!(target(0.0199, -0.01, -0.5), 0.0199);
        assert!(target(0.0201, 0.01, 0.0) > 0.0201, "a free needle is not limited");
    }

    #[test]
    fn the_force_follows_the_filtered_returned_wave_and_stays_near_the_tissue_force() {
        let mut waves = waves();
        waves.moved = 2e-5;
        // F = (b Δx - √(2b) v') / T, with the share T / (T + 5 ms) of the wave.
        let wave = -2e-4;
        let expected = (B * 2e-5 - (2.0 * B).sqrt() * wave * TICK_S / 6e-3) / TICK_S;
        let force = waves.receive_force(10.0, &arrived(wave), 0.0);
        assert!((force - expected).abs() < 1e-12, "{force} instead of {expected}");
        // At most a fifth above the tissue force, which decays after it has ended.
        assert!((waves.receive_force(1.0, &arrived(-1.0), 0.0) - 1.2 * 10.0 * (1.0 - TICK_S / 0.151)).abs() < 1e-12);
        let mut free = self::waves();
        free.moved = 2e-5;
        assert_eq!(free.receive_force(0.0, &arrived(0.0), 0.0), 0.0, "a hand in free motion feels nothing");
    }

    #[test]
    fn a_held_wave_is_reduced_to_its_available_energy() {
        let mut wave = waves().forward;
        let energy = |wave: f64| 0.5 * wave * wave / TICK_S;
        let budget = PassivitySettings::DEFAULT.budget.budget_j;
        let mut payload = [0.0; PAYLOAD];
        (payload[WAVE], payload[WAVE_ENERGY]) = (2e-3, energy(2e-3));
        assert_eq!(wave.receive(&Arrived { payload, is_fresh: true }), 2e-3);
        // Held while received energy and budget last: 10 mJ at 2 mJ per tick.
        payload[WAVE] = 99.0;
        let held = Arrived { payload, is_fresh: false };
        let ticks = (budget / energy(2e-3)) as usize;
        for tick in 0..ticks {
            assert!((wave.receive(&held) - 2e-3).abs() < 1e-9, "{tick}");
        }
        assert!(wave.receive(&held).abs() < 1e-6, "nothing is left");
        assert!(wave.spent <= payload[WAVE_ENERGY] + budget + 1e-15);
    }

    #[test]
    fn without_a_delay_positions_and_forces_are_sent() {
        let context = SchemeContext { is_immediate: true, ..SchemeContext::<f64>::for_tests() };
        let mut waves = Waves::build(&PassivitySettings::DEFAULT, &context);
        assert_eq!(waves.receive_position(0.03, &arrived(5.0), &port(1.0)), 0.03);
        assert_eq!(waves.receive_force(1.5, &arrived(5.0), 0.0), 1.5);
    }
}
