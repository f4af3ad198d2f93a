use super::machines::Machines;
use super::{ClosedLoop, LinearLoop, StabilityError, TissueRange};
use trocar_engine::channel::Schedule;
use trocar_engine::plant::ActuatorLimits;
use trocar_engine::teleoperation::{LinkSettings, PassivitySettings};
use trocar_scenario::{Scenario, TissueByDepth};

const STIFFNESSES: u32 = 12;
const REFINEMENTS: usize = 30;

const POINTS: i32 = 25;
const SPAN: f64 = 1e3;

const DAMPINGS: u32 = 6;

const TOLERANCE: f64 = 1e-9;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RangeVerdict {
    pub is_stable_advancing: bool,
    /// Also while the needle is drawn back.
    pub is_stable: bool,
    /// At every damping; `None` if unstable out of contact.
    pub stable_up_to_n_per_m: Option<f64>,
    pub is_stable_with_least_damping: bool,
}

impl LinearLoop {
    /// Of a range, the stiffest unstable point, otherwise the smallest gain margin. Uses the shortest of varying
    /// delays, because jitter is added to it ([`VaryingDelays`](super::VaryingDelays)).
    pub fn of(scenario: &Scenario, tissue: TissueRange) -> Result<Self, StabilityError> {
        let delay_s = |schedule: &Schedule, delay_s: f64| {
            schedule.ages().map_or(delay_s, |(shortest, _)| scenario.grid.time_s(shortest))
        };
        let stiffest = Self {
            tissue,
            by_depth: TissueByDepth::of(scenario),
            tick_s: scenario.grid.tick_s(),
            timing: scenario.timing,
            master: scenario.master,
            master_model: scenario.master_model.clone(),
            arm: scenario.arm,
            slave: scenario.slave.clone(),
            actuators: ActuatorLimits {
                master_lag_s: scenario.actuators.master_lag_s,
                slave_lag_s: scenario.actuators.slave_lag_s,
                ..ActuatorLimits::NONE
            },
            link: LinkSettings { passivity: PassivitySettings::DEFAULT, ..scenario.link },
            force_bandwidth_hz: scenario.sensor.force_bandwidth_hz,
            forward_delay_s: delay_s(&scenario.forward_schedule, scenario.delays.forward_delay_s),
            backward_delay_s: delay_s(&scenario.backward_schedule, scenario.delays.backward_delay_s),
            stiffness_n_per_m: tissue.stiffest_n_per_m(),
            damping_n_s_per_m: tissue.springs.damping_n_s_per_m.1,
            relaxation: tissue.springs.relaxation,
        };
        stiffest.at_worst()
    }

    fn at_worst(self) -> Result<Self, StabilityError> {
        let (least, most) = self.tissue.springs.damping_n_s_per_m;
        let mut worst = self.at_worst_stiffness(most)?;
        if least < most && worst.1 > 0.0 {
            let other = self.at_worst_stiffness(least)?;
            if other.1 < worst.1 {
                worst = other;
            }
        }
        Ok(worst.0)
    }

    fn at_worst_stiffness(&self, damping_n_s_per_m: f64) -> Result<(Self, f64), StabilityError> {
        let stiffest = Self { damping_n_s_per_m, ..self.clone() };
        let (low, high) = (self.tissue.springs.stiffness_n_per_m.0, self.tissue.stiffest_n_per_m());
        let machines = Machines::new(&stiffest)?;
        let closed = ClosedLoop::of(&machines, &stiffest, None)?;
        let at = |stiffness_n_per_m: f64| {
            let other = Self { stiffness_n_per_m, ..stiffest.clone() };
            ClosedLoop::of(&machines, &other, Some(&closed))
        };
        let stiffness = |k: u32| low + f64::from(k) / f64::from(STIFFNESSES) * (high - low);
        let mut worst = Worst { stiffness_n_per_m: high, change: closed.destabilising_change(f64::INFINITY)? };
        let mut interval = None;
        for k in (0..if low < high { STIFFNESSES } else { 0 }).rev() {
            // An unstable loop cannot become worse.
            if worst.change == 0.0 {
                break;
            }
            if worst.replace_by(stiffness(k), &at(stiffness(k))?)? && k > 0 {
                interval = Some((stiffness(k - 1), stiffness(k + 1).min(high)));
            }
        }
        if let Some((mut from, mut to)) = interval {
            for _ in 0..REFINEMENTS {
                let (a, b) = (from + (to - from) / 3.0, to - (to - from) / 3.0);
                let bound = f64::INFINITY;
                if at(a)?.destabilising_change(bound)? < at(b)?.destabilising_change(bound)? {
                    to = b
                } else {
                    from = a
                }
            }
            let middle = 0.5 * (from + to);
            worst.replace_by(middle, &at(middle)?)?;
        }
        Ok((Self { stiffness_n_per_m: worst.stiffness_n_per_m, ..stiffest }, worst.change))
    }

