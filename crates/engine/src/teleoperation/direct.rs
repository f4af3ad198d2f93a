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

#[cfg(test)]
mod tests {
    use super::*;
    use trocar_core::augmentation::Mode;

    #[test]
    fn position_and_force_arrive_scaled_in_the_same_tick() {
        let mut link = DirectLink::<f64>::new(0.5, 3.0);
        let master = AtMaster { position_m: 0.02, velocity_m_per_s: 9.0, hand_force_n: 9.0 };
        let slave = AtSlave { position_m: 9.0, velocity_m_per_s: 9.0, force_n: 2.5 };
        assert_eq!((link.position_scale(), link.force_scale()), (0.5, 3.0));
        assert_eq!(link.to_slave(&master, &slave), 0.01);
        assert_eq!(link.limit_reference(0.7, &slave), 0.7);
        assert_eq!(
            link.to_master(Modes::splat(Mode::Augmented), &slave, &master),
            (Modes::splat(Mode::Augmented), 7.5)
        );
        assert_eq!((link.limit(0.7, &master), link.deflection_m(5.0)), (0.7, 0.0));
        assert!(link.report(0).is_none());
    }
}
