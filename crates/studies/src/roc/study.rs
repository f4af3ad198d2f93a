use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use schemars::JsonSchema;
use serde::Serialize;

use super::RocError;
use super::curve::{Curve, Point};
use super::detector_bank::DetectorBank;
use super::misses;
use super::signal::Signal;
use super::tally::Tally;
use trocar_base::parallel::try_map;
use trocar_base::warning::{Code, Warning};
use trocar_core::detector::{DetectorInput, DetectorSettings};
use trocar_recording::InVivoLikeVariant;

#[derive(Debug, Clone)]
pub struct Study {
    /// All signals have the same detectors.
    pub signals: Vec<Signal>,
    pub noise_std_n: Vec<f64>,
    /// Seeds per condition, from 1.
    pub seeds: u64,
    /// Thresholds per detector, at least 2.
    pub thresholds: usize,
    /// Maximum delay of a detection.
    pub within_s: f64,
}

/// A signal with one noise level, and the performance of the detectors.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Condition {
    /// Name of the signal.
    pub signal: String,
    /// Standard deviation of the added noise, in N.
    pub noise_std_n: f64,
    /// Force drop of each rupture, in N; `None` for the shipped or recorded drop.
    pub drop_n: Option<f64>,
    /// Time constant of each force drop, in s; `None` for the shipped or recorded value.
    pub sharpness_s: Option<f64>,
    /// Depth of the first rupture, in m; `None` for the shipped or recorded depth.
    pub depth_m: Option<f64>,
    /// A curve per detector.
    pub curves: Vec<Curve>,
}

/// The result of a study.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Characteristics {
    /// Maximum delay of a detection, in s.
    pub within_s: f64,
    /// Number of planned cases.
    pub cases_planned: u64,
    /// Number of evaluated cases; fewer than planned if the study was stopped.
    pub cases: u64,
    /// The curves over all conditions.
    pub all: Vec<Curve>,
    /// The curves of each condition.
    pub conditions: Vec<Condition>,
}

impl Characteristics {
    pub fn warnings(&self) -> Vec<Warning> {
        let mut points = self.all.iter().flat_map(|curve| &curve.points).peekable();
        if points.peek().is_none() || points.any(|point| point.ruptures > 0) {
            return vec![];
        }
        let message = "no rupture is labelled: every alarm counts as false";
        let remedy = "give the true ruptures with --rupture-s, unless the recordings have none";
        vec![Warning::new(Code::NoRuptures, message).at("--rupture-s").remedy(remedy)]
    }

    /// Name, threshold (NaN without one) and points. Equal names form one curve.
    pub fn add_user_defined(&mut self, evaluated: &[(String, f64, UserDefinedPoints)]) {
        add_curves(&mut self.all, evaluated, |points| &points.all);
        for (index, condition) in self.conditions.iter_mut().enumerate() {
            add_curves(&mut condition.curves, evaluated, |points| &points.conditions[index]);
        }
        // Without a built-in detector no case has been counted yet.
        let cases = evaluated.first().map_or(0, |(_, _, points)| points.all.cases);
        (self.cases, self.cases_planned) = (self.cases.max(cases), self.cases_planned.max(cases));
    }
}

fn add_curves(
    curves: &mut Vec<Curve>,
    evaluated: &[(String, f64, UserDefinedPoints)],
    of: impl Fn(&UserDefinedPoints) -> &Point,
) {
    let mut added: Vec<Curve> = vec![];
    for (name, threshold, points) in evaluated {
        let point = Point { threshold: *threshold, ..of(points).clone() };
        match added.iter_mut().find(|curve| curve.detector == *name) {
            Some(curve) => curve.points.push(point),
            None => added.push(Curve {
                detector: name.clone().into(),
                is_baseline: false,
                is_user_defined: true,
                unit: "",
                own_threshold: *threshold,
                drift: f64::NAN,
                points: vec![point],
            }),
        }
    }
    curves.splice(0..0, added);
}

#[derive(Default)]
struct ThreadTallies {
    tallies: Vec<Tally>,
    input: Vec<DetectorInput<f64>>,
    alarms: Vec<Vec<usize>>,
}

#[derive(Debug, Clone, PartialEq)]
pub struct UserDefinedPoints {
    pub all: Point,
    pub conditions: Vec<Point>,
}

