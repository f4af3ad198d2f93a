use std::marker::PhantomData;

use trocar_core::settings::Key;

use super::{BuiltInScheme, PassivityScheme, SchemeContext};
use crate::teleoperation::PassivitySettings;
use trocar_core::lane::{Gather, LANES, Lane};

#[derive(Debug, Clone)]
pub struct NoScheme<L>(PhantomData<L>);

impl<L> Default for NoScheme<L> {
    fn default() -> Self {
        Self(PhantomData)
    }
}

impl<L: Lane> PassivityScheme<L> for NoScheme<L> {
    #[inline(always)]
    fn sends_payload(&self) -> bool {
        false
    }
}

impl<L: Lane> BuiltInScheme<L> for NoScheme<L> {
    const KEYS: &'static [&'static [Key]] = &[];

    fn build(_settings: &PassivitySettings, _context: &SchemeContext<L>) -> Self {
        Self::default()
    }
}

impl Gather for NoScheme<f64> {
    type Of<L: Lane> = NoScheme<L>;

    fn gather<L: Lane>(_all: [&Self; LANES]) -> Option<NoScheme<L>> {
        Some(NoScheme::default())
    }
}
