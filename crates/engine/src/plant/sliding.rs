use trocar_core::friction::CoulombFriction;

/// Omitted terms are below 1e-18 at `|z| <= 0.5`.
const TERMS: u32 = 14;

/// ```text
/// m v' = f - b v - F_c sign(v),   x' = v
/// ```
/// Without a driving force it stops after `t = m/b ln(1 + b |v| / (F_c - f sign(v)))`; then it rests while
/// `|f| <= F_c`, or moves back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlidingMass {
    pub mass_kg: f64,
    pub damping_n_s_per_m: f64,
    pub friction: CoulombFriction,
}

impl SlidingMass {
    pub fn advance(&self, mut motion: [f64; 2], force_n: f64, duration_s: f64) -> [f64; 2] {
        let mut left_s = duration_s;
        // A stopped mass rests or moves on: at most two parts.
        for _ in 0..2 {
            let [position_m, velocity_m_per_s] = motion;
            let driving_n = if velocity_m_per_s == 0.0 {
                self.friction.remainder_n(force_n)
            } else {
                force_n - self.friction.limit_n.copysign(velocity_m_per_s)
            };
            if velocity_m_per_s == 0.0 && driving_n == 0.0 {
                return motion;
            }
            let stop_s = self.stop_s(velocity_m_per_s, driving_n).filter(|stop_s| *stop_s < left_s);
            let [way_m, after] = self.slide(velocity_m_per_s, driving_n, stop_s.unwrap_or(left_s));
            motion = [position_m + way_m, if stop_s.is_some() { 0.0 } else { after }];
            match stop_s {
                Some(stop_s) => left_s -= stop_s,
                None => break,
            }
        }
        motion
    }

    /// `driving_n` includes friction.
    fn stop_s(&self, velocity_m_per_s: f64, driving_n: f64) -> Option<f64> {
        if velocity_m_per_s * driving_n >= 0.0 {
            return None;
        }
        let ratio = -velocity_m_per_s / driving_n;
        let damped = self.damping_n_s_per_m * ratio;
        let share = if damped < f64::MIN_POSITIVE { 1.0 } else { libm::log1p(damped) / damped };
        Some(self.mass_kg * ratio * share)
    }

    fn slide(&self, velocity_m_per_s: f64, driving_n: f64, duration_s: f64) -> [f64; 2] {
        let z = -self.damping_n_s_per_m / self.mass_kg * duration_s;
        let acceleration = (driving_n - self.damping_n_s_per_m * velocity_m_per_s) / self.mass_kg;
        let second = phi2(z);
        let first = 1.0 + z * second;
        [
            duration_s * (velocity_m_per_s + duration_s * acceleration * second),
            velocity_m_per_s + duration_s * acceleration * first,
        ]
    }
}

/// `(exp(z) - 1 - z) / z²`
fn phi2(z: f64) -> f64 {
    if z.abs() > 0.5 {
        return (libm::expm1(z) - z) / (z * z);
    }
    let mut sum = 0.0;
    for k in (0..TERMS).rev() {
        sum = (1.0 + z * sum) / f64::from(k + 2);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mass(damping_n_s_per_m: f64, limit_n: f64) -> SlidingMass {
        SlidingMass { mass_kg: 0.4, damping_n_s_per_m, friction: CoulombFriction { limit_n } }
    }

    #[test]
    fn a_sliding_mass_stops_after_the_time_and_way_of_the_closed_form() {
        for (b, v0, limit_n) in [(1.5, 0.2, 0.3), (0.0, 0.2, 0.3), (1e-9, -0.1, 0.05), (400.0, 0.5, 2.0)] {
            let mass = mass(b, limit_n);
            let (m, speed) = (0.4, f64::abs(v0));
            let (stop_s, way_m) = if b < 1e-6 {
                (m * speed / limit_n, m * speed * speed / (2.0 * limit_n))
            } else {
                let stop_s = m / b * (1.0 + b * speed / limit_n).ln();
                (stop_s, m / b * speed - limit_n / b * stop_s)
            };
            let [before, still] = mass.advance([0.0, v0], 0.0, stop_s * (1.0 - 1e-6));
            assert!(still * v0 > 0.0, "{b}: stopped too early");
            let after = mass.advance([0.0, v0], 0.0, stop_s * (1.0 + 1e-6));
            assert_eq!(after[1], 0.0, "{b}: not at rest");
            assert!((after[0] - way_m * v0.signum()).abs() < 1e-8 * way_m, "{b}: {after:?} against {way_m}");
            assert!((before - after[0]).abs() < 1e-5 * way_m, "{b}");
            // At rest for good, in many short parts as in one.
            let mut motion = [0.0, v0];
            for _ in 0..1000 {
                motion = mass.advance(motion, 0.0, stop_s * 2e-3);
            }
            assert!((motion[0] - after[0]).abs() < 1e-10 * (1.0 + way_m) && motion[1] == 0.0, "{b}: {motion:?}");
        }
    }

    #[test]
    fn friction_holds_a_mass_up_to_its_limit_and_the_rest_accelerates_it() {
        let mass = mass(0.0, 0.3);
        assert_eq!(mass.advance([0.1, 0.0], 0.3, 1.0), [0.1, 0.0]);
        assert_eq!(mass.advance([0.1, 0.0], -0.3, 1.0), [0.1, 0.0]);
        let [position_m, velocity] = mass.advance([0.0, 0.0], -0.5, 0.5);
        assert!((velocity + 0.2 / 0.4 * 0.5).abs() < 1e-12 && (position_m + 0.2 / 0.8 * 0.25).abs() < 1e-12);
    }

    #[test]
    fn a_force_turns_a_mass_round_within_a_step() {
        // Stops after m v / (f + F_c) = 0.1 s, then the force less friction drives it back for 0.9 s.
        let mass = mass(0.0, 0.5);
        let [position_m, velocity] = mass.advance([0.0, 0.5], -1.5, 1.0);
        assert!((velocity + 1.0 / 0.4 * 0.9).abs() < 1e-12, "{velocity}");
        assert!((position_m - (0.025 - 0.5 / 0.4 * 0.81)).abs() < 1e-12, "{position_m}");
    }

    #[test]
    fn the_function_of_the_way_is_smooth_where_its_forms_meet() {
        for z in [-0.5_f64, 0.5, -0.499, 1e-3, 0.0] {
            let exact = if z == 0.0 { 0.5 } else { (z.exp_m1() - z) / (z * z) };
            assert!((phi2(z) - exact).abs() < 1e-9, "{z}");
        }
        assert!((phi2(-0.5 - 1e-15) - phi2(-0.5)).abs() < 1e-14);
    }
}
