//! The animation of a rupture: needle, tissue, hand and felt force of one or two runs around their first rupture.
//!
//! [`Animation`] is a description: the shapes of each frame in one coordinate system. `assets/animation.js` places them on pages, and
//! `paint.rs` on an animated picture.

mod paint;
mod scene;
mod tissue;

use serde::Serialize;
use serde_json::Value as Json;

use crate::digits::Fine;
use scene::{Form, Moment, Scene, mode_name, tracks};
pub use scene::{LiveDrawing, LiveMoment};
use tissue::nearest;
pub use tissue::{DrawnTissue, Layer};
use trocar_document::show;
use trocar_metrics::{Outcome, RUPTURE_WINDOW_S, Unit};
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
#[derive(Clone, Debug, Serialize)]
pub struct Animation {
    /// What it shows.
    title: String,
    /// The times of the frames in s.
    time_s: Vec<Fine>,
    /// The time of each frame in words.
    clocks: Vec<String>,
    /// The time of the first rupture; without one, that of the largest tissue force.
    #[serde(skip)]
    origin_s: f64,
    slowness: f64,
    /// The frame that is displayed at rest.
    still: usize,
    /// The drawn depths in mm, of needle and hand.
    #[serde(skip)]
    range_mm: (f64, f64),
    /// The force of a full bar in N.
    #[serde(skip)]
    max_force_n: f64,
    panels: Vec<Panel>,
}

/// One run of an animation. Each list has one value per frame.
#[derive(Clone, Debug, Serialize)]
struct Panel {
    name: String,
    /// `classical` or `augmented`.
    scheme: &'static str,
    /// What the viewer should know, such as a missed rupture.
    note: String,
    /// The text alternative.
    alt: String,
    states: Vec<&'static str>,
    /// The shapes in a wide and in a narrow drawing.
    drawings: Vec<Json>,
    #[serde(skip)]
    layers: Vec<Layer>,
    #[serde(skip)]
    moments: Vec<Moment>,
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
        let panels: Vec<Panel> = runs.iter().map(|run| Panel::new(run, times_s, &ticks)).collect();
        let moments = || panels.iter().flat_map(|panel| &panel.moments);
        let positions_mm = moments().flat_map(|now| [now.tip_mm, now.hand_mm]);
        let ends = |(low, high): (f64, f64), mm: f64| (low.min(mm), high.max(mm));
        let (low, high) = positions_mm.filter(|mm| mm.is_finite()).fold((f64::MAX, f64::MIN), ends);
        let (low, high) = if low < high { (low, high) } else { (low.min(0.0), low.min(0.0) + MIN_RANGE_MM) };
        // The surface under the needle is drawn too, if the motion then still is a good part of the picture.
        let tops = panels.iter().filter_map(|panel| panel.surface_mm(low));
        let low = tops.filter(|top| *top > low - MAX_BULGE_SHARE * (high - low)).fold(low, f64::min);
        let margin = MARGIN * (high - low).max(MIN_RANGE_MM);
        let forces = moments().map(|now| now.felt_n.abs()).filter(|force| force.is_finite());
        let bracket = if rupture_s.is_some() { " The bracket is the overshoot in 0.5 s." } else { "" };
        let shown = match rupture_s {
            Some(_) => format!("{length_s} s around the first rupture, four times slower."),
            None => format!("No layer ruptures: {length_s} s around the largest tissue force, four times slower."),
        };
        let origin = if rupture_s.is_some() { "rupture" } else { "largest force" };
        let clock = |tick: &usize| {
            let after_ms = (1e3 * (times_s[*tick] - origin_s)).round();
            format!("{} ms {} the {origin}", after_ms.abs(), if after_ms < 0.0 { "before" } else { "after" })
        };
        let mut animation = Self {
            title: format!("{shown}{bracket}"),
            time_s: ticks.iter().map(|tick| Fine(times_s[*tick])).collect(),
            clocks: ticks.iter().map(clock).collect(),
            origin_s,
            slowness: SLOWNESS,
            still: ticks.len() - 1,
            range_mm: (low - margin, high + margin),
            max_force_n: forces.fold(1e-3, f64::max),
            panels: vec![],
        };
        let described = |panel: Panel| {
            let drawing = |form| {
                let scene = animation.scene(&panel, form);
                tracks(form, panel.moments.iter().map(|now| scene.shapes(now)))
            };
            Panel { drawings: Form::PAGE.map(drawing).into(), ..panel }
        };
        animation.panels = panels.into_iter().map(described).collect();
        Some(animation)
    }

    /// Returns the time in s of the first rupture; without one, that of the largest tissue force.
    #[must_use]
    pub fn origin_s(&self) -> f64 {
        self.origin_s
    }

    fn scene<'a>(&self, panel: &'a Panel, form: Form) -> Scene<'a> {
        Scene { form, layers: &panel.layers, range_mm: self.range_mm, max_force_n: self.max_force_n }
    }
}

