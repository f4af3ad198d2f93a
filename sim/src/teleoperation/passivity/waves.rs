//! Wave variables.

use super::{BuiltInScheme, PassivityScheme, SchemeContext, SlavePort};
use crate::lane::Lane;
use crate::teleoperation::PassivitySettings;
use trocar_core::settings::Key;

trocar_core::settings! {
    /// Settings of the wave variables.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct WavesSettings in "passivity." {
        /// Wave impedance b (wave-variables).
        wave_impedance_n_s_per_m: f64 [POSITIVE] = 40.0,
    }
}

/// After Niemeyer and Slotine (1991, *Stable adaptive teleoperation*): the link carries the waves `u = (b v + F) /
/// √(2b)` forward and `v = (b v - F) / √(2b)` back in place of velocity and force. A delay cannot amplify them.
///
/// ```text
/// master  u = √(2b) v_h - v_arrived         F_ed = b v_h - √(2b) v_arrived
/// slave   v_s = √(2/b) u_arrived - F_e / b  v = u_arrived - √(2/b) F_e,  x_ref = ∫ v_s
/// ```
/// The payload is the wave's integral, so that lost or late samples lose nothing and positions do not drift.
#[derive(Debug, Clone)]
pub struct Waves<L> {
    impedance: L,
    tick_s: L,
    inverse_tick: L,
    /// `√(2b)` and `√(2/b)`.
    gain_out: L,
    gain_in: L,
    inverse_impedance: L,
    forward_sent: L,
    forward_received: L,
    back_sent: L,
    back_received: L,
    /// The wave that came back to the master at the last tick, times the tick.
    returned: L,
    /// On the master's scale.
    reference: L,
}

impl<L: Lane> PassivityScheme<L> for Waves<L> {
    #[inline(always)]
    fn master_sends(&mut self, displacement_m: L) -> L {
        self.forward_sent = self.forward_sent + (self.gain_out * displacement_m - self.returned);
        self.forward_sent
    }

    #[inline(always)]
    fn receive_position(&mut self, _position_m: L, wave: L, port: &SlavePort<L>) -> L {
        let arrived = wave - self.forward_received;
        self.forward_received = wave;
        self.reference =
            self.reference + (self.gain_in * arrived - self.inverse_impedance * port.force_n * self.tick_s);
        self.back_sent = self.back_sent + (arrived - self.gain_in * port.force_n * self.tick_s);
        self.reference
    }

    #[inline(always)]
    fn slave_sends(&mut self) -> L {
        self.back_sent
    }

    #[inline(always)]
    fn receive_force(&mut self, _force_n: L, wave: L, velocity_m_per_s: L) -> L {
        self.returned = wave - self.back_received;
        self.back_received = wave;
        self.impedance * velocity_m_per_s - self.gain_out * self.returned * self.inverse_tick
    }
}

impl<L: Lane> BuiltInScheme<L> for Waves<L> {
    const CARRIES_POSITIONS: bool = false;
    const KEYS: &'static [&'static [Key]] = &[WavesSettings::KEYS];

    /// Without delay the two transformations cancel out.
    fn build(settings: &PassivitySettings, context: &SchemeContext<L>) -> Option<Self> {
        if context.is_immediate {
            return None;
        }
        let (b, tick_s, zero) = (settings.waves.wave_impedance_n_s_per_m, context.tick_s, L::zero());
        Some(Self {
            impedance: L::splat(b),
            tick_s: L::splat(tick_s),
            inverse_tick: L::splat(1.0 / tick_s),
            gain_out: L::splat((2.0 * b).sqrt()),
            gain_in: L::splat((2.0 / b).sqrt()),
            inverse_impedance: L::splat(1.0 / b),
            forward_sent: zero,
            forward_received: zero,
            back_sent: zero,
            back_received: zero,
            returned: zero,
            reference: context.start_m,
        })
    }
}

crate::lane::gather!(Waves {
    impedance,
    tick_s,
    inverse_tick,
    gain_out,
    gain_in,
    inverse_impedance,
    forward_sent,
    forward_received,
    back_sent,
    back_received,
    returned,
    reference,
});
