//! Delays that vary from tick to tick within a range, in any order.
//!
//! The receiver holds the arrived sample that was sent last, `y_(k-d_k)`, where `a <= d_k <= b` and `k - d_k` never
//! decreases. Around a constant delay of `m` ticks,
//!
//! ```text
//! y_(k-d_k) = y_(k-m) + e_k,      e = Δ u,      u_k = y_k - y_(k-1),      ‖Δ‖ <= g = max(m - a, b - m)
//! ```
//! `e_k` is a sum of at most `g` of the `u`, and each `u_i` is in at most `g` of these sums, so
//! `Σ |e_k|² <= g² Σ |u_i|²` (in continuous time: Shustin and Fridman, *Automatica* 43, 2007). Stability follows from
//! small gain (for one delay: Kao and Lincoln, *Automatica* 40, 2004). With `P = H_master H_slave` and
//! `L = z^-(m1 + m2) P`, the `Δ` of both directions act on
//!
//! ```text
//! M = (1 - z^-1) / (1 - L) [ z^-m2 P   H_master ]        from (e1, e2) to (u1, u2)
//!                          [ H_slave   z^-m1 P  ]
//! ```
//! The loop is stable for every order of the delays if it is stable with `m1` and `m2`, and if for one `δ > 0` both
//! singular values of `diag(g1, g2) diag(1, √δ)⁻¹ M diag(1, √δ)` are below 1 at every frequency. With `u = |1 - z^-1|`:
//!
//! ```text
//! u² (δ g1² |H_master|² + g2² |H_slave|² / δ + (g1² + g2² - g1² g2² u²) |P|²) < |1 - L|²,      g1 g2 u² |P| < |1 - L|
//! ```
//! (trace and determinant of its square). Bounds of the responses verify both on arcs of the unit circle and intervals
//! of the stiffness.

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector};

use super::machines::Machines;
use super::response::Response;
use super::response_path::Path;
use super::side::Side;
use super::{ClosedLoop, LinearLoop, StabilityError};
use trocar_core::time::nearest_ticks;
use trocar_lti::Complex64;
use trocar_scenario::Scenario;

const SLACK: f64 = 1e-6;

const MAX_BOXES: usize = 100_000;

const PIECES: u32 = 4;

const MAX_JITTER_TICKS: u64 = 10_000;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DelayRange {
    pub min_ticks: u64,
    pub max_ticks: u64,
}

impl DelayRange {
    fn nominal(self) -> (u64, f64) {
        let middle = self.min_ticks + (self.max_ticks - self.min_ticks) / 2;
        (middle, (self.max_ticks - middle) as f64)
    }