impl UserDefinedPoints {
    fn of(tallies: Vec<Tally>) -> Self {
        let mut all = Tally::default();
        tallies.iter().for_each(|tally| all.add(tally));
        let point = |tally: &Tally| Point::of(f64::NAN, tally);
        Self { all: point(&all), conditions: tallies.iter().map(point).collect() }
    }
}

impl Study {
    pub const NOISE_STDS_N: (f64, f64) = (0.0, 100.0);

    fn conditions(&self) -> Vec<(&Signal, f64)> {
        self.signals.iter().flat_map(|signal| self.noise_std_n.iter().map(move |&noise| (signal, noise))).collect()
    }

    /// `alarms` receives the index of a detector, the inputs of a case and the sampling interval (s), and writes the
    /// alarm samples.
    pub fn run_user_defined<E: From<RocError>>(
        &self,
        detectors: usize,
        mut alarms: impl FnMut(usize, &[DetectorInput<f64>], f64, &mut Vec<usize>) -> Result<(), E>,
    ) -> Result<Vec<UserDefinedPoints>, E> {
        let conditions = self.conditions();
        let mut tallies = vec![vec![Tally::default(); conditions.len()]; detectors];
        let (mut input, mut samples) = (vec![], vec![]);
        for (condition, (signal, noise_std_n)) in conditions.iter().enumerate() {
            for seed in 1..=self.seeds {
                let labels = signal.evaluate(*noise_std_n, seed, self.within_s, &mut input)?;
                for (detector, tallies) in tallies.iter_mut().enumerate() {
                    samples.clear();
                    alarms(detector, &input, labels.tick_s(), &mut samples)?;
                    tallies[condition].count(&samples, &labels);
                }
            }
        }
        Ok(tallies.into_iter().map(UserDefinedPoints::of).collect())
    }

    /// `alarms` creates a new detector for each case.
    pub fn run_user_defined_side_by_side<E: From<RocError> + Send>(
        &self,
        detectors: usize,
        alarms: impl Fn(usize, &[DetectorInput<f64>], f64, &mut Vec<usize>) -> Result<(), E> + Sync,
    ) -> Result<Vec<UserDefinedPoints>, E> {
        let conditions = self.conditions();
        let of_cases = try_map(conditions.len() * self.seeds as usize, |case| {
            let (signal, noise_std_n) = conditions[case / self.seeds as usize];
            let (mut input, mut samples) = (vec![], vec![]);
            let seed = 1 + case as u64 % self.seeds;
            let labels = signal.evaluate(noise_std_n, seed, self.within_s, &mut input)?;
            let tally = |detector| {
                samples.clear();
                alarms(detector, &input, labels.tick_s(), &mut samples)?;
                let mut tally = Tally::default();
                tally.count(&samples, &labels);
                Ok(tally)
            };
            (0..detectors).map(tally).collect::<Result<Vec<_>, E>>()
        })?;
        let mut tallies = vec![vec![Tally::default(); conditions.len()]; detectors];
        for (case, of_case) in of_cases.into_iter().enumerate() {
            for (detector, tally) in of_case.iter().enumerate() {
                tallies[detector][case / self.seeds as usize].add(tally);
            }
        }
        Ok(tallies.into_iter().map(UserDefinedPoints::of).collect())
    }

