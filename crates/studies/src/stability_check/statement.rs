use super::StabilityStudy;
use trocar_stability::Peaks;

/// Maximum multiple of the largest motion found.
const LOOSE: f64 = 10.0;

pub(super) const ASSUMPTIONS: [&str; 3] = [
    "the stiffness and the damping of the tissue stay within these ranges, and may change at every tick",
    "every other force of the tissue and the sensor is bounded, and its effect adds to that of the springs",
    "the arm is the scenario's",
];

#[derive(Debug, Clone, Copy)]
pub enum Statement<'a> {
    /// Everything decays under any sequence of events that keeps the enforced times, and an additional tissue force
    /// moves needle and hand within bounds.
    Decays(&'a Peaks),
    /// A sustained swing is not excluded, because the steps and the noise of the force sensor are an additional force,
    /// of this size in N.
    Bounded(&'a Peaks, f64),
    /// Neither is certified, for this reason.
    None(&'a str),
}

impl Statement<'_> {
    pub fn word(&self) -> &'static str {
        match self {
            Self::Decays(_) => "decays",
            Self::Bounded(..) => "bounded",
            Self::None(_) => "none",
        }
    }
}

/// Bounds in m/N; `None` if they are too loose to be useful.
pub(super) fn useful_bounds(peaks: &Peaks) -> Option<[f64; 2]> {
    let bounds = [peaks.needle_m_per_n, peaks.hand_m_per_n];
    let is_useful = |(bound, found): (&f64, &f64)| *bound <= LOOSE * found;
    bounds.iter().zip(&peaks.found_m_per_n).all(is_useful).then_some(bounds)
}

impl StabilityStudy {
    pub fn statement(&self) -> Statement<'_> {
        let switching = match &self.switching {
            Ok(switching) => switching,
            Err(reason) => return Statement::None(reason),
        };
        if self.covers_tissue() != Some(true) {
            return Statement::None("the range of stiffness does not contain the tissue's");
        }
        match &switching.peaks {
            Some(_) if self.sensor_force_n > 0.0 && !switching.settings.of_loop.adds_to_reading() => Statement::None(
                "the needle yields to the tissue, and the errors of the force sensor act on the hand only",
            ),
            Some(peaks) if self.sensor_force_n > 0.0 => Statement::Bounded(peaks, self.sensor_force_n),
            Some(peaks) => Statement::Decays(peaks),
            None if switching.settings.keeps_gap() => Statement::None(
                "the gap that an event leaves is kept, and out of contact nothing closes it: each drop of force can \
                 move the needle on",
            ),
            None if !self.verdict.range.is_stable => {
                Statement::None("the loop is unstable without events: see worst_events.toml")
            }
            None if switching.shows_growth() => {
                Statement::None("a sequence of events makes the motion grow: see worst_events.toml")
            }
            None => Statement::None("the search found no functions, which does not show instability"),
        }
    }
}
