//! What the engine asks of whatever joins the two sides, and the one that passes everything on.

use super::link::{AtMaster, AtSlave, Link, LinkReport};
use crate::lane::Lane;

/// Joins the two sides, one tick at a time.
pub trait Connection<L: Lane> {
    /// From the master to the slave: where its controller wants the slave's reference, in m.
    fn to_slave(&mut self, master: &AtMaster<L>, slave: &AtSlave<L>) -> L;

    /// From the slave, in `mode`, to the master: the mode that has arrived there, and the force (N) that its controller would
    /// feed back by itself.
    fn to_master(&mut self, mode: L, slave: &AtSlave<L>, master: &AtMaster<L>) -> (L, L);

    /// The force to feed back of the one that the force law asks for (N).
    fn limit(&mut self, force_n: L, master: &AtMaster<L>) -> L;

    /// The reference that the slave's controller works on (m), where the tissue pushes the slave off it with a force (N).
    fn apply_compliance(&self, reference_m: L, tissue_force_n: L) -> L;

    /// What the connection has seen so far in lane `index`; none where it passes everything on in the same tick.
    fn report(&self, index: usize) -> Option<LinkReport>;
}

/// Position and force passed on in the same tick, scaled: the paper's architecture without delay.
#[derive(Debug, Clone, Copy)]
pub struct DirectLink<L> {
    position_scale: L,
    force_scale: L,
}

impl<L: Lane> DirectLink<L> {
    /// A link of the slave's motion per master's and the force fed back per force measured.
    #[must_use]
    pub fn new(position_scale: f64, force_scale: f64) -> Self {
        Self { position_scale: L::splat(position_scale), force_scale: L::splat(force_scale) }
    }
}

impl<L: Lane> Connection<L> for DirectLink<L> {
    #[inline(always)]
    fn to_slave(&mut self, master: &AtMaster<L>, _slave: &AtSlave<L>) -> L {
        self.position_scale * master.position_m
    }

    #[inline(always)]
    fn to_master(&mut self, mode: L, slave: &AtSlave<L>, _master: &AtMaster<L>) -> (L, L) {
        (mode, self.force_scale * slave.force_n)
    }

    #[inline(always)]
    fn limit(&mut self, force_n: L, _master: &AtMaster<L>) -> L {
        force_n
    }

    #[inline(always)]
    fn apply_compliance(&self, reference_m: L, _tissue_force_n: L) -> L {
        reference_m
    }

    fn report(&self, _index: usize) -> Option<LinkReport> {
        None
    }
}

crate::lane::gather!(DirectLink { position_scale, force_scale });

impl<L: Lane> Connection<L> for Link<L> {
    #[inline(always)]
    fn to_slave(&mut self, master: &AtMaster<L>, slave: &AtSlave<L>) -> L {
        Link::to_slave(self, master, slave)
    }

    #[inline(always)]
    fn to_master(&mut self, mode: L, slave: &AtSlave<L>, master: &AtMaster<L>) -> (L, L) {
        Link::to_master(self, mode, slave, master)
    }

    #[inline(always)]
    fn limit(&mut self, force_n: L, master: &AtMaster<L>) -> L {
        Link::limit(self, force_n, master)
    }

    #[inline(always)]
    fn apply_compliance(&self, reference_m: L, tissue_force_n: L) -> L {
        Link::apply_compliance(self, reference_m, tissue_force_n)
    }

    fn report(&self, index: usize) -> Option<LinkReport> {
        (!self.is_direct()).then(|| Link::report(self, index))
    }
}
