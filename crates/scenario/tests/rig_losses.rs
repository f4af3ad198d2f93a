//! The controller of a rig finds the ruptures of a run of which samples are missing.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use trocar_core::rig::{Counters, DetectionState, HapticController, Sample};
use trocar_engine::engine::{Observer, Signals};
use trocar_scenario::{Scenario, Source};

/// Latest detection after a rupture, in ticks. Without losses it takes up to 12 ticks, as the force falls over several
/// ticks; the longest bridged gap and the first crossing after it add to them.
const DELAY_TICKS: u64 = 30;

const RUNS: u64 = 200;

/// The samples of a run, and the ticks of its ruptures.
#[derive(Default)]
struct Tape {
    samples: Vec<Sample>,
    ruptures: Vec<u64>,
}

impl Observer<f64> for Tape {
    fn observe(&mut self, signals: &Signals<f64>) {
        if signals.ruptured {
            self.ruptures.push(signals.tick);
        }
        self.samples.push(Sample {
            master_position_m: signals.master_position_m,
            slave_position_m: signals.slave_position_m,
            slave_velocity_m_per_s: signals.slave_velocity_m_per_s,
            force_n: signals.measured_force_n,
        });
    }
}

struct Run {
    scenario: Scenario,
    tape: Tape,
    /// The ticks of the alarms without losses.
    alarms: Vec<u64>,
}

impl Run {
    fn new(name: &str) -> Self {
        let scenario = Scenario::load(&Source::parse(&format!("builtin:{name}")), &[]).expect("loads");
        let mut tape = Tape::default();
        scenario.build().expect("builds").run(&mut tape).expect("runs");
        let mut run = Self { scenario, tape, alarms: vec![] };
        run.alarms = run.alarms_of(|sample, _| sample).0;
        run
    }

    fn controller(&self) -> HapticController {
        HapticController::new(&self.scenario.rig_settings()).expect("valid")
    }

    /// The ticks of the alarms on disturbed samples, and the counts of the samples.
    fn alarms_of(&self, mut disturb: impl FnMut(Sample, u64) -> Sample) -> (Vec<u64>, Counters) {
        let mut controller = self.controller();
        let mut alarms = vec![];
        for (tick, sample) in (0..).zip(&self.tape.samples) {
            if controller.step(&disturb(*sample, tick)).alarm {
                alarms.push(tick);
            }
        }
        (alarms, controller.counters())
    }

    /// The number of ruptures with an alarm, and of alarms without a rupture that the same run without losses does not
    /// raise.
    fn score(&self, alarms: &[u64]) -> (usize, usize) {
        let is_of = |alarm: u64, rupture: u64| (rupture..=rupture + DELAY_TICKS).contains(&alarm);
        let ruptures = &self.tape.ruptures;
        let found = ruptures.iter().filter(|rupture| alarms.iter().any(|alarm| is_of(*alarm, **rupture))).count();
        let is_known = |alarm: u64| {
            ruptures.iter().any(|rupture| is_of(alarm, *rupture))
                || self.alarms.iter().any(|known| alarm.abs_diff(*known) <= DELAY_TICKS)
        };
        (found, alarms.iter().filter(|alarm| !is_known(**alarm)).count())
    }
}

fn runs() -> [(Run, usize); 2] {
    [(Run::new("paper/augmented"), 2), (Run::new("layers/skin-augmented"), 3)]
}

/// Counts the runs in which every rupture is found, and the false alarms of all runs.
fn complete_runs(run: &Run, mut alarms: impl FnMut(&mut ChaCha8Rng) -> Vec<u64>) -> (u64, usize) {
    let (mut complete, mut false_alarms) = (0, 0);
    for seed in 0..RUNS {
        let (found, others) = run.score(&alarms(&mut ChaCha8Rng::seed_from_u64(seed)));
        complete += u64::from(found == run.tape.ruptures.len());
        false_alarms += others;
    }
    (complete, false_alarms)
}

#[test]
fn ruptures_are_found_when_up_to_five_percent_of_the_samples_are_missing_at_random() {
    for (run, ruptures) in runs() {
        assert_eq!(run.tape.ruptures.len(), ruptures);
        for share in [0.001, 0.01, 0.02, 0.05] {
            let (complete, false_alarms) = complete_runs(&run, |random| {
                run.alarms_of(|sample, _| if random.random::<f64>() < share { Sample::MISSING } else { sample }).0
            });
            println!("{}: {share}: {complete} of {RUNS}, {false_alarms} false", run.scenario.name);
            assert!(100 * complete >= 98 * RUNS, "{} {share}: {complete}", run.scenario.name);
            assert_eq!(false_alarms, 0, "{} {share}", run.scenario.name);
        }
    }
}

