mod scene;
mod tissue;

use crate::run::{Run, state};
use scene::{Event, Form, Moment, Scene, full_n};
pub use scene::{LiveDrawing, LiveMoment};
use tissue::nearest;
pub use tissue::{DrawnTissue, Layer};
use trocar_document::animation::{Animation, Drawing, Panel};
use trocar_document::{Fine, show};
use trocar_metrics::{Outcome, RUPTURE_WINDOW_S, Unit};

const BEFORE_S: f64 = 0.1;

const LENGTH_S: f64 = BEFORE_S + RUPTURE_WINDOW_S;

/// 62.5 frames per second at a quarter of the speed.
const FRAMES: usize = 151;

const LATER_S: f64 = 0.02;

const CAUGHT_UP_S: f64 = 0.1;
const MAX_AFTER_S: f64 = 1.5;

const SLOWNESS: f64 = 4.0;

const RUPTURING_S: f64 = 0.06;

const MARGIN: f64 = 0.12;

const MAX_BULGE_SHARE: f64 = 2.5;

const MIN_RANGE_MM: f64 = 4.0;

struct Frames {
    states: Vec<&'static str>,
    layers: Vec<Layer>,
    moments: Vec<Moment>,
}

/// `None` if a run has no ticks.
pub fn animation(runs: &[&Run]) -> Option<Animation> {
    Played::of(&runs[..runs.len().min(2)]).map(|played| played.animation())
}

pub fn animation_with_pictures(runs: &[&Run]) -> Option<Animation> {
    let played = Played::of(&runs[..runs.len().min(2)])?;
    let pictures = played.runs.iter().zip(&played.frames);
    let pictures = pictures.map(|(run, frames)| played.drawing(run, frames, Form::PICTURE)).collect();
    Some(Animation { pictures, ..played.animation() })
}

struct Played<'a> {
    runs: &'a [&'a Run],
    times_s: &'a [f64],
    ticks: Vec<usize>,
    still: usize,
    rupture_s: Option<f64>,
    /// Time of the first rupture, else of the largest tissue force.
    origin_s: f64,
    frames: Vec<Frames>,
    range_mm: (f64, f64),
    full_n: f64,
}

