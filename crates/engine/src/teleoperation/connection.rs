//! The interface between the two sides at a tick.

use trocar_core::augmentation::Modes;
use trocar_core::lane::Lane;

/// The master's measurements at a tick.
#[derive(Debug, Clone, Copy)]
pub struct AtMaster<L> {
    /// `x_h` in m.
    pub position_m: L,
    /// `v_h` in m/s.
    pub velocity_m_per_s: L,
    /// `F_h` in N.
    pub hand_force_n: L,
}

/// The slave's measurements at a tick.
#[derive(Debug, Clone, Copy)]
pub struct AtSlave<L> {
    /// `x_e` in m.
    pub position_m: L,
    /// `v_e` in m/s.
    pub velocity_m_per_s: L,
    /// Measured force in N.
    pub force_n: L,
}

/// Totals of the link at the end of a run, in one lane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinkReport {
    /// Number of outages in both directions.
    pub outages: u64,
    /// Length of the longest outage in ticks.
    pub longest_outage_ticks: f64,
    /// Tick at which the slave stopped following the link (`channel.recovery = "give-up"`).
    pub given_up_tick: Option<f64>,
    /// Energy from the master into the link in J, `∫ F_ed dx_h`.
    pub master_port_j: f64,
    /// Energy from the needle into the tissue in J, `∫ f_e dx_e`, from the measured force.
    pub slave_port_j: f64,
    /// Maximum of `E_s - E_m` in J, with the slave's energy scaled to the master: the largest energy that both ports
    /// have delivered beyond what they received.
    pub generated_j: f64,
    /// Bound in J that the passivity scheme promises for the generated energy; `None` without a promise.
    pub promised_j: Option<f64>,
    /// Distance in m by which the slave is deeper than the master, on the slave's scale; else 0.
    pub left_behind_m: f64,
    /// Energy that the passivity scheme dissipated at the master, in J.
    pub master_dissipated_j: f64,
    /// Work that the passivity scheme withheld from the slave, in J.
    pub slave_refused_j: f64,
}

/// Connects master and slave. A tick calls [`to_slave`](Connection::to_slave),
/// [`limit_reference`](Connection::limit_reference), [`to_master`](Connection::to_master) and
/// [`limit`](Connection::limit) once each, in this order.
pub trait Connection<L: Lane> {
    /// The slave motion per master motion.
    fn position_scale(&self) -> L;

    /// The feedback force per measured force.
    fn force_scale(&self) -> L;

    /// Transmits to the slave. Returns the target of its reference, in m.
    fn to_slave(&mut self, master: &AtMaster<L>, slave: &AtSlave<L>) -> L;

    /// Limits the supervisor's `reference_m`. Returns the slave's reference (m).
    fn limit_reference(&mut self, reference_m: L, slave: &AtSlave<L>) -> L;

    /// Transmits to the master. Returns the received mode, and the feedback force (N) before the force law.
    fn to_master(&mut self, mode: Modes<L>, slave: &AtSlave<L>, master: &AtMaster<L>) -> (Modes<L>, L);

    /// Limits the force law's `force_n`. Returns the feedback force (N).
    fn limit(&mut self, force_n: L, master: &AtMaster<L>) -> L;

    /// The deflection (m) of the slave from its reference by the tissue force.
    fn deflection_m(&self, tissue_force_n: L) -> L;

    /// The totals so far in lane `index`; `None` for a direct link.
    fn report(&self, index: usize) -> Option<LinkReport>;
}

impl<L: Lane, K: Connection<L> + ?Sized> Connection<L> for Box<K> {
    fn position_scale(&self) -> L {
        (**self).position_scale()
    }

    fn force_scale(&self) -> L {
        (**self).force_scale()
    }

    fn to_slave(&mut self, master: &AtMaster<L>, slave: &AtSlave<L>) -> L {
        (**self).to_slave(master, slave)
    }

    fn limit_reference(&mut self, reference_m: L, slave: &AtSlave<L>) -> L {
        (**self).limit_reference(reference_m, slave)
    }

    fn to_master(&mut self, mode: Modes<L>, slave: &AtSlave<L>, master: &AtMaster<L>) -> (Modes<L>, L) {
        (**self).to_master(mode, slave, master)
    }

    fn limit(&mut self, force_n: L, master: &AtMaster<L>) -> L {
        (**self).limit(force_n, master)
    }

    fn deflection_m(&self, tissue_force_n: L) -> L {
        (**self).deflection_m(tissue_force_n)
    }

    fn report(&self, index: usize) -> Option<LinkReport> {
        (**self).report(index)
    }
}
