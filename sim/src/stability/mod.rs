//! Where the teleoperator is stable, from its matrices alone: the engine is not asked.
//!
//! In permanent contact with a linear tissue `f_e = K x_e + B v_e` everything between person and tissue is linear and
//! repeats every tick, so one matrix takes the loop from tick to tick ([`ClosedLoop::matrix`]), and the loop is stable where
//! every eigenvalue of it lies inside the unit circle. The master's side and the slave's meet only in the two delayed numbers
//! that go over the link, so the same is said by one loop gain
//!
//! ```text
//! L(z) = z^-(d_forward + d_backward) H_master(z) H_slave(z),      the closed loop's poles are the zeros of 1 - L(z)
//! ```
//! and counted by how often `1 - L` winds around 0 (Nyquist), whose cost does not grow with the cube of the delay
//! ([`ClosedLoop::poles_outside`]). From the same response come the margins ([`ClosedLoop::margins`]).
//!
//! What the person and the tissue are is left open in [`Ports`]: hybrid parameters, Llewellyn's parameter, passivity,
//! transparency. [`SampledWall`] is the passivity condition of a sampled-data display.
//!
//! Contact that is lost, events, and limits of the motors are not linear and not here; `stability_check` holds the verdicts
//! against the engine.

mod analysis;
mod axis_text;
mod closed_loop;
mod error;
mod limit;
mod machines;
mod map;
mod margins;
mod mode;
mod parameter;
mod ports;
mod response;
mod sampled;
mod sensitivity;
mod settings;
mod side;
mod switching;
mod winding;

pub use analysis::{Analysis, LIMITED, PortPoint};
pub use closed_loop::ClosedLoop;
pub use error::StabilityError;
pub use limit::{Limit, Search, largest_stable};
pub use map::{Axis, Spacing, StabilityMap, is_near_boundary, map};
pub use margins::Margins;
pub use mode::Mode;
pub use parameter::Parameter;
pub use ports::{Hybrid, Ports, is_passive_impedance};
pub use sampled::{SampledBound, SampledWall};
pub use sensitivity::{Sensitivity, sensitivities};
pub use settings::LoopSettings;
pub use switching::{
    Certificate, Cycle, DwellPoint, EventBound, GAP_M, Growth, LONGEST_DWELL_S, Phases, Reach, Sequence, Switching,
    SwitchingSettings,
};
