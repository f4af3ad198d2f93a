//! Settings of a scenario that are best for a group of patients, found by an evolutionary [`Search`] and judged on
//! other patients with other noise ([`Validation`]).

mod bootstrap;
mod certify;
mod document;
mod evaluate;
mod file;
mod goals;
mod loops;
mod nsga;
mod patients;
mod population;
mod problem;
mod quantity;
mod race;
mod schema;
mod search;
mod sensitivity;
mod stages;
mod validation;

pub use bootstrap::Estimate;
pub use certify::Front;
pub use document::{DesignResultFile, DesignStudy};
pub use evaluate::{Ended, Evaluation};
pub use file::{DESIGN_KEYS, SearchSettings, Size};
pub use goals::{Constraint, Direction, Goals, Limit, Objective};
pub use nsga::{Gene, Point};
pub use patients::Patients;
pub use population::{Population, Use};
pub use problem::{Problem, is_design};
pub use quantity::{Aggregate, Quantity, Samples};
pub use schema::design_schema;
pub use search::{Search, State, Stopped};
pub use sensitivity::{Sensitivity, sensitivities};
pub use stages::{Design, DesignError, Follower, Stage};
pub use validation::{Designed, Estimates, Shipped, Validation};
