//! Bounds of the loop's motion at each tick, for a stiffness that varies within a range at every tick.
//!
//! Let `δ` be the position in the stiffness range. The feedback force is `(p + δ q) x`; with local feedback the slave's
//! reference has the same form. Around a nominal position `σ` the loop is linear and time-invariant, and the tissue
//! acts as a bounded input:
//!
//! ```text
//! x_(k+1) = A_σ x_k + b w_k,      w_k = (δ_k - σ) q x_k,      0 <= δ_k <= 1
//! s x_k   = s A_σ^k x_0 + Σ s A_σ^(k-1-j) b w_j,              j < k
//! ```
//! The bounds of `q x_j` at previous ticks give the bounds of `w_j`, and these the bounds of every signal at tick `k`.
//! In a cross-fade with the weight `v`, `w_k = (v δ_k - σ) q x_k - (1 - v) p x_k + (1 - v) φ` with the force `φ` before
//! the cross-fade. The narrowest bounds of all nominal positions are used: the softest is narrow where more stiffness
//! only pushes back; the middle one stays bounded for a wide range.
//!
//! After the slowest mode has decayed, the bounds hold for all later ticks if the resulting inputs stay within the
//! previous range. Motions without a gap decay for every tissue by the small-gain theorem: `Σ |q A^j b| / 2 < 1` around
//! the middle.
//!
//! Responses are interval enclosures from products of a few powers of `A`. `Σ |A^j v|` from tick `N` on is at most
//! `G |v| β / (1 - β)`, with `G = Σ |A^j|` before tick `N` and `β = |A^N|` in the maximum norm.

use super::modes::{Modes, Space};
use super::scaling::Scales;
use crate::StabilityError;
use crate::certificate::first_powers;
use crate::certificate::interval::{Enclosure, Interval, magnitude, power, product, sum};
use nalgebra::DMatrix;
use trocar_base::interrupt;

/// Decay of the slowest mode over the ticks with individual bounds, as a power of e.
const DECAY: f64 = 25.0;

/// The maximum number of ticks with individual bounds.
const MAX_TICKS: f64 = 50_000.0;

/// Nominal positions in the stiffness range. The last one is the middle, for the small gain.
const NOMINALS: [f64; 2] = [0.0, 0.5];

/// Allowance for the rounding of a sum over all ticks, relative to the sum of magnitudes.
const ROUNDING: f64 = 1e-9;

/// Enlargement of the inputs' range after the last tick, relative to the largest input.
const ROOM: f64 = 1e-6;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Range {
    pub(super) low: f64,
    pub(super) high: f64,
}

impl Range {
    const ALL: Self = Self { low: f64::NEG_INFINITY, high: f64::INFINITY };

    pub(super) fn largest(self) -> f64 {
        self.low.abs().max(self.high.abs())
    }

    fn plus(self, other: Self) -> Self {
        Self { low: self.low + other.low, high: self.high + other.high }
    }

    fn times(self, other: Self) -> Self {
        let (a, b) = (self.low * other.low, self.low * other.high);
        let (c, d) = (self.high * other.low, self.high * other.high);
        Self { low: a.min(b).min(c.min(d)), high: a.max(b).max(c.max(d)) }.wider(0.0)
    }

    fn wider(self, reach: f64) -> Self {
        let reach = reach + 1e-12 * self.largest();
        Self { low: self.low - reach, high: self.high + reach }
    }

    fn within(self, other: Self) -> Self {
        Self { low: self.low.max(other.low), high: self.high.min(other.high) }
    }

    fn with(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }
}

/// A start of a motion: the scaled states with the gap, the bounds of an unknown rest, and the largest force (N) before
/// an initial cross-fade.
pub(super) struct Start {
    pub(super) state: Vec<Interval>,
    pub(super) rest: Vec<f64>,
    pub(super) fades_from_n: Option<f64>,
}

pub(super) struct Track {
    /// Bounds of each scaled state of the loop, over all ticks.
    pub(super) states: Vec<f64>,
    /// Bounds of the scaled reference that an alarm at each tick holds; the last one for all later ticks.
    pub(super) reference: Vec<f64>,
    /// Bound of the slave's position in m.
    pub(super) slave: f64,
    /// Bound of the feedback force in N.
    pub(super) force_n: f64,
}

/// An input of the tissue: through the feedback force or the slave's reference.
struct Channel {
    column: Enclosure,
    is_force: bool,
}

