use std::fmt::Write as _;

use trocar_document::{TextFile, shortest};

use super::regression::regression;
use super::signals::Signals;
use super::two_springs::{Motions, TwoSprings};
use super::{Candidate, Chosen, Conclusions, Range, Spec};
use crate::IdentifyError;
use crate::filter::{cubic_slope, half, slope};
use crate::measured::{VELOCITY_HALF_S, span};

const RATE_HALF_S: f64 = 2.5e-3;

/// Represents a rigid grip.
const RIGID: f64 = 20.0;

/// Ratio of the spring behind the arm to the grip.
const STIFFNESS_RATIOS: [f64; 4] = [0.05, 1.0, 4.0, 20.0];

/// A hand, and a hand with the forearm.
const START_MASSES_KG: [f64; 2] = [0.5, 2.0];

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Structure {
    /// `F_h = k (x_d - x_h) + b (x_d' - x_h')`.
    Spring,
    /// Like `Spring`, with a mass at the master: `F_h = k (x_d - x_h) + b (x_d' - x_h') - m x_h''`.
    MassAtMaster,
    /// Eq. 32: `m_h x_a'' = k_h (x_d - x_a) + b_h (x_d' - x_a') - F_h`, `F_h = k_a (x_a - x_h) + b_a (x_a' - x_h')`.
    TwoSprings,
}

impl Structure {
    const ALL: [Self; 3] = [Self::Spring, Self::MassAtMaster, Self::TwoSprings];

    fn key(self) -> &'static str {
        match self {
            Self::Spring => "spring",
            Self::MassAtMaster => "mass-at-master",
            Self::TwoSprings => "two-springs",
        }
    }

    fn of_key(key: &str) -> Self {
        Self::ALL.into_iter().find(|structure| structure.key() == key).unwrap_or(Self::Spring)
    }

    fn name(self) -> &'static str {
        match self {
            Self::Spring => "spring and damper",
            Self::MassAtMaster => "spring, damper and mass",
            Self::TwoSprings => "mass between two springs",
        }
    }

    fn specs(self, span_m: f64, offset_m: f64) -> Vec<Spec> {
        let positive = |key, name, unit| Spec::new(key, name, unit, Range::Positive);
        let mut specs = match self {
            Self::Spring | Self::MassAtMaster => vec![
                positive("static_stiffness_n_per_m", "static stiffness", "N/m"),
                positive("static_damping_n_s_per_m", "damping", "N·s/m"),
            ],
            Self::TwoSprings => vec![
                positive("k_a_n_per_m", "stiffness between arm and master", "N/m"),
                positive("b_a_n_s_per_m", "damping between arm and master", "N·s/m"),
                positive("k_h_n_per_m", "stiffness between desired position and arm", "N/m"),
                positive("b_h_n_s_per_m", "damping between desired position and arm", "N·s/m"),
            ],
        };
        if self != Self::Spring {
            specs.push(positive("m_h_kg", "mass of the arm", "kg"));
        }
        let offset = "offset of the desired position";
        specs.push(Spec::new("desired_offset_m", offset, "m", Range::Any(offset_m, 0.1 * span_m)));
        specs
    }

    fn starts(self, rough: &Rough) -> Vec<Vec<f64>> {
        let Rough { stiffness, damping, mass_kg, offset_m } = *rough;
        match self {
            Self::Spring => vec![vec![stiffness, damping, offset_m]],
            Self::MassAtMaster => vec![vec![stiffness, damping, mass_kg, offset_m]],
            // From a stiff grip on a soft arm to the opposite.
            Self::TwoSprings => STIFFNESS_RATIOS
                .into_iter()
                .flat_map(|ratio| START_MASSES_KG.map(|mass_kg| (ratio, mass_kg)))
                .map(|(ratio, mass_kg)| {
                    let (k_a, k_h) = (stiffness * (1.0 + 1.0 / ratio), stiffness * (1.0 + ratio));
                    vec![k_a, damping, k_h, ratio.sqrt() * damping, mass_kg, offset_m]
                })
                .collect(),
        }
    }

    fn simulate(self, values: &[f64], signals: &Signals) -> Option<Vec<f64>> {
        let Signals { position_m, interval_s, velocity_m_per_s, .. } = signals;
        let offset_m = values[values.len() - 1];
        let fine = half(RATE_HALF_S, *interval_s);
        let desired_m: Vec<f64> = match &signals.input {
            Some(desired_m) => desired_m.iter().map(|desired_m| desired_m + offset_m).collect(),
            None => vec![offset_m; signals.len()],
        };
        let desired_rate = cubic_slope(&desired_m, fine, *interval_s);
        let rate = cubic_slope(position_m, fine, *interval_s);
        let spring = |sample: usize| {
            values[0] * (desired_m[sample] - position_m[sample]) + values[1] * (desired_rate[sample] - rate[sample])
        };
        let forces_n: Vec<f64> = match self {
            Self::Spring => (0..signals.len()).map(spring).collect(),
            Self::MassAtMaster => {
                let acceleration = slope(velocity_m_per_s, half(VELOCITY_HALF_S, *interval_s), *interval_s);
                (0..signals.len()).map(|sample| spring(sample) - values[2] * acceleration[sample]).collect()
            }
            Self::TwoSprings => {
                let [k_a, b_a, k_h, b_h, mass_kg] = [values[0], values[1], values[2], values[3], values[4]];
                let motions = Motions {
                    master_m: position_m,
                    master_rate: &rate,
                    desired_m: &desired_m,
                    desired_rate: &desired_rate,
                };
                TwoSprings { k_a, b_a, k_h, b_h, mass_kg }.forces_n(signals, &motions)
            }
        };
        forces_n.iter().all(|force_n| force_n.abs() < 1e9).then_some(forces_n)
    }
}

