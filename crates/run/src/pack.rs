use std::ops::Range;

use super::{RunError, measure, observe};
use trocar_core::lane::{LANES, Lane, of_each};
use trocar_engine::engine::{
    Additional, EventObserver, ExactPlants, GatheredPlants, InSet, InstructionSet, Wide, Wired,
};
use trocar_engine::sensor::NoiseBank;
#[cfg(target_arch = "x86_64")]
use trocar_engine::wide_lanes::{Avx2, Avx512};
use trocar_metrics::{LinkMetrics, Metrics, MetricsObserver, Outcome};
use trocar_scenario::{Scenario, ScenarioEngine};

/// More scenarios form further packs.
pub const PACK: usize = LANES;

/// With fewer scenarios, separate runs are faster than eight lanes.
const MIN_SCENARIOS: usize = 3;

/// The same bits as separate runs. Scenarios share lanes if they differ only in numbers (scales, gains, tissue,
/// machines, thresholds, seeds); others (kinds of tissue and controller, ticks, delays, sensors with and without noise)
/// run one after the other. A failed scenario gives an error at its index only.
pub fn run_pack(scenarios: &[Scenario]) -> Vec<Result<Metrics, RunError>> {
    run_pack_in(InstructionSet::widest(), scenarios)
}

/// One after the other if the machine lacks the instruction set.
pub fn run_pack_in(set: InstructionSet, scenarios: &[Scenario]) -> Vec<Result<Metrics, RunError>> {
    metrics_of(run_pack_observed(set, &mut NoiseBank::new(0), scenarios, &()))
}

/// Shares noise between runs of the same seed: identical results, faster.
pub fn run_pack_sharing(bank: &mut NoiseBank, scenarios: &[Scenario]) -> Vec<Result<Metrics, RunError>> {
    metrics_of(run_pack_observed(InstructionSet::widest(), bank, scenarios, &()))
}

fn metrics_of(runs: Vec<Result<(Metrics, ()), RunError>>) -> Vec<Result<Metrics, RunError>> {
    runs.into_iter().map(|run| run.map(|(metrics, ())| metrics)).collect()
}

#[doc(hidden)]
pub trait RunObserver {
    type OverLanes<L: Lane>: EventObserver<L>;
    type Finding;
    const OBSERVES: bool = true;

    /// Unused lanes repeat the last scenario.
    fn over_lanes<L: Lane>(&self, places: Range<usize>) -> Self::OverLanes<L>;

    fn finding<L: Lane>(observer: &Self::OverLanes<L>, lane: usize) -> Self::Finding;

    fn run_alone(&self, scenario: &Scenario, place: usize) -> Result<(Metrics, Self::Finding), RunError> {
        let mut over_one = self.over_lanes::<f64>(place..place + 1);
        let metrics = observe(scenario, &mut Additional(Some(&mut over_one)))?;
        Ok((metrics, Self::finding(&over_one, 0)))
    }
}

impl RunObserver for () {
    type OverLanes<L: Lane> = ();
    type Finding = ();
    const OBSERVES: bool = false;

    fn over_lanes<L: Lane>(&self, _places: Range<usize>) {}

    fn finding<L: Lane>(_observer: &(), _lane: usize) {}

    fn run_alone(&self, scenario: &Scenario, _place: usize) -> Result<(Metrics, ()), RunError> {
        Ok((measure(scenario)?, ()))
    }
}

#[doc(hidden)]
pub type ObservedRun<R> = Result<(Metrics, <R as RunObserver>::Finding), RunError>;

#[doc(hidden)]
pub fn run_pack_observed<R: RunObserver>(
    set: InstructionSet,
    bank: &mut NoiseBank,
    scenarios: &[Scenario],
    observer: &R,
) -> Vec<ObservedRun<R>> {
    let set = if set.is_available() { set } else { InstructionSet::Baseline };
    let packs = scenarios.chunks(PACK).enumerate();
    packs.flat_map(|(k, pack)| run_eight(set, bank, pack, (k * PACK, observer))).collect()
}

pub fn can_share(scenarios: &[Scenario]) -> bool {
    scenarios.len() <= PACK && Engines::of(scenarios).is_some_and(|engines| engines.can_share())
}

