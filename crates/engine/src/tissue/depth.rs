use std::sync::Arc;

use super::{Reaction, Springs, Tissue};
use trocar_core::error::{InvalidValue, positive};
use trocar_core::lane::{Lane, Mask};

const STEP_M: f64 = 1e-5;

/// Noise dominates over shorter distances.
pub const RISE_M: f64 = 5e-4;

const MAX_ENTRIES: usize = 1_000_000;

fn first_passages(samples: impl Iterator<Item = (f64, f64)>, from_m: f64, entries: usize) -> Vec<f64> {
    let mut force_n: Vec<f64> = Vec::with_capacity(entries);
    let mut last: Option<(f64, f64)> = None;
    for (position, force) in samples {
        let (deepest, last_force) = *last.get_or_insert((position, force));
        while force_n.len() < entries {
            let depth = from_m + force_n.len() as f64 * STEP_M;
            if depth > position {
                break;
            }
            let share = if position > deepest { ((depth - deepest) / (position - deepest)).max(0.0) } else { 0.0 };
            force_n.push(last_force + share * (force - last_force));
        }
        if position >= deepest {
            last = Some((position, force));
        }
    }
    force_n.resize(entries, last.map_or(0.0, |(_, force)| force));
    force_n
}

/// Linear between the entries of a regular grid; outside, the nearest entry applies.
#[derive(Debug, Clone, PartialEq)]
pub struct DepthCurves {
    from_m: f64,
    entries_n: Vec<[f64; 2]>,
}

impl DepthCurves {
    /// Samples in time order, within 10 m; the withdrawal's force is limited to the insertion's.
    pub fn new(position_m: &[f64], force_n: &[f64]) -> Result<Self, InvalidValue> {
        let min_m = position_m.iter().copied().fold(f64::INFINITY, f64::min);
        let max_m = position_m.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let span = max_m - min_m;
        let allowed = span.is_finite() && span / STEP_M < MAX_ENTRIES as f64;
        trocar_core::error::require("tissue.index", span, allowed, "by time for a recording of more than 10 m")?;
        let entries = (span / STEP_M) as usize + 2;
        let samples = || position_m.iter().copied().zip(force_n.iter().copied());
        let way_in = first_passages(samples(), min_m, entries);
        let way_out = first_passages(samples().rev(), min_m, entries);
        let entries_n = way_in.into_iter().zip(way_out).map(|(within, out)| [within, out.min(within)]).collect();
        Ok(Self { from_m: min_m, entries_n })
    }

    #[inline(always)]
    fn at<L: Lane>(&self, depth_m: L) -> [L; 2] {
        let last = self.entries_n.len() - 1;
        let place = (depth_m - L::splat(self.from_m)) / L::splat(STEP_M);
        let place = place.max(L::zero()).min(L::splat(last as f64));
        let index = |lane: usize| (place.lane(lane) as usize).min(last - 1);
        let share = place - L::from_lanes(|lane| index(lane) as f64);
        [0, 1].map(|way| {
            let here = L::from_lanes(|lane| self.entries_n[index(lane)][way]);
            let next = L::from_lanes(|lane| self.entries_n[index(lane) + 1][way]);
            here + share * (next - here)
        })
    }

    /// While drawn back, the force also changes to the withdrawal's.
    pub fn springs(&self, presliding_m: f64, until_m: f64) -> Springs {
        let entries = (RISE_M / STEP_M).round() as usize;
        let reached = ((until_m - self.from_m) / STEP_M).ceil().max(0.0) as usize;
        let (mut advancing, mut drawn_back) = (0.0_f64, 0.0_f64);
        for (from, to) in self.entries_n.iter().zip(self.entries_n.iter().skip(entries)).take(reached) {
            let [rise, rise_out] = [0, 1].map(|way| (to[way] - from[way]) / RISE_M);
            advancing = advancing.max(rise);
            let change_n = (from[0] - from[1]).max(to[0] - to[1]);
            drawn_back = drawn_back.max(rise.max(rise_out).max(0.0) + change_n / presliding_m);
        }
        Springs { drawn_back_n_per_m: drawn_back, ..Springs::between((0.0, advancing), (0.0, 0.0)) }
    }

    pub fn tables_n(&self) -> [Vec<f64>; 2] {
        [0, 1].map(|way| self.entries_n.iter().map(|forces| forces[way]).collect())
    }
}

/// The recorded force by depth `x`, with the largest depth so far `D`:
///
/// ```text
/// f = out(x) + s (min(in(x), in(D)) - out(x)),  s = max(1 - (D - x) / presliding, 0)
/// ```
/// `out` never exceeds `in`, so the tissue dissipates energy over any closed motion. The relaxation at rest is not
/// reproduced.
#[derive(Debug, Clone)]
pub struct DepthReplay<L> {
    curves: Arc<DepthCurves>,
    rupture_depths_m: Arc<[f64]>,
    inverse_presliding: L,
    deepest_m: L,
    deepest_n: L,
}

