mod law;
mod rough;
mod scenario;

use trocar_document::TextFile;

use super::rupture::Rupture;
use super::signals::Signals;
use super::{Candidate, Chosen, Conclusions, Part, PartSystem, Range, Simulation, Spec};
use crate::IdentifyError;
use crate::filter::delayed;
use crate::grid::{MIN_DURATION_S, MIN_SAMPLES};
use crate::problem::Problem;
use crate::questions::reversals;
use law::{Law, Velocity};
use rough::Rough;
use scenario::scenario;

const LAG_SD_S: f64 = 5e-3;

/// Order of the parameters: law, contact, lag, optional parts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Structure {
    law: Law,
    /// The zero of the force sensor is unknown.
    has_zero: bool,
    /// A spring that slides at a force.
    has_friction: bool,
    velocity: Velocity,
}

impl Structure {
    fn key(self) -> &'static str {
        match (self.law, self.has_friction) {
            (Law::KelvinVoigt, false) => "kelvin-voigt",
            (Law::KelvinVoigt, true) => "kelvin-voigt-friction",
            (Law::HuntCrossley, false) => "hunt-crossley",
            (Law::HuntCrossley, true) => "hunt-crossley-friction",
            (Law::Layer, false) => "layer",
            (Law::Layer, true) => "layer-friction",
        }
    }

    fn name(self) -> &'static str {
        match (self.law, self.has_friction) {
            (Law::KelvinVoigt, false) => "spring and damper (kelvin-voigt)",
            (Law::KelvinVoigt, true) => "spring, damper and friction of the shaft",
            (Law::HuntCrossley, false) => "power of the depth (hunt-crossley)",
            (Law::HuntCrossley, true) => "power of the depth and friction of the shaft",
            (Law::Layer, false) => "layer that stiffens with the depth",
            (Law::Layer, true) => "layer that stiffens, and friction of the shaft",
        }
    }

    fn essential(self) -> Vec<&'static str> {
        let mut essential = match self.law {
            Law::KelvinVoigt => vec![],
            Law::HuntCrossley => vec!["power"],
            Law::Layer => vec!["stiffness_n_per_m", "stiffening_n_per_m2"],
        };
        if self.has_friction {
            essential.push("grip_n");
        }
        essential
    }

    fn candidate(self, rough: &Rough) -> Candidate {
        let mut specs: Vec<Spec> = self.law.specs().into_iter().flatten().collect();
        let mut start = self.law.start(rough.stiffness_n_per_m, rough.damping_n_s_per_m, rough.depth_m);
        let mut add = |key, name, unit, range, value| {
            specs.push(Spec::new(key, name, unit, range));
            start.push(value);
        };
        add(
            "contact_m",
            "position of the surface",
            "m",
            Range::Any(rough.contact_m, 0.1 * rough.span_m),
            rough.contact_m,
        );
        add("force_lag_s", "lag of the force sensor", "s", Range::Near0(LAG_SD_S), rough.lag_s);
        if let Some(zero_n) = rough.zero_n {
            add("force_zero_n", "zero of the force sensor", "N", Range::Any(zero_n, 0.1 * rough.span_n), zero_n);
        }
        if self.has_friction {
            add("grip_n", "friction of the shaft", "N", Range::Positive, 0.03 * rough.span_n);
            let stiffness = 4.0 * rough.stiffness_n_per_m;
            let name = "stiffness of the shaft before it slides";
            add("shaft_stiffness_n_per_m", name, "N/m", Range::Positive, stiffness);
        }
        let other = Self { velocity: self.velocity.other(), ..self };
        let simulation =
            |structure: Self| -> Simulation { Box::new(move |values, signals| structure.simulate(values, signals)) };
        Candidate {
            key: self.key(),
            name: self.name(),
            specs,
            starts: vec![start],
            simulate: simulation(self),
            essential: self.essential(),
            alternative: Some(simulation(other)),
            reductions: self.law.specs()[1].iter().map(|damping| (damping.key, rough.reduction)).collect(),
        }
    }

    /// `reading(t) = f(d(t - lag), v(t - lag)) + g(t - lag) + zero` in N; the friction g follows the needle like a
    /// spring up to its maximum.
    fn simulate(self, values: &[f64], signals: &Signals) -> Option<Vec<f64>> {
        let Signals { position_m, interval_s, .. } = signals;
        let laws = self.law.specs().iter().flatten().count();
        let (law, others) = values.split_at(laws);
        let (contact_m, lag_s) = (others[0], others[1]);
        let zero_n = if self.has_zero { others[2] } else { 0.0 };
        let friction = if self.has_friction { others[others.len() - 2..].to_vec() } else { vec![0.0, 0.0] };
        let velocities = self.velocity.of(signals);
        let mut grip_n = 0.0_f64;
        let mut before_m = delayed(position_m, 0, lag_s, *interval_s);
        let reading_n = |sample: usize| {
            let here_m = delayed(position_m, sample, lag_s, *interval_s);
            let (depth_m, moved_m) = (here_m - contact_m, here_m - before_m);
            before_m = here_m;
            let velocity = delayed(&velocities, sample, lag_s, *interval_s);
            // The needle crosses the surface within an interval. Without this ramp the errors would be discontinuous.
            let contact = (0.5 + depth_m / (velocity.abs() * interval_s).max(1e-9)).clamp(0.0, 1.0);
            if contact == 0.0 {
                grip_n = 0.0;
                return zero_n;
            }
            grip_n = (grip_n + friction[1] * moved_m).clamp(-friction[0], friction[0]);
            contact * (self.law.force_n(law, depth_m.max(0.0), velocity) + grip_n) + zero_n
        };
        let readings: Vec<f64> = (0..signals.len()).map(reading_n).collect();
        readings.iter().all(|reading| reading.abs() < 1e9).then_some(readings)
    }
}

