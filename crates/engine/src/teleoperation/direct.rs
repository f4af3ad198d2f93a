use super::connection::{AtMaster, AtSlave, Connection, LinkReport};
use trocar_core::augmentation::Modes;
use trocar_core::lane::Lane;

/// A [`Link`](super::Link) that [`is_direct`](super::Link::is_direct), without state.
#[derive(Debug, Clone, Copy)]
pub struct DirectLink<L> {
    pub(super) position_scale: L,
    pub(super) force_scale: L,
}

impl<L: Lane> DirectLink<L> {
    pub fn new(position_scale: f64, force_scale: f64) -> Self {
        Self { position_scale: L::splat(position_scale), force_scale: L::splat(force_scale) }
    }
}

impl<L: Lane> Connection<L> for DirectLink<L> {
    #[inline(always)]
    fn position_scale(&self) -> L {
        self.position_scale
    }

    #[inline(always)]
    fn force_scale(&self) -> L {
        self.force_scale
    }

    #[inline(always)]
    fn to_slave(&mut self, master: &AtMaster<L>, _slave: &AtSlave<L>) -> L {
        self.position_scale * master.position_m
    }

    #[inline(always)]
    fn limit_reference(&mut self, reference_m: L, _slave: &AtSlave<L>) -> L {
        reference_m
    }

    #[inline(always)]
    fn to_master(&mut self, mode: Modes<L>, slave: &AtSlave<L>, _master: &AtMaster<L>) -> (Modes<L>, L) {
        (mode, self.force_scale * slave.force_n)
    }

    #[inline(always)]
    fn limit(&mut self, force_n: L, _master: &AtMaster<L>) -> L {
        force_n
    }

    #[inline(always)]
    fn deflection_m(&self, _tissue_force_n: L) -> L {
        L::zero()
    }

    fn report(&self, _index: usize) -> Option<LinkReport> {
        None
    }
}

trocar_core::lane::gather!(DirectLink { position_scale, force_scale });
