//! Several scenarios side by side.

use super::{RunError, measure_asking};
#[cfg(target_arch = "x86_64")]
use crate::engine::{Avx2, Avx512};
use crate::engine::{Engine, ExactPlants, InstructionSet, Plants, Wide, gather};
use crate::lane::{Gather, LANES, of_each};
use crate::metrics::{LinkMetrics, Metrics, MetricsObserver, Outcome};
use crate::scenario::{Scenario, ScenarioEngine};
use crate::sensor::NoiseBank;
use crate::teleoperation::Connection;

/// How many scenarios run side by side at most; more make more packs.
pub const PACK: usize = LANES;

/// Fewest scenarios for which eight lanes are faster than one run after the other.
const FEWEST: usize = 3;

/// Runs scenarios for their metrics, in their order, [`PACK`] by [`PACK`] side by side where they can be: each gives the bits
/// that it gives alone.
///
/// Scenarios can be side by side where they differ in numbers alone: scales, gains, tissue, machines, thresholds, seeds.
/// Those that differ in what there is (kinds of tissue and controller, ticks, delays, a sensor with noise and one without)
/// are run one after the other. A scenario that cannot be run is an error at its own place and no hindrance to the others.
pub fn run_pack(scenarios: &[Scenario]) -> Vec<Result<Metrics, RunError>> {
    run_pack_in(InstructionSet::widest(), scenarios)
}

/// [`run_pack`] in a given instruction set, or one after the other where the machine has not got it.
pub fn run_pack_in(set: InstructionSet, scenarios: &[Scenario]) -> Vec<Result<Metrics, RunError>> {
    metrics_of(run_pack_asking(set, &mut NoiseBank::new(0), scenarios, &[]))
}

/// [`run_pack`] with noise that runs of the same seed share: the same bits, sooner.
pub fn run_pack_sharing(bank: &mut NoiseBank, scenarios: &[Scenario]) -> Vec<Result<Metrics, RunError>> {
    metrics_of(run_pack_asking(InstructionSet::widest(), bank, scenarios, &[]))
}

fn metrics_of(answers: Vec<Result<Asked, RunError>>) -> Vec<Result<Metrics, RunError>> {
    answers.into_iter().map(|answer| answer.map(|asked| asked.metrics)).collect()
}

/// What came out of a run that was asked about other thresholds.
#[derive(Debug, Clone)]
pub(crate) struct Asked {
    pub(crate) metrics: Metrics,
    /// Those that were asked under which the run is the same, to the last bit; some of which that is true may be missing.
    pub(crate) alike: Vec<f64>,
}

/// [`run_pack_in`] with noise that runs of the same seed share, each scenario asked for its `higher` thresholds, which are above
/// its detector's own and below the cap.
pub(crate) fn run_pack_asking(
    set: InstructionSet,
    bank: &mut NoiseBank,
    scenarios: &[Scenario],
    higher: &[Vec<f64>],
) -> Vec<Result<Asked, RunError>> {
    let set = if set.is_available() { set } else { InstructionSet::Baseline };
    let packs = scenarios.chunks(PACK).enumerate();
    packs.flat_map(|(k, pack)| run_eight(set, bank, pack, higher.get(k * PACK..).unwrap_or(&[]))).collect()
}

/// Whether scenarios, [`PACK`] of them at most, can be run side by side on this machine.
#[must_use]
pub fn can_share(scenarios: &[Scenario]) -> bool {
    scenarios.len() <= PACK && Engines::of(scenarios).is_some_and(|engines| engines.can_share())
}

