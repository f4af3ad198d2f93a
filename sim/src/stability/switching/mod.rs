//! Events: teleoperation, frozen, re-engaging, as a switched linear system.
//!
//! The paper leaves out the stability of its event-based scheme, as one that "would require hybrid modelling". This
//! module analyses it: the maps of each phase (`modes`), a certificate that every sequence of events with a minimum
//! dwell between them decays (`conditions`, `certificate`; found by semidefinite programming, verified in interval
//! arithmetic), the bounds of motions that it gives (`reach`), the worst sequences found, with the tissue chosen anew at
//! every tick (`ascent`) and constant (`products`), which show how tight it is, and the effect of each re-engaging policy
//! at the end of one event (`event`).

mod ascent;
mod certificate;
mod conditions;
mod event;
mod interval;
mod modes;
mod products;
mod reach;
mod scaling;
mod sdp;
mod search;
mod semidefinite;
mod settings;

pub use ascent::{Cycle, Growth};
pub use certificate::{Certificate, Inequality, Lyapunov, StateMap, StateSpace, Summand};
pub use event::EventBound;
pub use products::{SimulatedCycle, SimulatedGrowth};
pub use reach::{Reach, Sequence};
pub use settings::{Phases, SwitchingSettings};

use crate::stability::StabilityError;
use ascent::Steps;
use modes::Modes;
use search::Search;

/// The maximum dwell in the search for a certificate, in s.
pub const LONGEST_DWELL_S: f64 = 4.0;

/// The gap at the end of an event, in m: the hand's travel in the paper's figure 16.
pub const GAP_M: f64 = 0.009;

/// The result for one dwell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DwellPoint {
    /// Ticks of teleoperation between two events.
    pub dwell_ticks: u64,
    /// The verified growth per event, in the norm of the certificate; `None` without a certificate.
    pub certified: Option<f64>,
    /// The largest growth per event found.
    pub found: f64,
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
    /// The certificate with the smallest growth at the supervisor's refractory time.
    pub at_refractory: Option<Certificate>,
    /// Whether the same is certified if the needle may lose contact at any tick; `None` if it is not certified in contact.
    pub covers_lost_contact: Option<bool>,
    /// Bounds of motions with the supervisor's refractory time between events; `None` if it is not certified, or with a
    /// delay.
    pub reach: Option<Reach>,
    /// The worst growth per event found at the refractory time, with the tissue chosen at every tick.
    pub growth: Growth,
    /// The growth on one constant stiffness, which a scenario can simulate, at the refractory time.
    pub shown: SimulatedGrowth,
    /// The longest tried dwell, up to the refractory time or the certified dwell, at which some sequence grows.
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
        let steps = Steps::new(&modes, phases);
        let mut search = Search::new(settings, &modes, phases)?;
        let alone = |vertex| products::growth(&modes, phases, phases.refractory, vertex);
        let found_growths = || {
            let (growth, (softest, stiffest)) =
                rayon::join(|| ascent::growth(&steps, phases.refractory), || rayon::join(|| alone(0), || alone(1)));
            Ok::<_, StabilityError>((growth?, softest?, stiffest?))
        };
        let (certificate, growths) = rayon::join(|| search.shortest(), found_growths);
        let (certificate, (growth, softest, stiffest)) = (certificate?, growths?);
        let is_certified = certificate.as_ref().is_some_and(|found| found.dwell_ticks <= phases.refractory);
        let tightest = || if is_certified { search.tightest(phases.refractory, growth.found) } else { Ok(None) };
        let without_contact = || is_certified.then(|| Self::keeps_without_contact(settings, phases)).transpose();
        let reach = || match search.choice(phases.refractory) {
            Some(choice) if is_certified && settings.delay_ticks() == 0 => {
                Reach::of(settings, (&modes, &steps), phases, choice)
            }
            _ => Ok(None),
        };
        let (at_refractory, (covers_lost_contact, reach)) =
            rayon::join(tightest, || rayon::join(without_contact, reach));
        let (at_refractory, covers_lost_contact, reach) = (at_refractory?, covers_lost_contact?, reach?);
        let longest = certificate.as_ref().map_or(phases.refractory, |found| found.dwell_ticks);
        let (growing_dwell_ticks, by_dwell) = rayon::join(
            || Self::growing_dwell(&steps, longest, (phases.refractory, &growth)),
            || search.by_dwell(&steps, at_refractory.as_ref(), &growth),
        );
        let (growing_dwell_ticks, by_dwell) = (growing_dwell_ticks?, by_dwell?);
        Ok(Self {
            phases,
            reach,
            certificate,
            at_refractory,
            covers_lost_contact,
            growth,
            by_dwell,
            shown: if stiffest.found >= softest.found { stiffest } else { softest },
            growing_dwell_ticks,
            events: EventBound::of_each_policy(settings, GAP_M)?,
            settings: settings.clone(),
        })
    }

    /// The longest tried dwell, from `dwell` down by factors of four, at which some sequence grows; the growth at one dwell is
    /// known.
    fn growing_dwell(
        steps: &Steps<'_>,
        mut dwell: u64,
        (of_known, known): (u64, &Growth),
    ) -> Result<Option<u64>, StabilityError> {
        loop {
            let found = if dwell == of_known { known.found } else { ascent::growth(steps, dwell)?.found };
            if found >= 1.0 {
                return Ok(Some(dwell));
            }
            if dwell == 1 {
                return Ok(None);
            }
            dwell = (dwell / 4).max(1);
        }
    }

    /// Whether the refractory time is certified with lost contact.
    fn keeps_without_contact(settings: &SwitchingSettings, phases: Phases) -> Result<bool, StabilityError> {
        let settings = SwitchingSettings { loses_contact: true, ..settings.clone() };
        let modes = Modes::new(&settings)?;
        Search::new(&settings, &modes, phases)?.is_certified(phases.refractory)
    }

    /// The shortest certified dwell only, in ticks; `None` without one up to [`LONGEST_DWELL_S`].
    ///
    /// # Errors
    /// [`StabilityError`].
    pub fn certified_dwell(settings: &SwitchingSettings) -> Result<Option<u64>, StabilityError> {
        let modes = Modes::new(settings)?;
        Ok(Search::new(settings, &modes, settings.phases())?.shortest()?.map(|found| found.dwell_ticks))
    }

    /// Whether `dwell_ticks` of teleoperation between events are certified: one programme or a few, where
    /// [`Switching::certified_dwell`] solves a dozen. With long delays each one takes seconds.
    ///
    /// # Errors
    /// [`StabilityError`].
    pub fn certifies(settings: &SwitchingSettings, dwell_ticks: u64) -> Result<bool, StabilityError> {
        let modes = Modes::new(settings)?;
        Search::new(settings, &modes, settings.phases())?.is_certified(dwell_ticks.max(1))
    }

    /// Whether the refractory time is at least the certified dwell, so that every sequence of events is stable.
    #[must_use]
    pub fn is_certified(&self) -> bool {
        self.certificate.as_ref().is_some_and(|found| found.dwell_ticks <= self.phases.refractory)
    }
}
