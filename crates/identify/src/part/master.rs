use std::fmt::Write as _;

use trocar_document::{TextFile, shortest};

use super::regression::regression;
use super::signals::Signals;
use super::{Candidate, Chosen, Conclusions, Range, Spec};
use crate::IdentifyError;
use crate::filter::{delayed, half, slope, smooth};
use crate::machine::{Load, Machine};
use crate::measured::{Measured, span};
use crate::questions::reversals;

/// The recorded forces displace the simulated master by this share of the motion; a free mass would drift.
const OBSERVER_SHARE: f64 = 0.2;

/// Time constant with which the simulated master returns to the measured one. Faster motions determine the mass.
const OBSERVER_S: f64 = 0.02;

const DELAY_SD_S: f64 = 5e-3;

const SMOOTHING_HALF_S: f64 = 10e-3;

/// Below it, the friction of the start is proportional to the velocity.
const SLOW_M_PER_S: f64 = 2e-3;

/// `m x'' = F_hand(t) + F_motor(t - δ) + F_0 - b x' - F_c sign(x')`.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Structure {
    /// F_c.
    has_coulomb: bool,
    /// F_0, which only reversals distinguish from Coulomb friction.
    has_constant: bool,
    /// δ.
    has_delay: bool,
    /// Draws the simulated master to the measured one.
    observer_n_per_m: f64,
}

impl Structure {
    fn key(self) -> &'static str {
        match (self.has_coulomb, self.has_delay) {
            (false, _) => "viscous",
            (true, false) => "coulomb",
            (true, true) => "coulomb-delay",
        }
    }

    fn name(self) -> &'static str {
        match (self.has_coulomb, self.has_delay) {
            (false, _) => "mass and viscous friction",
            (true, false) => "also Coulomb friction",
            (true, true) => "also a delay of the motor",
        }
    }

    fn candidate(self, rough: &Rough) -> Candidate {
        let mut specs = vec![
            Spec::new("mass_kg", "mass", "kg", Range::Positive),
            Spec::new("viscous_n_s_per_m", "viscous friction", "N·s/m", Range::Positive),
        ];
        let mut start = vec![rough.mass_kg, rough.viscous];
        if self.has_coulomb {
            specs.push(Spec::new("coulomb_n", "Coulomb friction", "N", Range::Positive));
            start.push(rough.coulomb_n);
        }
        if self.has_constant {
            let range = Range::Any(rough.constant_n, 0.05 * rough.span_n);
            specs.push(Spec::new("constant_force_n", "constant force forwards", "N", range));
            start.push(rough.constant_n);
        }
        if self.has_delay {
            specs.push(Spec::new("motor_delay_s", "delay of the motor", "s", Range::Near0(DELAY_SD_S)));
            start.push(0.0);
        }
        let starts = [1.0, 0.3, 3.0].map(|factor| {
            let mut start = start.clone();
            start[0] *= factor;
            start
        });
        Candidate {
            key: self.key(),
            name: self.name(),
            specs,
            starts: starts.into(),
            simulate: Box::new(move |values, signals| self.simulate(values, signals)),
            essential: if self.has_coulomb { vec!["coulomb_n"] } else { vec![] },
            alternative: None,
            reductions: vec![],
        }
    }

    /// Simulates a slave that follows the measured master by a weak spring.
    fn simulate(self, values: &[f64], signals: &Signals) -> Option<Vec<f64>> {
        let mut further = values[2..].iter().copied();
        let mut next = |has: bool| if has { further.next().unwrap_or_default() } else { 0.0 };
        let (coulomb_n, constant_n, delay_s) = (next(self.has_coulomb), next(self.has_constant), next(self.has_delay));
        let machine = Machine {
            mass_kg: values[0],
            viscous_n_s_per_m: values[1],
            coulomb_n,
            position_gain_n_per_m: self.observer_n_per_m,
            velocity_gain_n_s_per_m: OBSERVER_S * self.observer_n_per_m,
            delay_s: 0.0,
            load: Load { offset_n: -constant_n, ..Load::EXACT },
        };
        machine.simulate(&as_slave(signals, delay_s), 0.0)
    }
}

/// The load of the slave is minus the forces on the master.
fn as_slave(signals: &Signals, delay_s: f64) -> Measured {
    let Signals { name, interval_s, position_m, velocity_m_per_s, .. } = signals;
    Measured {
        name: name.clone(),
        interval_s: *interval_s,
        master_m: position_m.clone(),
        slave_m: position_m.clone(),
        force_n: forces(signals, delay_s).into_iter().map(|force_n| -force_n).collect(),
        actuator_n: None,
        // Integrating this velocity reproduces the noise of the position; a smoothed one would differ from the motion.
        master_velocity_m_per_s: slope(position_m, 1, *interval_s),
        master_acceleration_m_per_s2: vec![0.0; signals.len()],
        start_velocity_m_per_s: velocity_m_per_s[0],
        unfinished: None,
    }
}

fn forces(signals: &Signals, delay_s: f64) -> Vec<f64> {
    let Signals { interval_s, force_n, input, .. } = signals;
    let motor_n = |sample| input.as_ref().map_or(0.0, |motor_n| delayed(motor_n, sample, delay_s, *interval_s));
    force_n.iter().enumerate().map(|(sample, force_n)| force_n + motor_n(sample)).collect()
}

