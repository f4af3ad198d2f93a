use schemars::JsonSchema;
use serde::Serialize;

use crate::stability_check::statement::{ASSUMPTIONS, useful_bounds};
use crate::stability_check::study::DEVIATIONS;
use crate::stability_check::{EventLimit, StabilityStudy, Statement};
use trocar_document::{Cell, DataTable, Number, Table, Unit, significant};
use trocar_stability::{Certificate, EventBound, GAP_M, LONGEST_DWELL_S, Switching, SwitchingSettings};

pub(super) fn seconds(switching: &Switching, ticks: u64) -> f64 {
    // A multiple of a tick of 0.001 s has rounding errors in its last digits.
    (ticks as f64 * switching.settings.of_loop.tick_s * 1e12).round() / 1e12
}

fn milliseconds(switching: &Switching, ticks: u64) -> String {
    format!("{} ms", significant(1e3 * seconds(switching, ticks)))
}

pub(super) fn lines(switching: &Switching) -> Vec<String> {
    let ms = |ticks| milliseconds(switching, ticks);
    let (softest, stiffest) = switching.settings.stiffness_n_per_m;
    let phases = switching.phases;
    let mut lines = vec![format!(
        "switching: {} to {} N/m at any tick, frozen for {} to {}, cross-fade of {}, {}",
        significant(softest),
        significant(stiffest),
        ms(phases.held.0),
        ms(phases.held.1),
        ms(phases.blend),
        switching.settings.augmentation.reengage.word(),
    )];
    let conditions = switching.certificate.as_ref().map(Certificate::conditions);
    lines.push(match (switching.dwell_ticks(), conditions) {
        (Some(dwell), Some(conditions)) => format!(
            "springs alone: the motion decays under any sequence of events with {} of teleoperation between them; \
             {conditions} conditions verified",
            ms(dwell),
        ),
        _ => format!(
            "springs alone: no certificate found with up to {LONGEST_DWELL_S} s of teleoperation between events; \
             this does not show instability"
        ),
    });
    let enforced = match (switching.dwell_ticks(), switching.is_certified()) {
        (_, true) => format!("certified for springs of {} to {} N/m", significant(softest), significant(stiffest)),
        (Some(dwell), false) => {
            format!("not certified, augmentation.refractory_s must be {}", seconds(switching, dwell))
        }
        (None, false) => "not certified".to_owned(),
    };
    lines.push(format!("the supervisor enforces {}: {enforced}", ms(phases.refractory)));
    if let Some(covers) = switching.covers_lost_contact {
        let word = if covers { "certified" } else { "not certified" };
        lines.push(format!("with a needle that may lose contact at any tick: {word}"));
    }
    let found = switching.growth.found;
    let growth = format!(
        "growth per event at {}: {} found with the stiffness chosen at every tick",
        ms(phases.refractory),
        significant(found)
    );
    lines.push(match switching.certified_growth() {
        Some(certified) => format!(
            "{growth}, at most {} by the certificate, {} times as much",
            significant(certified),
            significant(certified / found),
        ),
        None => growth,
    });
    lines.push(match switching.growing_dwell_ticks {
        None => "no growing sequence found, down to one tick between events".to_owned(),
        Some(ticks) => format!("growing sequences found with {} between events", ms(ticks)),
    });
    if switching.shows_growth() {
        lines.push(format!(
            "with the enforced time, the motion grows {} times from one event to the next: see worst_events.toml",
            significant(switching.shown.found),
        ));
    }
    lines
}

