//! Events as a switched linear system: teleoperation, frozen, re-engaging.
//!
//! The paper does not analyse its event-based scheme, which "would require hybrid modelling". Here semidefinite
//! programming finds a certificate that every sequence of events with a minimum dwell decays. The worst sequences found
//! (`ascent`, `products`) show how tight it is.

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

pub const LONGEST_DWELL_S: f64 = 4.0;

/// The hand's travel in the paper's figure 16.
pub const GAP_M: f64 = 0.009;

const MAX_PIECES: u64 = 8;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DwellPoint {
    pub dwell_ticks: u64,
    /// Verified, in the norm of the certificate.
    pub certified: Option<f64>,
    pub found: f64,
}

#[derive(Debug, Clone)]
pub struct Switching {
    pub settings: SwitchingSettings,
    pub phases: Phases,
    /// Has the shortest dwell; `None` if none up to [`LONGEST_DWELL_S`].
    pub certificate: Option<Certificate>,
    /// Has the smallest growth at the refractory time.
    pub at_refractory: Option<Certificate>,
    /// `None` if contact itself is not certified.
    pub covers_lost_contact: Option<bool>,
    pub peaks: Option<Peaks>,
    pub growth: Growth,
    /// On one constant stiffness, which a scenario can simulate.
    pub shown: SimulatedGrowth,
    pub growing_dwell_ticks: Option<u64>,
    pub by_dwell: Vec<DwellPoint>,
    pub events: Vec<EventBound>,
}

impl Switching {
    pub fn of(settings: &SwitchingSettings) -> Result<Self, StabilityError> {
        let (springs, peaks) = rayon::join(|| Self::of_springs(&settings.with_least_damping()), || Peaks::of(settings));
        Ok(Self { settings: settings.clone(), peaks: peaks?, ..springs? })
    }

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

    pub fn certified_dwell(settings: &SwitchingSettings) -> Result<Option<u64>, StabilityError> {
        let settings = &settings.with_least_damping();
        let modes = Modes::new(settings)?;
        let mut search = Search::new(settings, &modes, settings.phases());
        Ok(search.shortest()?.map(|found| found.choice.dwell_ticks))
    }

    /// Cheaper than [`Switching::certified_dwell`].
    pub fn certifies(settings: &SwitchingSettings, dwell_ticks: u64) -> Result<bool, StabilityError> {
        let settings = &settings.with_least_damping();
        let modes = Modes::new(settings)?;
        Search::new(settings, &modes, settings.phases()).is_certified(dwell_ticks.max(1))
    }

    pub fn dwell_ticks(&self) -> Option<u64> {
        self.certificate.as_ref().map(|found| found.choice.dwell_ticks)
    }

    pub fn certified_growth(&self) -> Option<f64> {
        self.at_refractory.as_ref().map(|found| found.choice.contraction.sqrt())
    }

    /// A gap that does not change is no growth.
    pub fn shows_growth(&self) -> bool {
        self.shown.found > 1.0 + 1e-6
    }

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
