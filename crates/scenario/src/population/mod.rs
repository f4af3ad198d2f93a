//! A population around a scenario: people, tissues and links drawn at random.

mod draw;
mod settings;

pub use draw::{DIMENSIONS, Draw, log_normal};
pub use settings::{Arms, DelayRange, Delays, PeopleSettings, PopulationSettings, TissueSpread, Tissues};
