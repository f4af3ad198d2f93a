//! The animation of a rupture: needle, tissue, hand and felt force of one or two runs around their first rupture.
//!
//! [`Animation`] holds all positions, forces and modes at the times of its frames. `assets/animation.js` draws it on pages, and
//! `paint.rs` as an animated picture; neither computes anything but places on its paper.

mod paint;
mod tissue;

use serde::Serialize;

use crate::digits::{Few, Fine};
use crate::number::show;
use tissue::nearest;
pub use tissue::{DrawnTissue, Layer};
use trocar_engine::metrics::{Outcome, RUPTURE_WINDOW_S, Unit};
use trocar_studies::run::Run;

/// Displayed time before the rupture, in s. The time after it is that of the metric "overshoot in 0.5 s".
const BEFORE_S: f64 = 0.1;

/// Number of frames, which are 62.5 per second at a quarter of the speed.
const FRAMES: usize = 151;

/// How much slower than the run the animation plays.
const SLOWNESS: f64 = 4.0;

/// Time for which a rupture is named, in s.
const RUPTURING_S: f64 = 0.06;

/// Part of the drawn range above and below the motion.
const MARGIN: f64 = 0.12;

/// How far above the motion a surface is drawn, relative to the motion.
const MAX_BULGE_SHARE: f64 = 2.5;

/// Smallest drawn range of depths, in mm.
const MIN_RANGE_MM: f64 = 4.0;

/// The animation of one or two runs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Animation {
    /// What it shows.
    title: String,
    /// The times of the frames in s.
    time_s: Vec<Fine>,
    /// The time of the first rupture; without one, that of the largest tissue force.
    origin_s: Fine,
    /// What happens at the origin: `rupture` or `largest force`.
    origin: &'static str,
    slowness: f64,
    /// The frame that is displayed at rest.
    still: usize,
    /// The drawn depths in mm, of needle and hand.
    range_mm: [Few; 2],
    /// The force of a full bar in N.
    max_force_n: Few,
    panels: Vec<Panel>,
}

/// One run of an animation. Each list has one value per frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct Panel {
    name: String,
    /// `classical` or `augmented`.
    scheme: &'static str,
    layers: Vec<Layer>,
    /// The depth of each layer's top at the needle, in mm; a list per frame.
    tops_mm: Vec<Vec<Few>>,
    tip_mm: Vec<Few>,
    /// The position of the hand in mm, in the scale of the needle.
    hand_mm: Vec<Few>,
    /// The force on the hand in N.
    felt_n: Vec<Few>,
    mode: Vec<u8>,
    rupture: Option<Overshoot>,
    /// What the viewer should know, such as a missed rupture.
    note: String,
}

/// The advance after the first rupture.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct Overshoot {
    time_s: Fine,
    /// The place of the tip at the rupture in mm.
    from_mm: Few,
    /// The maximum advance so far in mm; a value per frame.
    reached_mm: Vec<Few>,
    /// The metric with its unit.
    text: String,
}

impl Animation {
    /// Returns the animation of the first two of some runs; `None` if a run has no ticks.
    #[must_use]
    pub fn of(runs: &[&Run]) -> Option<Self> {
        let runs = &runs[..runs.len().min(2)];
        let first = *runs.first()?;
        if runs.iter().any(|run| run.trace.is_empty()) {
            return None;
        }
        let ruptures_s = runs.iter().filter_map(|run| Some(run.metrics.ruptures.first()?.time_s));
        let rupture_s = ruptures_s.reduce(f64::min);
        let origin_s = rupture_s.unwrap_or_else(|| time_of_largest_force(first));
        let end_s = runs.iter().filter_map(|run| run.trace.time_s.last().copied()).fold(0.0, f64::max);
        let length_s = BEFORE_S + RUPTURE_WINDOW_S;
        let from_s = (origin_s - BEFORE_S).min(end_s - length_s).max(0.0);
        let wanted_s = (0..FRAMES).map(|frame| from_s + length_s * frame as f64 / (FRAMES - 1) as f64);
        let times_s = &runs.iter().max_by_key(|run| run.trace.len())?.trace.time_s;
        let mut ticks: Vec<usize> = wanted_s.map(|time_s| nearest(times_s, time_s).min(times_s.len() - 1)).collect();
        ticks.dedup();
        let panels: Vec<Panel> = runs.iter().map(|run| Panel::new(run, &ticks)).collect();
        let positions_mm = panels.iter().flat_map(|panel| panel.tip_mm.iter().chain(&panel.hand_mm));
        let ends = |(low, high): (f64, f64), mm: f64| (low.min(mm), high.max(mm));
        let (low, high) = positions_mm.map(|mm| mm.0).filter(|mm| mm.is_finite()).fold((f64::MAX, f64::MIN), ends);
        let (low, high) = if low < high { (low, high) } else { (low.min(0.0), low.min(0.0) + MIN_RANGE_MM) };
        // The surface under the needle is drawn too, if the motion then still is a good part of the picture.
        let tops = panels.iter().filter_map(|panel| panel.surface_mm(low));
        let low = tops.filter(|top| *top > low - MAX_BULGE_SHARE * (high - low)).fold(low, f64::min);
        let margin = MARGIN * (high - low).max(MIN_RANGE_MM);
        let forces = panels.iter().flat_map(|panel| &panel.felt_n).map(|force| force.0.abs());
        Some(Self {
            title: match rupture_s {
                Some(_) => format!("{length_s} s around the first rupture, four times slower"),
                None => format!("No layer ruptures: {length_s} s around the largest tissue force, four times slower"),
            },
            time_s: ticks.iter().map(|tick| Fine(times_s[*tick])).collect(),
            origin_s: Fine(origin_s),
            origin: if rupture_s.is_some() { "rupture" } else { "largest force" },
            slowness: SLOWNESS,
            still: ticks.len() - 1,
            range_mm: [Few(low - margin), Few(high + margin)],
            max_force_n: Few(forces.filter(|force| force.is_finite()).fold(1e-3, f64::max)),
            panels,
        })
    }

