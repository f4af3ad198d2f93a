//! A tank of energy on each side.

use super::meter::Meter;
use super::{PassivitySettings, SlavePort};
use crate::lane::Lane;

/// How many times its level a tank holds at most; what comes beyond is let go.
const MAX_LEVELS: f64 = 10.0;

/// After Franken, Stramigioli, Misra, Secchi and Macchelli (2011, *Bilateral telemanipulation with time delays: a two-layer
/// approach combining passivity and transparency*): the layer above wants what it wants, the one below lets through what
/// the side's tank has energy for.
///
/// ```text
/// H_m += F_ed Δx_h + received - sent      F_ed = F + d v_h,  d = limit · max(1 - H_m / level, 0)
///                                         |F| <= H_m / |T v_h| where it pushes the hand along
/// H_s -= f_e Δx_e - received + sent       the reference goes as far as H_s pays for
/// ```
/// Each tick each tank sends a share of what it holds. What is sent is sent as a running total, so that a lost sample
/// loses none of it.
#[derive(Debug, Clone)]
pub(in crate::teleoperation) struct Tank<L> {
    inverse_level: L,
    most: L,
    share: L,
    max_damping: L,
    tick_s: L,
    meter: Meter<L>,
    master: L,
    slave: L,
    master_sent: L,
    slave_sent: L,
    master_received: L,
    slave_received: L,
    fed_back: L,
    /// What the layer changed about the force that was wanted, in N.
    changed: L,
    /// Energy that the damping took from the hand for the tank, or that was kept from the hand, in J.
    pub(in crate::teleoperation) dissipated_j: L,
}

impl<L: Lane> Tank<L> {
    pub(in crate::teleoperation) fn new(settings: &PassivitySettings, tick_s: f64, reference: L) -> Self {
        let zero = L::zero();
        let level = L::splat(settings.tank_level_j);
        Self {
            inverse_level: L::splat(1.0 / settings.tank_level_j),
            most: L::splat(MAX_LEVELS * settings.tank_level_j),
            share: L::splat(settings.tank_share),
            max_damping: L::splat(settings.damping_limit_n_s_per_m),
            tick_s: L::splat(tick_s),
            meter: Meter::new(settings.catch_up_speed_m_per_s, tick_s, reference),
            master: level,
            slave: level,
            master_sent: zero,
            slave_sent: zero,
            master_received: zero,
            slave_received: zero,
            fed_back: zero,
            changed: zero,
            dissipated_j: zero,
        }
    }

    /// The master has moved by `displacement` (m) since the last tick; gives what to send.
    #[inline(always)]
    pub(in crate::teleoperation) fn master_moved(&mut self, displacement: L) -> L {
        self.master = self.master + self.fed_back * displacement;
        self.dissipated_j = self.dissipated_j + self.changed * displacement;
        self.master = self.master.min(self.most);
        let sent = self.share * self.master.max(L::zero());
        self.master = self.master - sent;
        self.master_sent = self.master_sent + sent;
        self.master_sent
    }

    /// The slave's reference, given what the master has sent.
    #[inline(always)]
    pub(in crate::teleoperation) fn meter(&mut self, target: L, energy: L, port: &SlavePort<L>) -> L {
        self.slave = self.slave + (energy - self.slave_received) - port.work_j;
        self.slave_received = energy;
        self.slave = self.slave.min(self.most);
        self.meter.follow(target, port.scaled_force, self.slave)
    }

    /// What the slave sends.
    #[inline(always)]
    pub(in crate::teleoperation) fn slave_sends(&mut self) -> L {
        let sent = self.share * self.slave.max(L::zero());
        self.slave = self.slave - sent;
        self.slave_sent = self.slave_sent + sent;
        self.slave_sent
    }

    /// The force to feed back, given what the slave has sent.
    #[inline(always)]
    pub(in crate::teleoperation) fn limit(&mut self, force: L, energy: L, velocity: L) -> L {
        let zero = L::zero();
        self.master = self.master + (energy - self.master_received);
        self.master_received = energy;
        let gives = (force * velocity).lt(zero);
        let travel = (self.tick_s * velocity).abs();
        let most = self.master.max(zero) / L::select(gives, travel, L::splat(1.0));
        let afforded = L::select(gives, force.clamp(-most, most), force);
        let damping = self.max_damping * (L::splat(1.0) - self.master * self.inverse_level).clamp(zero, L::splat(1.0));
        self.fed_back = afforded + damping * velocity;
        self.changed = self.fed_back - force;
        self.fed_back
    }

    /// Work that was refused at the slave in J.
    #[inline(always)]
    pub(in crate::teleoperation) fn refused_j(&self) -> L {
        self.meter.refused_j
    }
}

crate::lane::gather!(Tank {
    inverse_level,
    most,
    share,
    max_damping,
    tick_s,
    meter,
    master,
    slave,
    master_sent,
    slave_sent,
    master_received,
    slave_received,
    fed_back,
    changed,
    dissipated_j,
});
