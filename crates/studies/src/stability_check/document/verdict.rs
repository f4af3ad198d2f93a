//! The verdict on a linear loop, as a sentence and in JSON files.

use schemars::JsonSchema;
use serde::Serialize;

use crate::stability_check::LoopVerdict;
use trocar_document::significant;
use trocar_stability::{DelayRange, LeftOut, LinearLoop, LoopLimit, Margins, TissueRange, TissueSource, VaryingDelays};

pub(crate) fn sentence(verdict: &LoopVerdict) -> String {
    let settings = &verdict.settings;
    let tissue = in_tissue(settings);
    let word = |is_stable: bool| if is_stable { "stable" } else { "not stable" };
    let delays = verdict.delays.as_ref().map(ranges);
    match verdict.is_stable() {
        Some(true) => {
            let orders = delays.map(|ranges| format!(", for every order of {ranges} (small gain)"));
            let free = if settings.tissue.source == TissueSource::RecordedForce { "" } else { ", and out of contact" };
            format!("stable {tissue}{free}{}", orders.unwrap_or_default())
        }
        Some(false) if verdict.is_linear_loop_stable() => {
            format!("not stable at every smaller stiffness, but stable {tissue}")
        }
        Some(false) => format!("not stable {tissue}"),
        None => {
            let parts: Vec<String> = verdict.left_out.iter().map(LeftOut::to_string).collect();
            format!(
                "stability unknown: the analysis leaves out {}{}; without that, {} {tissue}",
                parts.join(", "),
                delays.map(|ranges| format!(", with {ranges}")).unwrap_or_default(),
                word(verdict.is_linear_loop_stable())
            )
        }
    }
}

/// The tissue of a loop, as a continuation of "stable".
fn in_tissue(settings: &LinearLoop) -> String {
    let TissueRange { source, stiffness_n_per_m: (low, high), .. } = settings.tissue;
    let (stiffness, damping) = (significant(settings.stiffness_n_per_m), significant(settings.damping_n_s_per_m));
    let range = format!("{} to {} N/m", significant(low), significant(high));
    let worst = format!("in contact with {range}, worst at {stiffness} N/m");
    match source {
        TissueSource::SpringDamper => format!("in contact with {stiffness} N/m and {damping} N·s/m"),
        TissueSource::Stated => {
            format!("in contact with {stiffness} N/m and {damping} N·s/m, stated in place of the recorded force")
        }
        TissueSource::RecordedForce => {
            "under the recorded force, which does not depend on the needle and closes no loop".to_owned()
        }
        TissueSource::Model => format!("{worst} (slopes of the tissue down to the intended depth)"),
        TissueSource::Layers => format!("{worst} (slopes of the layers between ruptures)"),
        TissueSource::RecordedDepth => format!("{worst} (rises of the recorded force)"),
        TissueSource::Run => format!("{worst} (slopes that the tissue showed in a run)"),
    }
}

fn ranges(delays: &VaryingDelays) -> String {
    let range = |way: DelayRange| format!("{} to {} ticks", way.min_ticks, way.max_ticks);
    format!("delays of {} to the slave and of {} to the master", range(delays.forward), range(delays.backward))
}

/// The verdict on a linear loop, with its tissue and the parts of the scenario that it leaves out.
#[derive(Debug, Serialize, JsonSchema)]
pub struct LoopPart<'a> {
    /// The verdict in one sentence.
    verdict: String,
    /// True if the loop is stable in contact and in free motion, for every order of varying delays; `None` if the
    /// analysis leaves out a part of the scenario.
    is_stable: Option<bool>,
    /// True if the loop is stable at the worst stiffness, without the parts that the analysis leaves out.
    is_linear_loop_stable: bool,
    tissue: TissuePart,
    /// Worst stiffness of the tissue, in N/m, for which the following numbers hold.
    stiffness_n_per_m: f64,
    /// Damping of the tissue, in N·s/m.
    damping_n_s_per_m: f64,
    mode: ModePart,
    /// The margins of the loop; `None` for an unstable loop, and for a margin without a limit, which has a flag.
    pub(super) margins: MarginsPart,
    /// Everything that the linear loop leaves out, including tissue and augmentation.
    unmodelled: &'a [String],
    /// The parts of the scenario without which the verdict holds.
    left_out: Vec<LeftOutPart>,
    /// The limits of motors and force sensor that the loop never reaches.
    never_reached: Vec<UnreachedPart>,
    /// Delays that vary from tick to tick; `None` if they are constant or unbounded.
    varying_delays: Option<DelaysPart>,
}

/// The range of stiffness that the needle encounters.
#[derive(Debug, Serialize, JsonSchema)]
struct TissuePart {
    /// Source of the range.
    source: &'static str,
    /// Minimum and maximum stiffness, in N/m.
    stiffness_n_per_m: (f64, f64),
    /// Damping, in N·s/m.
    damping_n_s_per_m: f64,
}

/// The dominant mode of the loop: the pole z = exp(s T) with the largest modulus.
#[derive(Debug, Serialize, JsonSchema)]
struct ModePart {
    /// Real and imaginary part of z.
    pole: [f64; 2],
    /// Modulus of z; the loop is stable below 1.
    spectral_radius: f64,
    /// -Re s / |s|; the mode does not oscillate at 1, and grows below 0.
    #[schemars(with = "Option<f64>")]
    damping_ratio: f64,
    /// |Im s| / 2π, in Hz.
    frequency_hz: f64,
    /// Re s, in 1/s.
    #[schemars(with = "Option<f64>")]
    growth_per_s: f64,
}

