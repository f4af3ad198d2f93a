//! The verdict on a linear loop, in a sentence and as JSON.

use serde_json::{Value as Json, json};

use crate::stability_check::LoopVerdict;
use trocar_document::significant;
use trocar_stability::{DelayRange, LeftOut, LinearLoop, TissueRange, TissueSource, VaryingDelays};

/// The verdict on the loop in a sentence, with the tissue that it stands for.
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

/// Returns the tissue of a loop, as it follows "stable".
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

/// Returns the ranges of delays that vary.
fn ranges(delays: &VaryingDelays) -> String {
    let range = |way: DelayRange| format!("{} to {} ticks", way.min_ticks, way.max_ticks);
    format!("delays of {} to the slave and of {} to the master", range(delays.forward), range(delays.backward))
}

/// The verdict on a loop, with its tissue and what it leaves out.
pub(crate) fn json(verdict: &LoopVerdict) -> Json {
    let LoopVerdict { settings, mode, margins, .. } = verdict;
    json!({
        "verdict": sentence(verdict),
        "is_stable": verdict.is_stable(),
        "is_linear_loop_stable": verdict.is_linear_loop_stable(),
        "tissue": {
            "source": settings.tissue.source.word(),
            "stiffness_n_per_m": settings.tissue.stiffness_n_per_m,
            "damping_n_s_per_m": settings.tissue.damping_n_s_per_m,
        },
        "stiffness_n_per_m": settings.stiffness_n_per_m,
        "damping_n_s_per_m": settings.damping_n_s_per_m,
        "mode": {
            "pole": [mode.pole.re, mode.pole.im],
            "spectral_radius": mode.spectral_radius,
            "damping_ratio": mode.damping_ratio,
            "frequency_hz": mode.frequency_hz,
            "growth_per_s": mode.growth_per_s,
        },
        "margins": {
            "gain": margins.gain,
            "gain_frequency_hz": margins.gain_frequency_hz,
            "gain_below": margins.gain_below,
            "phase_rad": margins.phase_rad,
            "phase_frequency_hz": margins.phase_frequency_hz,
            "delay_s": margins.delay_s,
        },
        "unmodelled": verdict.unmodelled,
        "left_out": verdict.left_out.iter().map(|part| json!({ "key": part.key, "what": part.what, "largest": part.bound })).collect::<Vec<_>>(),
        "never_reached": verdict.unreached.iter().map(|limit| json!({
            "key": limit.part.key, "limit": limit.limit, "largest": limit.part.bound,
        })).collect::<Vec<_>>(),
        "varying_delays": verdict.delays.map(|delays| json!({
            "forward_ticks": [delays.forward.min_ticks, delays.forward.max_ticks],
            "backward_ticks": [delays.backward.min_ticks, delays.backward.max_ticks],
            "is_proved_stable": delays.is_proved,
            "can_be_outage": delays.can_be_outage,
        })),
    })
}