    /// The only error is between grid points.
    pub fn in_range(&self) -> Result<RangeVerdict, StabilityError> {
        let (least, most) = self.tissue.springs.damping_n_s_per_m;
        let (advancing, stiffest) = (self.tissue.springs.stiffness_n_per_m.1, self.tissue.stiffest_n_per_m());
        let machines = Machines::new(self)?;
        let is_free_stable = |damping_n_s_per_m: f64| {
            let free = Self { stiffness_n_per_m: 0.0, damping_n_s_per_m, relaxation: None, ..self.clone() };
            ClosedLoop::of(&machines, &free, None)?.is_stable()
        };
        if !is_free_stable(0.0)? {
            return Ok(RangeVerdict {
                is_stable_advancing: false,
                is_stable: false,
                stable_up_to_n_per_m: None,
                is_stable_with_least_damping: false,
            });
        }
        let (mut up_to, mut up_to_with_least) = (stiffest, stiffest);
        let mut is_free_with_damping = true;
        for step in 0..=(if least < most { DAMPINGS } else { 0 }) {
            let damping_n_s_per_m = least + f64::from(step) / f64::from(DAMPINGS) * (most - least);
            is_free_with_damping &= is_free_stable(damping_n_s_per_m)?;
            for relaxation in self.relaxation.map(Some).into_iter().chain([None]) {
                let with = Self { damping_n_s_per_m, relaxation, ..self.clone() };
                let reached = with.stable_up_to(&machines, up_to)?;
                up_to = up_to.min(reached);
                if step == 0 {
                    up_to_with_least = up_to;
                }
            }
        }
        Ok(RangeVerdict {
            is_stable_advancing: is_free_with_damping && up_to >= advancing,
            is_stable: is_free_with_damping && up_to >= stiffest,
            stable_up_to_n_per_m: is_free_with_damping.then_some(up_to),
            is_stable_with_least_damping: up_to_with_least >= stiffest,
        })
    }

    fn stable_up_to(&self, machines: &Machines, high: f64) -> Result<f64, StabilityError> {
        let mut last: Option<ClosedLoop> = None;
        let mut is_stable = |stiffness_n_per_m: f64| -> Result<bool, StabilityError> {
            let at = Self { stiffness_n_per_m, ..self.clone() };
            let closed = last.insert(ClosedLoop::of(machines, &at, last.as_ref())?);
            closed.is_stable()
        };
        let mut stable = 0.0;
        for k in 0..POINTS {
            let next =
                if k + 1 == POINTS { high } else { high * SPAN.powf(f64::from(k + 1) / f64::from(POINTS) - 1.0) };
            if is_stable(next)? {
                stable = next;
                continue;
            }
            let mut unstable = next;
            while unstable - stable > TOLERANCE * unstable {
                let middle = 0.5 * (stable + unstable);
                if is_stable(middle)? { stable = middle } else { unstable = middle }
            }
            return Ok(stable);
        }
        Ok(high)
    }

