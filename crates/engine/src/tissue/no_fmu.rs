//! The types have no values, because no unit can be opened.

use std::convert::Infallible;
use std::marker::PhantomData;
use std::path::Path;
use std::sync::Arc;

use thiserror::Error;

use super::model::NEEDS_FILE;
use super::{FmuSettings, Model, Reaction, Tissue, UnfitUnit, UnitProblem};
use trocar_core::error::InvalidValue;
use trocar_core::lane::{Gather, LANES, Lane};

#[derive(Debug, Clone, PartialEq, Error)]
#[error("this build of trocar runs no functional mock-up units, because its feature `fmu` is off")]
pub struct FmuError;

#[derive(Debug, Clone, PartialEq)]
pub struct UnitTissue(Infallible);

impl UnitTissue {
    pub fn open(_: &Path, _: &FmuSettings, _tick_s: f64) -> Result<Self, UnfitUnit> {
        Err(UnfitUnit { key: Self::file_key(), problem: UnitProblem::Unit(FmuError) })
    }

    pub fn load(&self) -> Result<(), FmuError> {
        match self.0 {}
    }

    #[must_use]
    pub fn path(&self) -> &Path {
        match self.0 {}
    }

    #[must_use]
    pub fn sha256(&self) -> [u8; 32] {
        match self.0 {}
    }
}

#[derive(Debug, Clone)]
pub struct Fmu<L: Lane> {
    never: Infallible,
    lanes: PhantomData<L>,
}

impl<L: Lane> Fmu<L> {
    #[must_use]
    pub fn new(tissue: Arc<UnitTissue>) -> Self {
        match tissue.0 {}
    }
}

impl<L: Lane> Tissue<L> for Fmu<L> {
    fn react(&mut self, _tick: u64, _position_m: L, _velocity_m_per_s: L) -> Reaction<L> {
        match self.never {}
    }
}

impl<L: Lane> Model for Fmu<L> {
    type Settings = FmuSettings;

    fn build(_: &FmuSettings, _tick_s: f64, _start_m: f64) -> Result<Self, InvalidValue> {
        Err(NEEDS_FILE)
    }

    fn check(_: &FmuSettings, _tick_s: f64, _start_m: f64) -> Result<(), InvalidValue> {
        Ok(())
    }
}

impl Gather for Fmu<f64> {
    type Of<L: Lane> = Fmu<L>;

    fn gather<L: Lane>([first, ..]: [&Self; LANES]) -> Option<Fmu<L>> {
        match first.never {}
    }
}
