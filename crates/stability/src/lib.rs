//! Linear stability analysis of the teleoperator, without simulation.
//!
//! In permanent contact with `f_e = K x_e + B v_e` the loop is stable if all eigenvalues of [`ClosedLoop::matrix`] lie
//! inside the unit circle. The loop gain gives the same verdict:
//!
//! ```text
//! L(z) = z^-(d_forward + d_backward) H_master(z) H_slave(z),      the closed loop's poles are the zeros of 1 - L(z)
//! ```
//! The winding number of `1 - L` around 0 counts the unstable poles (Nyquist), without the cubic cost of eigenvalues.

mod analysis;
mod axis_text;
mod bounded;
mod certificate;
mod closed_loop;
mod coverage;
mod error;
mod limit;
mod linear_loop;
mod loop_response;
mod machines;
mod map;
mod margins;
mod measured;
mod mode;
mod parameter;
mod population;
mod ports;
mod re_engaging;
mod reached;
mod response;
mod response_path;
mod sampled;
mod semidefinite;
mod sensitivity;
mod shares;
mod side;
mod switching;
mod systems;
mod varying;
mod winding;
mod worst;
mod z_width;

pub use analysis::{Analysis, LIMITED, PortPoint};
pub use bounded::{AbsoluteOver, AbsolutePoint, Bounded, NeededDamping, Terminations, arm_impedance};
pub use certificate::{Certificate, Choice, Inequality, Lyapunov, MapFactor, State, StateMap, StateSpace, Summand};
pub use closed_loop::ClosedLoop;
pub use coverage::{LeftOut, LoopLimit, assumed_passive, inputs, left_out, left_out_with, loop_limits};
pub use error::StabilityError;
pub use limit::{Limit, Search, largest_stable};
pub use linear_loop::LinearLoop;
pub use loop_response::LoopResponse;
pub use map::{Axis, Spacing, StabilityMap, is_near_boundary, map};
pub use margins::{MAX_GAIN_MARGIN, Margins};
pub use measured::{FrequencyResponse, MeasuredLoop, MeasuredSides, MeasuredVerdict};
pub use mode::Mode;
pub use parameter::Parameter;
pub use population::{LimitQuantiles, Member, Population, Quantile, Worst};
pub use ports::{Hybrid, Ports, is_passive_impedance};
pub use re_engaging::EventBound;
pub use sampled::{SampledBound, SampledWall};
pub use sensitivity::{Sensitivity, sensitivities};
pub use shares::ShareMap;
pub use switching::{
    Cycle, DwellPoint, GAP_M, Growth, LONGEST_DWELL_S, Peaks, Phases, SimulatedCycle, SimulatedGrowth, Switching,
    SwitchingSettings, adversary,
};
pub use systems::{Locus, LoopSystem, PolesAndZeros};
pub use trocar_scenario::{TissueRange, TissueSource};
pub use varying::{DelayRange, VaryingDelays};
pub use worst::RangeVerdict;
pub use z_width::{Walls, ZWidth};
