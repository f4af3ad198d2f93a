//! Random cases of a passivity scheme: hands, tissues and links.

use std::f64::consts::PI;

/// A pseudo-random sequence (xorshift64*) that is the same on every machine.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    fn share(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.share()
    }

    /// Returns a number whose logarithm is uniform.
    fn scale(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    fn is(&mut self, share: f64) -> bool {
        self.share() < share
    }

    fn one<T: Copy>(&mut self, of: &[T]) -> T {
        of[(self.share() * of.len() as f64) as usize]
    }
}

/// A case: its base scenario, its settings without a scheme, and the settings of its link.
#[derive(Debug, Clone)]
pub struct Case {
    pub base: &'static str,
    pub settings: Vec<String>,
    pub link: Vec<String>,
}

impl Case {
    /// Draws a case of at most `duration_s` (s).
    pub fn draw(random: &mut Random, duration_s: f64) -> Self {
        let is_augmented = random.is(0.4);
        let base = match (is_augmented, random.is(0.3)) {
            (true, false) => "paper/augmented",
            (false, false) => "paper/classical",
            (true, true) => "paper/depth-augmented",
            (false, true) => "paper/depth-classical",
        };
        let mut settings = vec![format!("simulation.seed={}", random.between(1.0, 1e6) as u64)];
        let mut set = |key: &str, value: String| settings.push(format!("{key}={value}"));
        let kind = random.one(&["wall", "wall", "wall", "layers", "layers", "recording"]);
        let mut surface_m = 0.0;
        match kind {
            "wall" => {
                set("tissue.kind", "kelvin-voigt".into());
                let stiffness =
                    if random.is(0.5) { random.scale(50.0, 2e4) } else { random.one(&[200.0, 300.0, 1e3, 5e3, 2e4]) };
                set("tissue.stiffness_n_per_m", stiffness.to_string());
                let damping = if random.is(0.5) { 0.0 } else { random.between(0.0, 20.0) };
                set("tissue.damping_n_s_per_m", damping.to_string());
                // A third of the walls are preloaded.
                surface_m = random.between(-0.005, 0.01);
                set("tissue.contact_m", surface_m.to_string());
                set("estimator.contact_m", surface_m.to_string());
            }
            "layers" => {
                set("tissue.kind", "layers".into());
                surface_m = random.between(0.0, 0.005);
                set("tissue.contact_m", surface_m.to_string());
                set("estimator.contact_m", surface_m.to_string());
            }
            _ => {}
        }
        if kind == "recording" && random.is(0.5) {
            set("simulation.duration_s", duration_s.min(7.0).to_string());
        } else {
            set("simulation.duration_s", duration_s.to_string());
            let amplitude_m = random.between(0.001, 0.02);
            match random.one(&["sine", "step", "stab", "insertion"]) {
                "sine" => {
                    set("operator.kind", "sine".into());
                    // The needle starts outside layers.
                    let centre_m = if kind == "layers" { -0.001 } else { random.between(-0.005, 0.01) };
                    set("operator.start_m", (surface_m + centre_m).to_string());
                    set("operator.amplitude_m", amplitude_m.to_string());
                    set("operator.frequency_hz", random.between(0.3, 2.5 / (2.0 * PI) * 3.0).to_string());
                }
                "step" => {
                    set("operator.kind", "minimum-jerk".into());
                    set("operator.start_m", (-0.002).to_string());
                    set("operator.end_m", (surface_m + amplitude_m).to_string());
                    set("operator.movement_s", "0.05".into());
                }
                "stab" => {
                    set("operator.kind", "ramp".into());
                    set("operator.start_m", (-0.005).to_string());
                    set("operator.end_m", (surface_m + amplitude_m).to_string());
                    set("operator.speed_m_per_s", random.scale(0.01, 0.5).to_string());
                }
                _ => {
                    set("operator.kind", "insertion-extraction".into());
                    set("operator.start_m", (-0.003).to_string());
                    set("operator.end_m", (surface_m + 2.0 * amplitude_m).to_string());
                    set("operator.movement_s", (0.35 * duration_s).to_string());
                    set("operator.hold_s", (0.1 * duration_s).to_string());
                    set("operator.withdrawal_s", (0.3 * duration_s).to_string());
                }
            }
        }
        Self { base, settings, link: draw_link(random, duration_s) }
    }

    /// Draws a stab over a direct link: a hand that moves at a constant speed into a wall or into layers and stops
    /// there.
    pub fn draw_stab(random: &mut Random, duration_s: f64) -> Self {
        let base = random.one(&["paper/classical", "paper/augmented"]);
        let mut settings = vec![format!("simulation.seed={}", random.between(1.0, 1e6) as u64)];
        let mut set = |key: &str, value: String| settings.push(format!("{key}={value}"));
        set("simulation.duration_s", duration_s.to_string());
        if random.is(0.7) {
            set("tissue.kind", "kelvin-voigt".into());
            set("tissue.stiffness_n_per_m", random.scale(50.0, 2e4).to_string());
            set("tissue.damping_n_s_per_m", random.between(0.0, 20.0).to_string());
        } else {
            set("tissue.kind", "layers".into());
        }
        let surface_m = random.between(0.0, 0.005);
        set("tissue.contact_m", surface_m.to_string());
        set("estimator.contact_m", surface_m.to_string());
        set("operator.kind", "ramp".into());
        set("operator.start_m", (-0.005).to_string());
        set("operator.end_m", (surface_m + random.between(0.001, 0.02)).to_string());
        set("operator.speed_m_per_s", random.scale(0.01, 0.5).to_string());
        Self { base, settings, link: vec![] }
    }

    /// Returns the settings of the case with a scheme.
    pub fn with(&self, scheme: &str) -> Vec<String> {
        let scheme = format!("passivity.scheme={scheme}");
        self.settings.iter().chain(&self.link).cloned().chain([scheme]).collect()
    }
}

/// Draws a link: direct, with a constant delay each way, or lossy.
fn draw_link(random: &mut Random, duration_s: f64) -> Vec<String> {
    let mut delay_s = || if random.is(0.15) { 0.0 } else { random.between(0.0, 0.2) };
    let forward_s = delay_s();
    let backward_s = delay_s();
    let backward_s = if random.is(0.5) { forward_s } else { backward_s };
    let mut link =
        vec![format!("channel.forward_delay_s={forward_s}"), format!("channel.backward_delay_s={backward_s}")];
    if random.is(0.5) {
        if random.is(0.7) {
            link.push(format!("channel.jitter_s={}", random.between(0.0, 0.02)));
        }
        if random.is(0.7) {
            link.push(format!("channel.loss={}", random.between(0.0, 0.3)));
        }
        if random.is(0.4) {
            let start_s = random.between(0.2, 0.8) * duration_s;
            link.push(format!("channel.outages_s=[{start_s}, {}]", start_s + random.between(0.02, 0.4)));
            link.push(format!("channel.recovery={}", random.one(&["ramp", "ramp", "give-up"])));
        }
    }
    link
}