    /// Returns the time in s of the first rupture; without one, that of the largest tissue force.
    #[must_use]
    pub fn origin_s(&self) -> f64 {
        self.origin_s.0
    }
}

impl Panel {
    /// Returns the deepest top above a depth in mm: that of the layer in which the motion begins.
    fn surface_mm(&self, depth_mm: f64) -> Option<f64> {
        self.layers.iter().map(|layer| layer.top_mm.0).filter(|top| *top < depth_mm).reduce(f64::max)
    }

    fn new(run: &Run, ticks: &[usize]) -> Self {
        let (trace, scenario) = (&run.trace, &run.scenario);
        // A run that diverged ends earlier than the other one.
        let last = trace.len() - 1;
        let of =
            |column: &[f64], factor: f64| ticks.iter().map(|tick| Few(factor * column[(*tick).min(last)])).collect();
        let tip_mm: Vec<Few> = of(&trace.slave_position_m, 1e3);
        let mut tissue = DrawnTissue::of_run(run);
        let tops_mm = ticks.iter().zip(&tip_mm).map(|(tick, tip)| {
            tissue.step(trace.time_s[(*tick).min(last)], tip.0);
            tissue.depths_mm().iter().map(|mm| Few(*mm)).collect()
        });
        let tops_mm = tops_mm.collect();
        Self {
            name: scenario.name.clone(),
            scheme: if scenario.augmentation.enabled { "augmented" } else { "classical" },
            layers: tissue.layers().to_vec(),
            tops_mm,
            hand_mm: of(&trace.master_position_m, 1e3 * scenario.position_scale()),
            felt_n: of(&trace.operator_force_n, 1.0),
            mode: ticks.iter().map(|tick| trace.mode[(*tick).min(last)]).collect(),
            rupture: Overshoot::of(run, ticks),
            note: note(run),
            tip_mm,
        }
    }

    /// Returns the state at a frame, as the page names it.
    fn state(&self, frame: usize, time_s: f64) -> &'static str {
        let after_s = self.rupture.as_ref().map(|rupture| time_s - rupture.time_s.0);
        match self.mode[frame] {
            1 => "frozen",
            2 => "re-engaging",
            _ if after_s.is_some_and(|after_s| (0.0..RUPTURING_S).contains(&after_s)) => "rupture",
            _ => "teleoperation",
        }
    }
}

impl Overshoot {
    fn of(run: &Run, ticks: &[usize]) -> Option<Self> {
        let rupture = run.metrics.ruptures.first()?;
        let tip_m = &run.trace.slave_position_m;
        let at = nearest(&run.trace.time_s, rupture.time_s);
        let from_m = *tip_m.get(at)?;
        let (mut reached_m, mut next) = (0.0_f64, at);
        let reached = ticks.iter().map(|tick| {
            while next <= *tick && next < tip_m.len() {
                reached_m = reached_m.max(tip_m[next] - from_m);
                next += 1;
            }
            Few(1e3 * reached_m)
        });
        Some(Self {
            time_s: Fine(rupture.time_s),
            from_mm: Few(1e3 * from_m),
            reached_mm: reached.collect(),
            text: show(rupture.slave_overshoot_m, Unit::Metre),
        })
    }
}