impl<'a> Played<'a> {
    fn of(runs: &'a [&'a Run]) -> Option<Self> {
        let first = *runs.first()?;
        if runs.iter().any(|run| run.trace.is_empty()) {
            return None;
        }
        let ruptures_s = runs.iter().filter_map(|run| Some(run.metrics.ruptures.first()?.time_s));
        let rupture_s = ruptures_s.reduce(f64::min);
        let origin_s = rupture_s.unwrap_or_else(|| time_of_largest_force(first));
        let end_s = runs.iter().filter_map(|run| run.trace.time_s.last().copied()).fold(0.0, f64::max);
        let from_s = (origin_s - BEFORE_S).min(end_s - LENGTH_S).max(0.0);
        let wanted_s = (0..FRAMES).map(|frame| from_s + LENGTH_S * frame as f64 / (FRAMES - 1) as f64);
        let times_s = &runs.iter().max_by_key(|run| run.trace.len())?.trace.time_s;
        let after_s = if rupture_s.is_some() { after_s(runs, origin_s) } else { RUPTURE_WINDOW_S };
        let later = ((after_s - RUPTURE_WINDOW_S) / LATER_S).round() as usize;
        let later_s = (1..=later).map(|frame| from_s + LENGTH_S + LATER_S * frame as f64);
        let tick = |time_s: f64| nearest(times_s, time_s).min(times_s.len() - 1);
        let mut ticks: Vec<usize> = wanted_s.map(tick).collect();
        ticks.dedup();
        let still = ticks.len() - 1;
        ticks.extend(later_s.map(tick));
        ticks.dedup();
        let frames: Vec<Frames> = runs.iter().map(|run| Frames::new(run, times_s, &ticks)).collect();
        let moments = || frames.iter().flat_map(|frames| &frames.moments);
        let positions_mm = moments().flat_map(|now| [now.tip_mm, now.hand_mm]);
        let ends = |(low, high): (f64, f64), mm: f64| (low.min(mm), high.max(mm));
        let (low, high) = positions_mm.filter(|mm| mm.is_finite()).fold((f64::MAX, f64::MIN), ends);
        let (low, high) = if low < high { (low, high) } else { (low.min(0.0), low.min(0.0) + MIN_RANGE_MM) };
        let tops = frames.iter().filter_map(|frames| frames.surface_mm(low));
        let low = tops.filter(|top| *top > low - MAX_BULGE_SHARE * (high - low)).fold(low, f64::min);
        let margin = MARGIN * (high - low).max(MIN_RANGE_MM);
        let forces = moments().map(|now| now.felt_n.abs()).filter(|force| force.is_finite());
        let full_n = full_n(forces.fold(0.0, f64::max));
        let range_mm = (low - margin, high + margin);
        Some(Self { runs, times_s, ticks, still, rupture_s, origin_s, frames, range_mm, full_n })
    }

    fn animation(&self) -> Animation {
        let title = match self.rupture_s {
            Some(_) => {
                format!("The first rupture, four times slower. The bracket is the overshoot in {RUPTURE_WINDOW_S} s.")
            }
            None => "No layer ruptures: the time around the largest tissue force, four times slower.".to_owned(),
        };
        let origin = if self.rupture_s.is_some() { "rupture" } else { "largest force" };
        let clock = |tick: &usize| {
            let after_ms = (1e3 * (self.times_s[*tick] - self.origin_s)).round();
            format!("{} ms {} the {origin}", after_ms.abs(), if after_ms < 0.0 { "before" } else { "after" })
        };
        Animation {
            title,
            time_s: self.ticks.iter().map(|tick| Fine(self.times_s[*tick])).collect(),
            clocks: self.ticks.iter().map(clock).collect(),
            origin_s: self.origin_s,
            slowness: SLOWNESS,
            still: self.still,
            panels: self.runs.iter().zip(&self.frames).map(|(run, frames)| self.panel(run, frames)).collect(),
            pictures: vec![],
        }
    }

    fn panel(&self, run: &Run, frames: &Frames) -> Panel {
        let note = note(run);
        let advance = Overshoot::of(run).map_or(String::new(), |overshoot| {
            format!(" The needle advances by {} in the {RUPTURE_WINDOW_S} s after the rupture.", overshoot.text)
        });
        let name = run.scenario.name.clone();
        Panel {
            alt: format!("Needle, tissue and hand of the run {name}.{advance} {note}"),
            name,
            scheme: if run.scenario.augmentation.enabled { "augmented" } else { "classical" },
            note,
            states: frames.states.clone(),
            drawings: Form::PAGE.map(|form| self.drawing(run, frames, form)).into(),
        }
    }

    fn drawing(&self, run: &Run, frames: &Frames, form: Form) -> Drawing {
        let (range_mm, full_n, event) = (self.range_mm, self.full_n, Event::of(&run.scenario));
        let scene = Scene { form, layers: &frames.layers, range_mm, full_n, event };
        let frames = frames.moments.iter().map(|now| scene.shapes(now)).collect();
        Drawing { size: (form.width, form.height), frames }
    }
}

/// Extended until the needle has caught up after an event.
fn after_s(runs: &[&Run], rupture_s: f64) -> f64 {
    let caught_up = runs.iter().flat_map(|run| &run.metrics.events).filter_map(|event| {
        let is_of_rupture = (0.0..RUPTURE_WINDOW_S).contains(&(event.start_s - rupture_s));
        let end_s = event.start_s + event.augmented_s? + event.reengaging_s?;
        is_of_rupture.then_some(end_s - rupture_s + CAUGHT_UP_S)
    });
    caught_up.fold(RUPTURE_WINDOW_S, f64::max).min(MAX_AFTER_S)
}

fn time_of_largest_force(run: &Run) -> f64 {
    let forces = run.trace.tissue_force_n.iter().zip(&run.trace.time_s);
    forces.max_by(|a, b| a.0.total_cmp(b.0)).map_or(0.0, |(_, time_s)| *time_s)
}