pub(super) fn statement(study: &StabilityStudy) -> String {
    let statement = study.statement();
    let word = statement.word();
    let (peaks, sensor_n) = match statement {
        Statement::None(reason) => return format!("certificate: {word} ({reason})"),
        Statement::Decays(peaks) => (peaks, None),
        Statement::Bounded(peaks, sensor_n) => (peaks, Some(sensor_n)),
    };
    let mm = |metres: f64| significant(1e3 * metres);
    let motion = |times: f64| {
        useful_bounds(peaks).map(|[needle, hand]| {
            format!("the needle at most {} mm and the hand at most {} mm", mm(needle * times), mm(hand * times))
        })
    };
    let tissue = study.switching.as_ref().map(|switching| tissue(&switching.settings)).unwrap_or_default();
    let decay = significant(peaks.decay_per_s);
    let effect = match sensor_n {
        None => {
            format!("the effect of every rupture and of every other motion decays with {decay} 1/s of teleoperation")
        }
        Some(sensor_n) => format!(
            "the motion stays bounded: the errors of the force sensor, {} N with {DEVIATIONS} standard deviations of its \
             noise, move {}, and the effect of larger ones decays with {decay} 1/s of teleoperation",
            significant(sensor_n),
            motion(sensor_n).unwrap_or_else(|| "needle and hand within bounds that are too loose to be useful".into()),
        ),
    };
    let bound = match motion(1.0) {
        Some(motion) => format!(
            "1 N of drop, friction or noise moves {motion} ({} and {} mm without events)",
            mm(peaks.found_m_per_n[0]),
            mm(peaks.found_m_per_n[1]),
        ),
        None => "The bounds of the motion are too loose to be useful".to_owned(),
    };
    format!(
        "certificate: {word}. With {tissue}: {effect}, under any events that keep the enforced times. {bound}. It \
         assumes that {}",
        ASSUMPTIONS.join("; that ")
    )
}

fn tissue(settings: &SwitchingSettings) -> String {
    let ((softest, stiffest), (least, most)) = (settings.stiffness_n_per_m, settings.damping_n_s_per_m);
    if stiffest == 0.0 && most == 0.0 {
        return "a recorded force, which closes no loop".to_owned();
    }
    format!(
        "{} to {} N/m and {} to {} N·s/m at any tick, lost contact",
        significant(softest),
        significant(stiffest),
        significant(least),
        significant(most),
    )
}

pub(super) fn event_table(events: &[EventBound]) -> Table {
    let columns = [
        ("reengage", format!("released {} mm from the hand", significant(1e3 * GAP_M))),
        ("reference_jump_m", "reference jumps".to_owned()),
        ("slave_motion_m", "needle motion".to_owned()),
        ("slave_speed_m_per_s", "max speed".to_owned()),
        ("force_n", "max feedback force".to_owned()),
        ("force_step_n", "max step per tick".to_owned()),
    ];
    let mut table = Table::new("released", "The end of one event, by re-engagement policy", columns);
    // A motion below a nanometre or a force below a nanonewton is a rounding error.
    let shown = |value: f64, unit: Unit| Number::new(if value < 1e-9 { 0.0 } else { value }, unit);
    for event in events {
        table.row([
            Cell::from(event.reengage.word()),
            shown(event.reference_jump_m, Unit::Metre).into(),
            shown(event.slave_motion_m, Unit::Metre).into(),
            shown(event.slave_speed_m_per_s, Unit::MetrePerSecond).into(),
            shown(event.force_n, Unit::Newton).into(),
            shown(event.force_step_n, Unit::Newton).into(),
        ]);
    }
    table
}

pub(super) fn rows(matrix: &nalgebra::DMatrix<f64>) -> Vec<Vec<f64>> {
    matrix.row_iter().map(|row| row.iter().copied().collect()).collect()
}

/// The stability under switching.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(untagged)]
pub(super) enum SwitchingPart {
    /// The scenario cannot be analysed.
    Unmodelled {
        /// The reason.
        unmodelled: String,
    },
    /// The results.
    Analysed(Box<AnalysedPart>),
}

/// The stability under switching between teleoperation and events.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct AnalysedPart {
    /// Minimum and maximum stiffness of the tissue, in N/m, which may change at every tick.
    stiffness_n_per_m: (f64, f64),
    /// Minimum and maximum time for which the slave is held, in s.
    held_s: [f64; 2],
    /// Time of the cross-fade of the force after a release, in s.
    blend_s: f64,
    /// Minimum time between two events, in s.
    refractory_s: f64,
    /// True if the scenario is certified; `None` if the analysis leaves out a part of it, or does not cover its tissue.
    is_certified: Option<bool>,
    /// True if the analysed springs are certified.
    is_certified_for_range: bool,
    /// True if the range covers the tissue of the scenario.
    covers_tissue: Option<bool>,
    /// True if the certificate also holds for a needle that may lose contact at any tick; `None` if there is no
    /// certificate in contact.
    covers_lost_contact: Option<bool>,
    /// The certificate with the shortest time between events; `None` without one.
    certificate: Option<CertificatePart>,
    growth_per_event: GrowthPart,
    /// The gap between slave and hand at the end of an event in `released`, in m.
    gap_m: f64,
    /// The end of one event, by re-engagement policy.
    released: Vec<ReleasedPart>,
}

