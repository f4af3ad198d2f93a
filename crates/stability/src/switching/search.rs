use super::attempt;
use super::modes::Modes;
use super::settings::Phases;
use super::{LONGEST_DWELL_S, MAX_PIECES, SwitchingSettings};
use crate::StabilityError;
use crate::certificate::{Certificate, Choice};
use trocar_base::parallel::try_map;

const MAX_RATIO: f64 = 1.05;

const DWELLS_S: [f64; 6] = [0.01, 0.03, 0.1, 0.3, 1.0, LONGEST_DWELL_S];

const HOLDS_S: [f64; 4] = [0.1, 0.2, 0.05, 0.4];

/// Relative to the slowest mode's.
const RATES: [f64; 2] = [0.95, 0.0];

const MAX_GROWTH_RATIO: f64 = 2.0;

const PIECES: u64 = 2;
const PIECES_ON_TISSUE: u64 = MAX_PIECES;
const MAX_STATES_WITH_PIECES: usize = 12;

fn pieces(modes: &Modes) -> u64 {
    match (modes.states() <= MAX_STATES_WITH_PIECES, modes.is_frozen_map_unique()) {
        (false, _) => 1,
        (true, true) => PIECES,
        (true, false) => PIECES_ON_TISSUE,
    }
}

pub(super) struct Search<'a> {
    modes: &'a Modes,
    phases: Phases,
    longest: u64,
    keeps_gap: bool,
    pieces: u64,
    holds_s: &'static [f64],
    hold_s: Option<f64>,
}

impl<'a> Search<'a> {
    pub(super) fn new(settings: &SwitchingSettings, modes: &'a Modes, phases: Phases) -> Self {
        let pieces = pieces(modes);
        let holds_s = if modes.has_gap() { &HOLDS_S[..] } else { &HOLDS_S[..1] };
        let (longest, keeps_gap) = (settings.longest_dwell_ticks(), settings.keeps_gap());
        Self { modes, phases, longest, keeps_gap, pieces, holds_s, hold_s: None }
    }

    fn certify(&self, choice: Choice) -> Result<Option<Certificate>, StabilityError> {
        if self.keeps_gap {
            return Ok(None);
        }
        attempt::certify(self.modes, self.phases, choice)
    }

    fn plain(&self, dwell: u64, hold_s: f64) -> Choice {
        Choice {
            dwell_ticks: dwell,
            contraction: 1.0,
            rate_per_s: 0.0,
            bounds_m_per_n: None,
            is_driven: false,
            hold_s,
            pieces: self.pieces,
        }
    }

    fn with_holds(&self, dwell: u64, holds: &[f64]) -> Result<Option<(Certificate, f64)>, StabilityError> {
        let Some((first, others)) = holds.split_first() else { return Ok(None) };
        let at = |hold_s: f64| -> Result<_, StabilityError> {
            Ok(self.certify(self.plain(dwell, hold_s))?.map(|found| (found, hold_s)))
        };
        if let Some(found) = at(*first)? {
            return Ok(Some(found));
        }
        let found: Vec<Option<(Certificate, f64)>> = try_map(others.len(), |index| at(others[index]))?;
        Ok(found.into_iter().flatten().next())
    }

    pub(super) fn is_certified(&self, dwell: u64) -> Result<bool, StabilityError> {
        Ok(self.with_holds(dwell, self.holds_s)?.is_some())
    }

    pub(super) fn shortest(&mut self) -> Result<Option<Certificate>, StabilityError> {
        let ticks = |seconds: f64| ((seconds / self.modes.tick_s).round() as u64).clamp(1, self.longest);
        let mut fails = 0;
        let mut found = None;
        for dwell in DWELLS_S.map(ticks) {
            found = self.with_holds(dwell, self.holds_s)?;
            if found.is_some() {
                break;
            }
            fails = dwell;
        }
        let Some((mut best, mut hold_s)) = found else { return Ok(None) };
        loop {
            let dwell = best.choice.dwell_ticks;
            if dwell <= fails + 1 || dwell as f64 <= MAX_RATIO * fails as f64 {
                break;
            }
            let middle = ((dwell as f64) * (fails as f64).max(0.5)).sqrt().round() as u64;
            let middle = middle.clamp(fails + 1, dwell - 1);
            match self.with_holds(middle, &[hold_s])? {
                Some(found) => (best, hold_s) = found,
                None => fails = middle,
            }
        }
        self.hold_s = Some(hold_s);
        Ok(Some(best))
    }

    /// `found` is a lower bound.
    pub(super) fn tightest(&self, dwell: u64, found: f64) -> Result<Option<Certificate>, StabilityError> {
        let Some(hold_s) = self.hold_s else { return Ok(None) };
        let slowest = self.modes.slowest_decay_per_s()?;
        let mut best = None;
        let mut rate_per_s = 0.0;
        for share in RATES {
            // `V` is quadratic.
            rate_per_s = 2.0 * share * slowest;
            best = self.certify(Choice { rate_per_s, ..self.plain(dwell, hold_s) })?;
            if best.is_some() {
                break;
            }
        }
        let mut fails = found.clamp(1e-6, 1.0);
        let mut growth: f64 = 1.0;
        while best.is_some() && growth > MAX_GROWTH_RATIO * fails {
            let middle = (growth * fails).sqrt();
            let choice = Choice { contraction: middle * middle, rate_per_s, ..self.plain(dwell, hold_s) };
            let other = self.certify(choice)?;
            match other {
                Some(other) => (growth, best) = (middle, Some(other)),
                None => fails = middle,
            }
        }
        Ok(best)
    }
}