impl Frames {
    fn surface_mm(&self, depth_mm: f64) -> Option<f64> {
        self.layers.iter().map(|layer| layer.top_mm).filter(|top| *top < depth_mm).reduce(f64::max)
    }

    fn new(run: &Run, times_s: &[f64], ticks: &[usize]) -> Self {
        let (trace, scenario) = (&run.trace, &run.scenario);
        // A diverged run ends early.
        let last = trace.len() - 1;
        let mut tissue = DrawnTissue::of_run(run);
        let (overshoot, event) = (Overshoot::of(run), Event::of(scenario));
        let (mut moments, mut states) = (vec![], vec![]);
        for &tick in ticks {
            let (time_s, at) = (times_s[tick], tick.min(last));
            let tip_mm = 1e3 * trace.slave_position_m[at];
            tissue.step(trace.time_s[at], tip_mm);
            let mode = trace.mode[at];
            let after_s = overshoot.as_ref().map(|overshoot| time_s - overshoot.time_s);
            let is_rupturing = mode == 0 && after_s.is_some_and(|after_s| (0.0..RUPTURING_S).contains(&after_s));
            states.push(if is_rupturing { "rupture" } else { event.mode_name(mode) });
            let alarm = || trace.mode[..at].iter().rposition(|mode| *mode != 1).map_or(0, |before| before + 1);
            moments.push(Moment {
                tip_mm,
                hand_mm: 1e3 * scenario.position_scale() * trace.master_position_m[at],
                felt_n: trace.operator_force_n[at],
                mode,
                alarm_mm: (mode == 1).then(|| 1e3 * trace.slave_position_m[alarm()]),
                tops_mm: tissue.depths_mm().to_vec(),
                torn: tissue.layers().iter().map(|layer| layer.torn_s.is_some_and(|torn| torn <= time_s)).collect(),
                overshoot: overshoot.as_ref().filter(|overshoot| overshoot.time_s <= time_s).map(|one| one.at(tick)),
            });
        }
        if let (Some(metric), Some(reached_mm)) = (overshoot.as_ref(), moments.last().and_then(reached_mm)) {
            for (.., text) in
                moments.iter_mut().filter_map(|now| now.overshoot.as_mut()).filter(|now| now.1 == reached_mm)
            {
                text.clone_from(&metric.text);
            }
        }
        Self { states, layers: tissue.layers().to_vec(), moments }
    }
}

fn reached_mm(now: &Moment) -> Option<f64> {
    now.overshoot.as_ref().map(|overshoot| overshoot.1)
}

struct Overshoot<'a> {
    time_s: f64,
    tip_m: &'a [f64],
    from: usize,
    end: usize,
    text: String,
}

impl<'a> Overshoot<'a> {
    fn of(run: &'a Run) -> Option<Self> {
        let rupture = run.metrics.ruptures.first()?;
        let from = nearest(&run.trace.time_s, rupture.time_s);
        let end = nearest(&run.trace.time_s, rupture.time_s + RUPTURE_WINDOW_S);
        let text = show(rupture.slave_overshoot_m, Unit::Metre);
        (from < run.trace.len()).then_some(Self {
            time_s: rupture.time_s,
            tip_m: &run.trace.slave_position_m,
            from,
            end,
            text,
        })
    }

    /// Position of the tip at the rupture and its maximum advance, in mm, with a text.
    fn at(&self, tick: usize) -> (f64, f64, String) {
        let from_m = self.tip_m[self.from];
        let until = (tick.min(self.end) + 1).clamp(self.from + 1, self.tip_m.len());
        let reached_m = self.tip_m[self.from..until].iter().map(|tip_m| tip_m - from_m).fold(0.0, f64::max);
        (1e3 * from_m, 1e3 * reached_m, format!("{:.1} mm", 1e3 * reached_m))
    }
}