/// A certificate; `certificate.json` contains all data to verify it.
#[derive(Debug, Serialize, JsonSchema)]
struct CertificatePart {
    /// Required time between two events, in s.
    dwell_s: f64,
    /// Bound of the ratio of the Lyapunov function between the beginnings of consecutive events.
    contraction: f64,
    /// Number of verified conditions.
    conditions: u64,
    /// The matrix P of the Lyapunov function at the beginning of an event, by rows.
    p_at_events: Vec<Vec<f64>>,
}

/// The growth of the state per event.
#[derive(Debug, Serialize, JsonSchema)]
struct GrowthPart {
    /// Time between the events, in s.
    dwell_s: f64,
    /// Largest factor per event that was found, with a tissue that changes at every tick.
    found: f64,
    /// Number of changes of the stiffness per event in this sequence.
    found_changes_of_stiffness: usize,
    /// Proved bound of the factor; `None` without a certificate.
    certified: Option<f64>,
    /// Largest factor that was found with a constant stiffness.
    found_on_one_stiffness: f64,
    /// Longest time between events with which a sequence was found to grow, in s; `None` if none was found.
    growing_dwell_s: Option<f64>,
}

/// The end of one event.
#[derive(Debug, Serialize, JsonSchema)]
struct ReleasedPart {
    /// The re-engagement policy.
    reengage: &'static str,
    /// Jump of the slave's reference, in m.
    reference_jump_m: f64,
    /// Maximum motion of the needle, in m.
    slave_motion_m: f64,
    /// Maximum speed of the needle, in m/s.
    slave_speed_m_per_s: f64,
    /// Maximum feedback force, in N.
    force_n: f64,
    /// Maximum change of the feedback force in a tick, in N.
    force_step_n: f64,
}

/// The statement of the certificate about the scenario.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct StatementPart {
    /// `decays`, `bounded` or `none`.
    statement: &'static str,
    /// The statement as a sentence.
    sentence: String,
    /// The reason for `none`.
    reason: Option<String>,
    /// The scenario that shows a growing motion, if there is one.
    counterexample: Option<&'static str>,
    /// Decay rate of every motion during teleoperation, in 1/s.
    decay_per_s: Option<f64>,
    /// Bound of the needle's motion per newton of additional force, in m/N; `None` if it is too loose to be useful.
    needle_m_per_n: Option<f64>,
    /// Bound of the hand's motion per newton of additional force, in m/N; `None` if it is too loose to be useful.
    hand_m_per_n: Option<f64>,
    /// The additional force of the sensor's steps and noise in N, for `bounded`.
    sensor_force_n: Option<f64>,
    /// The assumptions of the statement.
    assumptions: &'static [&'static str],
}

/// The limit of a parameter of an event for the certificate, with all else unchanged.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct EventLimitPart {
    /// The scenario key.
    parameter: &'static str,
    /// The value in the scenario, in the unit of the key.
    value: f64,
    /// True if `certified` is the largest value that is certified, false if it is the smallest.
    is_largest: bool,
    /// The certified value; `None` if no tried value is certified.
    certified: Option<f64>,
    /// True if the end of the search is certified.
    is_beyond_search: bool,
}

impl EventLimitPart {
    pub(super) fn of(limit: &EventLimit) -> Self {
        let &EventLimit { key: parameter, value, is_largest, certified, is_beyond_search } = limit;
        Self { parameter, value, is_largest, certified, is_beyond_search }
    }
}