struct Rough {
    stiffness: f64,
    damping: f64,
    mass_kg: f64,
    offset_m: f64,
}

impl Rough {
    /// `None` if the force does not oppose the distance from the desired position.
    fn of(training: &[Signals]) -> Option<Self> {
        let mut rows = vec![];
        for one in training {
            let half = half(VELOCITY_HALF_S, one.interval_s);
            let acceleration = slope(&one.velocity_m_per_s, half, one.interval_s);
            let rate = one.input.as_ref().map(|desired_m| slope(desired_m, half, one.interval_s));
            for (sample, force_n) in one.force_n.iter().enumerate() {
                let desired_m = one.input.as_ref().map_or(0.0, |desired_m| desired_m[sample]);
                let desired_rate = rate.as_ref().map_or(0.0, |rate| rate[sample]);
                let row = vec![
                    desired_m - one.position_m[sample],
                    desired_rate - one.velocity_m_per_s[sample],
                    -acceleration[sample],
                    1.0,
                ];
                rows.push((row, *force_n));
            }
        }
        let found = regression(&rows)?;
        let stiffness = found.coefficients[0];
        if stiffness <= 0.0 || !found.explains_enough() {
            return None;
        }
        // Time constants of an arm are between 1 ms and 1 s.
        let damping = found.coefficients[1].clamp(1e-3 * stiffness, stiffness);
        let mass_kg = found.coefficients[2].clamp(1e-5 * stiffness, 1e-1 * stiffness);
        Some(Self { stiffness, damping, mass_kg, offset_m: found.coefficients[3] / stiffness })
    }
}

pub(super) fn candidates(training: &[Signals]) -> Result<Vec<Candidate>, IdentifyError> {
    let rough = Rough::of(training).ok_or_else(|| {
        IdentifyError::unexplained(
            training.iter().map(|one| one.name.as_str()),
            "the force of the hand does not pull the master towards the desired position",
            "check the sign of --force (positive when the hand pushes the master forwards), give --desired if the hand \
             moves on purpose, or record a perturbation",
        )
    })?;
    let span_m = training.iter().map(|one| span(&one.position_m)).fold(0.0, f64::max);
    let candidate = |structure: Structure| Candidate {
        key: structure.key(),
        name: structure.name(),
        specs: structure.specs(span_m, rough.offset_m),
        starts: structure.starts(&rough),
        simulate: Box::new(move |values, signals| structure.simulate(values, signals)),
        essential: match structure {
            Structure::Spring => vec![],
            Structure::MassAtMaster => vec!["m_h_kg"],
            Structure::TwoSprings => vec!["k_a_n_per_m", "k_h_n_per_m", "m_h_kg"],
        },
        alternative: None,
        reductions: vec![],
    };
    Ok(Structure::ALL.map(candidate).into())
}

pub(super) fn conclusions(training: &[Signals], chosen: &Chosen<'_>) -> Conclusions {
    let mut open: Vec<String> = vec![];
    let structure = Structure::of_key(chosen.candidate.key);
    if structure != Structure::TwoSprings {
        open.push(
            "The recordings cannot tell the spring at the hand (k_a, b_a) from that behind the arm (k_h, b_h): only their series, the \
             static stiffness, is known. Record a perturbation with parts above 15 Hz."
                .into(),
        );
    }
    if structure == Structure::Spring {
        open.push("The recordings do not determine the mass of the arm. Record faster perturbations.".into());
    }
    if training.iter().any(|one| one.input.is_none()) {
        open.push(
            "Without --desired, the hand is taken to hold one position: what the person does on purpose counts as error.".into(),
        );
    }
    open.push("The force sensor is taken to have no lag: a lag acts like less damping.".into());
    Conclusions { open, file: TextFile { name: "arm.toml".into(), text: scenario(chosen) } }
}

fn scenario(chosen: &Chosen<'_>) -> String {
    let value = |key: &str| chosen.value(key);
    let mut text =
        "# What does the identified arm do at the ruptures?\nbase = \"layers/skin-augmented\"\n\n[arm]\n".to_owned();
    let (stiffness, damping) = (value("static_stiffness_n_per_m"), value("static_damping_n_s_per_m"));
    // The series of both springs is the identified stiffness.
    let factor = RIGID / (RIGID - 1.0);
    let (keys, comment): (Vec<(&str, f64)>, &str) = match Structure::of_key(chosen.candidate.key) {
        Structure::TwoSprings => {
            let keys = ["k_a_n_per_m", "b_a_n_s_per_m", "k_h_n_per_m", "b_h_n_s_per_m", "m_h_kg"];
            (keys.map(|key| (key, value(key))).into(), "")
        }
        Structure::MassAtMaster => (
            vec![
                ("k_a_n_per_m", RIGID * stiffness),
                ("b_a_n_s_per_m", RIGID * damping),
                ("k_h_n_per_m", factor * stiffness),
                ("b_h_n_s_per_m", factor * damping),
                ("m_h_kg", value("m_h_kg")),
            ],
            "# Only the series of both springs is identified. The grip is taken as 20 times as stiff.\n",
        ),
        Structure::Spring => (
            vec![
                ("k_a_n_per_m", factor * stiffness),
                ("b_a_n_s_per_m", factor * damping),
                ("k_h_n_per_m", RIGID * stiffness),
                ("b_h_n_s_per_m", RIGID * damping),
            ],
            "# Only the series of both springs is identified. The arm behind the hand is taken as 20 times as stiff. The mass is the paper's.\n",
        ),
    };
    text.push_str(comment);
    for (key, value) in keys {
        let _ = writeln!(text, "{key} = {}", shortest(value));
    }
    text
}
