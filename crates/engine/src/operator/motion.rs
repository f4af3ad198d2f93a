use std::sync::Arc;

/// `x = start + (end - start) (10 τ³ - 15 τ⁴ + 6 τ⁵)`, `τ = t / movement <= 1` (Flash and Hogan 1985).
pub fn minimum_jerk(start_m: f64, end_m: f64, movement_s: f64, tick_s: f64, ticks: u64) -> Arc<[f64]> {
    let position = |tick: u64| {
        let tau = (tick as f64 * tick_s / movement_s).min(1.0);
        start_m + (end_m - start_m) * (tau * tau * tau * (10.0 + tau * (-15.0 + 6.0 * tau)))
    };
    (0..ticks).map(position).collect()
}

/// The pushes are chosen here.
pub fn insertion_extraction(
    (start_m, end_m): (f64, f64),
    (movement_s, pushes): (f64, u64),
    (hold_s, withdrawal_s): (f64, f64),
    tick_s: f64,
    ticks: u64,
) -> Arc<[f64]> {
    let share = |tau: f64| {
        let tau = tau.clamp(0.0, 1.0);
        tau * tau * tau * (10.0 + tau * (-15.0 + 6.0 * tau))
    };
    let count = pushes.max(1) as f64;
    let position = |tick: u64| {
        let time_s = tick as f64 * tick_s;
        let push = (count * time_s / movement_s).min(count);
        let done = push.floor();
        let way_in = (done + share(push - done)) / count;
        let way_out = share((time_s - movement_s - hold_s) / withdrawal_s);
        start_m + (end_m - start_m) * (way_in - way_out)
    };
    (0..ticks).map(position).collect()
}

/// `x = centre + amplitude sin(2π f t)`
pub fn sine(centre_m: f64, amplitude_m: f64, frequency_hz: f64, tick_s: f64, ticks: u64) -> Arc<[f64]> {
    let position = |tick: u64| {
        let turns = frequency_hz * (tick as f64 * tick_s);
        centre_m + amplitude_m * libm::sin(std::f64::consts::TAU * (turns - turns.floor()))
    };
    (0..ticks).map(position).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_insertion_advances_in_pushes_rests_and_returns() {
        let way = insertion_extraction((-0.01, 0.03), (2.0, 4), (0.5, 1.0), 1e-3, 4001);
        for (tick, position) in [(0, -0.01), (500, 0.0), (1000, 0.01), (2000, 0.03), (2500, 0.03), (3500, -0.01)] {
            assert!((way[tick] - position).abs() < 1e-12, "{tick}: {}", way[tick]);
        }
        assert_eq!((way[2250], way[4000]), (0.03, -0.01));
        assert!((way[3000] - 0.01).abs() < 1e-12, "half the way out at half time");
        let rest = (way[501] - way[499]).abs();
        assert!(rest < 1e-7 && way[1500] - way[1499] < 1e-7, "at rest between pushes: {rest}");
        assert!(way[..2001].windows(2).all(|pair| pair[1] >= pair[0]));
    }

    #[test]
    fn a_sine_oscillates_about_its_centre() {
        let way = sine(0.01, 0.002, 5.0, 1e-3, 401);
        assert_eq!(way[0], 0.01);
        assert!((way[50] - 0.012).abs() < 1e-12 && (way[150] - 0.008).abs() < 1e-12 && (way[400] - 0.01).abs() < 1e-12);
    }

    #[test]
    fn a_minimum_jerk_movement_follows_its_polynomial() {
        let way = minimum_jerk(0.01, 0.03, 0.8, 1e-3, 900);
        for tick in [0, 100, 200, 333, 700, 800, 899] {
            let tau = (tick as f64 * 1e-3 / 0.8).min(1.0);
            let share = 10.0 * tau.powi(3) - 15.0 * tau.powi(4) + 6.0 * tau.powi(5);
            assert!((way[tick] - (0.01 + 0.02 * share)).abs() < 1e-15, "{tick}");
        }
    }
}