fn run_eight<R: RunObserver>(
    set: InstructionSet,
    bank: &mut NoiseBank,
    scenarios: &[Scenario],
    (first, observer): (usize, &R),
) -> Vec<ObservedRun<R>> {
    let alone = |k: usize| observer.run_alone(&scenarios[k], first + k);
    let is_worthwhile = scenarios.len() >= MIN_SCENARIOS && set != InstructionSet::Baseline;
    let engines = if is_worthwhile { Engines::of(scenarios) } else { None };
    let together = engines.and_then(|mut engines| {
        engines.share_noise(bank);
        engines.run(set, scenarios, (first, observer))
    });
    match together {
        Some(runs) => {
            // A link continues to count after its lane has diverged.
            let ends_early = |metrics: &Metrics| metrics.link.is_some() && metrics.outcome != Outcome::Completed;
            let each = runs.into_iter().enumerate();
            each.map(|(k, run)| if ends_early(&run.0) { alone(k) } else { Ok(run) }).collect()
        }
        None => (0..scenarios.len()).map(alone).collect(),
    }
}

struct Engines(Vec<ScenarioEngine>);

impl Engines {
    /// `None` without scenarios, or if one cannot be built.
    fn of(scenarios: &[Scenario]) -> Option<Self> {
        let engines: Result<Vec<_>, _> = scenarios.iter().map(Scenario::build).collect();
        engines.ok().filter(|engines| !engines.is_empty()).map(Self)
    }

    fn share_noise(&mut self, bank: &mut NoiseBank) {
        for engine in &mut self.0 {
            if let ScenarioEngine::Exact(engine) = engine {
                engine.share_noise(bank);
            }
        }
    }

    fn lanes(&self) -> [&ScenarioEngine; LANES] {
        std::array::from_fn(|lane| &self.0[lane.min(self.0.len() - 1)])
    }

    fn can_share(&self) -> bool {
        let Some(engines) = self.exact() else { return false };
        match InstructionSet::widest() {
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx512 => {
                Wired::gather::<Avx512, GatheredPlants<Avx512>>(engines, GatheredPlants::gather).is_some()
            }
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx2 => {
                Wired::gather::<Avx2, GatheredPlants<Avx2>>(engines, GatheredPlants::gather).is_some()
            }
            #[cfg(not(target_arch = "x86_64"))]
            InstructionSet::Avx512 | InstructionSet::Avx2 => false,
            InstructionSet::Baseline => false,
        }
    }

    fn exact(&self) -> Option<[&Wired<f64, ExactPlants<f64>>; LANES]> {
        Some(of_each!(self.lanes(), |engine| match engine {
            ScenarioEngine::Exact(engine) => &**engine,
            ScenarioEngine::Limited(_)
            | ScenarioEngine::Split(_)
            | ScenarioEngine::Integrated(_)
            | ScenarioEngine::General(_) => return None,
        }))
    }

    fn run<R: RunObserver>(
        &self,
        set: InstructionSet,
        scenarios: &[Scenario],
        observer: (usize, &R),
    ) -> Option<Vec<(Metrics, R::Finding)>> {
        let engines = self.exact()?;
        match set {
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx512 => side_by_side::<Avx512, R>(engines, scenarios, observer),
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx2 => side_by_side::<Avx2, R>(engines, scenarios, observer),
            #[cfg(not(target_arch = "x86_64"))]
            InstructionSet::Avx512 | InstructionSet::Avx2 => None,
            InstructionSet::Baseline => None,
        }
    }
}

fn side_by_side<L: Wide, R: RunObserver>(
    engines: [&Wired<f64, ExactPlants<f64>>; LANES],
    scenarios: &[Scenario],
    (first, observer): (usize, &R),
) -> Option<Vec<(Metrics, R::Finding)>> {
    let mut engine = Wired::gather::<L, GatheredPlants<L>>(engines, GatheredPlants::gather)?;
    let grid = scenarios.first()?.grid;
    let ruptures = scenarios.iter().map(|scenario| scenario.rupture_times_s().len()).max().unwrap_or(0);
    let mut additional = InSet(observer.over_lanes::<L>(first..first + scenarios.len()));
    let traits = |lane: usize| scenarios[lane.min(scenarios.len() - 1)].operator_traits();
    let called = Additional(R::OBSERVES.then_some(&mut additional as &mut dyn EventObserver<L>));
    let mut observers = (MetricsObserver::<L>::new(grid, ruptures).of_operators(traits), called);
    // An exact engine cannot fail.
    engine.run_wide(&mut observers).ok()?;
    let (metrics, _) = observers;
    let run = |lane: usize| {
        let link = engine.link_report(lane).map(|report| LinkMetrics::new(&report, &grid));
        (Metrics { link, ..metrics.metrics(lane) }, R::finding(&additional.0, lane))
    };
    Some((0..scenarios.len()).map(run).collect())
}