    pub(super) fn at_ends(&self) -> Vec<Self> {
        let Self { stiffness_n_per_m, damping_n_s_per_m, .. } = *self;
        let (least, most) = self.tissue.springs.damping_n_s_per_m;
        let high = self.tissue.stiffest_n_per_m();
        let mut points = vec![(stiffness_n_per_m, damping_n_s_per_m)];
        for point in [(high, least), (high, most), (0.0, most)] {
            if !points.contains(&point) && point != (0.0, 0.0) {
                points.push(point);
            }
        }
        if !self.link.is_baseline() {
            points.push((0.0, 0.0));
        }
        let at = |(stiffness_n_per_m, damping_n_s_per_m)| Self { stiffness_n_per_m, damping_n_s_per_m, ..self.clone() };
        let mut all: Vec<Self> = points.into_iter().map(at).collect();
        if self.relaxation.is_some() {
            all.extend(all.clone().into_iter().map(|end| Self { relaxation: None, ..end }));
        }
        all
    }
}

struct Worst {
    stiffness_n_per_m: f64,
    change: f64,
}

impl Worst {
    fn replace_by(&mut self, stiffness_n_per_m: f64, closed: &ClosedLoop) -> Result<bool, StabilityError> {
        let change = closed.destabilising_change(self.change)?;
        let is_worse = change < self.change;
        if is_worse {
            *self = Self { stiffness_n_per_m, change };
        }
        Ok(is_worse)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trocar_engine::tissue::Relaxation;
    use trocar_scenario::Source;

    fn of(name: &str, settings: &[&str]) -> LinearLoop {
        let settings: Vec<String> = settings.iter().map(|setting| (*setting).to_owned()).collect();
        let scenario = Scenario::load(&Source::parse(name), &settings).expect("loads");
        LinearLoop::of(&scenario, TissueRange::of_parameters(&scenario).expect("known")).expect("analysed")
    }

    fn radius(settings: &LinearLoop) -> f64 {
        ClosedLoop::new(settings).and_then(|closed| closed.dominant_mode()).expect("a mode").spectral_radius
    }

    #[test]
    fn a_relaxing_spring_is_between_its_fast_and_its_slow_stiffness() {
        let fast = of("paper/classical", &["tissue.stiffness_n_per_m=1500", "tissue.damping_n_s_per_m=0"]);
        let slow = LinearLoop { stiffness_n_per_m: 600.0, ..fast.clone() };
        let relaxing = |time_s: f64| {
            radius(&LinearLoop { relaxation: Some(Relaxation { relaxed_share: 0.4, time_s }), ..fast.clone() })
        };
        // A slow relaxation adds a pole near 1, so a fast one shows the limits of the others.
        assert!((relaxing(1e-9) - radius(&slow)).abs() < 1e-9);
        let closed = |time_s| {
            let relaxation = Some(Relaxation { relaxed_share: 1.0, time_s });
            radius(&LinearLoop { relaxation, ..fast.clone() })
        };
        assert!((closed(0.01) - radius(&fast)).abs() < 1e-9, "without relaxation");
    }

    #[test]
    fn the_verdict_finds_the_largest_stable_stiffness_at_every_damping() {
        let spring = |stiffness: f64| {
            of("paper/classical", &[&format!("tissue.stiffness_n_per_m={stiffness}"), "tissue.damping_n_s_per_m=0"])
        };
        // The largest stable stiffness is 2517.7 N/m without damping.
        let (stable, unstable) = (spring(2500.0).in_range(), spring(2600.0).in_range().expect("analysed"));
        assert!(stable.expect("analysed").is_stable && !unstable.is_stable && !unstable.is_stable_advancing);
        assert!((unstable.stable_up_to_n_per_m.expect("free motion is stable") - 2517.7).abs() < 0.1);
        let layers = |damping: &str| of("layers/through-the-skin", &[damping]).in_range().expect("analysed");
        assert!(layers("tissue.layer.skin.damping_s_per_m=2").is_stable);
        let damped = layers("tissue.layer.skin.damping_s_per_m=100");
        assert!(!damped.is_stable && damped.is_stable_with_least_damping);
    }
}
