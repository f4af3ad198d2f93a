//! Absolute stability with bounded impedances.
//!
//! - A hand between the dampers `r` and `R` (N·s/m), `Z_h = r + (Z ‖ (R - r))` with any passive `Z`, lies in the disc
//!   with the diameter `[r, R]` on the real axis at each frequency.
//! - A tissue with a spring and a damper in ranges, `Z_e = B + K / (jω)`, lies in a rectangle.
//!
//! With `N = -h11 + D Z_e`, `M = 1 + h22 Z_e` and `D = h12 h21 - h11 h22` the loop has a pole at `jω` if
//! `Z_h = -Z_t(Z_e) = N / M`. It lies in the disc of the hand if
//!
//! ```text
//! q(Z_e) = |N|² / R - (1 + r/R) Re(N M*) + r |M|² = a |Z_e|² + 2 Re(b Z_e) + c <= 0
//! ```
//! On a rectangle `q` is a sum of two parabolas, so its minimum has a closed form. If it is positive at every
//! frequency, all loops are stable if one is (zero exclusion; Haddadi and Hashtrudi-Zaad, *IEEE Trans. Haptics* 3,
//! 2010).

use super::analysis::frequencies_hz;
use super::{Axis, ClosedLoop, Hybrid, LinearLoop, Parameter, Ports, StabilityError};
use trocar_base::parallel::try_map;
use trocar_base::quantiles::bisect;
use trocar_engine::plant::ArmParameters;
use trocar_lti::Complex64;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Terminations {
    /// The maximum may be infinite.
    pub hand_n_s_per_m: (f64, f64),
    pub stiffness_n_per_m: (f64, f64),
    pub damping_n_s_per_m: (f64, f64),
}