/// The smallest changes that make the loop unstable.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct MarginsPart {
    /// Smallest destabilising factor above 1 on the gain.
    gain: Option<f64>,
    /// True if the loop is stable, and no such factor makes it unstable.
    is_gain_unlimited: bool,
    /// Frequency of this gain margin, in Hz.
    gain_frequency_hz: Option<f64>,
    /// Largest destabilising factor below 1 on the gain, for a conditionally stable loop.
    gain_below: Option<f64>,
    /// Smallest destabilising phase in either direction, in rad.
    phase_rad: Option<f64>,
    /// True if the loop is stable, and no phase makes it unstable.
    is_phase_unlimited: bool,
    /// Frequency of this phase margin, in Hz.
    phase_frequency_hz: Option<f64>,
    /// Smallest destabilising additional delay around the loop, in s.
    delay_s: Option<f64>,
    /// True if the loop is stable, and no additional delay makes it unstable.
    is_delay_unlimited: bool,
    #[serde(flatten)]
    pub(super) jitter: Option<JitterPart>,
}

/// The jitter margin, which only `stability.json` contains.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct JitterPart {
    /// Largest jitter of both directions, in ticks, for which stability is proved in every order of the delays.
    pub(super) jitter_ticks: Option<u64>,
    /// The same jitter in s.
    pub(super) jitter_s: Option<f64>,
    /// True if stability is proved for any jitter.
    pub(super) is_jitter_unlimited: bool,
}

/// A part of the scenario that the analysis leaves out.
#[derive(Debug, Serialize, JsonSchema)]
struct LeftOutPart {
    /// The key that enables it.
    key: &'static str,
    /// Name.
    what: &'static str,
    /// For a limit: the largest magnitude in the loop, in the unit of the key, if known.
    largest: Option<f64>,
}

/// A limit that the loop never reaches.
#[derive(Debug, Serialize, JsonSchema)]
struct UnreachedPart {
    /// Key of the limit.
    key: &'static str,
    /// The limit, in the unit of the key.
    limit: f64,
    /// Largest magnitude in the loop, in the unit of the key.
    largest: Option<f64>,
}

/// Delays that vary from tick to tick.
#[derive(Debug, Serialize, JsonSchema)]
struct DelaysPart {
    /// Minimum and maximum delay from the master to the slave, in ticks.
    forward_ticks: [u64; 2],
    /// Minimum and maximum delay from the slave to the master, in ticks.
    backward_ticks: [u64; 2],
    /// True if stability is proved for every order of these delays.
    is_proved_stable: bool,
    /// True if a receiver can lack new samples long enough to detect an outage.
    can_be_outage: bool,
}

impl MarginsPart {
    fn of(margins: &Margins) -> Self {
        let finite = |margin: Option<f64>| margin.filter(|margin| margin.is_finite());
        let is_unlimited = |margin: Option<f64>| margin == Some(f64::INFINITY);
        Self {
            gain: finite(margins.gain),
            is_gain_unlimited: is_unlimited(margins.gain),
            gain_frequency_hz: margins.gain_frequency_hz,
            gain_below: margins.gain_below,
            phase_rad: finite(margins.phase_rad),
            is_phase_unlimited: is_unlimited(margins.phase_rad),
            phase_frequency_hz: margins.phase_frequency_hz,
            delay_s: finite(margins.delay_s),
            is_delay_unlimited: is_unlimited(margins.delay_s),
            jitter: None,
        }
    }
}

impl<'a> LoopPart<'a> {
    /// Creates the verdict without the jitter margin.
    #[must_use]
    pub fn of(verdict: &'a LoopVerdict) -> Self {
        let LoopVerdict { settings, mode, margins, .. } = verdict;
        let left_out = |part: &LeftOut| LeftOutPart { key: part.key, what: part.what, largest: part.bound };
        let unreached =
            |limit: &LoopLimit| UnreachedPart { key: limit.part.key, limit: limit.limit, largest: limit.part.bound };
        let ticks = |way: DelayRange| [way.min_ticks, way.max_ticks];
        Self {
            verdict: sentence(verdict),
            is_stable: verdict.is_stable(),
            is_linear_loop_stable: verdict.is_linear_loop_stable(),
            tissue: TissuePart {
                source: settings.tissue.source.word(),
                stiffness_n_per_m: settings.tissue.stiffness_n_per_m,
                damping_n_s_per_m: settings.tissue.damping_n_s_per_m,
            },
            stiffness_n_per_m: settings.stiffness_n_per_m,
            damping_n_s_per_m: settings.damping_n_s_per_m,
            mode: ModePart {
                pole: [mode.pole.re, mode.pole.im],
                spectral_radius: mode.spectral_radius,
                damping_ratio: mode.damping_ratio,
                frequency_hz: mode.frequency_hz,
                growth_per_s: mode.growth_per_s,
            },
            margins: MarginsPart::of(margins),
            unmodelled: &verdict.unmodelled,
            left_out: verdict.left_out.iter().map(left_out).collect(),
            never_reached: verdict.unreached.iter().map(unreached).collect(),
            varying_delays: verdict.delays.map(|delays| DelaysPart {
                forward_ticks: ticks(delays.forward),
                backward_ticks: ticks(delays.backward),
                is_proved_stable: delays.is_proved,
                can_be_outage: delays.can_be_outage,
            }),
        }
    }
}
