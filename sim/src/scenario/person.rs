//! From values to what a person adds to their motion: tremor and reflex.

use super::error::ScenarioError;
use super::values::Values;
use crate::operator::{Reflex, ReflexSettings, TremorSettings};

/// The hand's tremor.
pub(super) fn tremor(values: &Values) -> Result<TremorSettings, ScenarioError> {
    Ok(TremorSettings {
        amplitude_m: values.number("operator.tremor_amplitude_m")?,
        low_hz: values.number("operator.tremor_low_hz")?,
        high_hz: values.number("operator.tremor_high_hz")?,
    })
}

/// The person's reflex, if they have one.
pub(super) fn reflex(values: &Values) -> Result<Option<ReflexSettings>, ScenarioError> {
    let reflex = match values.text("operator.reflex")? {
        "stop" => Reflex::Stop,
        "withdraw" => Reflex::Withdraw {
            distance_m: values.number("operator.reflex_withdraw_m")?,
            speed_m_per_s: values.number("operator.reflex_withdraw_speed_m_per_s")?,
        },
        _ => return Ok(None),
    };
    Ok(Some(ReflexSettings {
        reflex,
        weber_fraction: values.number("operator.reflex_weber_fraction")?,
        reaction_min_s: values.number("operator.reflex_reaction_min_s")?,
        reaction_max_s: values.number("operator.reflex_reaction_max_s")?,
        memory_s: values.number("operator.reflex_memory_s")?,
        min_force_n: values.number("operator.reflex_least_force_n")?,
        pause_s: values.number("operator.reflex_pause_s")?,
    }))
}
