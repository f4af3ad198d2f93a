//! Events: teleoperation, frozen, re-engaging, as a switched linear system.
//!
//! The paper leaves out the stability of its event-based scheme, as one that "would require hybrid modelling". This
//! module analyses it: the maps of each phase (`modes`), a certificate that every sequence of events with a minimum
//! dwell between them decays (`conditions`, `certificate`; found by semidefinite programming, verified in interval
//! arithmetic), the bounds of motions that it gives (`reach`), the sequences with the maximum growth, which show how
//! tight it is (`products`), and the effect of each re-engaging policy at the end of one event (`event`).

mod certificate;
mod conditions;
mod event;
mod interval;
mod modes;
mod products;
mod reach;
mod sdp;
mod semidefinite;
mod settings;

use certificate::Attempt;
pub use certificate::Certificate;
pub use event::EventBound;
pub use products::{Cycle, Growth};
pub use reach::{Reach, Sequence};
pub use settings::{Phases, SwitchingSettings};

use nalgebra::DMatrix;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use crate::stability::StabilityError;
use conditions::Choice;
use modes::Modes;

/// The maximum dwell in the search for a certificate, in s.
pub const LONGEST_DWELL_S: f64 = 4.0;

/// The ratio of bounds at which the search for the shortest certified dwell ends.
const MAX_RATIO: f64 = 1.03;

/// Values of `a` in `conditions`, the decay of the gap's part of a function. Each is tried.
const DECAYS: [f64; 4] = [1.0 - 1.0 / 32.0, 1.0 - 1.0 / 64.0, 1.0 - 1.0 / 128.0, 1.0 - 1.0 / 256.0];

/// The gap at the end of an event, in m: the hand's travel in the paper's figure 16.
pub const GAP_M: f64 = 0.009;

/// The result for one dwell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DwellPoint {
    /// Ticks of teleoperation between two events.
    pub dwell_ticks: u64,
    /// The verified factor of `V` from one event to the next; `None` without a certificate.
    pub contraction: Option<f64>,
    /// The solver's margin: the conditions are feasible if it is above 0; 0 if the solver failed.
    pub margin: f64,
    /// Bounds of the growth per event of the sequences tried.
    pub growth: (f64, f64),
}

/// The analysis of the switching.
#[derive(Debug, Clone)]
pub struct Switching {
    /// The analysed loop and events.
    pub settings: SwitchingSettings,
    /// Its phases.
    pub phases: Phases,
    /// The certificate with the shortest dwell; `None` without one up to [`LONGEST_DWELL_S`].
    pub certificate: Option<Certificate>,
    /// Bounds of motions with the supervisor's refractory time between events; `None` if it is not certified.
    pub reach: Option<Reach>,
    /// Growth per event at the certified dwell, or without one at the refractory time.
    pub growth: Growth,
    /// The growth on one constant stiffness, which a scenario can simulate, at the refractory time.
    pub shown: Growth,
    /// Ticks of teleoperation between events in `growth`.
    pub dwell_ticks: u64,
    /// The longest tried dwell up to `dwell_ticks` at which some sequence grows.
    pub growing_dwell_ticks: Option<u64>,
    /// The results by dwell, increasing.
    pub by_dwell: Vec<DwellPoint>,
    /// The end of one event, by policy.
    pub events: Vec<EventBound>,
}

impl Switching {
    /// Analyses the switching.
    ///
    /// # Errors
    /// [`StabilityError`].
    pub fn of(settings: &SwitchingSettings) -> Result<Self, StabilityError> {
        let phases = settings.phases();
        let modes = Modes::new(settings)?;
        let mut search = Search::new(settings, &modes, phases);
        search.run()?;
        let found = search.best.clone();
        let reach = match &found {
            Some((found, decay)) if found.dwell_ticks <= phases.refractory => {
                Reach::of(settings, &modes, phases, Choice { dwell: phases.refractory, decay: *decay })?
            }
            _ => None,
        };
        let certificate = found.map(|(found, _)| found);
        let norm = certificate.as_ref().map(|found| found.at_events.clone());
        let dwell_ticks = certificate.as_ref().map_or(phases.refractory, |found| found.dwell_ticks);
        let alone = |vertex| products::growth(&modes, phases, phases.refractory, &[vertex], norm.as_ref());
        let [softest, stiffest] = [alone(0)?, alone(1)?];
        let mut growing_dwell_ticks = None;
        let mut dwell = dwell_ticks;
        loop {
            if search.growth_at(dwell, norm.as_ref())?.lower >= 1.0 {
                growing_dwell_ticks = Some(dwell);
                break;
            }
            if dwell == 1 {
                break;
            }
            dwell = (dwell * 3 / 4).max(1);
        }
        Ok(Self {
            phases,
            reach,
            certificate,
            growth: search.growth_at(dwell_ticks, norm.as_ref())?.clone(),
            by_dwell: search.points(norm.as_ref())?,
            shown: if stiffest.lower >= softest.lower { stiffest } else { softest },
            dwell_ticks,
            growing_dwell_ticks,
            events: EventBound::of_each_policy(settings, GAP_M)?,
            settings: settings.clone(),
        })
    }