struct Rough {
    mass_kg: f64,
    viscous: f64,
    coulomb_n: f64,
    constant_n: f64,
    span_n: f64,
}

impl Rough {
    /// Regresses smoothed forces on acceleration, velocity and its sign; `None` if they explain too little.
    fn of(training: &[Signals]) -> Option<Self> {
        let mut rows = vec![];
        let mut span_n = 0.0_f64;
        for one in training {
            let half = half(SMOOTHING_HALF_S, one.interval_s).min(one.len() / 16);
            let position_m = smooth(&one.position_m, half);
            let velocity = slope(&position_m, 1, one.interval_s);
            let acceleration = slope(&velocity, 1, one.interval_s);
            let force_n = forces(one, 0.0);
            span_n = span_n.max(span(&force_n));
            let force_n = smooth(&force_n, half);
            // Smoothing distorts the ends.
            for sample in 2 * half + 2..one.len() - 2 * half - 2 {
                let sign = (velocity[sample] / SLOW_M_PER_S).tanh();
                rows.push((vec![acceleration[sample], velocity[sample], sign, 1.0], force_n[sample]));
            }
        }
        let found = regression(&rows)?;
        let [mass, viscous, coulomb_n, constant_n] = [0, 1, 2, 3].map(|k| found.coefficients[k]);
        // Friction and inertia take power from the hand; the opposite sign supplies it.
        if !found.explains_enough() || (mass < 0.0 && viscous < 0.0) || coulomb_n < -0.05 * span_n {
            return None;
        }
        let mass_kg = mass.max(1e-3 * span_n);
        let (viscous, coulomb_n) = (viscous.max(0.1 * mass_kg), coulomb_n.max(1e-3 * span_n));
        Some(Self { mass_kg, viscous, coulomb_n, constant_n: -constant_n, span_n })
    }
}

fn reverses(training: &[Signals]) -> bool {
    training.iter().any(|one| reversals(&one.position_m) > 0)
}

fn has_motor(training: &[Signals]) -> bool {
    training.iter().any(|one| one.input.is_some())
}

pub(super) fn candidates(training: &[Signals]) -> Result<Vec<Candidate>, IdentifyError> {
    let rough = Rough::of(training).ok_or_else(|| {
        IdentifyError::unexplained(
            training.iter().map(|one| one.name.as_str()),
            "the forces do not move the master as they would move a mass with friction",
            "check the signs of --force and --actuator (positive when they push the master forwards), and that --master \
             is the position at which they act",
        )
    })?;
    let has_constant = reverses(training);
    let mut candidates = vec![(false, false), (true, false)];
    if has_motor(training) {
        candidates.push((true, true));
    }
    let span_m = training.iter().map(|one| span(&one.position_m)).fold(0.0, f64::max);
    let observer_n_per_m = rough.span_n / (OBSERVER_SHARE * span_m);
    let candidate = |(has_coulomb, has_delay)| {
        Structure { has_coulomb, has_constant, has_delay, observer_n_per_m }.candidate(&rough)
    };
    Ok(candidates.into_iter().map(candidate).collect())
}

pub(super) fn conclusions(training: &[Signals], chosen: &Chosen<'_>) -> Conclusions {
    let mut open: Vec<String> = vec![
        "All values rest on the calibration of the force sensor at the hand, which is assumed to be correct.".into(),
        "An offset of the force sensor cannot be distinguished from a constant force.".into(),
    ];
    if !reverses(training) {
        open.push(
            "The master never reverses, so that Coulomb friction cannot be distinguished from a constant force, which is \
             taken as 0. Record a motion with reversals."
                .into(),
        );
    }
    if !has_motor(training) {
        open.push(
            "Without --actuator, the motor is taken to be off: its force would count as friction, and its delay is unknown.".into(),
        );
    }
    Conclusions { open, file: TextFile { name: "master.toml".into(), text: scenario(chosen) } }
}

fn scenario(chosen: &Chosen<'_>) -> String {
    let mut text =
        "# What does the identified master do at the ruptures?\nbase = \"layers/skin-augmented\"\n\n[master]\n"
            .to_owned();
    let delay_s = chosen.value("motor_delay_s");
    if delay_s != 0.0 {
        let _ = writeln!(text, "# The motor acts on the tick; its identified delay of {delay_s:.3e} s is left out.");
    }
    text.push_str("model = \"mass-damper\"\n");
    let mass_kg = chosen.value("mass_kg");
    if mass_kg < 1e-6 {
        text.push_str("# The recordings do not determine the mass, which is that of the base.\n");
    } else {
        let _ = writeln!(text, "mass_kg = {}", shortest(mass_kg));
    }
    for (key, value) in [
        ("damping_n_s_per_m", chosen.value("viscous_n_s_per_m")),
        ("coulomb_friction_n", chosen.value("coulomb_n")),
        ("constant_force_n", chosen.value("constant_force_n")),
    ] {
        let _ = writeln!(text, "{key} = {}", shortest(value));
    }
    text
}