impl<L: Lane> DepthReplay<L> {
    pub fn new(
        curves: Arc<DepthCurves>,
        rupture_depths_m: Arc<[f64]>,
        presliding_m: f64,
        start_m: f64,
    ) -> Result<Self, InvalidValue> {
        positive("tissue.presliding_m", presliding_m)?;
        let inverse_presliding = L::splat(1.0 / presliding_m);
        let deepest_m = L::splat(start_m);
        let [deepest_n, _] = curves.at(deepest_m);
        Ok(Self { curves, rupture_depths_m, inverse_presliding, deepest_m, deepest_n })
    }
}

impl<L: Lane> Tissue<L> for DepthReplay<L> {
    #[inline(always)]
    fn react(&mut self, _tick: u64, position_m: L, _velocity_m_per_s: L) -> Reaction<L> {
        let one = L::splat(1.0);
        let before = self.deepest_m;
        self.deepest_m = position_m.max(before);
        let retreat = self.deepest_m - position_m;
        let share_in = (one - retreat * self.inverse_presliding).max(L::zero());
        let [inserted, unloaded] = self.curves.at(position_m);
        self.deepest_n = L::select(position_m.ge(before), inserted, self.deepest_n);
        let loaded = inserted.min(self.deepest_n);
        let force_n = unloaded + share_in * (loaded - unloaded).max(L::zero());
        let mut ruptured = L::Mask::splat(false);
        for &depth in self.rupture_depths_m.iter() {
            ruptured = ruptured | (before.lt(L::splat(depth)) & self.deepest_m.ge(L::splat(depth)));
        }
        Reaction { force_n, ruptured }
    }
}

impl trocar_core::lane::Gather for DepthReplay<f64> {
    type Of<L: Lane> = DepthReplay<L>;

