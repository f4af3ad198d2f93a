//! One moment of a run as shapes.

use serde_json::{Value as Json, json};

use super::tissue::{DrawnTissue, Layer};
use crate::run::event_shade;
use trocar_core::augmentation::HoldSettings;
use trocar_document::animation::{Anchor, Drawing, Role, Shape};
use trocar_document::figure::Shade;
use trocar_scenario::Scenario;

const MARGIN: f64 = 22.0;
const NEEDLE: f64 = 3.0;
const BEVEL: f64 = 12.0;
/// Length by which shapes extend beyond the drawing, for larger paper.
const BEYOND: f64 = 1500.0;
const SMALL: f64 = 12.0;
const LETTER: f64 = 0.62 * SMALL;
const DIP_POINTS: i32 = 7;
const LENGTHS_MM: [f64; 8] = [0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0];
/// Forces of a full bar: few, so most runs have the same scale.
const FULL_N: [f64; 6] = [5.0, 10.0, 20.0, 50.0, 100.0, 1000.0];
const NAMED_S: f64 = 0.1;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Form {
    pub(super) width: f64,
    pub(super) height: f64,
    bar: f64,
    bar_width: f64,
    hand: f64,
    tissue: f64,
    needle: f64,
    is_wide: bool,
}

impl Form {
    const fn wide(width: f64, height: f64) -> Self {
        let needle = 98.0 + 0.45 * (width - 98.0);
        Self { width, height, bar: 8.0, bar_width: 16.0, hand: 64.0, tissue: 98.0, needle, is_wide: true }
    }

    pub(super) const PAGE: [Self; 2] = [
        Self::wide(440.0, 216.0),
        Self {
            width: 200.0,
            height: 176.0,
            bar: 4.0,
            bar_width: 12.0,
            hand: 42.0,
            tissue: 64.0,
            needle: 76.0,
            is_wide: false,
        },
    ];
    const FIELD: Self = Self::wide(400.0, 384.0);
    pub(super) const PICTURE: Self = Self::wide(376.0, 260.0);
}

#[derive(Clone, Debug, Default)]
pub(super) struct Moment {
    pub(super) tip_mm: f64,
    /// Position of the hand, scaled to the needle.
    pub(super) hand_mm: f64,
    pub(super) felt_n: f64,
    pub(super) mode: u8,
    pub(super) alarm_mm: Option<f64>,
    pub(super) tops_mm: Vec<f64>,
    pub(super) torn: Vec<bool>,
    /// Tip position at the rupture and advance since then, in mm, with a text.
    pub(super) overshoot: Option<(f64, f64, String)>,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Scene<'a> {
    pub(super) form: Form,
    pub(super) layers: &'a [Layer],
    pub(super) range_mm: (f64, f64),
    pub(super) full_n: f64,
    pub(super) event: Event,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Event {
    hold: HoldSettings,
    gives_cue: bool,
}

impl Event {
    pub(super) fn of(scenario: &Scenario) -> Self {
        let settings = &scenario.augmentation;
        Self { hold: settings.hold, gives_cue: settings.cue }
    }

    pub(super) fn mode_name(&self, mode: u8) -> &'static str {
        match mode {
            0 => "teleoperation",
            1 => event_shade(self.hold).name(),
            _ => Shade::Reengaging.name(),
        }
    }
}

pub(super) fn full_n(max_force_n: f64) -> f64 {
    FULL_N.into_iter().find(|full| *full >= max_force_n).unwrap_or(max_force_n)
}