pub(super) fn intact(recording: Signals) -> Result<(Signals, Option<Rupture>), IdentifyError> {
    let Some(rupture) = Rupture::of(&recording) else { return Ok((recording, None)) };
    let at_s = rupture.sample as f64 * recording.interval_s;
    if rupture.sample < MIN_SAMPLES || at_s < MIN_DURATION_S {
        return Err(IdentifyError::EarlyRupture { recording: recording.name, at_s });
    }
    Ok((recording.before(rupture.sample), Some(rupture)))
}

pub(super) fn candidates(training: &[Signals]) -> Result<Vec<Candidate>, IdentifyError> {
    let rough = Rough::of(training).ok_or_else(|| {
        IdentifyError::unexplained(
            training.iter().map(|one| one.name.as_str()),
            "no contact: the force does not rise with the depth of the needle",
            "record an insertion into the tissue, or check the signs of --slave (increasing into the tissue) and --force \
             (positive when it resists)",
        )
    })?;
    let frictions = if reverses(training) { &[false, true][..] } else { &[false] };
    let mut candidates = vec![];
    for has_friction in frictions {
        for law in [Law::KelvinVoigt, Law::HuntCrossley, Law::Layer] {
            let has_zero = rough.zero_n.is_some();
            let structure = Structure { law, has_zero, has_friction: *has_friction, velocity: rough.velocity };
            candidates.push(structure.candidate(&rough));
        }
    }
    Ok(candidates)
}

fn reverses(training: &[Signals]) -> bool {
    training.iter().any(|one| reversals(&one.position_m) > 0)
}

pub(super) fn conclusions(training: &[Signals], chosen: &Chosen<'_>) -> Conclusions {
    let mut open = vec![];
    if chosen.candidate.specs.iter().all(|spec| spec.key != "force_zero_n") {
        open.push(
            "No recording has a part without contact, so that the zero of the force sensor cannot be distinguished from the position of \
             the surface; the zero is taken as 0. Record the approach from free space."
                .into(),
        );
    }
    for (recording, rupture) in chosen.ruptures {
        let (position_mm, force_n) = (1e3 * rupture.position_m, rupture.force_n);
        open.push(format!(
            "{recording}: the tissue ruptures at {position_mm:.3} mm and {force_n:.3} N. The samples after it are not used."
        ));
    }
    if !reverses(training) {
        open.push(
            "The needle never reverses, so that friction of the shaft cannot be distinguished from stiffness. Record a retreat."
                .into(),
        );
    }
    let has_power = chosen.candidate.specs.iter().any(|spec| spec.key == "power");
    if has_power {
        open.push(
            "The scenario has the nearest multiple of 0.25 as power, and μ and λ that were fitted with this power."
                .into(),
        );
    }
    let fitted = if has_power { with_quarter_power(training, chosen) } else { chosen.values.to_vec() };
    Conclusions { open, file: TextFile { name: "tissue.toml".into(), text: scenario(training, chosen, &fitted) } }
}

/// Refits at the nearest power that a scenario can have.
fn with_quarter_power(training: &[Signals], chosen: &Chosen<'_>) -> Vec<f64> {
    let Candidate { specs, simulate, .. } = chosen.candidate;
    let mut start = chosen.values.to_vec();
    let free = (0..specs.len()).filter(|index| specs[*index].key != "power").collect();
    if let Some(index) = specs.iter().position(|spec| spec.key == "power") {
        let power = ((4.0 * start[index]).round() / 4.0).clamp(0.25, 7.75);
        // μ and λ keep the force at a typical depth.
        let contact_m = chosen.value("contact_m");
        let deepest_m = training.iter().flat_map(|one| &one.position_m).copied().fold(f64::NEG_INFINITY, f64::max);
        let factor = (0.5 * (deepest_m - contact_m)).max(1e-9).powf(start[index] - power);
        start[0] *= factor;
        start[1] *= factor;
        start[index] = power;
    }
    let system = PartSystem { part: Part::Tissue, specs, simulate, recordings: training };
    Problem::new(system, free, start).solve().1.model()
}