fn note(run: &Run) -> String {
    if let Outcome::Diverged { .. } = run.metrics.outcome {
        return state(run);
    }
    let miss = run.metrics.ruptures.first().and_then(|rupture| rupture.miss.as_ref());
    match miss.filter(|_| run.scenario.augmentation.enabled) {
        Some(miss) => format!("rupture missed: {}", miss.reason),
        None => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::run;
    use trocar_scenario::{Scenario, Source};

    fn shipped(name: &str) -> Run {
        run(Scenario::load(&Source::Builtin(name.into()), &[]).expect("a scenario")).expect("a run")
    }

    #[test]
    fn the_frames_follow_the_trace_and_the_overshoot_is_the_metric() {
        for (classical, augmented) in [
            ("paper/classical.toml", "paper/augmented.toml"),
            ("layers/through-the-skin.toml", "layers/skin-augmented.toml"),
        ] {
            let runs = [shipped(classical), shipped(augmented)];
            let runs = runs.each_ref();
            let played = Played::of(&runs).expect("frames");
            let animation = played.animation();
            assert_eq!(animation.still, FRAMES - 1);
            let augmented = &played.frames[1];
            let (state, last) = augmented.states.last().zip(augmented.moments.last()).expect("frames");
            assert_eq!(*state, "teleoperation");
            assert!((last.tip_mm - last.hand_mm).abs() < 0.5, "{} {}", last.tip_mm, last.hand_mm);
            assert!(augmented.states[FRAMES - 1] != "teleoperation");
            for (panel, run) in played.frames.iter().zip(runs) {
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
                // Under load the layer lies at the tip. After the rupture it returns above the tip.
                let layer = panel.layers.iter().position(|layer| layer.torn_s.is_some()).expect("a torn layer");
                let first = &panel.moments[0];
                assert!((first.tops_mm[layer] - first.tip_mm).abs() < 1e-9);
                let top = panel.layers[layer].top_mm;
                assert!((last.tops_mm[layer] - top).abs() < 0.01 && top < last.tip_mm - 1.0);
                assert!(panel.moments.iter().all(|now| now.tops_mm.is_sorted()));
            }
            let json = serde_json::to_string(&animation).expect("JSON");
            assert!(json.len() < 300_000, "{} bytes", json.len());
        }
    }

    #[test]
    fn a_page_has_the_tip_of_each_frame() {
        let run = shipped("paper/augmented.toml");
        let runs = [&run];
        let played = Played::of(&runs).expect("frames");
        for (drawing, form) in played.animation().panels[0].drawings.iter().zip(Form::PAGE) {
            let drawing = drawing.description();
            let shapes = drawing["shapes"].as_array().expect("shapes");
            let needle = shapes.iter().find(|shape| shape["role"] == "needle").expect("a needle");
            let per_mm = (form.height - 44.0) / (played.range_mm.1 - played.range_mm.0);
            let mut drawn = 0.0;
            for (frame, now) in played.frames[0].moments.iter().enumerate() {
                let states = needle["states"].as_array().expect("states");
                let state = states.iter().find(|state| state[0].as_u64() == Some(frame as u64));
                drawn = state.and_then(|state| state[1][1].as_f64()).unwrap_or(drawn);
                let expected = 22.0 + per_mm * (now.tip_mm - played.range_mm.0);
                assert!((drawn - expected).abs() < 0.11, "{frame}: {drawn}, {expected}");
            }
        }
    }

    #[test]
    fn without_a_rupture_the_largest_force_is_shown() {
        let run = shipped("passivity/late-wall.toml");
        let runs = [&run];
        let played = Played::of(&runs).expect("frames");
        let title = played.animation().title;
        assert!(title.starts_with("No layer ruptures: "), "{title}");
        let panel = &played.frames[0];
        assert!(panel.moments.iter().all(|now| now.overshoot.is_none()) && panel.layers.len() == 1);
        assert_eq!(panel.layers[0].top_mm, 5.0, "tissue.contact_m of the scenario");
        let mut empty = run;
        empty.trace = trocar_engine::engine::Trace::new(empty.scenario.grid);
        assert!(animation(&[&empty]).is_none());
    }
}
