//! Wave variables.

use super::{BuiltInScheme, PassivityScheme, SlavePort, Surroundings};
use crate::lane::Lane;
use crate::teleoperation::PassivitySettings;
use trocar_core::settings::Key;

trocar_core::settings! {
    /// The numbers of the waves.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct WavesSettings in "passivity." {
        /// b of the waves (wave-variables).
        wave_impedance_n_s_per_m: f64 [POSITIVE] = 40.0,
    }
}

/// After Niemeyer and Slotine (1991, *Stable adaptive teleoperation*): instead of velocity and force the link carries the
/// waves `u = (b v + F) / √(2b)` forth and `v = (b v - F) / √(2b)` back, which a delay cannot amplify.
///
/// ```text
/// master  u = √(2b) v_h - v_arrived         F_ed = b v_h - √(2b) v_arrived
/// slave   v_s = √(2/b) u_arrived - F_e / b  v = u_arrived - √(2/b) F_e,  x_ref = ∫ v_s
/// ```
/// What is sent is the wave's integral: a sample that is lost or late takes nothing with it, and positions do not drift.
#[derive(Debug, Clone)]
pub struct Waves<L> {
    impedance: L,
    tick_s: L,
    inverse_tick: L,
    /// `√(2b)` and `√(2/b)`.
    up: L,
    down: L,
    inverse_impedance: L,
    forth_sent: L,
    forth_received: L,
    back_sent: L,
    back_received: L,
    /// The wave that came back to the master at the last tick, times the tick.
    returned: L,
    /// In the master's metres.
    reference: L,
}

impl<L: Lane> PassivityScheme<L> for Waves<L> {
    #[inline(always)]
    fn master_sends(&mut self, displacement_m: L) -> L {
        self.forth_sent = self.forth_sent + (self.up * displacement_m - self.returned);
        self.forth_sent
    }

    #[inline(always)]
    fn receive_position(&mut self, _position_m: L, wave: L, port: &SlavePort<L>) -> L {
        let arrived = wave - self.forth_received;
        self.forth_received = wave;
        self.reference = self.reference + (self.down * arrived - self.inverse_impedance * port.force_n * self.tick_s);
        self.back_sent = self.back_sent + (arrived - self.down * port.force_n * self.tick_s);
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
        self.impedance * velocity_m_per_s - self.up * self.returned * self.inverse_tick
    }
}

impl<L: Lane> BuiltInScheme<L> for Waves<L> {
    const CARRIES_POSITIONS: bool = false;
    const KEYS: &'static [&'static [Key]] = &[WavesSettings::KEYS];

    /// Without delay the two transformations cancel out.
    fn build(settings: &PassivitySettings, around: &Surroundings<L>) -> Option<Self> {
        if around.is_immediate {
            return None;
        }
        let (b, tick_s, zero) = (settings.waves.wave_impedance_n_s_per_m, around.tick_s, L::zero());
        Some(Self {
            impedance: L::splat(b),
            tick_s: L::splat(tick_s),
            inverse_tick: L::splat(1.0 / tick_s),
            up: L::splat((2.0 * b).sqrt()),
            down: L::splat((2.0 / b).sqrt()),
            inverse_impedance: L::splat(1.0 / b),
            forth_sent: zero,
            forth_received: zero,
            back_sent: zero,
            back_received: zero,
            returned: zero,
            reference: around.start_m,
        })
    }
}

crate::lane::gather!(Waves {
    impedance,
    tick_s,
    inverse_tick,
    up,
    down,
    inverse_impedance,
    forth_sent,
    forth_received,
    back_sent,
    back_received,
    returned,
    reference,
});
