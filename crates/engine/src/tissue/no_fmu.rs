//! The tissue in a functional mock-up unit, in a build without the feature `fmu`: no unit can be opened, so its types
//! have no values.

use std::convert::Infallible;
use std::marker::PhantomData;
use std::path::Path;
use std::sync::Arc;

use thiserror::Error;

use super::model::NEEDS_FILE;
use super::{FmuSettings, Model, Reaction, Tissue, UnfitUnit, UnitProblem};
use trocar_core::error::InvalidValue;
use trocar_core::lane::{Gather, LANES, Lane};

/// The error of every unit.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("this build of trocar runs no functional mock-up units, because its feature `fmu` is off")]
pub struct FmuError;

/// The unit of a tissue.
#[derive(Debug, Clone, PartialEq)]
pub struct UnitTissue(Infallible);

impl UnitTissue {
    /// Refuses the unit.
    ///
    /// # Errors
    /// Always.
    pub fn open(_: &Path, _: &FmuSettings, _tick_s: f64) -> Result<Self, UnfitUnit> {
        Err(UnfitUnit { key: Self::file_key(), problem: UnitProblem::Unit(FmuError) })
    }

    /// Loads the unit's library.
    ///
    /// # Errors
    /// Never.
    pub fn load(&self) -> Result<(), FmuError> {
        match self.0 {}
    }

    /// Path of the unit's file.
    #[must_use]
    pub fn path(&self) -> &Path {
        match self.0 {}
    }

    /// SHA-256 of the unit's file.
    #[must_use]
    pub fn sha256(&self) -> [u8; 32] {
        match self.0 {}
    }
}

/// A running tissue in a unit.
#[derive(Debug, Clone)]
pub struct Fmu<L: Lane> {
    never: Infallible,
    lanes: PhantomData<L>,
}

impl<L: Lane> Fmu<L> {
    /// Creates the tissue.
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

    /// [`UnitTissue::open`] refuses the unit.
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