impl Panel {
    /// Returns the deepest top above a depth in mm: that of the layer in which the motion begins.
    fn surface_mm(&self, depth_mm: f64) -> Option<f64> {
        self.layers.iter().map(|layer| layer.top_mm.0).filter(|top| *top < depth_mm).reduce(f64::max)
    }

    /// Returns the panel of a run at some ticks of a time axis, without its shapes.
    fn new(run: &Run, times_s: &[f64], ticks: &[usize]) -> Self {
        let (trace, scenario) = (&run.trace, &run.scenario);
        // A run that diverged ends earlier than the other one.
        let last = trace.len() - 1;
        let mut tissue = DrawnTissue::of_run(run);
        let overshoot = Overshoot::of(run);
        let (mut moments, mut states) = (vec![], vec![]);
        for &tick in ticks {
            let (time_s, at) = (times_s[tick], tick.min(last));
            let tip_mm = 1e3 * trace.slave_position_m[at];
            tissue.step(trace.time_s[at], tip_mm);
            let mode = trace.mode[at];
            let after_s = overshoot.as_ref().map(|overshoot| time_s - overshoot.time_s);
            let is_rupturing = mode == 0 && after_s.is_some_and(|after_s| (0.0..RUPTURING_S).contains(&after_s));
            states.push(if is_rupturing { "rupture" } else { mode_name(mode) });
            moments.push(Moment {
                tip_mm,
                hand_mm: 1e3 * scenario.position_scale() * trace.master_position_m[at],
                felt_n: trace.operator_force_n[at],
                mode,
                tops_mm: tissue.depths_mm().to_vec(),
                torn: tissue.layers().iter().map(|layer| layer.torn_s.is_some_and(|torn| torn.0 <= time_s)).collect(),
                overshoot: overshoot.as_ref().filter(|overshoot| overshoot.time_s <= time_s).map(|one| one.at(tick)),
            });
        }
        // The last frame has the metric, with all its digits.
        if let (Some(metric), Some(reached_mm)) = (overshoot.as_ref(), moments.last().and_then(reached_mm)) {
            for (.., text) in
                moments.iter_mut().filter_map(|now| now.overshoot.as_mut()).filter(|now| now.1 == reached_mm)
            {
                text.clone_from(&metric.text);
            }
        }
        let note = note(run);
        let advance = overshoot.as_ref().map_or(String::new(), |overshoot| {
            format!(" The needle advances by {} in the 0.5 s after the rupture.", overshoot.text)
        });
        Self {
            name: scenario.name.clone(),
            scheme: if scenario.augmentation.enabled { "augmented" } else { "classical" },
            alt: format!("Needle, tissue and hand of the run {}.{advance} {note}", scenario.name),
            note,
            states,
            drawings: vec![],
            layers: tissue.layers().to_vec(),
            moments,
        }
    }
}

fn reached_mm(now: &Moment) -> Option<f64> {
    now.overshoot.as_ref().map(|overshoot| overshoot.1)
}

/// The advance after the first rupture.
struct Overshoot<'a> {
    time_s: f64,
    tip_m: &'a [f64],
    /// The tick of the rupture.
    from: usize,
    /// The metric with its unit.
    text: String,
}

impl<'a> Overshoot<'a> {
    fn of(run: &'a Run) -> Option<Self> {
        let rupture = run.metrics.ruptures.first()?;
        let from = nearest(&run.trace.time_s, rupture.time_s);
        let text = show(rupture.slave_overshoot_m, Unit::Metre);
        (from < run.trace.len()).then_some(Self {
            time_s: rupture.time_s,
            tip_m: &run.trace.slave_position_m,
            from,
            text,
        })
    }

