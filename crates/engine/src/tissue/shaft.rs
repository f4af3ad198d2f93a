use super::literature::{SHAFT_DAMPING_N_S_PER_M2, SHAFT_STIFFNESS_N_PER_M, STATIC_RATIO, STICK_SPEED_M_PER_S};
use super::named_layers::Measurable;
use trocar_core::lane::{Lane, Mask};

trocar_core::settings! {
    /// A friction that rises with the displacement up to a kinetic friction (Dahl), with a viscous part (Kim and Lee
    /// 2016) and a larger static friction (Karnopp; Simone 2002, Okamura et al. 2004). The defaults are chosen here.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct ShaftParameters in "tissue." {
        /// σ of layers: stiffness with which the shaft drags the tissue before it slides.
        stiffness_n_per_m: f64 at "tissue.shaft_stiffness_n_per_m" [SHAFT_STIFFNESS_N_PER_M.range()] = 400.0,
        /// Ratio of the static to the kinetic friction of the shaft in layers.
        static_ratio: f64 [STATIC_RATIO.range()] = 1.1,
        /// Speed below which the shaft sticks again.
        stick_speed_m_per_s: f64 [STICK_SPEED_M_PER_S.range()] = 1e-3,
        /// Viscous friction of the shaft per length in layers.
        damping_n_s_per_m2: f64 at "tissue.shaft_damping_n_s_per_m2" [SHAFT_DAMPING_N_S_PER_M2.range()] = 10.0,
    }
}

impl ShaftParameters {
    pub(super) fn measured(&self) -> [Measurable<'static>; 4] {
        [
            ("tissue.shaft_stiffness_n_per_m", None, self.stiffness_n_per_m, &SHAFT_STIFFNESS_N_PER_M),
            ("tissue.static_ratio", None, self.static_ratio, &STATIC_RATIO),
            ("tissue.stick_speed_m_per_s", None, self.stick_speed_m_per_s, &STICK_SPEED_M_PER_S),
            ("tissue.shaft_damping_n_s_per_m2", None, self.damping_n_s_per_m2, &SHAFT_DAMPING_N_S_PER_M2),
        ]
    }
}

/// From one position to the next:
///
/// ```text
/// F = clamp(F + σ Δx, -F_max, F_max),  F_max = F_kinetic · (static_ratio where the shaft sticks, else 1)
/// ```
/// The stored energy `F²/2σ` grows at most by the motion's work. The shaft sticks again when the bound does not act, or
/// below the stick speed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shaft<L: Lane> {
    stiffness: L,
    compliance: L,
    static_ratio: L,
    stick_speed: L,
    damping: L,
    position: L,
    force: L,
    is_stuck: L::Mask,
}

impl<L: Lane> Shaft<L> {
    pub(super) fn new(parameters: &ShaftParameters, start_m: f64) -> Self {
        Self {
            stiffness: L::splat(parameters.stiffness_n_per_m),
            compliance: L::splat(1.0 / parameters.stiffness_n_per_m),
            static_ratio: L::splat(parameters.static_ratio),
            stick_speed: L::splat(parameters.stick_speed_m_per_s),
            damping: L::splat(parameters.damping_n_s_per_m2),
            position: L::splat(start_m),
            force: L::zero(),
            is_stuck: L::Mask::splat(true),
        }
    }

    /// Positive into the tissue.
    #[inline(always)]
    pub(super) fn drag_m(&self) -> L {
        self.force * self.compliance
    }

    #[inline(always)]
    pub(super) fn friction_n(&mut self, position: L, velocity: L, kinetic_n: L, length_m: L) -> L {
        let trial = self.force + self.stiffness * (position - self.position);
        let bound = kinetic_n * L::select(self.is_stuck, self.static_ratio, L::splat(1.0));
        let slides = trial.abs().gt(bound);
        self.force = trial.clamp(-bound, bound);
        self.is_stuck = !slides | velocity.abs().lt(self.stick_speed);
        self.position = position;
        self.force + self.damping * length_m * velocity
    }
}

