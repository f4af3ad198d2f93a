use nalgebra::{DMatrix, DVector};

use super::linear_algebra::check_finite;
use super::{Complex64, Continuous, Discrete, Domain, Error, StateSpace, zero_order_hold};
use trocar_base::interrupt;
use trocar_base::large_pages::with_capacity;

#[derive(Debug, Clone, PartialEq)]
pub struct FrequencyPoint {
    pub omega_rad_per_s: f64,
    /// H(jω) or H(exp(jωT)), p x m.
    pub response: DMatrix<Complex64>,
}

impl FrequencyPoint {
    /// A ratio, not in decibels.
    pub fn magnitude(&self) -> DMatrix<f64> {
        self.response.map(|h| h.norm())
    }

    /// Between -π and π; 0 where H is 0.
    pub fn phase_rad(&self) -> DMatrix<f64> {
        self.response.map(|h| h.arg())
    }
}

/// A discrete response repeats above π/T. Fails at a pole.
pub fn frequency_response<D: Domain>(
    system: &StateSpace<D>,
    omegas_rad_per_s: &[f64],
) -> Result<Vec<FrequencyPoint>, Error> {
    check_finite("the list of frequencies", omegas_rad_per_s)?;
    omegas_rad_per_s
        .iter()
        .map(|&omega_rad_per_s| {
            let response = system.evaluate(system.domain().frequency_point(omega_rad_per_s))?;
            Ok(FrequencyPoint { omega_rad_per_s, response })
        })
        .collect()
}

/// Response to a unit step of one input at time 0, from rest.
#[derive(Debug, Clone, PartialEq)]
pub struct StepResponse {
    pub time_s: Vec<f64>,
    /// p x samples.
    pub outputs: DMatrix<f64>,
}

/// Exact, because a step is a held input.
pub fn step_response(
    system: &StateSpace<Continuous>,
    input: usize,
    tick_s: f64,
    samples: usize,
) -> Result<StepResponse, Error> {
    step_response_discrete(&zero_order_hold(system, tick_s)?, input, samples)
}

pub fn step_response_discrete(
    system: &StateSpace<Discrete>,
    input: usize,
    samples: usize,
) -> Result<StepResponse, Error> {
    if input >= system.inputs() {
        return Err(Error::IndexOutOfRange { what: "input", index: input, count: system.inputs() });
    }
    let mut outputs = with_capacity(system.outputs() * samples);
    let mut x = DVector::zeros(system.states());
    let mut time_s = with_capacity(samples);
    for k in 0..samples {
        interrupt::check_at(k as u64);
        time_s.push(k as f64 * system.tick_s());
        let y = system.c() * &x + system.d().column(input);
        outputs.extend_from_slice(y.as_slice());
        x = system.a() * &x + system.b().column(input);
    }
    Ok(StepResponse { time_s, outputs: DMatrix::from_vec(system.outputs(), samples, outputs) })
}

#[cfg(test)]
mod tests {
    use nalgebra::dmatrix;

    use super::*;

    #[test]
    fn a_corner_frequency_is_three_decibels_and_forty_five_degrees() {
        let lag = StateSpace::continuous(dmatrix![-7.0], dmatrix![7.0], dmatrix![1.0], dmatrix![0.0]);
        let point = &frequency_response(&lag.expect("well formed"), &[7.0]).expect("regular")[0];
        assert!((point.magnitude()[(0, 0)] - 0.5f64.sqrt()).abs() < 1e-15);
        assert!((point.phase_rad()[(0, 0)] + std::f64::consts::FRAC_PI_4).abs() < 1e-15);
    }

    #[test]
    fn the_response_of_an_integrator_is_infinite_at_zero_frequency() {
        let integrator = StateSpace::continuous(dmatrix![0.0], dmatrix![1.0], dmatrix![1.0], dmatrix![0.0]);
        let at_rest = frequency_response(&integrator.expect("well formed"), &[0.0]);
        assert_eq!(at_rest, Err(Error::AtPole { re: 0.0, im: 0.0 }));
    }

    #[test]
    fn a_running_sum_counts_its_ticks() {
        let sum = StateSpace::discrete(dmatrix![1.0], dmatrix![1.0], dmatrix![1.0], dmatrix![0.0], 0.25);
        let response = step_response_discrete(&sum.expect("well formed"), 0, 4).expect("one input");
        assert_eq!(response.time_s, [0.0, 0.25, 0.5, 0.75]);
        assert_eq!(response.outputs, dmatrix![0.0, 1.0, 2.0, 3.0]);
    }
}