    /// The shortest certified dwell only, in ticks; `None` without one up to [`LONGEST_DWELL_S`].
    ///
    /// # Errors
    /// [`StabilityError`].
    pub fn certified_dwell(settings: &SwitchingSettings) -> Result<Option<u64>, StabilityError> {
        let modes = Modes::new(settings)?;
        let mut search = Search::new(settings, &modes, settings.phases());
        search.run()?;
        Ok(search.best.map(|(found, _)| found.dwell_ticks))
    }

    /// Whether the refractory time is at least the certified dwell, so that every sequence of events is stable.
    #[must_use]
    pub fn is_certified(&self) -> bool {
        self.certificate.as_ref().is_some_and(|found| found.dwell_ticks <= self.phases.refractory)
    }
}

/// The search for the certificate with the shortest dwell.
struct Search<'a> {
    longest: u64,
    modes: &'a Modes,
    phases: Phases,
    /// The certificate with the shortest dwell so far, and its decay.
    best: Option<(Certificate, f64)>,
    /// Each tried dwell with its margin, and the contraction if there is a certificate.
    tried: BTreeMap<u64, (f64, Option<f64>)>,
    /// Growth by dwell.
    growth: BTreeMap<u64, Growth>,
}

impl<'a> Search<'a> {
    fn new(settings: &SwitchingSettings, modes: &'a Modes, phases: Phases) -> Self {
        let longest = ((LONGEST_DWELL_S / settings.of_loop.tick_s) as u64).max(2);
        Self { longest, modes, phases, best: None, tried: BTreeMap::new(), growth: BTreeMap::new() }
    }

    fn certify(&self, dwell: u64, decay: f64) -> Result<Attempt, StabilityError> {
        match certificate::attempt(self.modes, self.phases, Choice { dwell, decay }, None) {
            // For an unstable loop the solver may fail.
            Err(StabilityError::Solver { .. }) => Ok(Attempt { margin: 0.0, certificate: None }),
            attempt => attempt,
        }
    }

    fn record(&mut self, dwell: u64, attempt: &Attempt) {
        let found = attempt.certificate.as_ref().map(|found| found.contraction);
        self.tried.insert(dwell, (attempt.margin, found));
    }

    fn run(&mut self) -> Result<(), StabilityError> {
        let decays: &[f64] = if self.modes.has_gap() { &DECAYS } else { &DECAYS[..1] };
        let at_longest: Vec<(Attempt, f64)> = decays
            .par_iter()
            .map(|&decay| Ok((self.certify(self.longest, decay)?, decay)))
            .collect::<Result<_, StabilityError>>()?;
        // The decay with the maximum margin at the longest dwell is likely to give the shortest dwell.
        let Some((first, decay)) = at_longest.into_iter().max_by(|a, b| a.0.margin.total_cmp(&b.0.margin)) else {
            return Ok(());
        };
        self.record(self.longest, &first);
        let Some(mut best) = first.certificate else { return Ok(()) };
        let mut fails = 0;
        // A kept gap needs no dwell.
        while self.modes.gap_closes()
            && best.dwell_ticks > fails + 1
            && best.dwell_ticks as f64 > MAX_RATIO * fails as f64
        {
            // Two dwells between, on two cores.
            let (low, high) = ((fails as f64).max(0.7).ln(), (best.dwell_ticks as f64).ln());
            let between = |part: f64| {
                let ticks = (low + part * (high - low)).exp().round() as u64;
                ticks.clamp(fails + 1, best.dwell_ticks - 1)
            };
            let (first, second) = (between(1.0 / 3.0), between(2.0 / 3.0));
            let (at_first, at_second) = rayon::join(|| self.certify(first, decay), || self.certify(second, decay));
            let (at_first, at_second) = (at_first?, at_second?);
            self.record(first, &at_first);
            self.record(second, &at_second);
            match (at_first.certificate, at_second.certificate) {
                (Some(found), _) => best = found,
                (None, Some(found)) => (best, fails) = (found, first),
                (None, None) => fails = second,
            }
        }
        self.best = Some((best, decay));
        Ok(())
    }

    /// The growth at a dwell, computed once.
    fn growth_at(&mut self, dwell: u64, norm: Option<&DMatrix<f64>>) -> Result<&Growth, StabilityError> {
        Ok(match self.growth.entry(dwell) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(place) => place.insert(products::growth(self.modes, self.phases, dwell, &[0, 1], norm)?),
        })
    }

    /// The results of every dwell that was tried.
    fn points(&mut self, norm: Option<&DMatrix<f64>>) -> Result<Vec<DwellPoint>, StabilityError> {
        for dwell in self.tried.keys().copied().collect::<Vec<_>>() {
            self.growth_at(dwell, norm)?;
        }
        let point = |(&dwell_ticks, &(margin, contraction)): (&u64, &(f64, Option<f64>))| DwellPoint {
            dwell_ticks,
            contraction,
            margin,
            growth: (self.growth[&dwell_ticks].lower, self.growth[&dwell_ticks].upper),
        };
        Ok(self.tried.iter().map(point).collect())
    }
}
