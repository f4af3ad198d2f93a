use super::armed_step::HOLDS;
use super::master_model::GeneralMaster;
use super::{PlantError, on};
use trocar_core::friction::CoulombFriction;
use trocar_lti::{Continuous, StateSpace, exact_step};

/// `x_h, v_h, x_a, v_a`.
const STATES: usize = 4;

const LEVELS: usize = 20;

const MAX_PHASES: usize = 16;

#[derive(Debug, Clone, PartialEq)]
struct Part {
    transition: [[f64; STATES]; STATES],
    desired_now: [f64; STATES],
    desired_next: [f64; STATES],
    force: [f64; STATES],
}

/// A step over `2^-l` of a tick is exact while the mass slides or rests: a tick takes the largest parts at whose end
/// the phase still lasts.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct StickSlip {
    friction: CoulombFriction,
    constant_n: f64,
    hand_force: [f64; STATES],
    parts: Vec<[Part; 2]>,
}

impl StickSlip {
    pub(super) fn new(
        master: &GeneralMaster<'_>,
        sliding: &StateSpace<Continuous>,
        tick_s: f64,
    ) -> Result<Self, PlantError> {
        let (mut a, mut b) = (sliding.a().clone(), sliding.b().clone());
        for row in 0..2 {
            a.row_mut(row).fill(0.0);
            b.row_mut(row).fill(0.0);
        }
        let held = StateSpace::continuous(a, b, sliding.c().clone(), sliding.d().clone()).map_err(on("master"))?;
        let part = |system: &StateSpace<Continuous>, level: usize| -> Result<Part, PlantError> {
            let duration_s = tick_s / (1_u64 << level) as f64;
            let step = exact_step(system, duration_s, &HOLDS).map_err(on("master"))?;
            Ok(Part {
                transition: std::array::from_fn(|i| std::array::from_fn(|j| step.phi[(i, j)])),
                desired_now: std::array::from_fn(|i| step.gamma_now[(i, 0)] - step.gamma_now[(i, 1)] / duration_s),
                desired_next: std::array::from_fn(|i| step.gamma_next[(i, 0)] + step.gamma_now[(i, 1)] / duration_s),
                force: std::array::from_fn(|i| step.gamma_now[(i, 3)]),
            })
        };
        let parts = (0..=LEVELS).map(|level| Ok([part(&held, level)?, part(sliding, level)?]));
        Ok(Self {
            friction: CoulombFriction { limit_n: master.model.coulomb_friction_n },
            constant_n: master.model.constant_force_n,
            hand_force: std::array::from_fn(|j| sliding.c()[(0, j)]),
            parts: parts.collect::<Result<_, PlantError>>()?,
        })
    }

    pub(super) fn advance(&self, mut state: [f64; STATES], desired_m: [f64; 2], motor_n: f64) -> [f64; STATES] {
        const WHOLE: u64 = 1 << LEVELS;
        let external_n = motor_n + self.constant_n;
        let at = |past: u64| desired_m[0] + (desired_m[1] - desired_m[0]) * (past as f64 / WHOLE as f64);
        let mut past = 0;
        for phase in 0.. {
            let is_last = phase == MAX_PHASES;
            let velocity = state[1];
            let net_n = external_n + self.hand_force_n(&state);
            let direction = if velocity != 0.0 { velocity } else { self.friction.remainder_n(net_n) };
            let slides = direction != 0.0;
            let force_n = if slides { external_n - self.friction.limit_n.copysign(direction) } else { 0.0 };
            let goes_on = |after: &[f64; STATES]| {
                if slides {
                    after[1] * direction > 0.0
                } else {
                    (external_n + self.hand_force_n(after)).abs() <= self.friction.limit_n
                }
            };
            for (level, both) in self.parts.iter().enumerate() {
                let length = WHOLE >> level;
                if length > WHOLE - past {
                    continue;
                }
                let part = &both[usize::from(slides)];
                let after = part.advance(&state, [at(past), at(past + length)], force_n);
                if goes_on(&after) || is_last {
                    (state, past) = (after, past + length);
                } else if level == LEVELS {
                    (state, past) = (after, past + length);
                    if slides {
                        state[1] = 0.0;
                    }
                }
            }
            if past >= WHOLE || is_last {
                break;
            }
        }
        state
    }

    fn hand_force_n(&self, state: &[f64; STATES]) -> f64 {
        self.hand_force.iter().zip(state).map(|(gain, value)| gain * value).sum()
    }
}

impl Part {
    fn advance(&self, state: &[f64; STATES], desired_m: [f64; 2], force_n: f64) -> [f64; STATES] {
        std::array::from_fn(|i| {
            let of_state: f64 = self.transition[i].iter().zip(state).map(|(gain, value)| gain * value).sum();
            of_state
                + self.desired_now[i] * desired_m[0]
                + self.desired_next[i] * desired_m[1]
                + self.force[i] * force_n
        })
    }
}