/// The response of a signal to an input at each tick: positive and negative parts, sums of the magnitude, sum of the
/// widths of the enclosures.
#[derive(Default)]
struct Impulse {
    positive: Vec<f64>,
    negative: Vec<f64>,
    sizes: Vec<f64>,
    widths: f64,
}

/// The loop at one nominal position.
struct Nominal {
    share: f64,
    /// `s A^k` for each signal and tick, with the gap.
    rows: Vec<Vec<Vec<Interval>>>,
    /// The responses by signal and channel.
    impulses: Vec<Vec<Impulse>>,
    steps: Vec<Enclosure>,
    leaps: Vec<Enclosure>,
    /// The product of `Σ |A^j|` and `β / (1 - β)`.
    tail: f64,
}

pub(super) struct Responses {
    channels: Vec<Channel>,
    /// `p` and `q` of each channel, then the references, then the slave's position.
    signals: Vec<Enclosure>,
    nominals: Vec<Nominal>,
    weights: Vec<f64>,
    ticks: usize,
    states: usize,
}

fn difference(a: &Enclosure, b: &Enclosure) -> Enclosure {
    sum(a, &times(b, -1.0))
}

fn times(a: &Enclosure, factor: f64) -> Enclosure {
    a.iter().map(|row| row.iter().map(|entry| *entry * Interval::exact(factor)).collect()).collect()
}

fn dot(row: &[Interval], column: &[Interval]) -> Interval {
    row.iter().zip(column).fold(Interval::exact(0.0), |all, (a, b)| all + *a * *b)
}

fn column(matrix: &Enclosure) -> Vec<Interval> {
    matrix.iter().map(|row| row[0]).collect()
}

fn max_norm(matrix: &Enclosure, states: usize) -> f64 {
    let row = |row: &Vec<Interval>| row[..states].iter().map(|entry| magnitude(*entry)).sum::<f64>();
    matrix[..states].iter().map(row).fold(0.0, f64::max)
}

fn largest(vector: &[Interval]) -> f64 {
    vector.iter().map(|entry| magnitude(*entry)).fold(0.0, f64::max)
}

impl Responses {
    /// `None` if the loop does not decay within [`MAX_TICKS`], or its gain is too large.
    pub(super) fn new(modes: &Modes, scales: &Scales, weights: Vec<f64>) -> Result<Option<Self>, StabilityError> {
        let slowest = modes.slowest_decay_per_s()?;
        let ticks = (DECAY / (slowest * modes.tick_s)).ceil().max(4.0 * weights.len() as f64);
        if ticks.is_nan() || ticks > MAX_TICKS {
            return Ok(None);
        }
        let space = Space::LoopGap;
        let row = |row: &DMatrix<f64>| scales.scaled(modes, &modes.row(row, space), (space, Space::Number));
        let (softest, stiffest) = (row(&modes.force(0)), row(&modes.force(1)));
        let (hand, hand_stiffest) = (row(&modes.hand(0)), row(&modes.hand(1)));
        let pairs = [(modes.of_force(), softest, stiffest), (modes.of_reference(), hand, hand_stiffest)];
        let (mut channels, mut signals) = (vec![], vec![]);
        for (k, (into, soft, stiff)) in pairs.into_iter().enumerate() {
            let is_force = k == 0;
            if is_force || !modes.has_unique_motion() {
                let into = modes.row(&into.transpose(), space).transpose();
                let column = scales.scaled(modes, &into, (Space::Number, space));
                channels.push(Channel { column, is_force });
                signals.extend([soft.clone(), difference(&stiff, &soft)]);
            }
        }
        let at_alarm = |vertex: usize| {
            let entry = modes.between(&(modes.freeze() * modes.teleoperation(vertex)), space, Space::Frozen);
            let row = scales.scaled(modes, &entry, (space, Space::Frozen)).swap_remove(modes.states());
            vec![row]
        };
        let first = at_alarm(0);
        signals.extend((1..modes.vertices().end).map(at_alarm).filter(|other| *other != first));
        signals.insert(2 * channels.len(), first);
        signals.push(row(&modes.slave()));
        let map = |vertex: usize| {
            scales.scaled(modes, &modes.between(&modes.teleoperation(vertex), space, space), (space, space))
        };
        let ends = [map(0), map(1)];
        let (ticks, states) = (ticks as usize, modes.states());
        let mut nominals = vec![];
        for share in NOMINALS {
            let a = sum(&times(&ends[0], 1.0 - share), &times(&ends[1], share));
            let Some(nominal) = Nominal::new(share, &a, (&channels, &signals), (ticks, states)) else {
                return Ok(None);
            };
            nominals.push(nominal);
        }
        let all = Self { channels, signals, nominals, weights, ticks, states };
        Ok(all.decays().then_some(all))
    }