/// Returns what the viewer should know about a run: it diverged, or its supervisor missed the rupture.
fn note(run: &Run) -> String {
    if let Outcome::Diverged { time_s } = run.metrics.outcome {
        return format!("diverges at {time_s} s");
    }
    let miss = run.metrics.ruptures.first().and_then(|rupture| rupture.miss.as_ref());
    match miss.filter(|_| run.scenario.augmentation.enabled) {
        Some(miss) => format!("rupture missed: {}", miss.reason),
        None => String::new(),
    }
}

fn time_of_largest_force(run: &Run) -> f64 {
    let forces = run.trace.tissue_force_n.iter().zip(&run.trace.time_s);
    forces.max_by(|a, b| a.0.total_cmp(b.0)).map_or(0.0, |(_, time_s)| *time_s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use trocar_scenario::{Scenario, Source};
    use trocar_studies::run::run;

    fn shipped(name: &str) -> Run {
        run(Scenario::load(&Source::Builtin(name.into()), &[]).expect("a scenario")).expect("a run")
    }

    #[test]
    fn the_frames_are_those_of_the_trace_and_the_overshoot_is_the_metric() {
        for (classical, augmented) in [
            ("paper/classical.toml", "paper/augmented.toml"),
            ("layers/through-the-skin.toml", "layers/skin-augmented.toml"),
        ] {
            let runs = [shipped(classical), shipped(augmented)];
            let animation = Animation::of(&[&runs[0], &runs[1]]).expect("an animation");
            assert_eq!(animation.time_s.len(), FRAMES);
            for (panel, run) in animation.panels.iter().zip(&runs) {
                let rupture = &run.metrics.ruptures[0];
                let overshoot = panel.rupture.as_ref().expect("a rupture");
                assert_eq!(overshoot.time_s.0, rupture.time_s);
                let reached_mm = overshoot.reached_mm[FRAMES - 1].0;
                assert!((reached_mm - 1e3 * rupture.slave_overshoot_m.expect("a whole window")).abs() < 1e-9);
                assert_eq!(overshoot.text, show(rupture.slave_overshoot_m, Unit::Metre));
                for (frame, time_s) in animation.time_s.iter().enumerate() {
                    let tick = run.trace.time_s.iter().position(|tick_s| *tick_s == time_s.0).expect("a tick");
                    assert_eq!(panel.tip_mm[frame].0, 1e3 * run.trace.slave_position_m[tick]);
                    assert_eq!(panel.felt_n[frame].0, run.trace.operator_force_n[tick]);
                    assert_eq!(panel.mode[frame], run.trace.mode[tick]);
                }
                // Under load the layer lies at the tip; after the rupture it returns above the tip.
                let layer = panel.layers.iter().position(|layer| layer.torn_s.is_some()).expect("a torn layer");
                assert!((panel.tops_mm[0][layer].0 - panel.tip_mm[0].0).abs() < 1e-9);
                let (last, top) = (&panel.tops_mm[FRAMES - 1], panel.layers[layer].top_mm.0);
                assert!((last[layer].0 - top).abs() < 0.01 && top < panel.tip_mm[FRAMES - 1].0 - 1.0);
                // No top crosses the one above it.
                assert!(panel.tops_mm.iter().all(|tops| tops.is_sorted_by(|above, below| above.0 <= below.0)));
            }
            let png = animation.png().expect("a picture");
            let reader = png::Decoder::new(std::io::Cursor::new(&png)).read_info().expect("a PNG file");
            assert_eq!(reader.info().animation_control().map(|control| control.num_frames), Some(51));
            assert!(png.len() < 1_000_000, "{} bytes", png.len());
        }
    }

    #[test]
    fn without_a_rupture_the_largest_force_is_shown() {
        let run = shipped("passivity/late-wall.toml");
        let animation = Animation::of(&[&run]).expect("an animation");
        assert!(animation.title.starts_with("No layer ruptures: "), "{}", animation.title);
        assert!(animation.panels[0].rupture.is_none() && animation.panels[0].layers.len() == 1);
        assert_eq!(animation.panels[0].layers[0].top_mm.0, 5.0, "tissue.contact_m of the scenario");
        assert!(animation.png().is_ok());
        let mut empty = run;
        empty.trace = trocar_engine::engine::Trace::new(empty.scenario.grid);
        assert_eq!(Animation::of(&[&empty]), None);
    }
}
