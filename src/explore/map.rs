//! The loop in permanent contact over two parameters, around the values of the page.

use serde_json::{Value, json};

use super::limits::MAP_POINTS;
use super::pair::PairMaker;
use super::protocol::{MapRequest, ServerMessage};
use super::state::StateError;
use trocar_document::figure::{self as figures, X_TICKS};
use trocar_stability::{Axis, Parameter, Spacing, map};
use trocar_studies::stability_check::{CheckError, LoopVerdict};

/// Ratio between the ends of an axis and a value other than 0.
const SPAN_RATIO: f64 = 12.0;

pub(super) fn mapped(request: &MapRequest, maker: &mut PairMaker) -> Result<ServerMessage, StateError> {
    let scenario = maker.unpaired(&request.state)?;
    let verdict = LoopVerdict::of(&scenario)?;
    let settings = &verdict.settings;
    let axes = || StateError::Axes(request.x.chars().take(80).collect(), request.y.chars().take(80).collect());
    let parameter = |key: &str| Parameter::of_key(key).ok_or_else(axes);
    let (x, y) = (parameter(&request.x)?, parameter(&request.y)?);
    if x.varies_with(y) {
        return Err(axes());
    }
    let x_axis = with_range(axis(x, settings.get(x)), request.x_range);
    let y_axis = with_range(axis(y, settings.get(y)), request.y_range);
    let map = map(settings, x_axis, y_axis).map_err(CheckError::from)?;
    let axis_json = |axis: &Axis| {
        let (name, per) = shown_unit(axis.parameter);
        let is_log = axis.spacing == Spacing::Logarithmic;
        let shown = figures::Axis::over((per * axis.low, per * axis.high), is_log, X_TICKS);
        let place = |at: f64| if is_log { at - per.log10() } else { at / per };
        let ticks: figures::Ticks = shown.all_ticks().into_iter().map(|(at, label)| (place(at), label)).collect();
        json!({
            "key": axis.parameter.key(),
            "name": name,
            "per": per,
            "low": axis.low,
            "high": axis.high,
            "count": axis.count,
            "log": is_log,
            "ticks": ticks,
            "now": settings.get(axis.parameter),
        })
    };
    let rows = map.stable.iter().map(|stable| if *stable { '1' } else { '0' });
    let mut message = json!({
        "type": "mapped",
        "id": request.id,
        "x": axis_json(&map.x),
        "y": axis_json(&map.y),
        "stable": rows.collect::<String>(),
        "boundary": map.boundary,
    });
    if let (Value::Object(message), Value::Object(verdict)) = (&mut message, verdict.json()) {
        message.extend(verdict);
    }
    Ok(ServerMessage::json(&message))
}

/// The caption, and displayed units per SI unit (delays are in ms).
fn shown_unit(parameter: Parameter) -> (String, f64) {
    let caption = parameter.caption();
    match parameter {
        Parameter::Delay | Parameter::ForwardDelay | Parameter::BackwardDelay => (caption.replace("(s)", "(ms)"), 1e3),
        _ => (caption.to_owned(), 1.0),
    }
}

fn with_range(axis: Axis, range: Option<(f64, f64)>) -> Axis {
    let (low, high) = range.unwrap_or((axis.low, axis.high));
    let is_valid = low < high.min(max_of(axis.parameter)) && low >= 0.0 && high.is_finite();
    if !is_valid {
        return axis;
    }
    // A map of this parameter was linear if it began at 0.
    let spacing = if low > 0.0 { Spacing::Logarithmic } else { Spacing::Linear };
    Axis { low, high: high.min(max_of(axis.parameter)), spacing, ..axis }
}

fn axis(parameter: Parameter, value: f64) -> Axis {
    let value = value.abs();
    let (low, high, spacing) = if value > 0.0 && value.is_finite() {
        (value / SPAN_RATIO, value * SPAN_RATIO, Spacing::Logarithmic)
    } else if matches!(parameter, Parameter::Delay | Parameter::ForwardDelay | Parameter::BackwardDelay) {
        (0.0, 0.05, Spacing::Linear)
    } else if parameter == Parameter::Stiffness {
        // The force law does not depend on the tissue, so any tissue is possible.
        (10.0, 5000.0, Spacing::Logarithmic)
    } else {
        let high = match parameter {
            Parameter::Compliance => 0.01,
            Parameter::MasterLag | Parameter::SlaveLag => 0.02,
            Parameter::AccelerationBandwidth | Parameter::ForceBandwidth => 200.0,
            _ => 10.0,
        };
        (0.0, high, Spacing::Linear)
    };
    let high = high.min(max_of(parameter));
    let low = if spacing == Spacing::Logarithmic { low.min(high / 2.0) } else { low };
    Axis { parameter, low, high, count: MAP_POINTS, spacing }
}

/// The upper limit of an axis: a long tick gives no loop, and each tick of delay adds a state.
fn max_of(parameter: Parameter) -> f64 {
    match parameter {
        Parameter::Tick => 0.02,
        Parameter::Delay | Parameter::ForwardDelay | Parameter::BackwardDelay => 0.25,
        _ => f64::INFINITY,
    }
}
