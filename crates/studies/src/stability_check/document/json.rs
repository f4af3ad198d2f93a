use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value as Json;

use super::absolute::{AbsolutePart, BoundedPart};
use super::measured::MeasuredPart;
use super::population::PopulationPart;
use super::switching::{EventLimitPart, StatementPart, SwitchingPart};
use super::verdict::{JitterPart, LoopPart};
use super::z_width::ZWidthPart;
use crate::stability_check::{Check, StabilityStudy, Unconfirmed};
use trocar_base::warning::Warning;
use trocar_document::json_of;
use trocar_stability::{
    Analysis, Axis, Limit, LinearLoop, PortPoint, SampledBound, Sensitivity, Spacing, is_passive_impedance,
};

/// `stability.json`: everything except the columns (points of the map, ports). An undefined value is `None`, and so is
/// a limit beyond the search range, for which `is_beyond_search` is true.
#[derive(Debug, Serialize, JsonSchema)]
pub struct StabilityFile<'a> {
    /// Version of trocar.
    trocar_version: &'static str,
    /// Name of the scenario.
    scenario: &'a str,
    /// The warnings about the analysis.
    warnings: Vec<Warning>,
    #[serde(flatten)]
    of_loop: LoopPart,
    /// The loop with measured frequency responses, with `--master-response` or `--slave-response`.
    measured: Option<MeasuredPart>,
    /// The Z-width, with `--z-width`.
    z_width: Option<ZWidthPart>,
    /// The limits over the population of the scenario; `None` without a population.
    population: Option<PopulationPart>,
    /// The stability limit of each parameter.
    limits: Vec<LimitPart<'a>>,
    /// The sensitivity of each finite limit to each parameter.
    sensitivities: Vec<SensitivityPart>,
    ports: PortsPart,
    /// Colgate and Schenkel's condition for passivity; `None` if it does not apply.
    sampled_data: Option<SampledPart>,
    certificate: StatementPart,
    /// The limits of the parameters of an event, if requested.
    event_limits: Vec<EventLimitPart>,
    switching: SwitchingPart,
    map: MapPart,
    /// The comparison of the map with simulated runs, if requested.
    simulated: Option<CheckPart>,
}

/// The stability limit of a parameter, in the unit of its key.
#[derive(Debug, Serialize, JsonSchema)]
struct LimitPart<'a> {
    /// Key of the parameter.
    parameter: &'static str,
    /// Value in the scenario.
    value: f64,
    /// Upper end of the stable range that contains this value, or of the last range below it; `None` without a stable
    /// range.
    largest_stable: Option<f64>,
    /// True if the range extends to the end of the search.
    is_beyond_search: bool,
    /// End of the search.
    searched_to: f64,
    /// The ranges with a stable loop, increasing.
    stable_ranges: &'a [(f64, f64)],
}

/// The sensitivity of a limit.
#[derive(Debug, Serialize, JsonSchema)]
struct SensitivityPart {
    /// Key of the limited parameter.
    limit: &'static str,
    /// Key of the changed parameter.
    parameter: &'static str,
    /// Relative change of the limit per relative change of the parameter.
    relative: Option<f64>,
}

/// The two-port of the teleoperator. A property is true if it holds at every frequency, and `None` without a hybrid
/// matrix.
#[derive(Debug, Serialize, JsonSchema)]
struct PortsPart {
    /// Absolutely stable: stable with any passive hand and tissue (Llewellyn).
    is_absolutely_stable: Option<bool>,
    /// Passive as a two-port.
    is_passive: Option<bool>,
    /// The hand's port is passive in free motion.
    hand_port_is_passive_in_free_motion: Option<bool>,
    /// The hand's port is passive in the tissue of the scenario.
    hand_port_is_passive_in_tissue: Option<bool>,
    /// The needle's port is passive with a fixed hand.
    needle_port_is_passive: Option<bool>,
    /// Absolute stability with bounded hands and tissues.
    bounded: BoundedPart,
    /// Absolute stability over a parameter, if requested.
    over: Option<AbsolutePart>,
}

/// The sampled-data passivity of the master.
#[derive(Debug, Serialize, JsonSchema)]
struct SampledPart {
    /// The required damping, in N·s/m.
    min_damping_n_s_per_m: f64,
    /// The damping of the master, in N·s/m.
    damping_n_s_per_m: f64,
    /// True if the damping of the master is sufficient.
    is_passive: bool,
}

/// The stability map.
#[derive(Debug, Serialize, JsonSchema)]
struct MapPart {
    /// The horizontal axis.
    x: AxisPart,
    /// The vertical axis.
    y: AxisPart,
    /// Share of the points with a stable loop.
    stable_share: f64,
}

/// An axis of the map, in the unit of its key.
#[derive(Debug, Serialize, JsonSchema)]
struct AxisPart {
    /// Key of the parameter.
    parameter: &'static str,
    /// Value in the scenario.
    value: f64,
    /// First value.
    low: f64,
    /// Last value.
    high: f64,
    /// Number of values.
    count: usize,
    /// `linear` or `log`.
    spacing: &'static str,
}