/// Up to eight scenarios.
fn run_eight(
    set: InstructionSet,
    bank: &mut NoiseBank,
    scenarios: &[Scenario],
    higher: &[Vec<f64>],
) -> Vec<Result<Asked, RunError>> {
    let higher_of = |k: usize| higher.get(k).map_or(&[][..], Vec::as_slice);
    let enough = scenarios.len() >= FEWEST && set != InstructionSet::Baseline;
    let engines = if enough { Engines::of(scenarios) } else { None };
    let together = engines.and_then(|mut engines| {
        engines.share_noise(bank);
        engines.ask(higher);
        engines.run(set, scenarios)
    });
    match together {
        Some(answers) => {
            // A link goes on counting after its lane has diverged, where a run of its own ends.
            let ends_early = |metrics: &Metrics| metrics.link.is_some() && metrics.outcome != Outcome::Completed;
            let each = answers.into_iter().zip(scenarios);
            each.map(|(asked, one)| if ends_early(&asked.metrics) { measure_asking(one, &[]) } else { Ok(asked) })
                .collect()
        }
        None => scenarios.iter().enumerate().map(|(k, one)| measure_asking(one, higher_of(k))).collect(),
    }
}

/// The engines of scenarios, all of one kind.
struct Engines(Vec<ScenarioEngine>);

impl Engines {
    /// Nothing where there are none, or one cannot be built: that is for its own run to say.
    fn of(scenarios: &[Scenario]) -> Option<Self> {
        let engines: Result<Vec<_>, _> = scenarios.iter().map(Scenario::build).collect();
        engines.ok().filter(|engines| !engines.is_empty()).map(Self)
    }

    fn share_noise(&mut self, bank: &mut NoiseBank) {
        for engine in &mut self.0 {
            if let ScenarioEngine::Exact(engine) = engine {
                engine.sensor.share_noise(bank, engine.grid.ticks());
            }
        }
    }

    fn ask(&mut self, higher: &[Vec<f64>]) {
        for (engine, higher) in self.0.iter_mut().zip(higher) {
            engine.ask_higher_thresholds(higher);
        }
    }

    /// Lanes that are left over run the last scenario again.
    fn lanes(&self) -> [&ScenarioEngine; LANES] {
        std::array::from_fn(|lane| &self.0[lane.min(self.0.len() - 1)])
    }

    fn can_share(&self) -> bool {
        let Some(engines) = self.exact() else { return false };
        match InstructionSet::widest() {
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx512 => gather::<Avx512, _, _>(engines, ExactPlants::gather::<Avx512>).is_some(),
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx2 => gather::<Avx2, _, _>(engines, ExactPlants::gather::<Avx2>).is_some(),
            _ => false,
        }
    }

    fn exact(&self) -> Option<[&Engine<f64, ExactPlants<f64>>; LANES]> {
        Some(of_each!(self.lanes(), |engine| match engine {
            ScenarioEngine::Exact(engine) => &**engine,
            _ => return None,
        }))
    }

    fn run(&self, set: InstructionSet, scenarios: &[Scenario]) -> Option<Vec<Asked>> {
        let engines = self.exact()?;
        match set {
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx512 => side_by_side::<Avx512>(engines, scenarios),
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx2 => side_by_side::<Avx2>(engines, scenarios),
            _ => None,
        }
    }
}

/// Runs engines in lanes, where they can share them.
fn side_by_side<L: Wide>(
    engines: [&Engine<f64, ExactPlants<f64>>; LANES],
    scenarios: &[Scenario],
) -> Option<Vec<Asked>> {
    match gather::<L, _, _>(engines, ExactPlants::gather_alike) {
        Some(engine) => run_gathered(engine, scenarios),
        None => run_gathered(gather::<L, _, _>(engines, ExactPlants::gather)?, scenarios),
    }
}

fn run_gathered<L: Wide, S: Plants<L>>(mut engine: Engine<L, S>, scenarios: &[Scenario]) -> Option<Vec<Asked>> {
    let grid = engine.grid;
    let ruptures = scenarios.iter().map(|scenario| scenario.rupture_times_s().len()).max().unwrap_or(0);
    let mut observer = MetricsObserver::<L>::new(grid, ruptures);
    // Stepped exactly, nothing gives up.
    L::run(&mut engine, &mut observer).ok()?;
    let answer = |lane: usize| {
        let link = engine.link.report(lane).map(|report| LinkMetrics::new(&report, &grid));
        Asked { metrics: Metrics { link, ..observer.metrics(lane) }, alike: engine.thresholds_alike(lane) }
    };
    Some((0..scenarios.len()).map(answer).collect())
}
