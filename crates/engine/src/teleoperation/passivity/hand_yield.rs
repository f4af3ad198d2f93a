use super::SchemeContext;
use trocar_core::lane::Lane;

/// The paper's arm (eq. 32), and the damping of master and arm.
const HAND_STIFFNESS_N_PER_M: f64 = 700.0;
const HAND_DAMPING_N_S_PER_M: f64 = 41.0;

/// Predicts how far the hand will yield to a force that has not reached it, like a Smith predictor (1959); the slave
/// stays behind the hand by `y`:
///
/// ```text
/// b y' + k y = f - F_ed    F_ed: the feedback force at the last known position of the hand
/// ```
/// The energy account limits the reference afterwards, so a wrong hand model costs tracking, not passivity.
#[derive(Debug, Clone)]
pub(super) struct HandYield<L> {
    compliance: L,
    share: L,
    way: L,
}

impl<L: Lane> HandYield<L> {
    pub(super) fn new(context: &SchemeContext<L>) -> Self {
        let lag_s = HAND_DAMPING_N_S_PER_M / HAND_STIFFNESS_N_PER_M;
        // Without a delay the hand feels every force.
        let compliance = if context.is_immediate { 0.0 } else { 1.0 / HAND_STIFFNESS_N_PER_M };
        Self {
            compliance: L::splat(compliance),
            share: L::splat(context.tick_s / (context.tick_s + lag_s)),
            way: L::zero(),
        }
    }

    #[inline(always)]
    pub(super) fn update(&mut self, force_n: L, felt_n: L) -> L {
        let zero = L::zero();
        let rest = (force_n - felt_n) * self.compliance;
        self.way = self.way + self.share * (rest - self.way);
        L::select(force_n.gt(zero), self.way.max(zero), self.way.min(zero))
    }
}

trocar_core::lane::gather!(HandYield { compliance, share, way });

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slave_yields_until_the_hand_has_felt_the_force_and_never_beyond_the_hand() {
        let mut hand = HandYield::new(&SchemeContext::<f64>::for_tests());
        let mut settle = |force_n, felt_n| (0..2000).map(|_| hand.update(force_n, felt_n)).last().expect("ticks");
        assert!((settle(7.0, 0.0) - 0.01).abs() < 1e-9);
        assert!((settle(-7.0, 0.0) + 0.01).abs() < 1e-9);
        assert!(settle(7.0, 7.0).abs() < 1e-9);
        assert_eq!(settle(1.0, 7.0), 0.0);
    }

    #[test]
    fn without_delay_the_signals_do_not_change() {
        let context = SchemeContext::<f64> { is_immediate: true, ..SchemeContext::for_tests() };
        assert_eq!(HandYield::new(&context).update(5.0, 0.0), 0.0);
    }
}
