//! The certificate of a candidate for all patients and persons.
//!
//! Patients with equal machines, arms and delays share a certificate over every stiffness and damping of their tissues,
//! and designs that differ only in the hold share one over all durations, if it exists.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::sync::{Mutex, PoisonError};

use super::nsga::{knee, spread};
use super::population::Population;
use super::problem::Problem;
use super::search::{State, front_of};
use crate::run::RunError;
use crate::stability_check::tissue_range;
use crate::sweep::sha256;
use trocar_base::parallel::{map, try_map};
use trocar_core::augmentation::{AugmentationSettings, AutomatonSettings, Reengage};
use trocar_scenario::{Scenario, Value};
use trocar_stability::{LinearLoop, Peaks, SwitchingSettings, TissueRange, VaryingDelays, left_out};

/// In multiples of the shown designs.
const TRIED: usize = 3;

/// An error is the reason why there can be no certificate.
type Loops = Result<Covered, String>;

#[derive(Debug, Clone, Default)]
struct Covered {
    loops: Vec<(String, SwitchingSettings)>,
    left_out: BTreeSet<String>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Front {
    pub shown: Vec<usize>,
    pub knee: Option<usize>,
    /// Candidates that are on the front without their certificates.
    pub uncertified: Vec<usize>,
    /// The reason for the first of them.
    pub reason: Option<String>,
    pub left_out: Vec<String>,
    pub candidates: usize,
}

#[derive(Debug)]
pub struct Certification<'a> {
    problem: &'a Problem,
    populations: Vec<&'a Population>,
    /// Keys are the bits of the coordinates.
    known: Mutex<HashMap<Vec<u64>, Loops>>,
}

impl<'a> Certification<'a> {
    /// Certificates must cover the patients of all populations.
    pub fn new(problem: &'a Problem, populations: Vec<&'a Population>) -> Self {
        Self { problem, populations, known: Mutex::default() }
    }

    /// The second value is true if designs still need certificates.
    pub fn front(&self, state: &State) -> Result<(Front, bool), RunError> {
        let points = state.points(self.problem);
        let mut refused = HashSet::new();
        loop {
            let candidates = front_of(&points, &refused);
            let knee = knee(&points, &candidates);
            let shown = spread(&points, &candidates, knee, self.problem.search.front);
            let mut uncertified: Vec<usize> = refused.iter().copied().collect();
            uncertified.sort_unstable();
            let (reason, left_out) = (self.first_reason(state, &uncertified)?, self.left_out(state, &shown)?);
            let mut front = Front { shown, knee, uncertified, reason, left_out, candidates: candidates.len() };
            if self.problem.goals.certified.is_none() {
                return Ok((front, false));
            }
            let statements: Vec<(usize, Option<bool>)> = front
                .shown
                .iter()
                .map(|&index| Ok((index, self.statement(&state.certificates, &state.archive[index].coordinates)?)))
                .collect::<Result<_, RunError>>()?;
            let without: Vec<usize> =
                statements.iter().filter(|(_, statement)| *statement == Some(false)).map(|(index, _)| *index).collect();
            if statements.iter().any(|(_, statement)| statement.is_none()) {
                return Ok((front, true));
            }
            if without.is_empty() {
                return Ok((front, false));
            }
            if refused.len() + without.len() > TRIED * self.problem.search.front {
                front.shown.retain(|index| !without.contains(index));
                front.knee = front.knee.filter(|index| !without.contains(index));
                front.uncertified.extend(without);
                return Ok((front, false));
            }
            refused.extend(without);
        }
    }

    fn first_reason(&self, state: &State, uncertified: &[usize]) -> Result<Option<String>, RunError> {
        let Some(&first) = uncertified.first() else { return Ok(None) };
        Ok(self.loops(&state.archive[first].coordinates)?.err())
    }

    fn left_out(&self, state: &State, shown: &[usize]) -> Result<Vec<String>, RunError> {
        let mut all = BTreeSet::new();
        if self.problem.goals.certified.is_some() {
            for &index in shown {
                all.extend(self.loops(&state.archive[index].coordinates)?.unwrap_or_default().left_out);
            }
        }
        Ok(all.into_iter().collect())
    }

