//! Studies of scenarios. The crate does not draw or print.

pub mod animation;
pub mod compare;
pub mod design;
pub mod fmu;
pub mod reference;
pub mod roc;
pub mod run;
pub mod stability_check;
pub mod sweep;
