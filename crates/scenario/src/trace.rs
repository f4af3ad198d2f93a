use super::Scenario;
use trocar_engine::engine::{Trace, UserDefinedParts};

/// Has all columns of the run.
pub fn empty_trace(scenario: &Scenario) -> Trace {
    empty_trace_with(scenario, &UserDefinedParts::default())
}

/// A user-defined estimator has no extra parameter.
pub fn empty_trace_with(scenario: &Scenario, parts: &UserDefinedParts) -> Trace {
    let column = scenario.estimator.extra_parameter_column().filter(|_| parts.estimator.is_none());
    Trace::new(scenario.grid).with_extra_parameter(column).with_contact(scenario.contact_m)
}