    pub(super) fn ticks(&self) -> usize {
        self.ticks
    }

    fn decays(&self) -> bool {
        let Some(middle) = self.nominals.last() else { return false };
        let gain = |to: usize, from: usize| {
            let input = &self.channels[from].column;
            0.5 * (middle.sum_of(2 * to + 1, from) + self.tail(middle, 2 * to + 1, largest(&column(input))))
        };
        match self.channels.len() {
            1 => gain(0, 0) < 1.0,
            _ => {
                let (a, d) = (1.0 - gain(0, 0), 1.0 - gain(1, 1));
                a > 0.0 && d > 0.0 && gain(0, 1) * gain(1, 0) < a * d
            }
        }
    }

    fn tail(&self, nominal: &Nominal, signal: usize, size: f64) -> f64 {
        let row: f64 = self.signals[signal][0][..self.states].iter().map(|entry| magnitude(*entry)).sum();
        row * nominal.tail * size * (1.0 + ROUNDING)
    }

    fn change(&self, nominal: &Nominal, start: &Start) -> f64 {
        let moved = nominal.steps[1].iter().map(|row| dot(row, &start.state));
        let change: Vec<Interval> = moved.zip(&start.state).map(|(moved, state)| moved - *state).collect();
        largest(&change[..self.states])
    }

    fn input(&self, channel: usize, share: f64, weight: f64, (p, q): (Range, Range), faded_n: f64) -> Range {
        let weight = if self.channels[channel].is_force { weight } else { 1.0 };
        let of_tissue = Range { low: -share, high: weight - share }.times(q);
        if weight == 1.0 {
            return of_tissue;
        }
        let away = Range { low: weight - 1.0, high: weight - 1.0 }.times(p);
        of_tissue.plus(away).wider((1.0 - weight) * faded_n)
    }

    /// The bounds of a motion; `None` if they do not hold for all later ticks.
    pub(super) fn track(&self, start: &Start) -> Option<Track> {
        let (ticks, channels) = (self.ticks, self.channels.len());
        let references = 2 * channels..self.signals.len() - 1;
        let slave = self.signals.len() - 1;
        // Inputs by nominal and channel, in reverse order of time.
        let mut lows = vec![vec![vec![0.0; ticks]; channels]; self.nominals.len()];
        let mut highs = lows.clone();
        let mut largest_inputs = vec![vec![0.0_f64; channels]; self.nominals.len()];
        let mut hulls =
            vec![vec![Range { low: f64::INFINITY, high: f64::NEG_INFINITY }; channels]; self.nominals.len()];
        let mut all = Track { states: vec![], reference: vec![], slave: 0.0, force_n: 0.0 };
        let see = |all: &mut Track, signals: &[Range], weight: f64| {
            all.reference.push(references.clone().map(|k| signals[k].largest()).fold(0.0, f64::max));
            all.slave = all.slave.max(signals[slave].largest());
            let force = signals[0].plus(Range { low: 0.0, high: 1.0 }.times(signals[1]));
            let faded = (1.0 - weight) * start.fades_from_n.unwrap_or(0.0);
            all.force_n = all.force_n.max(weight * force.largest() + faded);
        };
        let free = |nominal: &Nominal, signal: usize, tick: usize| {
            let row = &nominal.rows[signal][tick];
            let value = dot(row, &start.state);
            let rest: f64 = row.iter().zip(&start.rest).map(|(entry, rest)| magnitude(*entry) * rest).sum();
            Range { low: value.low, high: value.high }.wider(rest * (1.0 + ROUNDING))
        };
        let mut signals = vec![Range::ALL; self.signals.len()];
        for tick in 0..ticks {
            if tick % 64 == 0 {
                interrupt::check();
            }
            for (signal, range) in signals.iter_mut().enumerate() {
                *range = Range::ALL;
                for (at, nominal) in self.nominals.iter().enumerate() {
                    let mut one = free(nominal, signal, tick);
                    for channel in 0..channels {
                        let inputs = (&lows[at][channel][ticks - tick..], &highs[at][channel][ticks - tick..]);
                        let impulse = &nominal.impulses[signal][channel];
                        one = one.plus(impulse.respond(tick, inputs, largest_inputs[at][channel]));
                    }
                    *range = range.within(one);
                }
                if !(range.low <= range.high && range.largest().is_finite()) {
                    return None;
                }
            }
            let weight = start.fades_from_n.and(self.weights.get(tick)).copied().unwrap_or(1.0);
            see(&mut all, &signals, weight);
            for (at, nominal) in self.nominals.iter().enumerate() {
                for channel in 0..channels {
                    let pair = (signals[2 * channel], signals[2 * channel + 1]);
                    let input = self.input(channel, nominal.share, weight, pair, start.fades_from_n.unwrap_or(0.0));
                    let place = ticks - 1 - tick;
                    (lows[at][channel][place], highs[at][channel][place]) = (input.low, input.high);
                    let largest = &mut largest_inputs[at][channel];
                    *largest = largest.max(input.largest());
                    if tick >= ticks / 2 {
                        hulls[at][channel] = hulls[at][channel].with(input);
                    }
                }
            }
        }
        self.settle(start, &mut largest_inputs, &mut hulls, &mut signals)?;
        see(&mut all, &signals, 1.0);
        all.states = self.of_states(start, &largest_inputs);
        Some(all)
    }