    /// Once `stop` is set, no new case starts.
    // Dynamic dispatch, so that the detectors are compiled once.
    pub fn run(&self, stop: &AtomicBool, done: &(dyn Fn() + Sync)) -> Result<Characteristics, RocError> {
        let banks = self.detector_banks()?;
        let conditions = self.conditions();
        let per_condition: usize = banks.iter().map(|bank| bank.thresholds().len()).sum();
        let cases = conditions.len() as u64 * self.seeds;
        let shares: Mutex<Vec<ThreadTallies>> = Mutex::new(vec![]);
        let locked = || shares.lock().unwrap_or_else(PoisonError::into_inner);
        try_map(cases as usize, |case| {
            if stop.load(Ordering::Relaxed) {
                return Ok(());
            }
            let case = case as u64;
            let unused = locked().pop();
            let mut share = unused.unwrap_or_default();
            share.tallies.resize(per_condition * conditions.len(), Tally::default());
            let condition = (case / self.seeds) as usize;
            let (signal, noise_std_n) = conditions[condition];
            let tallies = &mut share.tallies[condition * per_condition..][..per_condition];
            let labels = signal.evaluate(noise_std_n, 1 + case % self.seeds, self.within_s, &mut share.input)?;
            let mut rest = tallies;
            for bank in &banks {
                let count = bank.thresholds().len();
                share.alarms.iter_mut().for_each(Vec::clear);
                share.alarms.resize(count.max(share.alarms.len()), vec![]);
                bank.evaluate(&share.input, labels.tick_s(), &mut |threshold, sample| {
                    share.alarms[threshold].push(sample)
                });
                let (tallies, others) = rest.split_at_mut(count);
                for ((tally, alarms), threshold) in tallies.iter_mut().zip(&share.alarms).zip(bank.thresholds()) {
                    let missed = tally.count(alarms, &labels);
                    let settings = bank.settings();
                    if *threshold == settings.cusum.threshold {
                        misses::count(tally, settings, &share.input, alarms, &labels, &missed);
                    }
                }
                rest = others;
            }
            locked().push(share);
            done();
            Ok::<_, RocError>(())
        })?;
        let mut tallies = vec![Tally::default(); per_condition * conditions.len()];
        for share in &*locked() {
            tallies.iter_mut().zip(&share.tallies).for_each(|(all, of_share)| all.add(of_share));
        }
        Ok(self.characteristics(&banks, &conditions, &tallies))
    }

    fn detector_banks(&self) -> Result<Vec<DetectorBank>, RocError> {
        let Some((first, others)) = self.signals.split_first() else { return Ok(vec![]) };
        for other in others {
            if let Some((one, _)) = first.detectors.iter().zip(&other.detectors).find(|(one, other)| one != other) {
                return Err(RocError::DifferentDetectors {
                    first: first.name.clone(),
                    second: other.name.clone(),
                    detector: one.distance.kind.word(),
                });
            }
        }
        first.detectors.iter().try_for_each(DetectorSettings::validate)?;
        Ok(first.detectors.iter().map(|settings| DetectorBank::around(*settings, self.thresholds)).collect())
    }

    fn characteristics(
        &self,
        banks: &[DetectorBank],
        conditions: &[(&Signal, f64)],
        tallies: &[Tally],
    ) -> Characteristics {
        let per_condition: usize = banks.iter().map(|bank| bank.thresholds().len()).sum();
        let of_condition = |index: usize| &tallies[index * per_condition..][..per_condition];
        let conditions: Vec<Condition> = conditions
            .iter()
            .enumerate()
            .map(|(index, (signal, noise_std_n))| {
                let InVivoLikeVariant { drop_n, fall_s, depth_m } = signal.variant;
                Condition {
                    signal: signal.name.clone(),
                    noise_std_n: *noise_std_n,
                    drop_n,
                    sharpness_s: fall_s,
                    depth_m,
                    curves: curves(banks, |(threshold, point)| Point::of(threshold, &of_condition(index)[point])),
                }
            })
            .collect();
        let all = curves(banks, |(threshold, point)| {
            let mut tally = Tally::default();
            (0..conditions.len()).for_each(|index| tally.add(&of_condition(index)[point]));
            Point::of(threshold, &tally)
        });
        Characteristics {
            within_s: self.within_s,
            cases_planned: conditions.len() as u64 * self.seeds,
            cases: all.first().and_then(|curve| curve.points.first()).map_or(0, |point| point.cases),
            all,
            conditions,
        }
    }
}

fn curves(banks: &[DetectorBank], point: impl Fn((f64, usize)) -> Point) -> Vec<Curve> {
    let mut index = 0;
    let mut next = || {
        index += 1;
        index - 1
    };
    let curve = |bank: &DetectorBank| {
        let settings = bank.settings();
        Curve {
            detector: settings.distance.kind.word().into(),
            is_baseline: settings.distance.kind.is_baseline(),
            is_user_defined: false,
            unit: settings.distance.kind.unit(),
            own_threshold: settings.cusum.threshold,
            drift: settings.cusum.drift,
            points: bank.thresholds().iter().map(|&threshold| point((threshold, next()))).collect(),
        }
    };
    banks.iter().map(curve).collect()
}
