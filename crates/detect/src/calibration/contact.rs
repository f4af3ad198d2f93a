use schemars::JsonSchema;
use serde::Serialize;

use super::spread::median;
use trocar_base::interrupt;
use trocar_base::large_pages::with_capacity;

/// The rule that determines the contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ContactRule {
    /// The user gives the contact.
    Given,
    /// The force below the contact is noise.
    FirstForce,
    /// The needle is loaded throughout. The line of force over position, up to the maximum force, is extrapolated to
    /// zero.
    Extrapolated,
    /// The force does not grow with position. The contact is 5 mm below the lowest position, where the estimator's gain
    /// is full.
    Lowest,
}

const NOISE_STDS: f64 = 6.0;
const MIN_FORCE_N: f64 = 0.05;
/// Maximum share of samples above the noise before the contact.
const STRAY_SHARE: f64 = 0.02;
/// One sample in this many decides whether the needle is free at the lowest positions.
const LOWEST_SHARE: usize = 20;
const MIN_LOWEST: usize = 20;
/// The full gain begins some distance below the contact.
const BELOW_LOWEST_M: f64 = 5e-3;

/// In m, from positions, forces and the noise of the force.
pub(super) fn contact(position_m: &[f64], force_n: &[f64], noise_n: f64) -> (f64, ContactRule) {
    let mut samples: Vec<(f64, f64)> = with_capacity(position_m.len());
    for (sample, (&position_m, &force_n)) in position_m.iter().zip(force_n).enumerate() {
        interrupt::check_at(sample as u64);
        samples.push((position_m, force_n));
    }
    let mut comparisons = 0;
    samples.sort_by(|a, b| {
        comparisons += 1;
        interrupt::check_at(comparisons);
        a.0.total_cmp(&b.0)
    });
    let Some(&(lowest_m, _)) = samples.first() else { return (0.0, ContactRule::Lowest) };
    let free_below_n = (NOISE_STDS * noise_n).max(MIN_FORCE_N);
    let lowest = &samples[..samples.len().min((samples.len() / LOWEST_SHARE).max(MIN_LOWEST))];
    let median_of = |part: fn(f64) -> f64| median(&lowest.iter().map(|sample| part(sample.1)).collect::<Vec<_>>());
    if median_of(f64::abs).unwrap_or(0.0) < free_below_n {
        let mut strays = 0.0;
        let mut contact_m = lowest_m;
        for (count, &(position_m, force_n)) in samples.iter().enumerate() {
            strays += f64::from(u8::from(force_n.abs() >= free_below_n));
            if strays < STRAY_SHARE * (count + 1) as f64 {
                contact_m = position_m;
            }
        }
        return (contact_m, ContactRule::FirstForce);
    }
    let loaded = median_of(|force| force).unwrap_or(0.0) > 0.0;
    // Beyond the maximum force, the tissue may have ruptured.
    let largest = samples.iter().max_by(|a, b| a.1.total_cmp(&b.1)).map_or(lowest_m, |sample| sample.0);
    let loading = &samples[..samples.partition_point(|sample| sample.0 <= largest)];
    match zero_force_position_m(loading).filter(|_| loaded) {
        Some(contact_m) => (contact_m.min(lowest_m), ContactRule::Extrapolated),
        None => (lowest_m - BELOW_LOWEST_M, ContactRule::Lowest),
    }
}

/// Zero of the least-squares line.
fn zero_force_position_m(samples: &[(f64, f64)]) -> Option<f64> {
    let count = samples.len() as f64;
    let mean = |part: fn(&(f64, f64)) -> f64| samples.iter().map(part).sum::<f64>() / count;
    let (mean_m, mean_n) = (mean(|sample| sample.0), mean(|sample| sample.1));
    let spread = samples.iter().map(|sample| (sample.0 - mean_m).powi(2)).sum::<f64>();
    let covariance = samples.iter().map(|sample| (sample.0 - mean_m) * (sample.1 - mean_n)).sum::<f64>();
    let stiffness = covariance / spread;
    (stiffness > 0.0 && stiffness.is_finite()).then(|| mean_m - mean_n / stiffness)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(from_mm: i32, to_mm: i32, force: impl Fn(f64) -> f64) -> (Vec<f64>, Vec<f64>) {
        let position: Vec<f64> = (100 * from_mm..100 * to_mm).map(|k| f64::from(k) * 1e-5).collect();
        let force = position.iter().map(|&p| force(p)).collect();
        (position, force)
    }

    #[test]
    fn free_motion_before_a_spring_ends_where_the_spring_begins() {
        let (position, force) = ramp(-5, 20, |p| 300.0 * (p - 4e-3).max(0.0));
        let (contact_m, rule) = contact(&position, &force, 1e-3);
        assert!((4e-3..4.5e-3).contains(&contact_m), "{contact_m}");
        assert_eq!(rule, ContactRule::FirstForce);
    }

    #[test]
    fn a_spring_that_is_always_loaded_is_extrapolated_to_zero_force() {
        let (position, force) = ramp(9, 11, |p| 3000.0 * (p - 6.3e-3));
        let (contact_m, rule) = contact(&position, &force, 1e-3);
        assert!((contact_m - 6.3e-3).abs() < 1e-9, "{contact_m}");
        assert_eq!(rule, ContactRule::Extrapolated);
    }

    #[test]
    fn samples_after_a_rupture_do_not_change_the_line() {
        let (position, force) = ramp(9, 13, |p| if p < 0.01127 { 3000.0 * (p - 6.3e-3) } else { 0.01 });
        let (contact_m, rule) = contact(&position, &force, 1e-3);
        assert!((contact_m - 6.3e-3).abs() < 1e-9, "{contact_m}");
        assert_eq!(rule, ContactRule::Extrapolated);
    }

    #[test]
    fn a_force_that_does_not_grow_has_no_contact() {
        let (position, force) = ramp(0, 5, |_| -0.4);
        assert_eq!(contact(&position, &force, 1e-3), (-5e-3, ContactRule::Lowest));
        let (position, force) = ramp(0, 5, |p| 2.0 - p);
        assert_eq!(contact(&position, &force, 1e-3).1, ContactRule::Lowest);
        assert_eq!(contact(&[], &[], 0.0).1, ContactRule::Lowest);
        assert_eq!(contact(&[1e-3; 50], &[2.0; 50], 0.0).1, ContactRule::Lowest);
    }
}
