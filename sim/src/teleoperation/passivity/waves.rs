//! Wave variables.

use super::PassivitySettings;
use crate::lane::Lane;

/// After Niemeyer and Slotine (1991, *Stable adaptive teleoperation*): instead of velocity and force the link carries the
/// waves `u = (b v + F) / √(2b)` forth and `v = (b v - F) / √(2b)` back, which a delay cannot amplify.
///
/// ```text
/// master  u = √(2b) v_h - v_arrived         F_ed = b v_h - √(2b) v_arrived
/// slave   v_s = √(2/b) u_arrived - F_e / b  v = u_arrived - √(2/b) F_e,  x_ref = ∫ v_s
/// ```
/// What is sent is the wave's integral: a sample that is lost or late takes nothing with it, and positions do not drift.
#[derive(Debug, Clone)]
pub(in crate::teleoperation) struct Waves<L> {
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
    reference: L,
}

impl<L: Lane> Waves<L> {
    pub(in crate::teleoperation) fn new(settings: &PassivitySettings, tick_s: f64, reference: L) -> Self {
        let (b, zero) = (settings.wave_impedance_n_s_per_m, L::zero());
        Self {
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
            reference,
        }
    }

    /// The master has moved by `displacement` (m) since the last tick; gives what to send.
    #[inline(always)]
    pub(in crate::teleoperation) fn master_moved(&mut self, displacement: L) -> L {
        self.forth_sent = self.forth_sent + (self.up * displacement - self.returned);
        self.forth_sent
    }

    /// The slave's reference in the master's metres, given the wave that has arrived and the force scaled to the master.
    #[inline(always)]
    pub(in crate::teleoperation) fn receive(&mut self, wave: L, force: L) -> L {
        let arrived = wave - self.forth_received;
        self.forth_received = wave;
        self.reference = self.reference + (self.down * arrived - self.inverse_impedance * force * self.tick_s);
        self.back_sent = self.back_sent + (arrived - self.down * force * self.tick_s);
        self.reference
    }

    /// What the slave sends.
    #[inline(always)]
    pub(in crate::teleoperation) fn slave_sends(&self) -> L {
        self.back_sent
    }

    /// The force to feed back, given the wave that has arrived.
    #[inline(always)]
    pub(in crate::teleoperation) fn force(&mut self, wave: L, velocity: L) -> L {
        self.returned = wave - self.back_received;
        self.back_received = wave;
        self.impedance * velocity - self.up * self.returned * self.inverse_tick
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