#[test]
fn ruptures_are_found_when_bursts_of_one_to_nine_samples_are_missing() {
    for (run, _) in runs() {
        for share in [0.01, 0.02, 0.05] {
            let (complete, false_alarms) = complete_runs(&run, |random| {
                let mut left = 0;
                let lose = |sample, _| {
                    // A burst has five samples on average.
                    if left == 0 && random.random::<f64>() < share / 5.0 {
                        left = random.random_range(1..=9);
                    }
                    let is_lost = left > 0;
                    left -= u64::from(is_lost);
                    if is_lost { Sample::MISSING } else { sample }
                };
                run.alarms_of(lose).0
            });
            println!("{}: bursts {share}: {complete} of {RUNS}, {false_alarms} false", run.scenario.name);
            assert!(100 * complete >= 98 * RUNS, "{} {share}: {complete}", run.scenario.name);
            assert_eq!(false_alarms, 0, "{} {share}", run.scenario.name);
        }
    }
}

#[test]
fn every_rupture_is_found_when_a_force_sample_is_missing_in_regular_intervals() {
    for (run, ruptures) in runs() {
        for interval in 30..=200 {
            let lose = |sample: Sample, tick| Sample {
                force_n: if tick % interval == interval / 2 { f64::NAN } else { sample.force_n },
                ..sample
            };
            let (alarms, counters) = run.alarms_of(lose);
            assert_eq!(run.score(&alarms), (ruptures, 0), "{} every {interval} ms: {alarms:?}", run.scenario.name);
            // A missing last sample has no next one.
            let is_last = (run.tape.samples.len() as u64 - 1) % interval == interval / 2;
            assert_eq!((counters.bridged, counters.gaps), (counters.bad - u64::from(is_last), 0));
        }
    }
}

#[test]
fn a_gap_that_is_too_long_is_reported_as_blind_and_then_as_settling() {
    let run = Run::new("paper/augmented");
    let mut controller = run.controller();
    let first = run.tape.ruptures[0] as usize;
    let settle_ticks = 100;
    // Ten samples are missing well before the first rupture, in quiet contact.
    let gap = first - 500..first - 490;
    let mut states = vec![];
    for (tick, sample) in run.tape.samples[..first].iter().enumerate() {
        let command = controller.step(if gap.contains(&tick) { &Sample::MISSING } else { sample });
        states.push((command.detection, command.detection_ticks));
    }
    let from = gap.start;
    assert!(states[from - 1].0 == DetectionState::Armed && states[from + 8].0 == DetectionState::Armed);
    assert_eq!(states[from + 9], (DetectionState::Blind, 0), "the tenth missing sample");
    assert_eq!(states[gap.end], (DetectionState::Settling, 0));
    let armed = states[gap.end..].iter().position(|state| state.0 == DetectionState::Armed).expect("armed again");
    assert!((settle_ticks..settle_ticks + 3).contains(&armed), "{armed}");
    assert_eq!(states[gap.end + armed].1, 0);
    assert_eq!(controller.counters(), Counters { bad: 10, gaps: 1, ..Counters::default() });
}

#[test]
fn swapped_repeated_and_skipped_samples_are_recognised_by_their_numbers() {
    for (run, ruptures) in runs() {
        let mut controller = run.controller();
        let mut alarms = vec![];
        let mut take = |tick: u64, number: usize| {
            if controller.step_numbered(&run.tape.samples[number], number as u64 + 1).alarm {
                alarms.push(tick);
            }
        };
        let mut lost = 0;
        for tick in 0..run.tape.samples.len() {
            match tick % 50 {
                // Samples 10 and 11 arrive in the wrong order, 20 arrives instead of 21, and 30 never arrives.
                10 if tick + 1 < run.tape.samples.len() => take(tick as u64, tick + 1),
                11 => take(tick as u64, tick - 1),
                21 => take(tick as u64, tick - 1),
                30 => lost += 1,
                _ => take(tick as u64, tick),
            }
        }
        assert_eq!(run.score(&alarms), (ruptures, 0), "{}: {alarms:?}", run.scenario.name);
        let fifties = run.tape.samples.len() as u64 / 50;
        let expected = Counters { bad: 2 * fifties, repeated: fifties, late: fifties, bridged: 3 * fifties, gaps: 0 };
        assert_eq!((controller.counters(), lost), (expected, fifties));
    }
}
