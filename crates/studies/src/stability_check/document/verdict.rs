use schemars::JsonSchema;
use serde::Serialize;

use crate::stability_check::LoopVerdict;
use trocar_document::significant;
use trocar_engine::tissue::{Relaxation, Springs};
use trocar_stability::{DelayRange, LeftOut, Limit, LinearLoop, LoopLimit, Margins, TissueSource, VaryingDelays};

pub(crate) fn sentence(verdict: &LoopVerdict) -> String {
    let delays = verdict.delays.as_ref().map(ranges);
    let of_loop = of_range(verdict);
    match verdict.is_stable() {
        Some(true) => {
            let orders = delays.map(|ranges| format!(", for every order of {ranges} (small gain)"));
            format!("{of_loop}{}", orders.unwrap_or_default())
        }
        Some(false) => of_loop,
        None => {
            let parts: Vec<String> = verdict.left_out.iter().map(LeftOut::to_string).collect();
            format!(
                "stability unknown: the analysis leaves out {}{}; without that, {of_loop}",
                parts.join(", "),
                delays.map(|ranges| format!(", with {ranges}")).unwrap_or_default(),
            )
        }
    }
}

fn of_range(LoopVerdict { settings, range, .. }: &LoopVerdict) -> String {
    let Springs { stiffness_n_per_m: (low, high), drawn_back_n_per_m, damping_n_s_per_m, .. } = settings.tissue.springs;
    let stiffness = |(low, high): (f64, f64)| format!("{} to {} N/m", significant(low), significant(high));
    if settings.tissue.source == TissueSource::RecordedForce {
        return match range.is_stable {
            true => "stable by itself; the recorded force closes no loop".to_owned(),
            false => "not stable by itself, although the recorded force closes no loop".to_owned(),
        };
    }
    if range.is_stable {
        return format!("stable {}, and out of contact", in_tissue(settings));
    }
    let bears = match range.stable_up_to_n_per_m {
        Some(up_to) if up_to > 0.0 => format!(": the loop bears {} N/m", significant(up_to)),
        _ => String::new(),
    };
    if range.is_stable_advancing {
        format!(
            "stable while the needle advances, {}; not stable when it is drawn back, up to {} N/m{bears}",
            stiffness((low, high)),
            significant(drawn_back_n_per_m),
        )
    } else if range.is_stable_with_least_damping {
        let (_, most) = damping_n_s_per_m;
        format!("not stable with the damping of the tissue, up to {} N·s/m{bears}", significant(most))
    } else {
        format!("not stable {}{bears}", in_tissue(settings))
    }
}

/// Adds the largest stable force scale.
pub(crate) fn instability(verdict: &LoopVerdict, limit: &Limit) -> String {
    let when = if verdict.range.is_stable_advancing { " when the needle is drawn back" } else { "" };
    let at = significant(limit.value);
    match limit.largest() {
        Some(largest) if largest < limit.value => {
            format!("not stable{when} at force scale {at}: at most {}", significant(largest))
        }
        Some(_) => format!("not stable{when} at force scale {at}"),
        None => format!("not stable{when} at any tried force scale (here {at})"),
    }
}

/// Continues "stable".
fn in_tissue(settings: &LinearLoop) -> String {
    let Springs { stiffness_n_per_m: (low, high), drawn_back_n_per_m, damping_n_s_per_m: (least, most), .. } =
        settings.tissue.springs;
    let (stiffness, damping) = (significant(settings.stiffness_n_per_m), significant(settings.damping_n_s_per_m));
    let single = format!("in contact with {stiffness} N/m and {damping} N·s/m");
    let back = if drawn_back_n_per_m > high {
        format!(", up to {} N/m when the needle is drawn back", significant(drawn_back_n_per_m))
    } else {
        String::new()
    };
    let (dampings, worst_damping) = if most > 0.0 {
        (format!(" and {} to {} N·s/m", significant(least), significant(most)), format!(" and {damping} N·s/m"))
    } else {
        (String::new(), String::new())
    };
    let worst = format!(
        "in contact with {} to {} N/m{back}{dampings}, worst at {stiffness} N/m{worst_damping}",
        significant(low),
        significant(high)
    );
    match settings.tissue.source {
        TissueSource::SpringDamper => single,
        TissueSource::Stated => format!("{single}, stated in place of the recorded force"),
        TissueSource::RecordedForce => "under the recorded force".to_owned(),
        TissueSource::Model => format!("{worst} (slopes of the tissue down to the depth that the needle may reach)"),
        TissueSource::Layers => format!("{worst} (slopes of the layers between ruptures)"),
        TissueSource::RecordedDepth => format!("{worst} (slopes of the recorded force)"),
    }
}

