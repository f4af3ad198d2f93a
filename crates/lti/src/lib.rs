//! Linear time-invariant systems: from printed transfer functions to matrices for exact simulation steps.
//!
//! The crate depends only on `trocar-base`. The crate `trocar` re-exports it as `trocar::lti`.
//!
//! Typical use:
//!
//! 1. write the blocks as [`TransferFunction`]s, as printed;
//! 2. [`realise`] them, or use [`realise_with_derivative`] for position and velocity;
//! 3. [`append`] the blocks and connect them with an [`Interconnection`] (or [`connect`], its matrix form);
//! 4. compute [`exact_step`] over one tick.
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
//! Matrices for simulations use plain multiplications and additions in a fixed order, so every computer computes the
//! same bits.
//!
//! No function panics on invalid numbers; each returns an [`Error`] with the number and the remedy.

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

/// The complex number type of nalgebra.
pub type Complex64 = nalgebra::Complex<f64>;
