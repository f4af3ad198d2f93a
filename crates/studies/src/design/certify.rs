//! The certificate of a candidate for all patients and persons.
//!
//! Patients whose machines, arms and delays are equal share a certificate: its tissue has every stiffness and damping of
//! their tissues. It is stronger than the certificates of single patients. A certificate is stored under all that it
//! depends on, so another candidate with the same events does not need another search.

use std::collections::{BTreeMap, HashSet};

use super::nsga::{knee, spread};
use super::population::Population;
use super::problem::Problem;
use super::search::{State, front_of};
use crate::run::RunError;
use crate::stability_check::tissue_range;
use crate::sweep::sha256;
use trocar_base::parallel::{map, try_map};
use trocar_scenario::{Scenario, Value};
use trocar_stability::{LinearLoop, Peaks, SwitchingSettings, TissueRange, TissueSource, VaryingDelays, left_out};

/// Maximum number of candidates whose certificates are searched for, as a multiple of the shown designs.
const TRIED: usize = 3;

/// The loops of a candidate for which a certificate is needed, or the reason why there can be none.
type Loops = Result<Vec<(String, SwitchingSettings)>, String>;

/// The designs on the front, by their index in the archive.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Front {
    /// The shown designs, ascending by index.
    pub shown: Vec<usize>,
    /// The knee.
    pub knee: Option<usize>,
    /// Candidates that are on the front without their certificates.
    pub uncertified: Vec<usize>,
    /// Number of candidates on the front.
    pub candidates: usize,
}

/// Selects the shown designs from a complete search and searches for their certificates.
#[derive(Debug)]
pub struct Certification<'a> {
    problem: &'a Problem,
    populations: Vec<&'a Population>,
}

impl<'a> Certification<'a> {
    /// Certificates must cover the patients of all these populations.
    #[must_use]
    pub fn new(problem: &'a Problem, populations: Vec<&'a Population>) -> Self {
        Self { problem, populations }
    }

    /// The front as far as certificates are known, and the candidates whose certificates are needed next; none if the
    /// front is final. `uncertified` has the candidates without a certificate so far.
    ///
    /// # Errors
    /// [`RunError`] of a candidate whose scenario is invalid for a patient.
    pub fn front(&self, state: &State) -> Result<(Front, Vec<usize>), RunError> {
        let points = state.points(self.problem);
        let mut refused = HashSet::new();
        loop {
            let candidates = front_of(&points, &refused);
            let mut shown = spread(&points, &candidates, self.problem.search.front);
            let knee = knee(&points, &candidates);
            shown.extend(knee.filter(|knee| !shown.contains(knee)));
            shown.sort_unstable();
            let mut uncertified: Vec<usize> = refused.iter().copied().collect();
            uncertified.sort_unstable();
            let mut front = Front { shown, knee, uncertified, candidates: candidates.len() };
            if self.problem.goals.certified.is_none() {
                return Ok((front, vec![]));
            }
            let statements: Vec<(usize, Option<bool>)> = front
                .shown
                .iter()
                .map(|&index| Ok((index, self.statement(&state.certificates, &state.archive[index].coordinates)?)))
                .collect::<Result<_, RunError>>()?;
            let needed: Vec<usize> =
                statements.iter().filter(|(_, statement)| statement.is_none()).map(|(index, _)| *index).collect();
            let without: Vec<usize> =
                statements.iter().filter(|(_, statement)| *statement == Some(false)).map(|(index, _)| *index).collect();
            if !needed.is_empty() {
                return Ok((front, needed));
            }
            if without.is_empty() {
                return Ok((front, vec![]));
            }
            if refused.len() + without.len() > TRIED * self.problem.search.front {
                front.shown.retain(|index| !without.contains(index));
                front.knee = front.knee.filter(|index| !without.contains(index));
                front.uncertified.extend(without);
                return Ok((front, vec![]));
            }
            refused.extend(without);
        }
    }

    /// Searches for the certificates of candidates of the archive, and adds the results to the state.
    ///
    /// # Errors
    /// As [`Certification::front`].
    pub fn certify(&self, state: &mut State, candidates: &[usize], done: &(dyn Fn() + Sync)) -> Result<(), RunError> {
        let mut needed: BTreeMap<String, SwitchingSettings> = BTreeMap::new();
        for &index in candidates {
            let loops = self.loops(&state.archive[index].coordinates)?.unwrap_or_default();
            needed.extend(loops.into_iter().filter(|(key, _)| !state.certificates.contains_key(key)));
        }
        let needed: Vec<(String, SwitchingSettings)> = needed.into_iter().collect();
        let found = map(needed.len(), |index| {
            let found = Peaks::exist(&needed[index].1, None).unwrap_or(false);
            done();
            found
        });
        state.certificates.extend(needed.into_iter().map(|(key, _)| key).zip(found));
        Ok(())
    }

