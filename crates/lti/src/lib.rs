//! Linear time-invariant systems: [`realise`] and [`append`] printed [`TransferFunction`]s, connect them by an
//! [`Interconnection`], and compute the [`exact_step`] for simulations.
//!
//! ```
//! # mod trocar { pub use trocar_lti as lti; }
//! use trocar::lti::{InputHold, TransferFunction, exact_step, realise_with_derivative};
//!
//! // Eq. 28, the master: 1 / (0.245 s² + 4.1 s), force to position.
//! let master = TransferFunction::new(&[1.0], &[0.245, 4.1, 0.0])?;
//! let system = realise_with_derivative(&master)?; // states: position, velocity
//! let step = exact_step(&system, 1e-3, &[InputHold::Held])?;
//! assert_eq!(step.phi.shape(), (2, 2));
//! # Ok::<(), trocar::lti::Error>(())
//! ```
//!
//! Matrices for simulations have the same bits on every computer. No function panics on invalid numbers.

mod connections;
mod domain;
mod error;
mod hold;
mod interconnection;
mod lag;
mod linear_algebra;
mod matrix_function;
mod polynomial;
mod realisation;
mod response;
mod state_space;
mod static_gains;
mod transfer_function;
mod tustin;

pub use connections::{append, feedback, parallel, series};
pub use domain::{Continuous, Discrete, Domain};
pub use error::Error;
pub use hold::{ExactStep, InputHold, exact_step, undo_zero_order_hold, zero_order_hold};
pub use interconnection::{Interconnection, Signal, WeightedSignals};
pub use lag::{LaggedInput, lagged_input};
pub use linear_algebra::eigenvalues;
pub use matrix_function::{exponential, logarithm};
pub use polynomial::Polynomial;
pub use realisation::{outputs_first, realise, realise_with_derivative};
pub use response::{FrequencyPoint, StepResponse, frequency_response, step_response, step_response_discrete};
pub use state_space::StateSpace;
pub use static_gains::connect;
pub use transfer_function::TransferFunction;
pub use tustin::{tustin, undo_tustin};

pub type Complex64 = nalgebra::Complex<f64>;