impl Scene<'_> {
    fn per_mm(&self) -> f64 {
        (self.form.height - 2.0 * MARGIN) / (self.range_mm.1 - self.range_mm.0)
    }

    fn y(&self, mm: f64) -> f64 {
        MARGIN + (mm - self.range_mm.0) * self.per_mm()
    }

    /// The number and order of the shapes are constant.
    pub(super) fn shapes(&self, now: &Moment) -> Vec<Shape> {
        let Form { width, height, bar, bar_width, hand, tissue, needle, is_wide } = self.form;
        let (tip, bottom) = (self.y(now.tip_mm), height - MARGIN);
        let mut shapes = vec![];
        for (index, layer) in self.layers.iter().enumerate() {
            let (flat, dip) = (self.y(layer.top_mm), self.y(now.tops_mm[index]));
            let mut outline = self.top(flat, dip);
            outline.extend([(width + BEYOND, height + BEYOND), (tissue, height + BEYOND)]);
            let (x, y) = outline.into_iter().unzip();
            let area = Shape { role: [Role::TissueEven, Role::TissueOdd][index % 2], x, y, text: None };
            let (wide, deep) = (NEEDLE + 7.0, (tip - dip).min(16.0));
            let tear = [-wide, -NEEDLE - 3.0, -NEEDLE, NEEDLE, NEEDLE + 3.0, wide].map(|x| needle + x);
            let down = [-1.0, 0.2 * deep, deep, deep, 0.2 * deep, -1.0].map(|y| dip + y);
            let tear = Shape { role: Role::Tear, x: tear.into(), y: down.into(), text: None };
            shapes.extend([area, tear.shown_if(now.torn[index] && tip > dip)]);
        }
        shapes.extend(self.labels());
        let at = self.y(now.hand_mm).clamp(-4.0, height + 4.0);
        shapes.push(Shape::new(Role::Level, [(hand, at), (needle, at)]));
        let (from, reached, text) = now
            .overshoot
            .as_ref()
            .map_or((0.0, 0.0, ""), |(from, reached, text)| (self.y(*from), self.y(from + reached), text.as_str()));
        let right = needle + if is_wide { 24.0 } else { 16.0 };
        let bracket = [(right - 8.0, from), (right, from), (right, reached), (right - 8.0, reached)];
        let middle = (0.5 * (from + reached)).min(height - 11.0);
        let overshoot = Shape::text(Role::Overshoot, (right + 6.0, middle), Anchor::Start, text);
        let has_overshoot = now.overshoot.is_some();
        shapes.push(Shape::new(Role::Bracket, bracket).shown_if(has_overshoot));
        shapes.push(overshoot.shown_if(has_overshoot));
        let (left_edge, right_edge) = (needle - NEEDLE, needle + NEEDLE);
        let outline = [(left_edge, -BEYOND), (left_edge, tip), (right_edge, tip - BEVEL), (right_edge, -BEYOND)];
        shapes.push(Shape::new(Role::Needle, outline));
        let is_event = now.mode == 1;
        for side in [-1.0, 1.0] {
            let jaw = |role, gap: f64| {
                let middle = needle + side * (NEEDLE + gap);
                Shape::rectangle(role, (middle - 6.0, middle + 6.0), (2.0, 17.0))
            };
            let (is_frozen, is_slowed) =
                (self.event.hold == HoldSettings::Frozen, matches!(self.event.hold, HoldSettings::SpeedLimit(_)));
            shapes.push(jaw(Role::Clamp, 7.0).shown_if(is_event && is_frozen));
            shapes.push(jaw(Role::Brake, 10.0).shown_if(is_event && is_slowed));
        }
        let is_bounded = matches!(self.event.hold, HoldSettings::ForbiddenRegion(_) | HoldSettings::Yielding(_));
        let deepest = now.alarm_mm.filter(|_| is_event && is_bounded);
        let barrier = self.y(deepest.unwrap_or_default());
        shapes.push(
            Shape::new(Role::Barrier, [(needle - 16.0, barrier), (needle + 16.0, barrier)]).shown_if(deepest.is_some()),
        );
        shapes.push(Shape::new(Role::Rail, [(hand, MARGIN - 8.0), (hand, bottom + 4.0)]));
        shapes.push(Shape::rectangle(Role::Hand, (hand - 17.0, hand + 17.0), (at - 9.0, at + 9.0)));
        shapes.push(Shape::new(Role::Grip, [(hand - 8.0, at), (hand + 8.0, at)]));
        for side in [-1.0, 1.0] {
            let wave = |k: usize| (hand + side * (20.0 + 4.0 * (k % 2) as f64), at - 9.0 + 3.0 * k as f64);
            let wave: [(f64, f64); 7] = std::array::from_fn(wave);
            shapes.push(Shape::new(Role::Vibration, wave).shown_if(is_event && self.event.gives_cue));
        }
        let foot = height - 9.0;
        shapes.push(Shape::text(Role::Label, (hand, foot), Anchor::Middle, "hand"));
        let across = (bar, bar + bar_width);
        shapes.push(Shape::rectangle(Role::Track, across, (MARGIN, bottom)));
        let full = bottom - (now.felt_n.abs() / self.full_n).min(1.0) * (bottom - MARGIN);
        for (role, is_shown) in [(Role::Force, now.felt_n >= 0.0), (Role::Pull, now.felt_n < 0.0)] {
            shapes.push(Shape::rectangle(role, across, (full, bottom)).shown_if(is_shown));
        }
        // Adding zero removes the sign of a negative zero.
        let shown_n = format!("{:.2} N", (100.0 * now.felt_n).round() / 100.0 + 0.0);
        shapes.push(Shape::text(Role::Newtons, (2.0, 0.5 * MARGIN - 1.0), Anchor::Start, shown_n));
        let unit = if is_wide { " N" } else { "" };
        let scale = format!("{}{unit}", trocar_document::plain(self.full_n));
        shapes.push(Shape::text(Role::Label, (bar + bar_width + 2.0, MARGIN + 5.0), Anchor::Start, scale));
        shapes.push(Shape::text(Role::Label, (2.0, foot), Anchor::Start, "force").shown_if(is_wide));
        let range_mm = self.range_mm.1 - self.range_mm.0;
        let length_mm = LENGTHS_MM.into_iter().rfind(|mm| *mm <= range_mm / 3.0).unwrap_or(range_mm / 4.0);
        let (x, low, high) = (tissue + 9.0, height - 8.0, height - 8.0 - length_mm * self.per_mm());
        let ends = [(x - 3.0, high), (x + 3.0, high), (x, high), (x, low), (x - 3.0, low), (x + 3.0, low)];
        shapes.push(Shape::new(Role::Ruler, ends));
        shapes.push(Shape::text(Role::Label, (x + 6.0, low - 6.0), Anchor::Start, format!("{length_mm} mm")));
        shapes
    }

    fn top(&self, flat: f64, dip: f64) -> Vec<(f64, f64)> {
        let Form { width, tissue, needle, is_wide, .. } = self.form;
        let (half, reach) = (NEEDLE + 1.0, if is_wide { 90.0_f64 } else { 60.0 });
        // Half a dip as a Bézier curve, horizontal at both ends.
        let side = (0..=DIP_POINTS).map(|k| f64::from(k) / f64::from(DIP_POINTS)).map(|t| {
            let rest = 1.0 - t;
            let across = 3.0 * rest * t * (0.2 * rest + 0.45 * t) + t.powi(3);
            (half + reach * across, flat + (dip - flat) * rest * rest * (1.0 + 2.0 * t))
        });
        let mut points: Vec<(f64, f64)> = side.clone().map(|(x, y)| ((needle - x).max(tissue), y)).collect();
        points.push((tissue, flat));
        points.reverse();
        points.extend(side.map(|(x, y)| (needle + x, y)));
        points.push((width + BEYOND, flat));
        points
    }

    fn labels(&self) -> Vec<Shape> {
        let Form { width, height, .. } = self.form;
        let tops = || self.layers.iter().map(|layer| self.y(layer.top_mm));
        let mut free = f64::NEG_INFINITY;
        let label = |((layer, top), next): ((&Layer, f64), f64)| {
            let top = top.max(0.0);
            let at = if next - top < 16.0 { top - 8.0 } else { top + 9.0 };
            let fits = !layer.label.is_empty() && at > free && at < height - 8.0 && next > 0.0;
            free = if fits { at + SMALL + 1.0 } else { free };
            let is_short = LETTER * (layer.label.chars().count() as f64) < width - self.form.tissue;
            Shape::text(Role::Label, (width - 6.0, at), Anchor::End, &*layer.label).shown_if(fits && is_short)
        };
        self.layers.iter().zip(tops()).zip(tops().skip(1).chain([height])).map(label).collect()
    }
}

