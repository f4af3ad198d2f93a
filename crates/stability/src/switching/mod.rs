//! Events: teleoperation, frozen, re-engaging, as a switched linear system.
//!
//! The paper does not analyse the stability of its event-based scheme, which "would require hybrid modelling". This
//! module does:
//!
//! - `modes`: the maps of each phase;
//! - `conditions`, `attempt`, `rebuild`: a certificate that every sequence of events with a minimum dwell between them decays,
//!   found by semidefinite programming and verified by `crate::certificate`;
//! - `peaks`: bounds of motions under a tissue force in addition to springs and dampers: the statement about a scenario;
//! - `ascent`, `products`: the worst sequences found, with a tissue that changes at every tick or is constant, to show
//!   how tight the certificate is.

mod adversary;
mod ascent;
mod attempt;
mod conditions;
pub(crate) mod modes;
mod peaks;
mod products;
mod rebuild;
mod scaling;
mod search;
mod settings;

pub use adversary::adversary;
pub use ascent::{Cycle, Growth};
pub use peaks::Peaks;
pub use products::{SimulatedCycle, SimulatedGrowth};
pub use settings::{Phases, SwitchingSettings};

pub(crate) use rebuild::required;

use crate::certificate::Certificate;
use crate::{EventBound, StabilityError};
use ascent::Steps;
use modes::Modes;
use search::Search;
use trocar_base::parallel::try_map;

/// The maximum dwell in the search for a certificate, in s.
pub const LONGEST_DWELL_S: f64 = 4.0;

/// The gap at the end of an event, in m: the hand's travel in the paper's figure 16.
pub const GAP_M: f64 = 0.009;

/// The maximum number of pieces of a certificate's functions in time, in each phase.
const MAX_PIECES: u64 = 8;

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
    /// The loop and its events.
    pub settings: SwitchingSettings,
    /// The phases of an event.
    pub phases: Phases,
    /// The certificate with the shortest dwell; `None` if no dwell up to [`LONGEST_DWELL_S`] has one.
    pub certificate: Option<Certificate>,
    /// The certificate with the smallest growth at the supervisor's refractory time.
    pub at_refractory: Option<Certificate>,
    /// True if the certificate also covers loss of contact at any tick; `None` if contact itself is not certified.
    pub covers_lost_contact: Option<bool>,
    /// Bounds of the motion per newton of additional tissue force, with the decay of every motion; `None` if not certified.
    pub peaks: Option<Peaks>,
    /// The worst growth per event found at the refractory time, with a tissue chosen at every tick.
    pub growth: Growth,
    /// The growth at the refractory time on one constant stiffness, which a scenario can simulate.
    pub shown: SimulatedGrowth,
    /// The longest tried dwell at which some sequence grows, up to the refractory time or the certified dwell.
    pub growing_dwell_ticks: Option<u64>,
    /// The results by dwell, increasing.
    pub by_dwell: Vec<DwellPoint>,
    /// The end of one event, for each policy.
    pub events: Vec<EventBound>,
}

impl Switching {
    /// Analyses the switching.
    ///
    /// # Errors
    /// [`StabilityError`].
    pub fn of(settings: &SwitchingSettings) -> Result<Self, StabilityError> {
        let (springs, peaks) = rayon::join(|| Self::of_springs(&settings.with_least_damping()), || Peaks::of(settings));
        Ok(Self { settings: settings.clone(), peaks: peaks?, ..springs? })
    }

    /// The analysis without the damping that some tissues have in addition, and without an additional force.
    fn of_springs(settings: &SwitchingSettings) -> Result<Self, StabilityError> {
        let phases = settings.phases();
        let modes = Modes::new(settings)?;
        let steps = Steps::new(&modes, phases);
        let alone = |vertex| products::growth(&modes, phases, phases.refractory, vertex);
        let found_growths = || {
            let (growth, (softest, stiffest)) =
                rayon::join(|| ascent::growth(&steps, phases.refractory), || rayon::join(|| alone(0), || alone(1)));
            Ok::<_, StabilityError>((growth?, softest?, stiffest?))
        };
        let mut search = Search::new(settings, &modes, phases);
        let (shortest, growths) = rayon::join(|| search.shortest(), found_growths);
        let (shortest, (growth, softest, stiffest)) = (shortest?, growths?);
        let is_certified = shortest.as_ref().is_some_and(|found| found.choice.dwell_ticks <= phases.refractory);
        let proved = match (&shortest, is_certified) {
            (Some(_), true) => AtRefractory::of(settings, &search, phases, &growth)?,
            _ => AtRefractory::default(),
        };
        let longest = shortest.as_ref().map_or(phases.refractory, |found| found.choice.dwell_ticks);
        let certified = |dwell: u64| match (&shortest, &proved.tightest) {
            (_, Some(tightest)) if dwell >= phases.refractory => Some(tightest.growth_after(dwell, modes.tick_s)),
            (Some(_), _) if dwell >= longest => Some(1.0),
            _ => None,
        };
        let (growing_dwell_ticks, by_dwell) = rayon::join(
            || Self::growing_dwell(&steps, longest, (phases.refractory, &growth)),
            || {
                by_dwell(
                    settings,
                    (&steps, &growth),
                    shortest.as_ref().map(|found| found.choice.dwell_ticks),
                    &certified,
                )
            },
        );
        let (growing_dwell_ticks, by_dwell) = (growing_dwell_ticks?, by_dwell?);
        let AtRefractory { tightest, covers_lost_contact } = proved;
        Ok(Self {
            phases,
            peaks: None,
            certificate: shortest,
            at_refractory: tightest,
            covers_lost_contact,
            growth,
            by_dwell,
            shown: if stiffest.found >= softest.found { stiffest } else { softest },
            growing_dwell_ticks,
            events: EventBound::of_each_policy(settings, GAP_M)?,
            settings: settings.clone(),
        })
    }

