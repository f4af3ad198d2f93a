//! A synthetic recording with the properties of the paper's insertion into a liver through the skin.
//!
//! The original is not published. A small mechanical model reproduces the facts stated in the paper: two layers that
//! rupture at 5.52 s and 8.85 s, the second less suddenly; forces between about -5.7 and 2.5 N in the paper's sign; a
//! shaft friction that pulls during extraction, near 14.5 s, without a rupture; 1 kHz; measurement noise.

use std::fmt::Write as _;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

const RATE_HZ: f64 = 1000.0;

const SAMPLES: u32 = 17_000;

pub const RUPTURES_S: [f64; 2] = [5.52, 8.85];

const NOISE_STD_N: f64 = 0.010;

/// Points (s, mm): approach, insertion through two layers, hold, and extraction.
const TRAJECTORY: [(f64, f64); 15] = [
    (0.0, -6.0),
    (0.9, 0.0),
    (3.0, 13.0),
    (5.52, 27.05),
    (5.82, 28.15),
    (6.1, 28.5),
    (7.2, 30.5),
    (8.85, 37.5),
    (9.5, 40.0),
    (11.0, 46.0),
    (12.2, 48.0),
    (14.1, 48.0),
    (14.5, 44.0),
    (16.4, -2.0),
    (17.0, -6.0),
];

const RUPTURE_DEPTH_M: f64 = 27.05e-3;

/// The force is a power of the compression. At the rupture most of the force drops fast, and the rest relaxes slowly.
struct Layer {
    from_m: f64,
    power: f64,
    rupture_n: f64,
    rupture_s: f64,
    fall_s: f64,
    /// Fraction of the force that relaxes slowly.
    residual: f64,
    relaxation_s: f64,
}

const LAYERS: [Layer; 2] = [
    Layer {
        from_m: 0.0,
        power: 1.8,
        rupture_n: 5.66,
        rupture_s: RUPTURES_S[0],
        fall_s: 0.045,
        residual: 0.06,
        relaxation_s: 0.12,
    },
    Layer {
        from_m: 28e-3,
        power: 1.6,
        rupture_n: 4.0,
        rupture_s: RUPTURES_S[1],
        fall_s: 0.045,
        residual: 0.2,
        relaxation_s: 0.4,
    },
];

/// Per m of needle beyond [`FRICTION_FROM_M`].
const FRICTION_N_PER_M: f64 = 232.0;
const FRICTION_FROM_M: f64 = 29e-3;
/// Travel over which the friction reverses (Dahl), in m.
const PRESLIDING_M: f64 = 2.6e-3;
/// After a rest of two seconds most of the friction has relaxed.
const FRICTION_RELAXATION_S: f64 = 1.2;

/// `None` keeps the shipped value.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct InVivoLikeVariant {
    /// Force that each rupture releases at once, in N, above 0 (shipped: 5.32 and 3.2; the rest relaxes slowly).
    pub drop_n: Option<f64>,
    /// Time constant of each drop, in s, above 0 (shipped: 0.045).
    pub fall_s: Option<f64>,
    /// Depth of the first rupture in m, above 0 (shipped: 0.02705). All lengths scale with it; the forces do not
    /// change.
    pub depth_m: Option<f64>,
}

impl InVivoLikeVariant {
    pub const DROPS_N: (f64, f64) = (0.01, 1000.0);
    pub const FALLS_S: (f64, f64) = (1e-4, 10.0);
    pub const DEPTHS_M: (f64, f64) = (1e-3, 1.0);

    fn scale(&self) -> f64 {
        self.depth_m.map_or(1.0, |depth_m| depth_m / RUPTURE_DEPTH_M)
    }

    fn layers(&self) -> [Layer; 2] {
        LAYERS.map(|layer| Layer {
            from_m: layer.from_m * self.scale(),
            rupture_n: self.drop_n.map_or(layer.rupture_n, |drop_n| drop_n / (1.0 - layer.residual)),
            fall_s: self.fall_s.unwrap_or(layer.fall_s),
            ..layer
        })
    }
}

impl Layer {
    /// Force at time `t` (s), position `p` and position at the rupture `p_rupture` (m).
    fn force_n(&self, t: f64, p: f64, p_rupture: f64) -> f64 {
        let since = t - self.rupture_s;
        if since < 0.0 {
            let compression = ((p - self.from_m) / (p_rupture - self.from_m)).max(0.0);
            return self.rupture_n * libm::pow(compression, self.power);
        }
        let fallen = (1.0 - self.residual) * libm::exp(-since / self.fall_s);
        self.rupture_n * (fallen + self.residual * libm::exp(-since / self.relaxation_s))
    }
}

/// The same seed gives the same bytes.
pub fn in_vivo_like_csv(seed: u64) -> String {
    in_vivo_like_variant_csv(seed, &InVivoLikeVariant::default())
}

