//! A quiet hand: an insertion, a hold, and in half of the cases a retreat and another hold.

use super::draw::Draw;
use super::recording::Recording;

/// Start of the needle before the surface, in m.
const START_M: f64 = -2e-3;

/// Length of each hold in s, and its beginning that is not judged.
const HOLD_S: f64 = 6.0;
const SETTLE_S: f64 = 0.5;

/// Samples per second of the recorded motion.
const RATE_HZ: f64 = 100.0;

/// The needle's intended motion. Times in s, positions in m.
pub struct Hand {
    insertion_s: f64,
    depth_m: f64,
    retreat_s: f64,
    retreat_m: f64,
}

impl Hand {
    pub fn draw(draw: &mut Draw) -> Self {
        let (insertion_s, depth_m) = (draw.log(0.5, 4.0), draw.log(5e-3, 0.04));
        let retreat_m = if draw.chance(0.5) { draw.log(5e-4, 0.01).min(0.8 * depth_m) } else { 0.0 };
        Self { insertion_s, depth_m, retreat_s: retreat_m / draw.log(1e-3, 0.01), retreat_m }
    }

    /// The ends of the movements and of the run.
    fn ends_s(&self) -> [f64; 3] {
        let retreat_s = self.insertion_s + HOLD_S;
        let held_s = if self.retreat_m > 0.0 { self.retreat_s + HOLD_S } else { 0.0 };
        [self.insertion_s, retreat_s, retreat_s + held_s]
    }

    pub fn duration_s(&self) -> f64 {
        self.ends_s()[2]
    }

    /// The judged times of rest.
    pub fn holds_s(&self) -> Vec<(f64, f64)> {
        let [inserted_s, retreat_s, end_s] = self.ends_s();
        let last = (retreat_s + self.retreat_s + SETTLE_S, end_s);
        let holds = [(inserted_s + SETTLE_S, retreat_s), last];
        holds[..if self.retreat_m > 0.0 { 2 } else { 1 }].to_vec()
    }

    fn position_m(&self, time_s: f64) -> f64 {
        let share = |from_s: f64, length_s: f64| {
            let u = ((time_s - from_s) / length_s).clamp(0.0, 1.0);
            u * u * u * (10.0 + u * (6.0 * u - 15.0))
        };
        let [_, retreat_s, _] = self.ends_s();
        let out_m = if self.retreat_m > 0.0 { self.retreat_m * share(retreat_s, self.retreat_s) } else { 0.0 };
        START_M + (self.depth_m - START_M) * share(0.0, self.insertion_s) - out_m
    }

    /// The motion as a recording in CSV. After the run a deep insertion and a complete withdrawal follow, so that the
    /// forces are known at every depth.
    pub fn csv(&self, position_scale: f64, forces: Option<&Recording>) -> String {
        let ticks = (self.duration_s() * RATE_HZ).ceil() as usize + 2;
        let of_run = (0..ticks).map(|tick| (self.position_m(tick as f64 / RATE_HZ) / position_scale, false));
        let deep = || (-70..1000).map(|k| 1e-4 * f64::from(k));
        let after = deep().map(|m| (m, false)).chain(deep().rev().map(|m| (m, true)));
        let row = |(tick, (position_m, is_out)): (usize, (f64, bool))| {
            let force_n = forces.map_or(0.0, |forces| forces.force_n(position_m, is_out));
            format!("{},{position_m:e},{force_n:e}\n", tick as f64 / RATE_HZ)
        };
        let rows: String = of_run.chain(after).enumerate().map(row).collect();
        format!("time_s,position_m,force_n\n{rows}")
    }
}