trocar_core::lane::gather!(Shaft { stiffness, compliance, static_ratio, stick_speed, damping, position, force } masks { is_stuck });

#[cfg(test)]
mod tests {
    use super::*;

    const PARAMETERS: ShaftParameters = ShaftParameters {
        stiffness_n_per_m: 400.0,
        static_ratio: 1.5,
        stick_speed_m_per_s: 1e-3,
        damping_n_s_per_m2: 0.0,
    };

    #[test]
    fn the_shaft_drags_the_tissue_until_it_slips_at_the_static_friction_and_slides_at_the_kinetic_friction() {
        let mut shaft = Shaft::<f64>::new(&PARAMETERS, 0.01);
        let mut at = |position| shaft.friction_n(position, 0.01, 2.0, 0.0);
        assert!((at(0.015) - 2.0).abs() < 1e-12, "400 N/m over 5 mm");
        assert!((at(0.0174) - 2.96).abs() < 1e-12, "above the kinetic friction it still sticks");
        assert_eq!(at(0.02), 3.0, "1.5 times 2 N");
        assert_eq!(at(0.0201), 2.0, "it slides");
        assert_eq!(at(0.0301), 2.0);
    }

    #[test]
    fn after_a_reversal_the_shaft_sticks_and_then_slides_the_other_way() {
        let mut shaft = Shaft::<f64>::new(&PARAMETERS, 0.0);
        for step in 1..=20 {
            shaft.friction_n(1e-3 * f64::from(step), 0.01, 2.0, 0.0);
        }
        assert!((shaft.drag_m() - 2.0 / 400.0).abs() < 1e-15, "the tissue is dragged by F/σ");
        let back = shaft.friction_n(0.0175, -0.01, 2.0, 0.0);
        assert!((back - 1.0).abs() < 1e-12, "{back}");
        assert_eq!(shaft.friction_n(0.005, -0.01, 2.0, 0.0), -3.0, "it sticks, so that the static friction counts");
        assert_eq!(shaft.friction_n(0.004, -0.01, 2.0, 0.0), -2.0);
    }

    #[test]
    fn a_slow_shaft_sticks() {
        let slide = |speed: f64| {
            let mut shaft = Shaft::<f64>::new(&PARAMETERS, 0.0);
            shaft.friction_n(0.1, 0.01, 2.0, 0.0);
            shaft.friction_n(0.2, speed, 2.0, 0.0);
            shaft.friction_n(0.3, 0.01, 2.0, 0.0)
        };
        assert_eq!([slide(1e-3), slide(0.99e-3), slide(-0.99e-3), slide(-1e-3)], [2.0, 3.0, 3.0, 2.0]);
    }

    #[test]
    fn viscous_friction_is_added_per_length() {
        let mut shaft = Shaft::<f64>::new(&ShaftParameters { damping_n_s_per_m2: 10.0, ..PARAMETERS }, 0.0);
        let friction = shaft.friction_n(1e-3, 0.02, 2.0, 0.05);
        assert!((friction - (0.4 + 10.0 * 0.05 * 0.02)).abs() < 1e-12, "{friction}");
        assert!((shaft.drag_m() - 1e-3).abs() < 1e-15, "it drags nothing");
    }

    #[test]
    fn each_parameter_has_its_measured_range() {
        let measured = PARAMETERS.measured();
        assert_eq!(measured.map(|(_, _, value, _)| value), [400.0, 1.5, 1e-3, 0.0]);
        let keys = ["shaft_stiffness_n_per_m", "static_ratio", "stick_speed_m_per_s", "shaft_damping_n_s_per_m2"];
        for ((key, _, value, bounds), expected) in measured.into_iter().zip(keys) {
            assert_eq!(key, format!("tissue.{expected}"));
            assert!(bounds.contains(value), "{key}");
        }
    }
}
