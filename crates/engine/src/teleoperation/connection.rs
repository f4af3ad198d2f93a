use trocar_core::augmentation::Modes;
use trocar_core::lane::Lane;

#[derive(Debug, Clone, Copy)]
pub struct AtMaster<L> {
    pub position_m: L,
    pub velocity_m_per_s: L,
    pub hand_force_n: L,
}

#[derive(Debug, Clone, Copy)]
pub struct AtSlave<L> {
    pub position_m: L,
    pub velocity_m_per_s: L,
    pub force_n: L,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinkReport {
    pub outages: u64,
    pub longest_outage_ticks: f64,
    pub given_up_tick: Option<f64>,
    /// `∫ F_ed dx_h`
    pub master_port_j: f64,
    /// `∫ f_e dx_e`, from the measured force.
    pub slave_port_j: f64,
    /// Maximum of `E_s - E_m`, scaled to the master.
    pub generated_j: f64,
    pub promised_j: Option<f64>,
    /// Slave minus master, on the slave's scale.
    pub left_behind_m: f64,
    pub master_dissipated_j: f64,
    pub slave_refused_j: f64,
}

/// Order of calls at a tick: [`to_slave`](Connection::to_slave), [`limit_reference`](Connection::limit_reference),
/// [`to_master`](Connection::to_master), [`limit`](Connection::limit).
pub trait Connection<L: Lane> {
    fn position_scale(&self) -> L;

    fn force_scale(&self) -> L;

    fn to_slave(&mut self, master: &AtMaster<L>, slave: &AtSlave<L>) -> L;

    fn limit_reference(&mut self, reference_m: L, slave: &AtSlave<L>) -> L;

    fn to_master(&mut self, mode: Modes<L>, slave: &AtSlave<L>, master: &AtMaster<L>) -> (Modes<L>, L);

    fn limit(&mut self, force_n: L, master: &AtMaster<L>) -> L;

    fn deflection_m(&self, tissue_force_n: L) -> L;

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