    /// The longest tried dwell, from `dwell` down by factors of four, at which some sequence grows.
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

    /// Returns only the shortest certified dwell, in ticks; `None` if there is none up to [`LONGEST_DWELL_S`].
    ///
    /// # Errors
    /// [`StabilityError`].
    pub fn certified_dwell(settings: &SwitchingSettings) -> Result<Option<u64>, StabilityError> {
        let settings = &settings.with_least_damping();
        let modes = Modes::new(settings)?;
        let mut search = Search::new(settings, &modes, settings.phases());
        Ok(search.shortest()?.map(|found| found.choice.dwell_ticks))
    }

    /// True if `dwell_ticks` of teleoperation between events are certified. Solves one or a few programmes, where
    /// [`Switching::certified_dwell`] solves a dozen, of seconds each with long delays.
    ///
    /// # Errors
    /// [`StabilityError`].
    pub fn certifies(settings: &SwitchingSettings, dwell_ticks: u64) -> Result<bool, StabilityError> {
        let settings = &settings.with_least_damping();
        let modes = Modes::new(settings)?;
        Search::new(settings, &modes, settings.phases()).is_certified(dwell_ticks.max(1))
    }

    /// The shortest certified dwell in ticks.
    #[must_use]
    pub fn dwell_ticks(&self) -> Option<u64> {
        self.certificate.as_ref().map(|found| found.choice.dwell_ticks)
    }

    /// The certified growth per event at the refractory time, if it is certified.
    #[must_use]
    pub fn certified_growth(&self) -> Option<f64> {
        self.at_refractory.as_ref().map(|found| found.choice.contraction.sqrt())
    }

    /// True if a sequence on one stiffness makes the motion grow. A gap that out of contact does not change is no growth.
    #[must_use]
    pub fn shows_growth(&self) -> bool {
        self.shown.found > 1.0 + 1e-6
    }

    /// True if the refractory time is at least the certified dwell: every sequence of events is stable.
    #[must_use]
    pub fn is_certified(&self) -> bool {
        self.dwell_ticks().is_some_and(|dwell| dwell <= self.phases.refractory)
    }
}

#[derive(Default)]
struct AtRefractory {
    tightest: Option<Certificate>,
    covers_lost_contact: Option<bool>,
}

impl AtRefractory {
    fn of(
        settings: &SwitchingSettings,
        search: &Search<'_>,
        phases: Phases,
        growth: &Growth,
    ) -> Result<Self, StabilityError> {
        let dwell = phases.refractory;
        let without_contact = || {
            let settings = SwitchingSettings { loses_contact: true, ..settings.clone() };
            let modes = Modes::new(&settings)?;
            Search::new(&settings, &modes, phases).is_certified(dwell)
        };
        let (tightest, covers_lost_contact) = rayon::join(|| search.tightest(dwell, growth.found), without_contact);
        Ok(Self { tightest: tightest?, covers_lost_contact: Some(covers_lost_contact?) })
    }
}

/// Dwells for which the growth is shown, as multiples of the refractory time.
const LONGER: [u64; 3] = [1, 2, 4];

fn by_dwell(
    settings: &SwitchingSettings,
    (steps, found): (&Steps<'_>, &Growth),
    shortest: Option<u64>,
    certified: &(impl Fn(u64) -> Option<f64> + Sync),
) -> Result<Vec<DwellPoint>, StabilityError> {
    let (refractory, longest) = (settings.phases().refractory, settings.longest_dwell_ticks());
    let mut dwells: Vec<u64> = LONGER.iter().map(|times| refractory * times).chain(shortest).collect();
    dwells.sort_unstable();
    dwells.dedup();
    dwells.retain(|dwell| *dwell <= longest || *dwell == refractory);
    let point = |dwell_ticks: u64| -> Result<DwellPoint, StabilityError> {
        let found = if dwell_ticks == refractory { found.found } else { ascent::growth(steps, dwell_ticks)?.found };
        Ok(DwellPoint { dwell_ticks, certified: certified(dwell_ticks), found })
    };
    try_map(dwells.len(), |index| point(dwells[index]))
}