    /// Searches for at most `count` certificates. The results do not depend on `count`.
    pub fn certify(
        &self,
        state: &mut State,
        candidates: &[usize],
        count: usize,
        done: &(dyn Fn() + Sync),
    ) -> Result<(), RunError> {
        let mut alike: BTreeMap<String, BTreeMap<String, SwitchingSettings>> = BTreeMap::new();
        for &index in candidates {
            for (key, settings) in self.loops(&state.archive[index].coordinates)?.unwrap_or_default().loops {
                alike.entry(key_of(&with_hold(&settings, (0.0, 0.0)))).or_default().insert(key, settings);
            }
        }
        let mut jobs: Vec<(Vec<String>, SwitchingSettings)> = vec![];
        for members in alike.into_values() {
            if members.keys().all(|key| state.certificates.contains_key(key)) {
                continue;
            }
            let longest = over_all_holds(members.values());
            match longest.map(|settings| (key_of(&settings), settings)) {
                Some((key, settings)) if state.certificates.get(&key) != Some(&false) => {
                    jobs.push((members.into_keys().chain([key]).collect(), settings));
                }
                _ => jobs.extend(
                    members
                        .into_iter()
                        .filter(|(key, _)| !state.certificates.contains_key(key))
                        .map(|(key, settings)| (vec![key], settings)),
                ),
            }
        }
        jobs.truncate(count.max(1));
        let found = map(jobs.len(), |index| {
            let found = Peaks::exist(&jobs[index].1, None).unwrap_or(false);
            done();
            found
        });
        for ((mut keys, _), found) in jobs.into_iter().zip(found) {
            if !found && keys.len() > 1 {
                // Without a certificate over all holds, each design needs its own.
                keys.drain(..keys.len() - 1);
            }
            state.certificates.extend(keys.into_iter().map(|key| (key, found)));
        }
        Ok(())
    }

    pub fn statement(&self, known: &BTreeMap<String, bool>, coordinates: &[f64]) -> Result<Option<bool>, RunError> {
        let Ok(Covered { loops, .. }) = self.loops(coordinates)? else { return Ok(Some(false)) };
        let found: Vec<Option<bool>> = loops.iter().map(|(key, _)| known.get(key).copied()).collect();
        Ok(match found {
            found if found.contains(&Some(false)) => Some(false),
            found if found.contains(&None) => None,
            _ => Some(true),
        })
    }

    fn loops(&self, coordinates: &[f64]) -> Result<Loops, RunError> {
        let bits: Vec<u64> = coordinates.iter().map(|coordinate| coordinate.to_bits()).collect();
        if let Some(loops) = self.known.lock().unwrap_or_else(PoisonError::into_inner).get(&bits) {
            return Ok(loops.clone());
        }
        let loops = self.loops_of(coordinates)?;
        self.known.lock().unwrap_or_else(PoisonError::into_inner).insert(bits, loops.clone());
        Ok(loops)
    }