/// In the format of [`in_vivo_like_csv`], with ruptures at [`RUPTURES_S`].
pub fn in_vivo_like_variant_csv(seed: u64, variant: &InVivoLikeVariant) -> String {
    let scale = variant.scale();
    let layers = variant.layers();
    let way = TRAJECTORY.map(|(t, y)| (t, scale * y));
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let slopes = monotone_slopes(&way);
    let at = |t: f64| hermite(&way, &slopes, t);
    let rupture_m = RUPTURES_S.map(|rupture_s| at(rupture_s).0);
    let mut text = String::with_capacity(SAMPLES as usize * 40);
    text.push_str("time_s,position_m,velocity_m_per_s,force_n\n");
    let mut friction = 0.0;
    let mut last = at(0.0).0;
    for k in 0..SAMPLES {
        let t = f64::from(k) / RATE_HZ;
        let (p, v) = at(t);
        let step = p - last;
        last = p;
        // Dahl's model, with relaxation.
        friction += step / (scale * PRESLIDING_M) * (1.0 - friction * step.signum())
            - friction / (RATE_HZ * FRICTION_RELAXATION_S);
        let shaft = FRICTION_N_PER_M / scale * (p - scale * FRICTION_FROM_M).max(0.0) * friction;
        let layers: f64 = layers.iter().zip(rupture_m).map(|(layer, p_rupture)| layer.force_n(t, p, p_rupture)).sum();
        let noise: f64 = StandardNormal.sample(&mut rng);
        let force = layers + shaft + NOISE_STD_N * noise;
        let _ = writeln!(text, "{t:.3},{p:.8},{v:.6},{force:.4}");
    }
    text
}

/// Slopes per s at the points of a trajectory for which its cubic interpolation does not overshoot (Fritsch and Butland
/// 1984).
fn monotone_slopes<const N: usize>(way: &[(f64, f64); N]) -> [f64; N] {
    let secant = |i: usize| (way[i + 1].1 - way[i].1) / (way[i + 1].0 - way[i].0);
    std::array::from_fn(|i| {
        if i == 0 || i + 1 == N {
            return 0.0;
        }
        let (before, after) = (secant(i - 1), secant(i));
        if before * after <= 0.0 {
            return 0.0;
        }
        let (h0, h1) = (way[i].0 - way[i - 1].0, way[i + 1].0 - way[i].0);
        let (w0, w1) = (2.0 * h1 + h0, h1 + 2.0 * h0);
        (w0 + w1) / (w0 / before + w1 / after)
    })
}

/// Position (m) and velocity (m/s) on a trajectory in mm, by cubic Hermite interpolation.
fn hermite<const N: usize>(way: &[(f64, f64); N], slopes: &[f64; N], t: f64) -> (f64, f64) {
    let i = way[1..N - 1].iter().take_while(|(time, _)| *time <= t).count();
    let ((t0, y0), (t1, y1)) = (way[i], way[i + 1]);
    let h = t1 - t0;
    let u = ((t - t0) / h).clamp(0.0, 1.0);
    let (d0, d1) = (h * slopes[i], h * slopes[i + 1]);
    let (a, b) = (2.0 * (y0 - y1) + d0 + d1, -3.0 * (y0 - y1) - 2.0 * d0 - d1);
    let position = y0 + u * (d0 + u * (b + u * a));
    let velocity = (d0 + u * (2.0 * b + u * 3.0 * a)) / h;
    (1e-3 * position, 1e-3 * velocity)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_generator_writes_the_shipped_recording() {
        let shipped = include_str!("../../../scenarios/recordings/in_vivo_like.csv");
        assert!(in_vivo_like_csv(1) == shipped, "run `trocar record --out scenarios/recordings/in_vivo_like.csv`");
        assert!(in_vivo_like_csv(2) != shipped);
    }

    #[test]
    fn a_variant_has_the_given_drop_depth_and_time_constant() {
        let rows = |variant: &InVivoLikeVariant| -> Vec<Vec<f64>> {
            let text = in_vivo_like_variant_csv(1, variant);
            text.lines()
                .skip(1)
                .map(|row| row.split(',').map(|cell| cell.parse().expect("a number")).collect())
                .collect()
        };
        let variant = InVivoLikeVariant { drop_n: Some(2.0), fall_s: Some(0.01), depth_m: Some(0.01) };
        let (varied, shipped) = (rows(&variant), rows(&InVivoLikeVariant::default()));
        assert!((varied[5520][1] - 0.01).abs() < 1e-8);
        let fall = |from: usize, to: usize| varied[from][3] - varied[to][3];
        // After ten time constants the relaxing 6 % has also lost 1 - exp(-0.1/0.12) of its 0.128 N.
        assert!((fall(5520, 5620) - 2.0 - 0.072).abs() < 0.05, "{}", fall(5520, 5620));
        assert!((fall(5520, 5530) - 2.0 * (1.0 - libm::exp(-1.0))).abs() < 0.06, "{}", fall(5520, 5530));
        // During extraction only friction remains, with an unchanged force.
        assert!((varied[14_600][3] - shipped[14_600][3]).abs() < 0.05);
    }

    #[test]
    fn the_trajectory_is_smooth_and_passes_through_its_points() {
        let slopes = monotone_slopes(&TRAJECTORY);
        for (t, y) in TRAJECTORY {
            assert!((hermite(&TRAJECTORY, &slopes, t).0 - 1e-3 * y).abs() < 1e-12);
        }
        for k in 1..SAMPLES {
            let t = f64::from(k) / RATE_HZ;
            let difference =
                (hermite(&TRAJECTORY, &slopes, t + 1e-6).0 - hermite(&TRAJECTORY, &slopes, t - 1e-6).0) / 2e-6;
            assert!((difference - hermite(&TRAJECTORY, &slopes, t).1).abs() < 1e-4, "{t}");
        }
    }
}
