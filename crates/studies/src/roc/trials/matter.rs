use rand_chacha::ChaCha8Rng;

use super::{STEP_S, log_uniform, uniform};

/// A force sensor cannot distinguish two closer falls.
const APART_S: f64 = 0.05;

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Matter {
    /// One to three ruptures.
    Membranes,
    /// The force grows with the square of the depth, with friction.
    Foam,
    Spring,
    RigidStop,
    Nothing,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fall {
    pub start_s: f64,
    pub duration_s: f64,
    /// Fall between two noise-free samples: less than the drop of the layer if other layers load the needle meanwhile,
    /// or if the sensor is too slow.
    pub drop_n: f64,
}

impl Fall {
    /// Merges falls that begin within [`APART_S`] of the previous one's end.
    pub(super) fn merged(all: Vec<Self>, forces: &[f64], tick_s: f64) -> Vec<Self> {
        let mut merged: Vec<Self> = vec![];
        for fall in all {
            match merged.last_mut().filter(|last| fall.start_s <= last.end_s() + APART_S) {
                Some(last) => last.duration_s = last.duration_s.max(fall.end_s() - last.start_s),
                None => merged.push(fall),
            }
        }
        for fall in &mut merged {
            let first = (fall.start_s / tick_s).floor() as usize;
            let end = (fall.end_s() / tick_s).ceil() as usize + 1;
            let (mut highest_n, mut drop_n) = (f64::MIN, 0.0_f64);
            for &force_n in &forces[first.min(forces.len())..end.min(forces.len())] {
                highest_n = highest_n.max(force_n);
                drop_n = drop_n.max(highest_n - force_n);
            }
            fall.drop_n = drop_n;
        }
        merged
    }

    pub fn end_s(&self) -> f64 {
        self.start_s + self.duration_s
    }
}

#[derive(Debug, Clone)]
struct Layer {
    surface_m: f64,
    stiffness_n_per_m: f64,
    rupture_n: f64,
    drop_n: f64,
    duration_s: f64,
    relaxation_s: f64,
    ruptured_s: Option<f64>,
}

impl Layer {
    fn force_n(&self, time_s: f64, position_m: f64) -> f64 {
        let Some(ruptured_s) = self.ruptured_s else {
            return self.stiffness_n_per_m * (position_m - self.surface_m).max(0.0);
        };
        let since_s = time_s - ruptured_s;
        let share = (since_s / self.duration_s).min(1.0);
        let fallen_n = self.drop_n * (0.5 - 0.5 * libm::cos(std::f64::consts::PI * share));
        let left_n = self.rupture_n - self.drop_n;
        let relaxed_n = left_n * (1.0 - libm::exp(-(since_s - self.duration_s).max(0.0) / self.relaxation_s));
        let open = ((position_m - self.surface_m) / 1e-3).clamp(0.0, 1.0);
        open * (self.rupture_n - fallen_n - relaxed_n)
    }
}

#[derive(Debug, Clone)]
pub(super) struct Contact {
    pub(super) matter: Matter,
    pub(super) surface_m: f64,
    pub(super) falls: Vec<Fall>,
    layers: Vec<Layer>,
    stiffness: f64,
    damping_n_s_per_m: f64,
    friction_n: f64,
    /// Distance over which the friction reverses.
    presliding_m: f64,
    stretch_m: f64,
}

impl Contact {
    pub(super) fn drawn(random: &mut ChaCha8Rng, matter: Matter) -> Self {
        let surface_m = uniform(random, 2e-3, 8e-3);
        let mut layers = vec![];
        if matter == Matter::Membranes {
            let mut next_m = surface_m;
            for _ in 0..1 + (3.0 * uniform(random, 0.0, 1.0)) as usize {
                let drop_n = log_uniform(random, 0.2, 15.0);
                let rupture_n = drop_n / uniform(random, 0.5, 1.0);
                // Layers stretch by 0.5 to 30 mm before they rupture.
                let stiffness_n_per_m = log_uniform(random, 20.0, 5000.0).clamp(rupture_n / 0.03, rupture_n / 5e-4);
                layers.push(Layer {
                    surface_m: next_m,
                    stiffness_n_per_m,
                    rupture_n,
                    drop_n,
                    duration_s: log_uniform(random, 1e-3, 50e-3),
                    relaxation_s: log_uniform(random, 0.1, 1.0),
                    ruptured_s: None,
                });
                next_m += rupture_n / stiffness_n_per_m + log_uniform(random, 5e-4, 1e-2);
            }
        }
        let stiffness = match matter {
            Matter::Membranes | Matter::Nothing => 0.0,
            // N/m²
            Matter::Foam => log_uniform(random, 3e4, 1e6),
            Matter::Spring => log_uniform(random, 50.0, 5000.0),
            Matter::RigidStop => log_uniform(random, 8e3, 4e4),
        };
        let damping_n_s_per_m = if matter == Matter::Nothing { 0.0 } else { log_uniform(random, 0.1, 10.0) };
        let friction_n =
            if matches!(matter, Matter::Membranes | Matter::Foam) { uniform(random, 0.0, 0.3) } else { 0.0 };
        Self {
            matter,
            surface_m,
            falls: vec![],
            layers,
            stiffness,
            damping_n_s_per_m,
            friction_n,
            presliding_m: log_uniform(random, 1e-4, 1e-3),
            stretch_m: 0.0,
        }
    }

    pub(super) fn end_m(&self) -> f64 {
        let last = self.layers.iter().map(|layer| layer.surface_m + layer.rupture_n / layer.stiffness_n_per_m);
        last.fold(self.surface_m, f64::max) + 4e-3
    }

    pub(super) fn depth_m(&self, force_n: f64) -> f64 {
        match self.matter {
            Matter::Foam => libm::sqrt(force_n / self.stiffness),
            Matter::Spring | Matter::RigidStop => force_n / self.stiffness,
            Matter::Membranes | Matter::Nothing => 0.0,
        }
    }

    pub(super) fn hand_compliance_m_per_n(&self, random: &mut ChaCha8Rng) -> f64 {
        let is_machine = uniform(random, 0.0, 1.0) < 0.3;
        if is_machine && self.matter != Matter::RigidStop { 1e-5 } else { 1.0 / log_uniform(random, 1000.0, 5000.0) }
    }

    /// Damping and friction are added later.
    fn static_n(&mut self, time_s: f64, position_m: f64) -> f64 {
        let depth_m = position_m - self.surface_m;
        if depth_m <= 0.0 {
            return 0.0;
        }
        let mut force_n = match self.matter {
            Matter::Foam => self.stiffness * depth_m * depth_m,
            Matter::Spring | Matter::RigidStop => self.stiffness * depth_m,
            Matter::Membranes | Matter::Nothing => 0.0,
        };
        for layer in &mut self.layers {
            force_n += layer.force_n(time_s, position_m);
            let stretch_n = layer.stiffness_n_per_m * (position_m - layer.surface_m);
            if layer.ruptured_s.is_none() && stretch_n >= layer.rupture_n {
                layer.ruptured_s = Some(time_s);
                let Layer { duration_s, drop_n, .. } = *layer;
                self.falls.push(Fall { start_s: time_s, duration_s, drop_n });
            }
        }
        force_n
    }

    /// Velocity of the needle in m/s and force on it in N. A hand with a compliance (m/N) and a lag (s) pulls the
    /// needle towards `wanted_m`.
    pub(super) fn step(&mut self, time_s: f64, position_m: f64, wanted_m: f64, hand: (f64, f64)) -> (f64, f64) {
        let (compliance, lag_s) = hand;
        let static_n = self.static_n(time_s, position_m);
        let damping = if position_m > self.surface_m { self.damping_n_s_per_m } else { 0.0 };
        // Explicit damping would oscillate with a compliant hand.
        let velocity_m_per_s = (wanted_m - compliance * static_n - position_m) / (lag_s + compliance * damping);
        if position_m <= self.surface_m {
            self.stretch_m = 0.0;
            return (velocity_m_per_s, 0.0);
        }
        let resisting_n = static_n + damping * velocity_m_per_s;
        // Nothing pulls at a blunt tip. Friction acts along the shaft.
        self.stretch_m = (self.stretch_m + velocity_m_per_s * STEP_S).clamp(-self.presliding_m, self.presliding_m);
        (velocity_m_per_s, resisting_n.max(0.0) + self.friction_n * self.stretch_m / self.presliding_m)
    }
}