    /// Returns the place of the tip at the rupture, the maximum advance until a tick in mm, and its text.
    fn at(&self, tick: usize) -> (f64, f64, String) {
        let from_m = self.tip_m[self.from];
        let until = (tick + 1).clamp(self.from + 1, self.tip_m.len());
        let reached_m = self.tip_m[self.from..until].iter().map(|tip_m| tip_m - from_m).fold(0.0, f64::max);
        (1e3 * from_m, 1e3 * reached_m, format!("{:.1} mm", 1e3 * reached_m))
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
                let last = &panel.moments[FRAMES - 1];
                let (_, reached_mm, text) = last.overshoot.as_ref().expect("a rupture");
                assert!((reached_mm - 1e3 * rupture.slave_overshoot_m.expect("a whole window")).abs() < 1e-9);
                assert_eq!(*text, show(rupture.slave_overshoot_m, Unit::Metre));
                for (now, time_s) in panel.moments.iter().zip(&animation.time_s) {
                    let tick = run.trace.time_s.iter().position(|tick_s| *tick_s == time_s.0).expect("a tick");
                    assert_eq!(now.tip_mm, 1e3 * run.trace.slave_position_m[tick]);
                    assert_eq!(now.felt_n, run.trace.operator_force_n[tick]);
                    assert_eq!(now.mode, run.trace.mode[tick]);
                    assert_eq!(now.overshoot.is_some(), time_s.0 >= rupture.time_s);
                }
                // Under load the layer lies at the tip; after the rupture it returns above the tip.
                let layer = panel.layers.iter().position(|layer| layer.torn_s.is_some()).expect("a torn layer");
                let first = &panel.moments[0];
                assert!((first.tops_mm[layer] - first.tip_mm).abs() < 1e-9);
                let top = panel.layers[layer].top_mm.0;
                assert!((last.tops_mm[layer] - top).abs() < 0.01 && top < last.tip_mm - 1.0);
                // No top crosses the one above it.
                assert!(panel.moments.iter().all(|now| now.tops_mm.is_sorted()));
            }
            let png = animation.png().expect("a picture");
            let reader = png::Decoder::new(std::io::Cursor::new(&png)).read_info().expect("a PNG file");
            assert_eq!(reader.info().animation_control().map(|control| control.num_frames), Some(51));
            assert!(png.len() < 1_000_000, "{} bytes", png.len());
            let json = serde_json::to_string(&animation).expect("JSON");
            assert!(json.len() < 300_000, "{} bytes", json.len());
        }
    }

    #[test]
    fn a_page_has_the_tip_of_each_frame() {
        let run = shipped("paper/augmented.toml");
        let animation = Animation::of(&[&run]).expect("an animation");
        let panel = &animation.panels[0];
        for (drawing, form) in panel.drawings.iter().zip(Form::PAGE) {
            let shapes = drawing["shapes"].as_array().expect("shapes");
            let needle = shapes.iter().find(|shape| shape["role"] == "needle").expect("a needle");
            let per_mm = (form.height - 44.0) / (animation.range_mm.1 - animation.range_mm.0);
            let mut drawn = 0.0;
            for (frame, now) in panel.moments.iter().enumerate() {
                let states = needle["states"].as_array().expect("states");
                let state = states.iter().find(|state| state[0].as_u64() == Some(frame as u64));
                drawn = state.and_then(|state| state[1][1].as_f64()).unwrap_or(drawn);
                let expected = 22.0 + per_mm * (now.tip_mm - animation.range_mm.0);
                assert!((drawn - expected).abs() < 0.11, "{frame}: {drawn}, {expected}");
            }
        }
    }

    #[test]
    fn without_a_rupture_the_largest_force_is_shown() {
        let run = shipped("passivity/late-wall.toml");
        let animation = Animation::of(&[&run]).expect("an animation");
        assert!(animation.title.starts_with("No layer ruptures: "), "{}", animation.title);
        let panel = &animation.panels[0];
        assert!(panel.moments.iter().all(|now| now.overshoot.is_none()) && panel.layers.len() == 1);
        assert_eq!(panel.layers[0].top_mm.0, 5.0, "tissue.contact_m of the scenario");
        assert!(animation.png().is_ok());
        let mut empty = run;
        empty.trace = trocar_engine::engine::Trace::new(empty.scenario.grid);
        assert!(Animation::of(&[&empty]).is_none());
    }
}