#[derive(Debug)]
pub struct LiveDrawing {
    layers: Vec<Layer>,
    range_mm: (f64, f64),
    position_scale: f64,
    event: Event,
    max_force_n: f64,
    ruptured_s: f64,
    alarm_mm: Option<f64>,
}

#[derive(Clone, Copy, Debug, Default)]
pub struct LiveMoment<'a> {
    pub time_s: f64,
    pub tip_mm: f64,
    pub master_mm: f64,
    pub felt_n: f64,
    /// 0 for teleoperation, 1 for an event, 2 for re-engaging.
    pub mode: u8,
    pub tops_mm: &'a [f64],
    pub torn: &'a [bool],
    pub ruptures: bool,
}

impl LiveDrawing {
    /// `from_m` and `to_m` are the range of the hand.
    pub fn new(scenario: &Scenario, (from_m, to_m): (f64, f64)) -> Self {
        let position_scale = scenario.position_scale();
        let (from_mm, to_mm) = (1e3 * position_scale * from_m, 1e3 * position_scale * to_m);
        let margin_mm = 0.05 * (to_mm - from_mm).max(1.0);
        Self {
            layers: DrawnTissue::of_scenario(scenario).layers().to_vec(),
            range_mm: (from_mm - margin_mm, to_mm + margin_mm),
            position_scale,
            event: Event::of(scenario),
            max_force_n: 0.0,
            ruptured_s: f64::NEG_INFINITY,
            alarm_mm: None,
        }
    }

