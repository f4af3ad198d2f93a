//! What joins the two sides, as a tick uses it.

use crate::lane::Lane;

/// What the master's side knows of itself at a tick.
#[derive(Debug, Clone, Copy)]
pub struct AtMaster<L> {
    /// `x_h` in m.
    pub position_m: L,
    /// `v_h` in m/s.
    pub velocity_m_per_s: L,
    /// `F_h` in N.
    pub hand_force_n: L,
}

/// What the slave's side measures of itself at a tick.
#[derive(Debug, Clone, Copy)]
pub struct AtSlave<L> {
    /// `x_e` in m.
    pub position_m: L,
    /// `v_e` in m/s.
    pub velocity_m_per_s: L,
    /// The measured force in N.
    pub force_n: L,
}

/// What a link has recorded by the end of a run, in one lane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinkReport {
    /// Outages of either direction.
    pub outages: u64,
    /// Ticks of the longest.
    pub longest_outage_ticks: f64,
    /// The tick at which the slave gave the link up.
    pub given_up_tick: Option<f64>,
    /// `∫ F_ed dx_h` in J: what the master's machine put into the link.
    pub master_port_j: f64,
    /// `∫ f_e dx_e` in J: what the needle put into the tissue, as measured.
    pub slave_port_j: f64,
    /// What passivity dissipated at the master's side in J.
    pub master_dissipated_j: f64,
    /// What it kept from the slave in J.
    pub slave_refused_j: f64,
}

/// What joins master and slave. A tick calls [`to_slave`](Connection::to_slave), [`to_master`](Connection::to_master) and
/// [`limit`](Connection::limit) in this order, each once.
pub trait Connection<L: Lane> {
    /// Slave's motion per master's.
    fn position_scale(&self) -> L;

    /// Force fed back per force measured.
    fn force_scale(&self) -> L;

    /// From the master to the slave: the target for the slave's reference, in m.
    fn to_slave(&mut self, master: &AtMaster<L>, slave: &AtSlave<L>) -> L;

    /// From the slave, in `mode`, to the master: the mode that has arrived there, and the force (N) that its controller
    /// feeds back where no law changes it.
    fn to_master(&mut self, mode: L, slave: &AtSlave<L>, master: &AtMaster<L>) -> (L, L);

    /// The force that is fed back (N), where the force law asks for `force_n`.
    fn limit(&mut self, force_n: L, master: &AtMaster<L>) -> L;

    /// The reference that the slave's controller works on (m), where the tissue pushes the slave off it with a force (N).
    fn apply_compliance(&self, reference_m: L, tissue_force_n: L) -> L;

    /// What has been recorded so far in lane `index`; none where positions and forces arrive at once and as they are.
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

    fn to_master(&mut self, mode: L, slave: &AtSlave<L>, master: &AtMaster<L>) -> (L, L) {
        (**self).to_master(mode, slave, master)
    }

    fn limit(&mut self, force_n: L, master: &AtMaster<L>) -> L {
        (**self).limit(force_n, master)
    }

    fn apply_compliance(&self, reference_m: L, tissue_force_n: L) -> L {
        (**self).apply_compliance(reference_m, tissue_force_n)
    }

    fn report(&self, index: usize) -> Option<LinkReport> {
        (**self).report(index)
    }
}