fn ranges(delays: &VaryingDelays) -> String {
    let range = |way: DelayRange| format!("{} to {} ticks", way.min_ticks, way.max_ticks);
    format!("delays of {} to the slave and of {} to the master", range(delays.forward), range(delays.backward))
}

/// The verdict on a linear loop, with its tissue and the parts of the scenario that it leaves out.
#[derive(Debug, Serialize, JsonSchema)]
pub struct LoopPart {
    /// The verdict in one sentence.
    verdict: String,
    /// True if the loop is stable at every spring and damper of its tissue and out of contact, for every order of varying
    /// delays; `None` if the analysis leaves out a part of the scenario.
    is_stable: Option<bool>,
    /// The same without the parts that the analysis leaves out.
    is_linear_loop_stable: bool,
    /// True if the loop is stable while the needle advances, without the parts that the analysis leaves out.
    is_stable_advancing: bool,
    /// Stiffness in N/m up to which the loop is stable at every damping of its tissue, at most the tissue's largest;
    /// `None` if it is not stable out of contact.
    stable_up_to_n_per_m: Option<f64>,
    tissue: TissuePart,
    /// Worst stiffness of the tissue, in N/m, for which the following numbers hold.
    stiffness_n_per_m: f64,
    /// Worst damping of the tissue, in N·s/m.
    damping_n_s_per_m: f64,
    mode: ModePart,
    /// The margins of the loop; `None` for an unstable loop, and for a margin without a limit, which has a flag.
    pub(super) margins: MarginsPart,
    /// The parts of the scenario with which the stability is unknown: they can supply energy or delay.
    left_out: Vec<LeftOutPart>,
    /// The parts that the loop does not model because they only dissipate energy.
    assumed_passive: Vec<LeftOutPart>,
    /// The parts that act on the loop as inputs.
    inputs: Vec<LeftOutPart>,
    /// The limits of motors and force sensor that the loop never reaches.
    never_reached: Vec<UnreachedPart>,
    /// Delays that vary from tick to tick; `None` if they are constant or unbounded.
    varying_delays: Option<DelaysPart>,
}

/// The springs and dampers that the needle meets.
#[derive(Debug, Serialize, JsonSchema)]
struct TissuePart {
    /// Source of the ranges.
    source: &'static str,
    /// Minimum and maximum stiffness while the needle advances, in N/m.
    stiffness_n_per_m: (f64, f64),
    /// Maximum stiffness when the needle is drawn back, in N/m.
    drawn_back_n_per_m: f64,
    /// Minimum and maximum damping, in N·s/m.
    damping_n_s_per_m: (f64, f64),
    /// The relaxation of the stiffest spring; `None` if it does not relax.
    relaxation: Option<RelaxationPart>,
}

/// The relaxation of a spring.
#[derive(Debug, Serialize, JsonSchema)]
struct RelaxationPart {
    /// Stiffness of a slow deflection over that of a fast one.
    relaxed_share: f64,
    /// Time constant of a held deflection, in s.
    time_s: f64,
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

/// A part of the scenario that the linear loop does not model.
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

impl LoopPart {
    /// Leaves out the jitter margin.
    pub fn of(verdict: &LoopVerdict) -> Self {
        let LoopVerdict { settings, mode, margins, .. } = verdict;
        let springs = &settings.tissue.springs;
        let part = |part: &LeftOut| LeftOutPart { key: part.key, what: part.what, largest: part.bound };
        let unreached =
            |limit: &LoopLimit| UnreachedPart { key: limit.part.key, limit: limit.limit, largest: limit.part.bound };
        let ticks = |way: DelayRange| [way.min_ticks, way.max_ticks];
        Self {
            verdict: sentence(verdict),
            is_stable: verdict.is_stable(),
            is_linear_loop_stable: verdict.range.is_stable,
            is_stable_advancing: verdict.range.is_stable_advancing,
            stable_up_to_n_per_m: verdict.range.stable_up_to_n_per_m,
            tissue: TissuePart {
                source: settings.tissue.source.word(),
                stiffness_n_per_m: springs.stiffness_n_per_m,
                drawn_back_n_per_m: springs.drawn_back_n_per_m,
                damping_n_s_per_m: springs.damping_n_s_per_m,
                relaxation: springs
                    .relaxation
                    .map(|Relaxation { relaxed_share, time_s }| RelaxationPart { relaxed_share, time_s }),
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
            left_out: verdict.left_out.iter().map(part).collect(),
            assumed_passive: verdict.assumed_passive.iter().map(part).collect(),
            inputs: verdict.inputs.iter().map(part).collect(),
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