    /// Two heights of the drawing with the hand's position there in mm.
    pub fn heights(&self) -> Json {
        let hand = |mm: f64| mm / self.position_scale;
        json!([[MARGIN, hand(self.range_mm.0)], [Form::FIELD.height - MARGIN, hand(self.range_mm.1)]])
    }

    /// The state's name, the force of a full bar in N, and the shapes.
    pub fn frame(&mut self, now: &LiveMoment<'_>) -> Json {
        self.max_force_n = self.max_force_n.max(now.felt_n.abs());
        if now.ruptures {
            self.ruptured_s = now.time_s;
        }
        self.alarm_mm = (now.mode == 1).then(|| self.alarm_mm.unwrap_or(now.tip_mm));
        let moment = Moment {
            tip_mm: now.tip_mm,
            hand_mm: now.master_mm * self.position_scale,
            felt_n: now.felt_n,
            mode: now.mode,
            alarm_mm: self.alarm_mm,
            tops_mm: now.tops_mm.to_vec(),
            torn: now.torn.to_vec(),
            overshoot: None,
        };
        let (form, range_mm, full_n, event) = (Form::FIELD, self.range_mm, full_n(self.max_force_n), self.event);
        let shapes = Scene { form, layers: &self.layers, range_mm, full_n, event }.shapes(&moment);
        let is_rupturing = now.mode == 0 && now.time_s - self.ruptured_s < NAMED_S;
        let mut drawing = Drawing { size: (form.width, form.height), frames: vec![shapes] }.description();
        drawing["full_n"] = json!(full_n);
        drawing["state"] = if is_rupturing { "rupture" } else { event.mode_name(now.mode) }.into();
        drawing
    }
}
