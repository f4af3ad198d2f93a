use rand_chacha::ChaCha8Rng;

use super::matter::{Contact, Matter};
use super::{log_uniform, one_of, uniform};

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Hand {
    Ramp,
    Smooth,
    Stab,
    Tremble,
    Stops,
    Presses,
    Taps,
}

/// Desired position, smooth or linear between points.
#[derive(Debug, Clone)]
pub(super) struct Path {
    /// Time in s and position in m.
    points: Vec<(f64, f64)>,
    is_even: bool,
    tremor_m: f64,
    tremor_hz: f64,
    pub(super) duration_s: f64,
}

impl Path {
    pub(super) fn at(&self, time_s: f64) -> f64 {
        let next = self.points.partition_point(|(at_s, _)| *at_s <= time_s);
        let position_m = match (next.checked_sub(1).map(|last| self.points[last]), self.points.get(next)) {
            (Some((from_s, from_m)), Some(&(to_s, to_m))) => {
                let share = (time_s - from_s) / (to_s - from_s);
                let eased = share * share * share * (10.0 - 15.0 * share + 6.0 * share * share);
                from_m + (to_m - from_m) * if self.is_even { share } else { eased }
            }
            (Some((_, last_m)), None) => last_m,
            (None, first) => first.map_or(0.0, |(_, first_m)| *first_m),
        };
        position_m + self.tremor_m * libm::sin(std::f64::consts::TAU * self.tremor_hz * time_s)
    }
}

impl Hand {
    pub(super) fn drawn(random: &mut ChaCha8Rng, matter: Matter) -> Self {
        let inserting = [Self::Ramp, Self::Smooth, Self::Stab, Self::Tremble, Self::Stops];
        match matter {
            Matter::Membranes => one_of(random, &inserting),
            Matter::Nothing => one_of(random, &[Self::Smooth, Self::Tremble]),
            Matter::Foam | Matter::Spring | Matter::RigidStop => {
                one_of(random, &[Self::Smooth, Self::Tremble, Self::Stops, Self::Presses, Self::Presses, Self::Taps])
            }
        }
    }

    pub(super) fn path(self, random: &mut ChaCha8Rng, contact: &Contact) -> Path {
        let mut points = vec![(0.0, 0.0)];
        let (mut time_s, mut position_m) = (0.3 + uniform(random, 0.0, 0.5), 0.0);
        points.push((time_s, position_m));
        let mut to = |points: &mut Vec<(f64, f64)>, target_m: f64, duration_s: f64| {
            time_s += duration_s;
            position_m = target_m;
            points.push((time_s, target_m));
        };
        let end_m = match contact.matter {
            // The desired position leads the needle, because the hand is compliant.
            Matter::Membranes => contact.end_m() + 4e-3,
            Matter::Nothing => 30e-3,
            Matter::Foam | Matter::Spring | Matter::RigidStop => {
                contact.surface_m + contact.depth_m(uniform(random, 2.0, 12.0)) + 2e-3
            }
        };
        match self {
            Self::Ramp | Self::Tremble => {
                let speed_m_per_s = log_uniform(random, 1e-3, 3e-2).max(end_m / 10.0);
                to(&mut points, end_m, end_m / speed_m_per_s);
            }
            Self::Smooth => to(&mut points, end_m, log_uniform(random, 0.5, 6.0)),
            Self::Stab => to(&mut points, end_m, end_m / log_uniform(random, 0.05, 0.3)),
            Self::Stops => {
                let pieces = 2 + (3.0 * uniform(random, 0.0, 1.0)) as u32;
                for piece in 1..=pieces {
                    let target_m = end_m * f64::from(piece) / f64::from(pieces);
                    to(&mut points, target_m, log_uniform(random, 0.1, 1.5));
                    to(&mut points, target_m, uniform(random, 0.2, 1.0));
                }
            }
            Self::Presses | Self::Taps => {
                let (low_s, high_s) = if self == Self::Taps { (0.02, 0.06) } else { (0.1, 1.0) };
                for _ in 0..4 {
                    let press_m = end_m * uniform(random, 0.9, 1.3);
                    to(&mut points, press_m, log_uniform(random, low_s, high_s));
                    if self == Self::Presses {
                        to(&mut points, press_m, uniform(random, 0.1, 0.8));
                    }
                    let back_m = contact.surface_m - uniform(random, 1e-3, 3e-3);
                    to(&mut points, back_m, log_uniform(random, 0.02, 0.3));
                    to(&mut points, back_m, uniform(random, 0.1, 0.5));
                }
            }
        }
        to(&mut points, end_m, uniform(random, 0.3, 1.5));
        to(&mut points, -1e-3, log_uniform(random, 0.2, 2.0));
        to(&mut points, -1e-3, 0.4);
        let trembles = self == Self::Tremble;
        Path {
            is_even: matches!(self, Self::Ramp | Self::Tremble | Self::Stops),
            tremor_m: if trembles { log_uniform(random, 3e-5, 3e-4) } else { 0.0 },
            tremor_hz: uniform(random, 6.0, 12.0),
            duration_s: time_s,
            points,
        }
    }
}
