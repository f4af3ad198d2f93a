use super::TRANSIENT_S;
use crate::run::Run;
use trocar_base::moments::Moments;

pub(super) const CHANGE_S: f64 = 0.02;
const BEFORE_S: f64 = 0.1;

#[derive(Debug, Clone, Copy)]
pub(super) struct Errors {
    pub(super) mean_n: f64,
    pub(super) std_n: f64,
    pub(super) max_n: f64,
    pub(super) max_at_s: f64,
}

impl Errors {
    pub(super) fn of(run: &Run) -> Self {
        let absolute = || run.trace.residual_n.iter().map(|e| e.abs());
        let (mean_n, variance) = mean_and_variance(absolute());
        let largest = run.trace.time_s.iter().zip(absolute()).max_by(|a, b| a.1.total_cmp(&b.1));
        let (max_at_s, max_n) = largest.map_or((f64::NAN, f64::NAN), |(time_s, error)| (*time_s, error));
        Self { mean_n, std_n: variance.sqrt(), max_n, max_at_s }
    }
}

pub(super) struct Terms {
    pub(super) elastic_n: f64,
    pub(super) viscous_n: f64,
    pub(super) force_n: f64,
    /// The share of `B` in a correction of eq. 12 with `F = F_0`, which is along `(p, v)`: `v² / (p² + v²)`.
    pub(super) viscous_share: f64,
    /// Cosine of the angle between depth and velocity.
    pub(super) alignment: f64,
}

impl Terms {
    pub(super) fn at(run: &Run, time_s: f64) -> Self {
        let trace = &run.trace;
        let tick = tick(run, time_s);
        let depth = |tick: usize| trace.slave_position_m[tick] - run.scenario.contact_m;
        let velocity = |tick: usize| trace.slave_velocity_m_per_s[tick];
        let (p, v) = (depth(tick), velocity(tick));
        let [mut pp, mut vv, mut pv] = [0.0; 3];
        for before in self::tick(run, time_s - BEFORE_S)..=tick {
            let (p, v) = (depth(before), velocity(before));
            (pp, vv, pv) = (pp + p * p, vv + v * v, pv + p * v);
        }
        Self {
            elastic_n: trace.stiffness_n_per_m[tick] * p,
            viscous_n: trace.damping_n_s_per_m[tick] * v,
            force_n: trace.measured_force_n[tick],
            viscous_share: v * v / (p * p + v * v),
            alignment: pv / (pp * vv).sqrt(),
        }
    }
}

pub(super) fn terms(run: &Run) -> [Vec<f64>; 2] {
    let trace = &run.trace;
    let elastic = trace.stiffness_n_per_m.iter().zip(&trace.slave_position_m);
    let viscous = trace.damping_n_s_per_m.iter().zip(&trace.slave_velocity_m_per_s);
    let depth = |position_m: f64| (position_m - run.scenario.contact_m).max(0.0);
    [elastic.map(|(k, x)| k * depth(*x)).collect(), viscous.map(|(b, v)| b * v).collect()]
}

pub(super) fn tick(run: &Run, time_s: f64) -> usize {
    // Times of ticks are rounded.
    let from_s = time_s - 0.5 * run.scenario.grid.tick_s();
    run.trace.time_s.partition_point(|time| *time < from_s).min(run.trace.len().saturating_sub(1))
}

pub(super) fn ruptures_s(run: &Run) -> Vec<f64> {
    run.metrics.ruptures.iter().map(|rupture| rupture.time_s).collect()
}

const SUDDEN_S: f64 = 0.1;

/// The last change over [`CHANGE_S`] before each rupture, and the largest one within [`SUDDEN_S`] after it.
pub(super) fn jumps(run: &Run, column: &[f64]) -> Vec<(f64, f64)> {
    let ticks = tick(run, CHANGE_S);
    let change = |from: usize| column[(from + ticks).min(column.len() - 1)] - column[from];
    let of = |time_s: f64| {
        let after = (tick(run, time_s)..=tick(run, time_s + SUDDEN_S)).map(change);
        let largest = after.max_by(|a, b| a.abs().total_cmp(&b.abs()));
        (change(tick(run, time_s - CHANGE_S)), largest.unwrap_or(0.0))
    };
    ruptures_s(run).into_iter().map(of).collect()
}

/// The largest change over [`CHANGE_S`] outside the [`TRANSIENT_S`] after a rupture.
pub(super) fn largest_change_elsewhere(run: &Run, column: &[f64]) -> f64 {
    let ruptures_s = ruptures_s(run);
    let ticks = tick(run, CHANGE_S);
    let changes = run.trace.time_s.iter().zip(column.windows(ticks + 1));
    let elsewhere = changes.filter(|(from_s, _)| {
        ruptures_s.iter().all(|rupture_s| !(-CHANGE_S..=TRANSIENT_S).contains(&(*from_s - rupture_s)))
    });
    elsewhere.map(|(_, window)| (window[ticks] - window[0]).abs()).fold(0.0, f64::max)
}

/// The smaller peak at a rupture, divided by the largest value elsewhere.
pub(super) fn contrast(run: &Run, distance: &[f64]) -> f64 {
    let ruptures_s = ruptures_s(run);
    let mut at_ruptures = vec![0.0_f64; ruptures_s.len()];
    let mut elsewhere = 0.0_f64;
    for (time_s, value) in run.trace.time_s.iter().zip(distance) {
        let near = ruptures_s.iter().position(|rupture_s| (0.0..=TRANSIENT_S).contains(&(time_s - rupture_s)));
        let peak = near.map_or(&mut elsewhere, |index| &mut at_ruptures[index]);
        *peak = peak.max(*value);
    }
    at_ruptures.into_iter().reduce(f64::min).unwrap_or(0.0) / elsewhere
}

pub(super) fn squared_changes_n2(run: &Run) -> Vec<f64> {
    let force = &run.trace.measured_force_n;
    let changes = force.windows(2).map(|pair| (pair[1] - pair[0]).powi(2));
    std::iter::once(0.0).take(force.len()).chain(changes).collect()
}

pub(super) fn range(values: &[f64]) -> (f64, f64) {
    let ends = (f64::INFINITY, f64::NEG_INFINITY);
    values.iter().fold(ends, |(low, high), value| (low.min(*value), high.max(*value)))
}

pub(super) fn mean_and_variance(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    let mut moments = Moments::default();
    values.into_iter().for_each(|value| moments.add(value));
    (moments.mean, moments.squares / moments.count.max(1) as f64)
}

/// In teleoperation only.
pub(super) fn tracking_error_m(run: &Run, (from_s, to_s): (f64, f64)) -> f64 {
    let trace = &run.trace;
    let ticks = tick(run, from_s)..=tick(run, to_s);
    let errors = ticks.filter(|tick| trace.mode[*tick] == 0);
    errors.map(|tick| (trace.master_position_m[tick] - trace.slave_position_m[tick]).abs()).fold(0.0, f64::max)
}