    fn width(self) -> u64 {
        self.max_ticks - self.min_ticks
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct VaryingDelays {
    pub forward: DelayRange,
    pub backward: DelayRange,
    /// At every stiffness up to the largest, with the smallest and largest damping.
    pub is_proved: bool,
    /// A receiver can lack samples for so long that it detects an outage.
    pub can_be_outage: bool,
}

impl VaryingDelays {
    /// `None` if the delays are constant or unbounded.
    pub fn of(scenario: &Scenario, settings: &LinearLoop) -> Result<Option<Self>, StabilityError> {
        let Some([forward, backward]) = ranges(scenario, settings) else { return Ok(None) };
        let stiffest = LinearLoop { stiffness_n_per_m: settings.tissue.stiffest_n_per_m(), ..settings.clone() };
        let (least, most) = settings.tissue.springs.damping_n_s_per_m;
        let is_proved = |damping_n_s_per_m: f64| {
            let stiffest = LinearLoop { damping_n_s_per_m, ..stiffest.clone() };
            Proof::new(&stiffest)?.covers_stiffness(forward, backward)
        };
        let outage_ticks = nearest_ticks(scenario.link.recovery.outage_s, settings.tick_s).max(1);
        Ok(Some(Self {
            forward,
            backward,
            is_proved: is_proved(least)? && (least == most || is_proved(most)?),
            can_be_outage: forward.width().max(backward.width()) >= outage_ticks,
        }))
    }
}

fn ranges(scenario: &Scenario, settings: &LinearLoop) -> Option<[DelayRange; 2]> {
    let irregularity = &scenario.irregularity;
    let jitter = irregularity.jitter_ticks(settings.tick_s);
    let range = |schedule: &trocar_engine::channel::Schedule, link_ticks: u64| {
        let (min_ticks, max_ticks) = if schedule.has_delays() { schedule.ages()? } else { (link_ticks, link_ticks) };
        let is_bounded = irregularity.loss == 0.0 && !schedule.has_outages();
        is_bounded.then_some(DelayRange { min_ticks, max_ticks: max_ticks + jitter })
    };
    let forward = range(&scenario.forward_schedule, settings.forward().whole)?;
    let backward = range(&scenario.backward_schedule, settings.backward().whole)?;
    (forward.width() + backward.width() > 0).then_some([forward, backward])
}

/// The largest proved; `None` if unstable or unlimited.
pub(super) fn jitter_margin_ticks(settings: &LinearLoop) -> Result<Option<u64>, StabilityError> {
    let proof = Proof::new(settings)?;
    if !proof.closed.is_stable()? {
        return Ok(None);
    }
    let from = |least: u64, jitter: u64| DelayRange { min_ticks: least, max_ticks: least + jitter };
    let (forward, backward) = (settings.forward().whole, settings.backward().whole);
    let holds = |jitter| proof.covers(from(forward, jitter), from(backward, jitter), (1.0, 1.0));
    let (mut proved, mut open) = (0, 1);
    while holds(open)? {
        (proved, open) = (open, 2 * open);
        if open > MAX_JITTER_TICKS {
            return Ok(None);
        }
    }
    while open - proved > 1 {
        let middle = proved + (open - proved) / 2;
        if holds(middle)? { proved = middle } else { open = middle }
    }
    Ok(Some(proved))
}

/// Linear in a share `κ` of the stiffness: `A + κ A'`, `c + κ c'`, in balanced states.
#[derive(Debug, Clone)]
struct SideOfShare {
    a: DMatrix<f64>,
    a_slope: DMatrix<f64>,
    b: DVector<f64>,
    c: DVector<f64>,
    c_slope: DVector<f64>,
    slopes: (f64, f64),
}

#[derive(Debug, Clone, Copy)]
struct Disc {
    centre: Complex64,
    by_angle: f64,
    by_share: f64,
}

impl Disc {
    fn radius(&self) -> f64 {
        self.by_angle + self.by_share
    }
}

impl SideOfShare {
    fn through(none: &Side, all: &Side) -> Self {
        let ((mut a, b, c), (a_all, _, c_all)) = (none.with_held(), all.with_held());
        let (mut a_slope, c_slope) = (a_all - &a, c_all - &c);
        let scales = nalgebra::linalg::balancing::balance_parlett_reinsch(&mut a);
        a_slope = DMatrix::from_fn(a.nrows(), a.nrows(), |i, j| a_slope[(i, j)] * scales[j] / scales[i]);
        let c_slope = c_slope.component_mul(&scales);
        let slopes = (a_slope.norm(), c_slope.norm());
        Self { a, a_slope, b: b.component_div(&scales), c: c.component_mul(&scales), c_slope, slopes }
    }

    /// Bounds the responses within `reach` of `z` and `spread` of `share`; `None` if the box is too large or contains a
    /// pole.
    ///
    /// Let `R = (z I - A)⁻¹`, `E` the change of its inverse, and `ε = ‖E‖ < 1 / ‖R‖`. The response is `(c + κ c') R' b`
    /// with `R' = R - R E R + R E R' E R` and `‖R'‖ <= ‖R‖ / (1 - ε ‖R‖)`: a linear part and a second-order remainder.
    fn responses(&self, z: Complex64, reach: f64, (share, spread): (f64, f64)) -> Option<Disc> {
        let complex = |x: f64| Complex64::new(x, 0.0);
        let n = self.a.nrows();
        let inverse = DMatrix::from_fn(n, n, |i, j| {
            let pole = if i == j { z } else { complex(0.0) };
            pole - self.a[(i, j)] - share * self.a_slope[(i, j)]
        });
        let r = inverse.try_inverse()?;
        let c = (&self.c + &self.c_slope * share).map(complex);
        let (rb, cr) = (&r * self.b.map(complex), r.tr_mul(&c));
        let centre = c.dot(&rb);
        if reach == 0.0 && spread == 0.0 {
            return centre.is_finite().then_some(Disc { centre, by_angle: 0.0, by_share: 0.0 });
        }
        let size = r.norm();
        let change = reach + spread * self.slopes.0;
        if size.is_nan() || change * size >= 1.0 {
            return None;
        }
        let rest = change * size / (1.0 - change * size);
        let rest = rb.norm() * rest * (cr.norm() * change + spread * self.slopes.1);
        let of_share = cr.dot(&(self.a_slope.map(complex) * &rb)) + self.c_slope.map(complex).dot(&rb);
        let (by_angle, by_share) = (reach * cr.dot(&rb).norm(), spread * of_share.norm());
        let part = reach / change;
        Some(Disc { centre, by_angle: by_angle + rest * part, by_share: by_share + rest * (1.0 - part) })
    }
}

#[derive(Debug, Clone, Copy)]
struct Region {
    angle: (f64, f64),
    share: (f64, f64),
}

enum Known {
    Holds,
    Fails,
    /// Split the box along the share or the angle.
    Open {
        along_share: bool,
    },
}

#[derive(Debug, Clone, Copy)]
struct Criterion {
    ticks: [f64; 2],
    /// `g1²` and `g2²`.
    gains: [f64; 2],
    scaling: f64,
}

struct Proof {
    closed: ClosedLoop,
    master: SideOfShare,
    slave: SideOfShare,
    tops: Vec<(f64, Response)>,
}

impl Proof {
    fn new(settings: &LinearLoop) -> Result<Self, StabilityError> {
        let machines = Machines::new(settings)?;
        let at = |share: f64| {
            let stiffness_n_per_m = share * settings.stiffness_n_per_m;
            Side::slave(&machines, &LinearLoop { stiffness_n_per_m, ..settings.clone() })
        };
        let closed = ClosedLoop::of(&machines, settings, None)?;
        Self::of(closed, at)
    }

    fn of(closed: ClosedLoop, slave: impl Fn(f64) -> Result<Side, StabilityError>) -> Result<Self, StabilityError> {
        let top = |piece: u32| -> Result<_, StabilityError> {
            let share = f64::from(piece) / f64::from(PIECES);
            Ok((share, Response::new(&slave(share)?)))
        };
        Ok(Self {
            master: SideOfShare::through(&closed.master, &closed.master),
            slave: SideOfShare::through(&slave(0.0)?, &slave(1.0)?),
            tops: (1..=PIECES).map(top).collect::<Result<_, _>>()?,
            closed,
        })
    }

    /// If the criterion holds, `L` is never 1, so no pole crosses the unit circle as the stiffness changes: the nominal
    /// loop is stable at all stiffnesses if it is at one.
    fn covers_stiffness(&self, forward: DelayRange, backward: DelayRange) -> Result<bool, StabilityError> {
        let width = 1.0 / f64::from(PIECES);
        for (top, _) in self.tops.iter().rev() {
            if !self.covers(forward, backward, (top - width, *top))? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    fn covers(
        &self,
        forward: DelayRange,
        backward: DelayRange,
        (low, high): (f64, f64),
    ) -> Result<bool, StabilityError> {
        let ((forward, forward_gain), (backward, backward_gain)) = (forward.nominal(), backward.nominal());
        let nominal = self.closed.with_delays(forward, backward);
        let top = self.tops.iter().find(|(top, _)| *top >= high);
        let (true, Some((_, slave))) = (nominal.is_stable()?, top) else { return Ok(false) };
        let criterion = Criterion {
            ticks: [forward as f64, backward as f64],
            gains: [forward_gain * forward_gain, backward_gain * backward_gain],
            scaling: 1.0,
        };
        let Some(scaling) = scaling(&criterion, &nominal, slave)? else { return Ok(false) };
        Ok(self.holds(&Criterion { scaling, ..criterion }, (0.5 * (low + high), 0.5 * (high - low))))
    }

    fn holds(&self, criterion: &Criterion, share: (f64, f64)) -> bool {
        let half = |k: i32| PI * 0.5_f64.powi(k);
        let first = Region { angle: (0.5 * half(12), 0.5 * half(12)), share };
        let octave = |k: i32| Region { angle: (0.75 * half(k), 0.25 * half(k)), share };
        let mut open: Vec<Region> = std::iter::once(first).chain((0..12).map(octave)).collect();
        let mut count = 0;
        while let Some(region) = open.pop() {
            count += 1;
            match self.known(criterion, &region) {
                Known::Holds => {}
                Known::Fails => return false,
                Known::Open { .. } if count > MAX_BOXES => return false,
                Known::Open { along_share } => {
                    let halved =
                        |(middle, half): (f64, f64)| [-0.5, 0.5].map(|side| (middle + side * half, 0.5 * half));
                    open.extend(if along_share {
                        halved(region.share).map(|share| Region { share, ..region })
                    } else {
                        halved(region.angle).map(|angle| Region { angle, ..region })
                    });
                }
            }
        }
        true
    }

    fn known(&self, criterion: &Criterion, region: &Region) -> Known {
        let Region { angle: (angle, reach), share: (share, spread) } = *region;
        let z = Complex64::from_polar(1.0, angle);
        let discs = |reach: f64, spread: f64| {
            Some([self.master.responses(z, reach, (share, 0.0))?, self.slave.responses(z, reach, (share, spread))?])
        };
        match discs(reach, spread) {
            Some([master, slave]) => {
                if criterion.holds([&master, &slave], (angle, reach)) {
                    return Known::Holds;
                }
                let point = |disc: &Disc| Disc { by_angle: 0.0, by_share: 0.0, ..*disc };
                if !criterion.holds([&point(&master), &point(&slave)], (angle, 0.0)) {
                    return Known::Fails;
                }
                let relative = |part: f64, disc: &Disc| part / (disc.centre.norm() + f64::MIN_POSITIVE);
                let turned = reach * (criterion.ticks[0] + criterion.ticks[1]);
                let by_angle = relative(master.by_angle, &master) + relative(slave.by_angle, &slave) + turned;
                Known::Open { along_share: relative(slave.by_share, &slave) > by_angle }
            }
            None if discs(0.0, 0.0).is_none() => Known::Fails,
            None => Known::Open { along_share: spread * self.slave.slopes.0 > reach },
        }
    }
}

impl Criterion {
    fn holds(&self, [master, slave]: [&Disc; 2], (angle, reach): (f64, f64)) -> bool {
        let [forward, backward] = self.ticks;
        let [g1, g2] = self.gains;
        let turn = Complex64::from_polar(1.0, -(forward + backward) * angle);
        let product = master.centre * slave.centre;
        let (of_master, of_slave) = (master.centre.norm() + master.radius(), slave.centre.norm() + slave.radius());
        let spread = of_master * of_slave - product.norm();
        let (smallest, largest) = ((product.norm() - spread).max(0.0), of_master * of_slave);
        let turned = product.norm() * ((forward + backward) * reach).min(2.0);
        let apart = (Complex64::new(1.0, 0.0) - product * turn).norm() - spread - turned;
        let step = |angle: f64| 2.0 * (0.5 * angle.clamp(0.0, PI)).sin();
        let (low, high) = (step(angle - reach), step(angle + reach));
        let [of_both, of_ways] = self.gains_of(low);
        let product_part = of_both.max(0.0) * largest * largest + of_both.min(0.0) * smallest * smallest;
        let ways = if g1 * g2 > 0.0 {
            self.scaling * g1 * of_master * of_master + g2 * of_slave * of_slave / self.scaling
        } else {
            // With one Δ the scaling can make the other direction's part arbitrarily small.
            0.0
        };
        let room = (1.0 - SLACK) * apart.max(0.0);
        high * high * (ways + product_part) < room * room && high * high * of_ways * largest <= room
    }

    fn gains_of(&self, step: f64) -> [f64; 2] {
        let [g1, g2] = self.gains;
        [g1 + g2 - g1 * g2 * step * step, (g1 * g2).sqrt()]
    }
}

/// Largest change of the delay's phase between points in rad, and `ln |L|` below which it is negligible.
const TURN_OF_POINTS: f64 = 0.5;
const LN_NEGLIGIBLE: f64 = -1.4;

fn scaling(criterion: &Criterion, nominal: &ClosedLoop, slave: &Response) -> Result<Option<f64>, StabilityError> {
    let [g1, g2] = criterion.gains;
    let delay = criterion.ticks[0] + criterion.ticks[1];
    let (mut low, mut high) = (0.0_f64, f64::INFINITY);
    let mut at_angle = |angle_rad: f64| {
        let z = Complex64::from_polar(1.0, angle_rad);
        let (of_master, of_slave) = (nominal.responses_at(z)[0], slave.at(z));
        let product = of_master * of_slave;
        let gain = product * Complex64::from_polar(1.0, -delay * angle_rad);
        let step = (Complex64::new(1.0, 0.0) - z.conj()).norm();
        let [of_both, _] = criterion.gains_of(step);
        // a δ + b / δ < room
        let squared = step * step;
        let room = (Complex64::new(1.0, 0.0) - gain).norm_sqr() - squared * of_both * product.norm_sqr();
        let (a, b) = (squared * g1 * of_master.norm_sqr(), squared * g2 * of_slave.norm_sqr());
        let root = (room * room - 4.0 * a * b).sqrt();
        if root >= 0.0 && room > 0.0 {
            low = low.max(2.0 * b / (room + root));
            high = high.min((room + root) / (2.0 * a));
        } else if a * b > 0.0 || room <= 0.0 {
            high = 0.0;
        }
    };
    Path::new(nominal, 1.0).resolve(|from, to| {
        let width = to.angle_rad - from.angle_rad;
        let turned = if from.ln_gain.max(to.ln_gain) < LN_NEGLIGIBLE { 0.0 } else { delay * width };
        let points = (turned / TURN_OF_POINTS).ceil().max(1.0) as usize;
        (1..=points).for_each(|k| at_angle(from.angle_rad + width * k as f64 / points as f64));
    })?;
    if g1 * g2 == 0.0 {
        return Ok((high > 0.0).then_some(1.0));
    }
    let middle = if low == 0.0 { 0.5 * high } else { (low * high).sqrt() };
    Ok((low < high).then_some(if middle.is_finite() { middle } else { 1.0 }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::side::External;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn side(a: &[f64], now: &[f64], c: &[f64]) -> Side {
        let (n, nothing) = (now.len(), DVector::zeros(now.len()));
        Side {
            a: DMatrix::from_row_slice(n, n, a),
            now: DVector::from_column_slice(now),
            before: None,
            c: DVector::from_column_slice(c),
            local: nothing.clone(),
            force: nothing,
            desired: None,
            external: External::none(n),
        }
    }

    fn proof(master: Side, slave: impl Fn(f64) -> Side) -> Proof {
        let closed = ClosedLoop::of_sides((master, slave(1.0)), 1e-3, (0, 0), None).expect("built");
        Proof::of(closed, |share| Ok(slave(share))).expect("built")
    }

    const fn range(min_ticks: u64, max_ticks: u64) -> DelayRange {
        DelayRange { min_ticks, max_ticks }
    }

    const FIXED: DelayRange = range(0, 0);

    /// The decay of the integrator per tick. A pole on the circle would have an unbounded response.
    const KEPT: f64 = 1.0 - 1e-5;

    /// Approximately `x_{k+1} = x_k - α x_{k-1-d_k}`.
    fn integrator(alpha: f64) -> Proof {
        proof(side(&[KEPT], &[-alpha], &[1.0]), |_| side(&[0.0], &[1.0], &[1.0]))
    }

    /// The largest `α` with a proof for delays up to `longest` ticks, to 1e-4.
    fn proved_limit(longest: u64) -> f64 {
        let (mut proved, mut open) = (0.0, 2.0);
        while open - proved > 1e-4 {
            let alpha = 0.5 * (proved + open);
            let holds = integrator(alpha).covers(range(0, longest), FIXED, (1.0, 1.0)).expect("computed");
            if holds { proved = alpha } else { open = alpha }
        }
        proved
    }

    #[test]
    fn oracle_the_proved_limit_of_an_integrator_lies_between_kao_and_lincoln_and_the_sharp_limit() {
        for longest in [2, 4, 10, 40] {
            let limit = proved_limit(longest);
            // With effective delays of 1 to N + 1 ticks, α (N + 2) < 3/2 + 1 / (2 (N + 2)) suffices (Erbe, Xia and Yu
            // 1995, Global stability of a linear nonautonomous delay difference equation); 3/2 is sharp for long delays
            // (Myshkis 1951).
            let ticks = longest as f64 + 2.0;
            let sharp = (1.5 + 0.5 / ticks) / ticks;
            assert!(limit < sharp, "{longest}: {limit} {sharp}");
            // Kao and Lincoln treat all N + 1 ticks as uncertainty: (N + 1) |z - 1| < |(z - 1 + α) / α|, at z = -1.
            let kao_lincoln = 2.0 / (2.0 * longest as f64 + 3.0);
            assert!(limit > kao_lincoln, "{longest}: {limit} {kao_lincoln}");
        }
    }

    #[test]
    fn a_proved_loop_decays_for_every_order_of_delays_and_beyond_the_sharp_limit_one_order_grows() {
        let longest = 10;
        // The worst order for an integrator: the oldest sample as long as possible, then the newest.
        let swing = |alpha: f64, order: &mut dyn FnMut(usize) -> usize| {
            let mut x = vec![1.0_f64; 40];
            for k in 39..4000 {
                let next = KEPT * x[k] - alpha * x[k - 1 - order(k)];
                x.push(next);
            }
            x[3900..].iter().fold(0.0, |max: f64, x| max.max(x.abs()))
        };
        let limit = proved_limit(longest);
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for period in 1..40 {
            let held = |k: usize| (k % period).min(longest as usize);
            assert!(swing(0.99 * limit, &mut |k| held(k)) < 1e-6, "{period}");
        }
        for _ in 0..200 {
            let mut delay = 0;
            let mut order = |_| {
                delay = rng.random_range(0..=(delay + 1).min(longest as usize));
                delay
            };
            assert!(swing(0.99 * limit, &mut order) < 1e-6);
        }
        let beyond = 1.6 / (longest as f64 + 1.0);
        let grows = (1..80).any(|period| swing(beyond, &mut |k| (k % period).min(longest as usize)) > 1.0);
        assert!(grows, "the order is not the worst");
        assert!(!integrator(beyond).covers(range(0, longest), FIXED, (1.0, 1.0)).expect("computed"));
    }

    /// Random stable sides of second order.
    fn random_side(rng: &mut ChaCha8Rng, size: f64) -> Side {
        let (radius, angle) = (rng.random_range(0.5..0.95), rng.random_range(0.0..2.0));
        let (sum, product) = (2.0 * radius * f64::cos(angle), radius * radius);
        let at_one = 1.0 - sum + product;
        let c = [rng.random_range(-1.0..1.0), rng.random_range(-1.0..1.0)].map(|weight: f64| weight * size * at_one);
        side(&[sum, -product, 1.0, 0.0], &[1.0, 0.0], &c)
    }

    /// The largest singular value over a fine grid of frequencies, with the best scaling.
    fn norm_by_grid(proof: &Proof, ticks: [u64; 2], gains: [f64; 2]) -> f64 {
        let nominal = proof.closed.with_delays(ticks[0], ticks[1]);
        let one = Complex64::new(1.0, 0.0);
        let matrices: Vec<[[Complex64; 2]; 2]> = (1..=1000)
            .map(|k| {
                let z = Complex64::from_polar(1.0, PI * f64::from(k) / 1000.0);
                let [h1, h2] = nominal.responses_at(z);
                let late = |ticks: u64| z.powi(-(ticks as i32));
                let factor = (one - z.inv()) / (one - h1 * h2 * late(ticks[0] + ticks[1]));
                [
                    [factor * h1 * h2 * late(ticks[1]) * gains[0], factor * h1 * gains[0]],
                    [factor * h2 * gains[1], factor * h1 * h2 * late(ticks[0]) * gains[1]],
                ]
            })
            .collect();
        let worst = |scaling: f64| {
            let size = |m: &[[Complex64; 2]; 2]| {
                let scaled = DMatrix::from_row_slice(2, 2, &[m[0][0], m[0][1] * scaling, m[1][0] / scaling, m[1][1]]);
                scaled.singular_values()[0]
            };
            matrices.iter().map(size).fold(0.0, f64::max)
        };
        (-30..=30).map(|k| worst(10.0_f64.powf(0.1 * f64::from(k)))).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn oracle_the_proof_agrees_with_the_singular_values_on_a_fine_grid() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut counts = [0, 0];
        for _ in 0..60 {
            let (master, slave) = (random_side(&mut rng, 0.8), random_side(&mut rng, 0.8));
            let proof = proof(master, |_| slave.clone());
            let mut delays = || {
                let least = rng.random_range(0..4);
                range(least, least + 2 * rng.random_range(0..4))
            };
            let (forward, backward) = (delays(), delays());
            let ((m1, g1), (m2, g2)) = (forward.nominal(), backward.nominal());
            if !proof.closed.with_delays(m1, m2).is_stable().expect("counted") {
                continue;
            }
            let norm = norm_by_grid(&proof, [m1, m2], [g1, g2]);
            if (norm - 1.0).abs() > 0.03 {
                let is_proved = proof.covers(forward, backward, (1.0, 1.0)).expect("computed");
                assert_eq!(is_proved, norm < 1.0, "{norm} {forward:?} {backward:?}");
                counts[usize::from(is_proved)] += 1;
            }
        }
        assert!(counts.iter().all(|count| *count > 5), "{counts:?}");
    }

    #[test]
    fn a_proof_over_a_stiffness_range_holds_at_each_stiffness() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let mut counts = [0, 0];
        for _ in 0..40 {
            let (master, slack, stiff) =
                (random_side(&mut rng, 0.9), random_side(&mut rng, 0.2), rng.random_range(0.0..2.0));
            let slave = |share: f64| {
                let mut slave = slack.clone();
                slave.c *= 1.0 + share * stiff;
                slave.a[(0, 1)] -= 0.02 * share;
                slave
            };
            let delays = range(0, 2);
            let all = proof(master.clone(), slave).covers_stiffness(delays, delays).expect("computed");
            let each = (0..=10).all(|k| {
                let at = slave(0.1 * f64::from(k));
                proof(master.clone(), |_| at.clone()).covers(delays, delays, (1.0, 1.0)).expect("computed")
            });
            assert!(each || !all);
            counts[usize::from(all)] += 1;
        }
        assert!(counts.iter().all(|count| *count > 3), "{counts:?}");
    }
}