    fn gather<L: Lane>(all: [&Self; trocar_core::lane::LANES]) -> Option<DepthReplay<L>> {
        use trocar_core::lane::{Gather, same_list};
        let equal = same_list(trocar_core::lane::of_each!(all, |one| &one.rupture_depths_m))
            && all.iter().all(|one| Arc::ptr_eq(&one.curves, &all[0].curves) || one.curves == all[0].curves);
        if !equal {
            return None;
        }
        Some(DepthReplay {
            curves: all[0].curves.clone(),
            rupture_depths_m: all[0].rupture_depths_m.clone(),
            inverse_presliding: Gather::gather(trocar_core::lane::of_each!(all, |one| &one.inverse_presliding))?,
            deepest_m: Gather::gather(trocar_core::lane::of_each!(all, |one| &one.deepest_m))?,
            deepest_n: Gather::gather(trocar_core::lane::of_each!(all, |one| &one.deepest_n))?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An insertion to 10 mm with 100 N/m and a rupture at 6 mm, and a withdrawal with a pull of 0.2 N.
    fn recording() -> (Vec<f64>, Vec<f64>) {
        let way_in = (0..=100).map(|k| 1e-4 * f64::from(k));
        let way_out = (0..100).rev().map(|k| 1e-4 * f64::from(k));
        let load = |p: f64| if p <= 6e-3 { 100.0 * p } else { 100.0 * (p - 6e-3) };
        let force = way_in.clone().map(load).chain(way_out.clone().map(|_| -0.2)).collect();
        (way_in.chain(way_out).collect(), force)
    }

    fn tissue() -> DepthReplay<f64> {
        let (position, force) = recording();
        let curves = DepthCurves::new(&position, &force).expect("valid");
        DepthReplay::new(Arc::new(curves), Arc::from([6e-3]), 1e-3, 0.0).expect("valid")
    }

    #[test]
    fn the_force_of_the_insertion_is_the_recorded_one_and_constant_on_a_frozen_needle() {
        let mut tissue = tissue();
        for k in 0..59 {
            let depth = 1e-4 * f64::from(k);
            let reaction = tissue.react(0, depth, 0.0);
            assert!((reaction.force_n - 100.0 * depth).abs() < 1e-9 && !reaction.ruptured, "{depth}");
        }
        let held = tissue.react(0, 5.9e-3, 0.0).force_n;
        assert!((0..1000).all(|_| tissue.react(0, 5.9e-3, 0.0).force_n == held));
    }

    #[test]
    fn a_layer_ruptures_once_at_its_depth() {
        let mut tissue = tissue();
        let depths = (0..80).chain((0..80).rev()).chain(0..100).map(|k| 1e-4 * f64::from(k));
        let ruptures: Vec<f64> = depths.filter(|&depth| tissue.react(0, depth, 0.0).ruptured).collect();
        assert_eq!(ruptures.len(), 1);
        assert!((ruptures[0] - 6e-3).abs() < 1e-9);
    }

    #[test]
    fn a_retreat_changes_to_the_force_of_the_withdrawal_and_back() {
        let mut tissue = tissue();
        let deep = tissue.react(0, 5e-3, 0.0).force_n;
        let half = tissue.react(0, 4.5e-3, 0.0).force_n;
        assert!((deep - 0.5).abs() < 1e-9 && (half - (-0.2 + 0.5 * 0.65)).abs() < 1e-9, "{deep} {half}");
        assert!((tissue.react(0, 3e-3, 0.0).force_n + 0.2).abs() < 1e-9);
        assert_eq!(tissue.react(0, 4.5e-3, 0.0).force_n, half);
        assert!((tissue.react(0, 5.5e-3, 0.0).force_n - 0.55).abs() < 1e-9);
    }

    #[test]
    fn beyond_the_recording_the_last_force_applies() {
        assert!((tissue().react(0, 0.5, 0.0).force_n - 0.4).abs() < 1e-9);
        assert!((tissue().react(0, -0.5, 0.0).force_n + 0.2).abs() < 1e-9, "a retreat from the start is a way out");
    }

    #[test]
    fn the_steepest_rise_is_over_half_a_millimetre() {
        // 1 N over 2 mm, with a step of 0.1 N in between.
        let position: Vec<f64> = (0..=200).map(|k| 1e-5 * f64::from(k)).collect();
        let force: Vec<f64> = position.iter().map(|p| 500.0 * p + if *p > 1e-3 { 0.1 } else { 0.0 }).collect();
        let curves = DepthCurves::new(&position, &force).expect("valid");
        let (_, rise) = curves.springs(2e-3, 1.0).stiffness_n_per_m;
        assert!((rise - (500.0 + 0.1 / RISE_M)).abs() < 1e-6, "{rise}");
    }

    #[test]
    fn the_springs_bound_every_slope_of_the_force_on_any_way() {
        let (position, force) = recording();
        let curves = Arc::new(DepthCurves::new(&position, &force).expect("valid"));
        for presliding_m in [5e-4, 2e-3, 8e-3] {
            let Springs { stiffness_n_per_m: (_, advancing), drawn_back_n_per_m, .. } =
                curves.springs(presliding_m, 1.0);
            assert!((advancing - 100.0).abs() < 1e-6, "{advancing}");
            let (mut largest, step_m) = (0.0_f64, RISE_M);
            // Up to twice the recorded depth: the steep end of the withdrawal acts on a needle that was deeper.
            for deepest in 1..=40 {
                let mut tissue =
                    DepthReplay::<f64>::new(curves.clone(), Arc::from([]), presliding_m, 0.0).expect("valid");
                let mut last_n = tissue.react(0, step_m * f64::from(deepest), 0.0).force_n;
                for back in (0..deepest).rev() {
                    let force_n = tissue.react(0, step_m * f64::from(back), 0.0).force_n;
                    largest = largest.max((last_n - force_n) / step_m);
                    last_n = force_n;
                }
            }
            assert!(
                largest <= drawn_back_n_per_m && drawn_back_n_per_m < 1.5 * largest,
                "{largest} {drawn_back_n_per_m}"
            );
        }
    }

    #[test]
    fn the_tables_contain_the_force_at_the_first_passage_of_each_depth() {
        // In to 3 steps, back by 2, in to 5; then out with half of the force.
        let position = [0.0, 1e-5, 3e-5, 1e-5, 5e-5, 0.0];
        let force = [1.0, 2.0, 4.0, 9.0, 8.0, 0.5];
        let curves = DepthCurves::new(&position, &force).expect("valid");
        let [way_in, way_out] = curves.tables_n();
        let is_close = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9);
        // Depths 4 and 5 are reached between 3 steps at 4 N and 5 steps at 8 N.
        assert!(is_close(&way_in[..6], &[1.0, 2.0, 3.0, 4.0, 6.0, 8.0]), "{way_in:?}");
        // On the way out each depth is last passed between 5 steps at 8 N and 0 at 0.5 N, limited to the way in.
        assert!(is_close(&way_out[..6], &[0.5, 2.0, 3.0, 4.0, 6.0, 8.0]), "{way_out:?}");
    }

    #[test]
    fn a_recording_of_more_than_10_m_is_refused() {
        assert!(DepthCurves::new(&[0.0, 9.9], &[0.0, 1.0]).is_ok());
        assert_eq!(DepthCurves::new(&[0.0, 10.1], &[0.0, 1.0]).expect_err("too long").name, "tissue.index");
        assert!(DepthCurves::new(&[0.0, f64::NAN], &[0.0, 1.0]).is_ok(), "the extremes ignore what is no number");
        assert!(DepthCurves::new(&[], &[]).is_err());
    }
}