/// The comparison of the map with simulated runs, which leave out the parts in `left_out`, too.
#[derive(Debug, Serialize, JsonSchema)]
struct CheckPart {
    /// Number of runs.
    runs: usize,
    /// Number of runs more than 0.5 % away from the boundary.
    judged: usize,
    /// Share of these runs in which analysis and simulation agree, of those that decide; `None` without any.
    agreement: Option<f64>,
    /// The points at which analysis and simulation disagree.
    disagreements: Vec<UnconfirmedPart>,
    /// The points at which the simulated motion neither decays nor grows.
    undecided: Vec<UnconfirmedPart>,
}

/// A point at which the simulation does not confirm the analysis.
#[derive(Debug, Serialize, JsonSchema)]
struct UnconfirmedPart {
    /// Value of the horizontal axis.
    x: f64,
    /// Value of the vertical axis.
    y: f64,
    /// True if the linear loop is stable there.
    analytic_stable: bool,
    /// The outcome of a small motion in the simulation: `decays`, `grows` or `undecided`.
    simulated: &'static str,
    /// True if the boundary is within 0.5 %.
    is_near_boundary: bool,
}

pub(super) fn json(study: &StabilityStudy) -> Json {
    let StabilityStudy { name, verdict, analysis, map, check, .. } = study;
    let Analysis { settings, jitter_margin_ticks, limits, sensitivities, ports, sampled, .. } = analysis;
    let mut of_loop = LoopPart::of(verdict);
    of_loop.margins.jitter = Some(JitterPart {
        jitter_ticks: *jitter_margin_ticks,
        jitter_s: jitter_margin_ticks.map(|ticks| ticks as f64 * settings.tick_s),
        is_jitter_unlimited: analysis.is_jitter_unlimited(),
    });
    json_of(&StabilityFile {
        trocar_version: env!("CARGO_PKG_VERSION"),
        scenario: name,
        warnings: study.warnings(),
        of_loop,
        measured: study.measured.as_ref().map(|measured| MeasuredPart::of(measured, &study.analysis)),
        z_width: study.z_width.as_ref().map(ZWidthPart::of),
        population: study.population.as_ref().map(PopulationPart::of),
        limits: limits.iter().map(LimitPart::of).collect(),
        sensitivities: sensitivities.iter().map(SensitivityPart::of).collect(),
        ports: PortsPart {
            is_absolutely_stable: all(ports, |point| point.is_absolutely_stable),
            is_passive: all(ports, |point| point.is_passive),
            hand_port_is_passive_in_free_motion: all(ports, |point| is_passive_impedance(point.hybrid.h[0][0])),
            hand_port_is_passive_in_tissue: all(ports, |point| is_passive_impedance(point.transmitted)),
            needle_port_is_passive: all(ports, |point| is_passive_impedance(point.hybrid.h[1][1])),
            bounded: BoundedPart::of(analysis, &study.bounded),
            over: study.absolute.as_ref().map(AbsolutePart::of),
        },
        sampled_data: sampled.as_ref().map(SampledPart::of),
        certificate: StatementPart::of(study),
        event_limits: study.event_limits.iter().map(EventLimitPart::of).collect(),
        switching: SwitchingPart::of(study),
        map: MapPart {
            x: AxisPart::of(&map.x, settings),
            y: AxisPart::of(&map.y, settings),
            stable_share: map.stable_share(),
        },
        simulated: check.as_ref().map(CheckPart::of),
    })
}

impl<'a> LimitPart<'a> {
    fn of(limit: &'a Limit) -> Self {
        let largest = limit.largest();
        Self {
            parameter: limit.parameter.key(),
            value: limit.value,
            largest_stable: largest.filter(|largest| largest.is_finite()),
            is_beyond_search: largest.is_some_and(f64::is_infinite),
            searched_to: limit.search.high,
            stable_ranges: &limit.stable,
        }
    }
}

impl SensitivityPart {
    fn of(sensitivity: &Sensitivity) -> Self {
        let Sensitivity { limit, parameter, relative } = sensitivity;
        Self { limit: limit.key(), parameter: parameter.key(), relative: *relative }
    }
}

impl SampledPart {
    fn of(bound: &SampledBound) -> Self {
        let &SampledBound { min_damping_n_s_per_m, damping_n_s_per_m } = bound;
        Self { min_damping_n_s_per_m, damping_n_s_per_m, is_passive: bound.is_passive() }
    }
}

impl AxisPart {
    fn of(axis: &Axis, settings: &LinearLoop) -> Self {
        let &Axis { parameter, low, high, count, spacing } = axis;
        let spacing = if spacing == Spacing::Linear { "linear" } else { "log" };
        Self { parameter: parameter.key(), value: settings.get(parameter), low, high, count, spacing }
    }
}

impl CheckPart {
    fn of(check: &Check) -> Self {
        let point = |&Unconfirmed { x, y, analytic_stable, simulated, is_near_boundary }: &Unconfirmed| {
            UnconfirmedPart { x, y, analytic_stable, simulated: simulated.word(), is_near_boundary }
        };
        Self {
            runs: check.simulated.iter().flatten().count(),
            judged: check.judged,
            agreement: check.agreement(),
            disagreements: check.disagreements.iter().map(point).collect(),
            undecided: check.undecided.iter().map(point).collect(),
        }
    }
}

pub(super) fn all(ports: &[PortPoint], holds: impl Fn(&PortPoint) -> bool) -> Option<bool> {
    (!ports.is_empty()).then(|| ports.iter().all(holds))
}
