//! A random population of people, tissues and links around a scenario.

mod draw;
mod settings;

pub use draw::{DIMENSIONS, Draw, log_normal};
pub use settings::{Arms, DelayRange, Delays, PeopleSettings, PopulationSettings, TissueSpread, Tissues};
