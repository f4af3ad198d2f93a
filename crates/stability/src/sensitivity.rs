use super::limit::StabilityTester;
use super::{Limit, LinearLoop, Parameter, StabilityError};
use trocar_base::parallel::try_map;

const STEP: f64 = 1e-4;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensitivity {
    pub limit: Parameter,
    pub parameter: Parameter,
    /// `d ln(limit) / d ln(parameter)`; `None` if the limit vanishes within the step.
    pub relative: Option<f64>,
}

pub fn sensitivities(settings: &LinearLoop, limits: &[Limit]) -> Result<Vec<Sensitivity>, StabilityError> {
    let mut pairs = vec![];
    for limit in limits {
        let Some(largest) = limit.largest().filter(|largest| largest.is_finite() && *largest > 0.0) else { continue };
        for parameter in Parameter::all() {
            let delays = [Parameter::Delay, Parameter::ForwardDelay, Parameter::BackwardDelay];
            let both_delays = delays.contains(&limit.parameter) && delays.contains(&parameter);
            if parameter != limit.parameter
                && parameter != Parameter::Delay
                && !both_delays
                && is_effective(settings, parameter)
            {
                pairs.push((limit.parameter, largest, parameter));
            }
        }
    }
    try_map(pairs.len(), |index| {
        let (limit, largest, parameter) = pairs[index];
        let value = settings.get(parameter);
        let near = |factor: f64| nearby(&settings.with(parameter, value * factor), limit, largest);
        let ends = near(1.0 + STEP)?.zip(near(1.0 - STEP)?);
        let relative = ends.map(|(up, down)| (up / down).ln() / ((1.0 + STEP) / (1.0 - STEP)).ln());
        Ok(Sensitivity { limit, parameter, relative })
    })
}

fn is_effective(settings: &LinearLoop, parameter: Parameter) -> bool {
    let couples = settings.link.controller.kind != trocar_engine::teleoperation::ControllerKind::PositionForce;
    let of_controller = matches!(
        parameter,
        Parameter::CouplingStiffness
            | Parameter::CouplingDamping
            | Parameter::MasterForceGain
            | Parameter::SlaveForceGain
            | Parameter::AccelerationBandwidth
    );
    settings.get(parameter) != 0.0 && (couples || !of_controller)
}

fn nearby(settings: &LinearLoop, limit: Parameter, known: f64) -> Result<Option<f64>, StabilityError> {
    let tester = StabilityTester::new(settings)?;
    let mut reach = 10.0 * STEP;
    while reach < 0.3 {
        let (low, high) = (known * (1.0 - reach), known * (1.0 + reach));
        if tester.is_stable(&[(limit, low)])? && !tester.is_stable(&[(limit, high)])? {
            return tester.boundary(limit, (low, high), true, 0.0).map(Some);
        }
        reach *= 3.0;
    }
    Ok(None)
}