impl StatementPart {
    pub(super) fn of(study: &StabilityStudy) -> Self {
        let found = study.statement();
        let (peaks, reason, sensor_force_n) = match found {
            Statement::Decays(peaks) => (Some(peaks), None, None),
            Statement::Bounded(peaks, step_n) => (Some(peaks), None, Some(step_n)),
            Statement::None(reason) => (None, Some(reason), None),
        };
        let bounds = peaks.and_then(useful_bounds);
        let grows = study.switching.as_ref().is_ok_and(Switching::shows_growth);
        let is_shown = peaks.is_none() && grows && study.worst_events.is_some();
        Self {
            statement: found.word(),
            sentence: statement(study),
            reason: reason.map(str::to_owned),
            counterexample: is_shown.then_some("worst_events.toml"),
            decay_per_s: peaks.map(|peaks| peaks.decay_per_s),
            needle_m_per_n: bounds.map(|[needle, _]| needle),
            hand_m_per_n: bounds.map(|[_, hand]| hand),
            sensor_force_n,
            assumptions: if peaks.is_some() { &ASSUMPTIONS } else { &[] },
        }
    }
}

impl SwitchingPart {
    pub(super) fn of(study: &StabilityStudy) -> Self {
        match &study.switching {
            Ok(switching) => Self::Analysed(Box::new(AnalysedPart::of(study, switching))),
            Err(unmodelled) => Self::Unmodelled { unmodelled: unmodelled.clone() },
        }
    }
}

impl AnalysedPart {
    fn of(study: &StabilityStudy, switching: &Switching) -> Self {
        let s = |ticks| seconds(switching, ticks);
        Self {
            stiffness_n_per_m: switching.settings.stiffness_n_per_m,
            held_s: [s(switching.phases.held.0), s(switching.phases.held.1)],
            blend_s: s(switching.phases.blend),
            refractory_s: s(switching.phases.refractory),
            is_certified: study.is_certified(),
            is_certified_for_range: switching.is_certified(),
            covers_tissue: study.covers_tissue(),
            covers_lost_contact: switching.covers_lost_contact,
            certificate: switching.certificate.as_ref().map(|found| CertificatePart {
                dwell_s: s(found.choice.dwell_ticks),
                contraction: found.choice.contraction,
                conditions: found.conditions(),
                p_at_events: rows(&found.p_at_events()),
            }),
            growth_per_event: GrowthPart {
                dwell_s: s(switching.phases.refractory),
                found: switching.growth.found,
                found_changes_of_stiffness: switching.growth.changes,
                certified: switching.certified_growth(),
                found_on_one_stiffness: switching.shown.found,
                growing_dwell_s: switching.growing_dwell_ticks.map(s),
            },
            gap_m: GAP_M,
            released: switching.events.iter().map(ReleasedPart::of).collect(),
        }
    }
}

impl ReleasedPart {
    fn of(event: &EventBound) -> Self {
        let &EventBound { reengage, reference_jump_m, slave_motion_m, slave_speed_m_per_s, force_n, force_step_n } =
            event;
        let reengage = reengage.word();
        Self { reengage, reference_jump_m, slave_motion_m, slave_speed_m_per_s, force_n, force_step_n }
    }
}

pub(super) fn growth(switching: &Switching) -> DataTable<'static> {
    let points = &switching.by_dwell;
    DataTable::new("switching")
        .numbers("dwell_s", points.iter().map(|point| seconds(switching, point.dwell_ticks)))
        .optional("certified_growth", points.iter().map(|point| point.certified))
        .numbers("found_growth", points.iter().map(|point| point.found))
}

pub(super) fn released(events: &[EventBound]) -> DataTable<'static> {
    DataTable::new("released")
        .texts("reengage", events.iter().map(|event| event.reengage.word()))
        .numbers("gap_m", events.iter().map(|_| GAP_M))
        .numbers("reference_jump_m", events.iter().map(|event| event.reference_jump_m))
        .numbers("slave_motion_m", events.iter().map(|event| event.slave_motion_m))
        .numbers("slave_speed_m_per_s", events.iter().map(|event| event.slave_speed_m_per_s))
        .numbers("force_n", events.iter().map(|event| event.force_n))
        .numbers("force_step_n", events.iter().map(|event| event.force_step_n))
}