    /// True if every loop of a candidate is certified; `None` if it is not yet known.
    ///
    /// # Errors
    /// As [`Certification::front`].
    pub fn statement(&self, known: &BTreeMap<String, bool>, coordinates: &[f64]) -> Result<Option<bool>, RunError> {
        let Ok(loops) = self.loops(coordinates)? else { return Ok(Some(false)) };
        let found: Vec<Option<bool>> = loops.iter().map(|(key, _)| known.get(key).copied()).collect();
        Ok(match found {
            found if found.contains(&Some(false)) => Some(false),
            found if found.contains(&None) => None,
            _ => Some(true),
        })
    }

    /// Number of certificates of a candidate; `None` if there can be none.
    ///
    /// # Errors
    /// As [`Certification::front`].
    pub fn count(&self, coordinates: &[f64]) -> Result<Option<usize>, RunError> {
        Ok(self.loops(coordinates)?.ok().map(|loops| loops.len()))
    }

    fn loops(&self, coordinates: &[f64]) -> Result<Loops, RunError> {
        let values = self.problem.values(coordinates);
        let mut scenarios = vec![];
        for population in &self.populations {
            let of_patient = |patient| scenarios_of(population, patient, &values);
            scenarios.extend(try_map(population.patients(), of_patient)?.into_iter().flatten());
        }
        loops_of(&scenarios)
    }
}

fn scenarios_of(population: &Population, patient: usize, values: &[Value]) -> Result<Vec<Scenario>, RunError> {
    Ok(population.with_persons(&mut population.factory(patient), patient, values)?)
}

/// The loops of scenarios, one for each set of machines, arms and delays.
fn loops_of(scenarios: &[Scenario]) -> Result<Loops, RunError> {
    let mut groups: BTreeMap<String, (&Scenario, TissueRange)> = BTreeMap::new();
    for scenario in scenarios {
        let tissue = tissue_range(scenario)?;
        if tissue.source == TissueSource::Run {
            return Ok(Err("the stiffness of the tissue is known from a run only".to_owned()));
        }
        if scenario.sensor.force_resolution_n > 0.0 {
            return Ok(Err("the force sensor has steps, and motions within them need not decay".to_owned()));
        }
        let key = format!(
            "{:?}",
            (
                (scenario.grid.tick_s(), scenario.timing, &scenario.master, &scenario.master_model, &scenario.arm),
                (&scenario.slave, &scenario.actuators, &scenario.link, scenario.sensor.force_bandwidth_hz),
                (&scenario.forward, &scenario.backward, tissue.source, tissue.damping_n_s_per_m),
            )
        );
        let (_, range) = groups.entry(key).or_insert((scenario, tissue));
        let (low, high) = range.stiffness_n_per_m;
        range.stiffness_n_per_m = (low.min(tissue.stiffness_n_per_m.0), high.max(tissue.stiffness_n_per_m.1));
        range.largest_damping_n_s_per_m = range.largest_damping_n_s_per_m.max(tissue.largest_damping_n_s_per_m);
    }
    let mut loops = vec![];
    for (scenario, tissue) in groups.into_values() {
        let Ok(of_loop) = LinearLoop::of(scenario, tissue) else {
            return Ok(Err("the loop cannot be analysed".to_owned()));
        };
        let delays = VaryingDelays::of(scenario, &of_loop).ok().flatten();
        if let Some(part) = left_out(scenario, delays.as_ref()).first() {
            return Ok(Err(format!("the analysis leaves out {}", part.what)));
        }
        match SwitchingSettings::of(scenario, of_loop, tissue.stiffness_n_per_m) {
            Ok(settings) if settings.keeps_gap() => return Ok(Err("an event leaves a gap that is kept".to_owned())),
            Ok(settings) => loops.push((sha256(format!("{settings:?}").as_bytes()), settings)),
            Err(reason) => return Ok(Err(reason.to_owned())),
        }
    }
    Ok(Ok(loops))
}