const MAX_DAMPING: f64 = 1e6;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NeededDamping {
    pub frequency_hz: f64,
    /// Infinite if neither the hand's maximum nor 1e6 N·s/m suffices.
    pub damping_n_s_per_m: f64,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Bounded {
    pub terminations: Terminations,
    pub needed: Vec<NeededDamping>,
    /// True if one loop in the middle of the ranges is stable.
    pub is_middle_stable: bool,
}

#[derive(Debug, Clone, Copy)]
struct Quadratic {
    a: f64,
    b: Complex64,
    c: f64,
}

impl Quadratic {
    fn of(hybrid: &Hybrid, r: f64, g: f64) -> Self {
        let [[h11, h12], [h21, h22]] = hybrid.h;
        let d = h12 * h21 - h11 * h22;
        let both = 1.0 + r * g;
        Self {
            a: g * d.norm_sqr() - both * (d * h22.conj()).re + r * h22.norm_sqr(),
            b: (h11.conj() * d * (-2.0 * g) - (d - h11.conj() * h22) * both + h22 * (2.0 * r)) * 0.5,
            c: g * h11.norm_sqr() + both * h11.re + r,
        }
    }

    fn min(&self, real: (f64, f64), imaginary: (f64, f64)) -> f64 {
        // a t² + 2 s t between two ends.
        let parabola = |s: f64, (low, high): (f64, f64)| {
            let at = |t: f64| (self.a * t + 2.0 * s) * t;
            let lowest = if self.a > 0.0 { (-s / self.a).clamp(low, high) } else { low };
            at(lowest).min(at(low)).min(at(high))
        };
        parabola(self.b.re, real) + parabola(-self.b.im, imaginary) + self.c
    }
}

/// A position that drifts has a pole at 1, which does not count as growing.
const GROWS: f64 = 1.0 + 1e-8;

impl Terminations {
    fn excludes(&self, hybrid: &Hybrid, omega: f64, r: f64) -> bool {
        let (soft, stiff) = self.stiffness_n_per_m;
        let quadratic = Quadratic::of(hybrid, r, self.hand_n_s_per_m.1.recip());
        quadratic.min(self.damping_n_s_per_m, (-stiff / omega, -soft / omega)) > 0.0
    }

    fn needed(&self, hybrid: &Hybrid, omega: f64) -> f64 {
        let most = self.hand_n_s_per_m.1.min(MAX_DAMPING);
        if !self.excludes(hybrid, omega, most) {
            return f64::INFINITY;
        }
        if self.excludes(hybrid, omega, 0.0) {
            return 0.0;
        }
        // The discs shrink as r grows.
        bisect(0.0, most, |r| !self.excludes(hybrid, omega, r))
    }

    fn middle(&self, settings: &LinearLoop, low: f64) -> LinearLoop {
        let high = self.hand_n_s_per_m.1;
        let damper = if high.is_finite() { 0.5 * (low + high) } else { 2.0 * low + 1.0 };
        let mut other = settings.clone();
        // A stiff spring and damper hold the mass behind the damper.
        other.arm.k_a_n_per_m = 0.0;
        other.arm.b_a_n_s_per_m = damper;
        other.arm.m_h_kg = 1.0;
        other.arm.k_h_n_per_m = 1e6;
        other.arm.b_h_n_s_per_m = 1e4;
        other.stiffness_n_per_m = 0.5 * (self.stiffness_n_per_m.0 + self.stiffness_n_per_m.1);
        other.damping_n_s_per_m = 0.5 * (self.damping_n_s_per_m.0 + self.damping_n_s_per_m.1);
        other
    }
}

impl Bounded {
    /// Ignores the arm and the tissue in `settings`.
    pub fn of(settings: &LinearLoop, terminations: &Terminations) -> Result<Self, StabilityError> {
        let ports = Ports::new(settings)?;
        let mut needed = vec![];
        for frequency_hz in frequencies_hz(settings.tick_s) {
            let omega = std::f64::consts::TAU * frequency_hz;
            if let Some(hybrid) = ports.at(omega)? {
                needed.push(NeededDamping { frequency_hz, damping_n_s_per_m: terminations.needed(&hybrid, omega) });
            }
        }
        let mut bounded = Self { terminations: *terminations, needed, is_middle_stable: false };
        let low = terminations.hand_n_s_per_m.0.max(bounded.most().map_or(0.0, |most| most.damping_n_s_per_m));
        if low.is_finite() {
            bounded.is_middle_stable = ClosedLoop::new(&terminations.middle(settings, low))?.poles_outside(GROWS)? == 0;
        }
        Ok(bounded)
    }

    pub fn most(&self) -> Option<NeededDamping> {
        self.needed.iter().copied().reduce(
            |most, one| {
                if one.damping_n_s_per_m > most.damping_n_s_per_m { one } else { most }
            },
        )
    }

    /// Infinite if none suffices.
    pub fn needed_damping(&self) -> Option<f64> {
        let most = self.most()?;
        Some(if self.is_middle_stable { most.damping_n_s_per_m } else { f64::INFINITY })
    }

    pub fn is_stable(&self) -> Option<bool> {
        Some(self.needed_damping()? <= self.terminations.hand_n_s_per_m.0)
    }
}

/// At the master in N·s/m, with a constant desired position.
pub fn arm_impedance(arm: &ArmParameters, frequency_hz: f64) -> Complex64 {
    let s = Complex64::new(0.0, std::f64::consts::TAU * frequency_hz);
    let at_master = s.inv() * arm.k_a_n_per_m + arm.b_a_n_s_per_m;
    let behind = s * arm.m_h_kg + s.inv() * arm.k_h_n_per_m + arm.b_h_n_s_per_m;
    at_master * behind / (at_master + behind)
}

#[derive(Debug, Clone, PartialEq)]
pub struct AbsolutePoint {
    pub value: f64,
    /// Infinite without a hybrid matrix.
    pub min_llewellyn: f64,
    pub is_absolutely_stable: bool,
    pub bounded: Bounded,
}

#[derive(Debug, Clone, PartialEq)]
pub struct AbsoluteOver {
    pub parameter: Parameter,
    pub points: Vec<AbsolutePoint>,
}

impl AbsoluteOver {
    pub fn of(settings: &LinearLoop, axis: &Axis, terminations: &Terminations) -> Result<Self, StabilityError> {
        let at = |index: usize| -> Result<AbsolutePoint, StabilityError> {
            let value = axis.value(index);
            let settings = settings.with(axis.parameter, value);
            let ports = Ports::new(&settings)?;
            let (mut min_llewellyn, mut is_absolutely_stable) = (f64::INFINITY, true);
            for frequency_hz in frequencies_hz(settings.tick_s) {
                let hybrid = ports.at(std::f64::consts::TAU * frequency_hz)?;
                min_llewellyn = hybrid.map_or(min_llewellyn, |hybrid| min_llewellyn.min(hybrid.llewellyn()));
                is_absolutely_stable &= hybrid.is_some_and(|hybrid| hybrid.is_absolutely_stable());
            }
            Ok(AbsolutePoint {
                value,
                min_llewellyn,
                is_absolutely_stable,
                bounded: Bounded::of(&settings, terminations)?,
            })
        };
        let points = try_map(axis.count, at)?;
        Ok(Self { parameter: axis.parameter, points })
    }
}

#[cfg(test)]
mod tests {
    use super::super::TissueRange;
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use trocar_scenario::{Scenario, Source};

    const OMEGA: f64 = 20.0;

    fn random_hybrid(rng: &mut ChaCha8Rng) -> Hybrid {
        let mut number = |size: f64| Complex64::new(rng.random_range(-size..size), rng.random_range(-size..size));
        let (h11, h12, h21, h22) = (number(30.0), number(1.5), number(1.5), number(0.05));
        Hybrid { h: [[h11 + 10.0, h12], [h21, h22 + 0.02]] }
    }

    /// Compares the boundaries of the hand's disc and the tissue's rectangle, and a point inside. Two connected sets
    /// first touch at their boundaries.
    fn meets_by_brute_force(hybrid: &Hybrid, ranges: &Terminations) -> bool {
        const FINE: usize = 120;
        let (r, most) = ranges.hand_n_s_per_m;
        let (soft, stiff) = ranges.stiffness_n_per_m;
        let (low, high) = ranges.damping_n_s_per_m;
        let share = |k: usize| k as f64 / FINE as f64;
        let (middle, radius) = (0.5 * (r + most), 0.5 * (most - r));
        (0..=FINE).flat_map(|i| (0..=FINE).map(move |j| (i, j))).any(|(i, j)| {
            let tissue = Complex64::new(low + share(i) * (high - low), -(soft + share(j) * (stiff - soft)) / OMEGA);
            (hybrid.transmitted(tissue) + middle).norm() <= radius
        })
    }

    #[test]
    fn oracle_the_closed_form_agrees_with_a_fine_grid() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut counts = [0, 0];
        for _ in 0..400 {
            let hybrid = random_hybrid(&mut rng);
            let (r, soft, low) =
                (rng.random_range(0.0..20.0), rng.random_range(0.0..300.0), rng.random_range(0.0..5.0));
            let ranges = Terminations {
                hand_n_s_per_m: (r, r + rng.random_range(1.0..60.0)),
                stiffness_n_per_m: (soft, soft + rng.random_range(1.0..500.0)),
                damping_n_s_per_m: (low, low + rng.random_range(0.1..20.0)),
            };
            let excludes = ranges.excludes(&hybrid, OMEGA, r);
            // The grid only misses impedances between its points.
            let slightly_larger = Terminations { hand_n_s_per_m: (r, ranges.hand_n_s_per_m.1), ..ranges };
            let meets = meets_by_brute_force(&hybrid, &slightly_larger);
            assert!(!(excludes && meets), "{hybrid:?} {ranges:?}");
            if !excludes && !meets {
                let wider = Terminations { hand_n_s_per_m: (r - 0.6, ranges.hand_n_s_per_m.1 + 0.6), ..ranges };
                assert!(meets_by_brute_force(&hybrid, &wider), "{hybrid:?} {ranges:?}");
            }
            counts[usize::from(excludes)] += 1;
        }
        assert!(counts.iter().all(|count| *count > 50), "{counts:?}");
    }

    #[test]
    fn oracle_without_bounds_the_condition_is_llewellyns() {
        // Approximates any passive tissue at one frequency by a large rectangle.
        let any = Terminations {
            hand_n_s_per_m: (0.0, f64::INFINITY),
            stiffness_n_per_m: (-1e9, 1e9),
            damping_n_s_per_m: (0.0, 1e9),
        };
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let mut counts = [0, 0];
        for _ in 0..2000 {
            let mut hybrid = random_hybrid(&mut rng);
            hybrid.h[0][1] *= 0.3;
            let margin = hybrid.llewellyn();
            let is_strict = hybrid.h[0][0].re > 1e-3 && hybrid.h[1][1].re > 1e-3 && (margin - 1.0).abs() > 1e-3;
            if is_strict {
                assert_eq!(any.excludes(&hybrid, OMEGA, 0.0), margin > 1.0, "{hybrid:?}");
                counts[usize::from(margin > 1.0)] += 1;
            }
        }
        assert!(counts.iter().all(|count| *count > 100), "{counts:?}");
    }

    /// Bounds for every passive hand without a tissue, in a shipped scenario with settings.
    fn in_free_motion(settings: &[&str]) -> Bounded {
        let settings: Vec<String> = settings.iter().map(|setting| (*setting).to_owned()).collect();
        let scenario = Scenario::load(&Source::parse("paper/classical"), &settings).expect("good");
        let tissue = TissueRange::of_parameters(&scenario).expect("a recorded force");
        let of_loop = LinearLoop::of(&scenario, tissue).expect("analysed");
        let free = Terminations {
            hand_n_s_per_m: (0.0, f64::INFINITY),
            stiffness_n_per_m: (0.0, 0.0),
            damping_n_s_per_m: (0.0, 0.0),
        };
        Bounded::of(&of_loop, &free).expect("analysed")
    }

    #[test]
    fn a_drifting_position_without_a_tissue_is_stable_with_every_hand() {
        for settings in [&[][..], &["controller.kind=position-position"]] {
            let bounded = in_free_motion(settings);
            assert_eq!((bounded.needed_damping(), bounded.is_stable()), (Some(0.0), Some(true)), "{settings:?}");
        }
    }

    #[test]
    fn an_unstable_loop_without_a_tissue_is_stable_with_no_hand() {
        let bounded = in_free_motion(&["controller.kind=four-channel", "channel.delay_s=0.1"]);
        assert_eq!((bounded.needed_damping(), bounded.is_stable()), (Some(f64::INFINITY), Some(false)));
    }
}