    fn loops_of(&self, coordinates: &[f64]) -> Result<Loops, RunError> {
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

/// One loop for each set of machines, arms and delays.
fn loops_of(scenarios: &[Scenario]) -> Result<Loops, RunError> {
    let mut groups: BTreeMap<String, (&Scenario, TissueRange)> = BTreeMap::new();
    for scenario in scenarios {
        let tissue = tissue_range(scenario)?;
        if scenario.sensor.force_resolution_n > 0.0 {
            return Ok(Err("the force sensor has steps, and motions within them need not decay".to_owned()));
        }
        let key = format!(
            "{:?}",
            (
                (scenario.grid.tick_s(), scenario.timing, &scenario.master, &scenario.master_model, &scenario.arm),
                (&scenario.slave, &scenario.actuators, &scenario.link, scenario.sensor.force_bandwidth_hz),
                (&scenario.forward, &scenario.backward, tissue.source),
            )
        );
        let (_, range) = groups.entry(key).or_insert((scenario, tissue));
        range.springs = range.springs.and(&tissue.springs);
    }
    let mut covered = Covered::default();
    for (scenario, tissue) in groups.into_values() {
        let Ok(of_loop) = LinearLoop::of(scenario, tissue) else {
            return Ok(Err("the loop cannot be analysed".to_owned()));
        };
        let delays = VaryingDelays::of(scenario, &of_loop).ok().flatten();
        covered.left_out.extend(left_out(scenario, delays.as_ref()).iter().map(ToString::to_string));
        match SwitchingSettings::of(scenario, of_loop, tissue.sector_n_per_m()) {
            Ok(settings) if settings.keeps_gap() => return Ok(Err("an event leaves a gap that is kept".to_owned())),
            Ok(settings) => {
                let settings = essential(&settings);
                covered.loops.push((key_of(&settings), settings));
            }
            Err(reason) => return Ok(Err(reason)),
        }
    }
    Ok(Ok(covered))
}

fn key_of(settings: &SwitchingSettings) -> String {
    sha256(format!("{settings:?}").as_bytes())
}

/// Removes values that do not affect a certificate: it holds for a ramp of any speed, and depends on the automaton only
/// by the times that it enforces.
fn essential(settings: &SwitchingSettings) -> SwitchingSettings {
    let augmentation = settings.augmentation;
    let AutomatonSettings { min_hold_s, max_hold_s, exit_quiet_s, refractory_s, .. } = augmentation.automaton;
    let reengage = match augmentation.reengage {
        Reengage::Ramp { .. } => Reengage::default(),
        other => other,
    };
    // Only the longer of quiet time and hold has an effect.
    let automaton = AutomatonSettings {
        min_hold_s: min_hold_s.max(exit_quiet_s),
        max_hold_s,
        exit_quiet_s: 0.0,
        refractory_s,
        ..AutomatonSettings::DEFAULT
    };
    let augmentation = AugmentationSettings { reengage, cue: false, automaton, ..augmentation };
    SwitchingSettings { augmentation, ..settings.clone() }
}

fn with_hold(settings: &SwitchingSettings, (min_hold_s, max_hold_s): (f64, f64)) -> SwitchingSettings {
    let automaton = AutomatonSettings { min_hold_s, max_hold_s, ..settings.augmentation.automaton };
    let augmentation = AugmentationSettings { automaton, ..settings.augmentation };
    SwitchingSettings { augmentation, ..settings.clone() }
}

/// The settings differ in their holds only.
fn over_all_holds<'a>(settings: impl Iterator<Item = &'a SwitchingSettings>) -> Option<SwitchingSettings> {
    let all: Vec<&SwitchingSettings> = settings.collect();
    let holds = || all.iter().map(|settings| &settings.augmentation.automaton);
    let least = holds().map(|automaton| automaton.min_hold_s).fold(f64::INFINITY, f64::min);
    let most = holds().map(|automaton| automaton.max_hold_s).fold(0.0, f64::max);
    all.first().filter(|_| all.len() > 1).map(|first| with_hold(first, (least, most)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use trocar_scenario::Source;

    fn settings(changes: &[&str]) -> SwitchingSettings {
        let changes: Vec<String> = changes.iter().map(|&change| format!("augmentation.{change}")).collect();
        let scenario = Scenario::load(&Source::parse("layers/skin-augmented"), &changes).expect("good");
        let loops = loops_of(&[scenario]).expect("analysed").expect("covered").loops;
        assert_eq!(loops.len(), 1);
        loops[0].1.clone()
    }

    #[test]
    fn designs_share_a_certificate_unless_its_times_or_laws_differ() {
        let key = |changes: &[&str]| key_of(&settings(changes));
        let base = key(&[]);
        assert_eq!(base, key(&["catch_up_speed_m_per_s=0.01", "cue=true", "exit_ratio=0.3"]));
        assert_eq!(key(&["min_hold_s=0.01"]), key(&["min_hold_s=0.03"]), "shorter than the quiet time");
        for change in ["min_hold_s=0.3", "max_hold_s=1.5", "refractory_s=0.3", "reengage=snap", "force_law=amplify"] {
            assert_ne!(base, key(&[change]), "{change}");
        }
        assert_ne!(key(&["reengage=fade"]), key(&["reengage=fade", "gap_time_constant_s=1"]));
        let all = [settings(&["min_hold_s=0.3"]), settings(&["max_hold_s=1.5"])];
        let over_all = over_all_holds(all.iter()).expect("two");
        assert_eq!(over_all, settings(&["min_hold_s=0.3", "max_hold_s=1.5"]));
        assert_eq!(over_all_holds(all[..1].iter()), None);
    }

    #[test]
    fn equal_arms_share_a_certificate_over_all_tissues() {
        let scenario = |changes: &[&str]| {
            let changes: Vec<String> = changes.iter().map(|&change| change.to_owned()).collect();
            Scenario::load(&Source::parse("layers/skin-augmented"), &changes).expect("good")
        };
        let patients = [
            scenario(&["tissue.layer.skin.stiffness_n_per_m=100"]),
            scenario(&["tissue.layer.skin.stiffness_n_per_m=400"]),
            scenario(&["arm.grip=firm"]),
        ];
        let loops = loops_of(&patients).expect("analysed").expect("covered").loops;
        assert_eq!(loops.len(), 2);
        let stiffest = |scenario: &Scenario| tissue_range(scenario).expect("known").stiffest_n_per_m();
        let covered = loops.iter().map(|(_, settings)| settings.stiffness_n_per_m.1).fold(0.0, f64::max);
        assert_eq!(covered, stiffest(&patients[1]).max(stiffest(&patients[0])));
    }

    #[test]
    fn a_scenario_that_a_certificate_does_not_cover_has_a_reason() {
        let reason = |changes: &[&str]| {
            let changes: Vec<String> = changes.iter().map(|&change| change.to_owned()).collect();
            let scenario = Scenario::load(&Source::parse("layers/skin-augmented"), &changes).expect("good");
            loops_of(&[scenario]).expect("analysed").expect_err("not covered")
        };
        assert!(reason(&["augmentation.reengage=clutch"]).contains("gap"));
        assert!(reason(&["augmentation.enabled=false"]).contains("no events"));
        assert!(reason(&["sensor.force_resolution_n=0.01"]).contains("steps"));
    }
}