    /// Bounds from the last tick on; they hold for all later ticks if the resulting inputs stay within `hulls`.
    fn settle(
        &self,
        start: &Start,
        largest_inputs: &mut [Vec<f64>],
        hulls: &mut [Vec<Range>],
        signals: &mut [Range],
    ) -> Option<()> {
        let (ticks, half) = (self.ticks, self.ticks / 2);
        for (hulls, largest) in hulls.iter_mut().zip(largest_inputs.iter_mut()) {
            for (hull, largest) in hulls.iter_mut().zip(largest) {
                *hull = hull.wider(ROOM * *largest);
                *largest = largest.max(hull.largest());
            }
        }
        let rest = start.rest.iter().copied().fold(0.0, f64::max);
        for (signal, range) in signals.iter_mut().enumerate() {
            *range = Range::ALL;
            for ((nominal, hulls), largest) in self.nominals.iter().zip(&*hulls).zip(&*largest_inputs) {
                let value = dot(&nominal.rows[signal][ticks], &start.state);
                let reach = self.tail(nominal, signal, self.change(nominal, start) + rest);
                let mut one = Range { low: value.low, high: value.high }.wider(reach);
                for (channel, (hull, &largest)) in hulls.iter().zip(largest).enumerate() {
                    let impulse = &nominal.impulses[signal][channel];
                    let constant = (&vec![hull.low; half][..], &vec![hull.high; half][..]);
                    let later = impulse.sizes[ticks] - impulse.sizes[half];
                    let tail = self.tail(nominal, signal, largest_of_column(&self.channels[channel]));
                    one = one.plus(impulse.respond(half, constant, largest)).wider((later + tail) * largest);
                }
                *range = range.within(one);
            }
        }
        for (nominal, hulls) in self.nominals.iter().zip(hulls) {
            for (channel, hull) in hulls.iter().enumerate() {
                let pair = (signals[2 * channel], signals[2 * channel + 1]);
                let input = self.input(channel, nominal.share, 1.0, pair, 0.0);
                // Also false for NaN.
                if !(input.low >= hull.low && input.high <= hull.high) {
                    return None;
                }
            }
        }
        Some(())
    }

    fn of_states(&self, start: &Start, largest_inputs: &[Vec<f64>]) -> Vec<f64> {
        let n = self.states;
        let (Some(nominal), Some(inputs)) = (self.nominals.last(), largest_inputs.last()) else { return vec![] };
        let mut all = vec![0.0_f64; n];
        let mut sums = vec![vec![0.0; n]; self.channels.len()];
        let mut tick = 0;
        for leap in &nominal.leaps {
            let leaped = |vector: &[Interval]| -> Vec<Interval> { leap.iter().map(|row| dot(row, vector)).collect() };
            let state = leaped(&start.state);
            let columns: Vec<Vec<Interval>> =
                self.channels.iter().map(|channel| leaped(&column(&channel.column))).collect();
            let sized = |matrix: &Enclosure, vector: &[f64]| -> Vec<f64> {
                let row = |row: &Vec<Interval>| row.iter().zip(vector).map(|(a, b)| magnitude(*a) * b).sum();
                matrix[..n].iter().map(row).collect()
            };
            let rest = sized(leap, &start.rest);
            for step in &nominal.steps {
                if tick > self.ticks {
                    break;
                }
                let rest = sized(step, &rest);
                for i in 0..n {
                    all[i] = all[i].max(magnitude(dot(&step[i], &state)) + rest[i]);
                    for (sums, column) in sums.iter_mut().zip(&columns) {
                        sums[i] += magnitude(dot(&step[i], column));
                    }
                }
                tick += 1;
            }
        }
        let rest = start.rest.iter().copied().fold(0.0, f64::max);
        let later = nominal.tail * (self.change(nominal, start) + rest);
        for (i, bound) in all.iter_mut().enumerate() {
            *bound += later;
            for ((sums, channel), input) in sums.iter().zip(&self.channels).zip(inputs) {
                *bound += (sums[i] + nominal.tail * largest_of_column(channel)) * input;
            }
            *bound *= 1.0 + ROUNDING;
        }
        all
    }
}

