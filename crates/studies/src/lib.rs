//! Studies of scenarios. The crate uses every package of the simulator except `trocar-link`, and does not draw or
//! print.

pub mod animation;
pub mod compare;
pub mod design;
pub mod fmu;
pub mod reference;
pub mod roc;
pub mod run;
pub mod stability_check;
pub mod sweep;
