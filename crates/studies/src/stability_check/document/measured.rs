use schemars::JsonSchema;
use serde::Serialize;

use trocar_document::significant;
use trocar_stability::{Analysis, MeasuredLoop, MeasuredVerdict, Parameter};

/// A larger change of phase between two rows is uncertain.
const UNCERTAIN_DEG: f64 = 120.0;

/// The loop with measured frequency responses, over the range of their tables.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct MeasuredPart {
    /// Lowest and highest frequency of all tables, in Hz.
    range_hz: (f64, f64),
    /// `stable`, `unstable`, or `open` if the loop gain is not below 1 at the highest frequency.
    verdict: &'static str,
    /// The smallest factor of the loop gain at which the loop is not stable; `None` without one in the range.
    gain_margin: Option<f64>,
    /// The frequency of the gain margin, in Hz.
    gain_frequency_hz: Option<f64>,
    /// The smallest destabilising phase, in degrees; `None` unless a stable loop gain crosses 1.
    phase_margin_deg: Option<f64>,
    /// The smallest destabilising delay around the loop, in s.
    delay_margin_s: Option<f64>,
    /// The force scale up to which the loop is stable; `None` without a limit in the range.
    largest_force_scale: Option<f64>,
    /// The position scale up to which the loop is stable; `None` without a limit in the range.
    largest_position_scale: Option<f64>,
    /// The force scale from which the tables do not decide.
    open_from_force_scale: f64,
}

fn scales(analysis: &Analysis) -> [f64; 2] {
    [Parameter::ForceScale, Parameter::PositionScale].map(|parameter| analysis.settings.get(parameter))
}

impl MeasuredPart {
    pub(super) fn of(measured: &MeasuredLoop, analysis: &Analysis) -> Self {
        let [force, position] = scales(analysis);
        let factor = measured.limit.map(|(factor, _)| factor);
        Self {
            range_hz: measured.range_hz,
            verdict: match measured.verdict {
                MeasuredVerdict::Stable => "stable",
                MeasuredVerdict::Unstable => "unstable",
                MeasuredVerdict::Open => "open",
            },
            gain_margin: factor,
            gain_frequency_hz: measured.limit.map(|(_, hertz)| hertz),
            phase_margin_deg: measured.phase.map(|(phase, ..)| phase.to_degrees()),
            delay_margin_s: measured.phase.map(|(.., delay_s)| delay_s),
            largest_force_scale: factor.map(|factor| factor * force),
            largest_position_scale: factor.map(|factor| factor * position),
            open_from_force_scale: measured.open_from * force,
        }
    }
}

pub(super) fn lines(measured: &MeasuredLoop, analysis: &Analysis) -> Vec<String> {
    let part = MeasuredPart::of(measured, analysis);
    let (low, high) = part.range_hz;
    let range = format!("{} to {} Hz", significant(low), significant(high));
    let high = significant(high);
    let verdict = match measured.verdict {
        MeasuredVerdict::Stable => {
            format!("With the measured responses, known from {range}, the loop is stable.")
        }
        MeasuredVerdict::Unstable => format!("With the measured responses, known from {range}, the loop is unstable."),
        MeasuredVerdict::Open => format!(
            "The measured responses, known from {range}, do not decide: the loop gain is above 1 at {high} Hz. Measure \
             to a higher frequency."
        ),
    };
    let limit = match (measured.limit, part.largest_force_scale, part.largest_position_scale) {
        (Some((factor, hertz)), Some(force), Some(position)) => {
            let [factor, hertz, force, position] = [factor, hertz, force, position].map(significant);
            format!(
                "Gain margin {factor} at {hertz} Hz: the limit of the force scale is {force}, of the position scale \
                 {position}."
            )
        }
        _ => "In this range no scale makes the loop unstable.".to_owned(),
    };
    let phase = part.phase_margin_deg.zip(part.delay_margin_s).map(|(degrees, delay_s)| {
        format!("Phase margin {}°, delay margin {} ms.", significant(degrees), significant(1e3 * delay_s))
    });
    let open = format!(
        "Left open by the range: the loop gain above {high} Hz, which must stay below 1; from a force scale of {} it \
         is above 1 at {high} Hz already.",
        significant(part.open_from_force_scale)
    );
    let turn = measured.largest_turn_rad.to_degrees();
    let coarse = (turn > UNCERTAIN_DEG).then(|| {
        format!(
            "A measured phase changes by {}° between two rows; whole turns may be missing. Measure more frequencies.",
            significant(turn)
        )
    });
    [verdict, limit].into_iter().chain(phase).chain([open]).chain(coarse).collect()
}