fn largest_of_column(channel: &Channel) -> f64 {
    largest(&column(&channel.column))
}

impl Nominal {
    fn new(
        share: f64,
        a: &Enclosure,
        (channels, signals): (&[Channel], &[Enclosure]),
        (ticks, states): (usize, usize),
    ) -> Option<Self> {
        let stride = (ticks as f64).sqrt() as usize + 1;
        let steps = first_powers(a, stride);
        let leaps = first_powers(&power(a, stride as u64), ticks / stride + 1);
        let sizes = |all: &[Enclosure]| all.iter().map(|one| max_norm(one, states)).sum::<f64>();
        let last = max_norm(&power(a, ticks as u64), states);
        if last.is_nan() || last >= 0.5 {
            return None;
        }
        let tail = sizes(&steps) * sizes(&leaps) * last / (1.0 - last) * (1.0 + ROUNDING);
        let row = |signal: &Enclosure| -> Vec<Vec<Interval>> {
            let leaped = leaps.iter().map(|leap| product(signal, leap));
            let all = leaped.flat_map(|row| steps.iter().map(move |step| product(&row, step).swap_remove(0)));
            all.take(ticks + 1).collect()
        };
        let rows: Vec<Vec<Vec<Interval>>> = signals.iter().map(row).collect();
        let impulse = |rows: &[Vec<Interval>], channel: &Channel| {
            let column = column(&channel.column);
            let mut all = Impulse { sizes: vec![0.0], ..Impulse::default() };
            let mut size = 0.0;
            for row in &rows[..ticks] {
                let value = dot(row, &column);
                all.positive.push(value.high.max(0.0));
                all.negative.push(value.low.min(0.0));
                size += magnitude(value);
                all.sizes.push(size * (1.0 + ROUNDING));
                all.widths += value.high - value.low;
            }
            all
        };
        let impulses =
            rows.iter().map(|rows| channels.iter().map(|channel| impulse(rows, channel)).collect()).collect();
        Some(Self { share, rows, impulses, steps, leaps, tail })
    }

    fn sum_of(&self, signal: usize, channel: usize) -> f64 {
        self.impulses[signal][channel].sizes.last().copied().unwrap_or(f64::INFINITY)
    }
}

/// Number of partial sums, for vectorised code.
const WIDTH: usize = 4;

impl Impulse {
    fn respond(&self, ticks: usize, (low, high): (&[f64], &[f64]), largest: f64) -> Range {
        let (mut below, mut above) = ([0.0; WIDTH], [0.0; WIDTH]);
        let mut add = |k: usize, (positive, negative): (f64, f64), (low, high): (f64, f64)| {
            below[k] += positive * low + negative * high;
            above[k] += positive * high + negative * low;
        };
        let (positive, negative) = (&self.positive[..ticks], &self.negative[..ticks]);
        let (low, high) = (&low[..ticks], &high[..ticks]);
        let whole = ticks - ticks % WIDTH;
        for from in (0..whole).step_by(WIDTH) {
            let part = |all: &[f64]| -> [f64; WIDTH] { std::array::from_fn(|k| all[from + k]) };
            let (positive, negative, low, high) = (part(positive), part(negative), part(low), part(high));
            for k in 0..WIDTH {
                add(k, (positive[k], negative[k]), (low[k], high[k]));
            }
        }
        for at in whole..ticks {
            add(0, (positive[at], negative[at]), (low[at], high[at]));
        }
        let slack = (ROUNDING * self.sizes[ticks] + 2.0 * self.widths) * largest;
        Range { low: below.iter().sum::<f64>() - slack, high: above.iter().sum::<f64>() + slack }
    }
}
