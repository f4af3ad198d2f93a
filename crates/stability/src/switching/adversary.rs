//! A greedy adversary, to compare the bounds of [`Peaks`](super::Peaks) with motions that exist.
//!
//! A sequence of events fixes the map `M_k` of each tick except for the tissue. The position `c x_N` under forces `|w| <= 1`
//! is at most `Σ |p_{k+1}ᵀ b_k|` with `p_N = c` and `p_k = M_kᵀ p_{k+1}`, and the forces of these signs reach it. Backwards
//! from the last tick, the adversary takes in each tick the spring and damper that makes `p_k` largest, or the same in
//! every tick, whichever moves the position farther.

use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::modes::{Modes, Space};
use super::settings::{Phases, SwitchingSettings};
use crate::StabilityError;
use trocar_core::augmentation::cross_fade;

/// Extra ticks of teleoperation between events, at most.
const EXTRA_TICKS: [u64; 3] = [0, 20, 400];

/// The largest motions of needle and hand in m/N that the adversary finds in this number of random sequences of events.
///
/// # Errors
/// [`StabilityError`].
pub fn adversary(
    settings: &SwitchingSettings,
    (sequences, events): (u64, usize),
    seed: u64,
) -> Result<[f64; 2], StabilityError> {
    let modes = Modes::new(&SwitchingSettings { loses_contact: true, ..settings.clone() })?;
    let mut largest = [0.0_f64; 2];
    for sequence in 0..sequences {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(sequence);
        let steps = steps(&modes, settings.phases(), events, &mut rng);
        for (largest, row) in largest.iter_mut().zip([modes.slave(), modes.hand_position()]) {
            let strategies = std::iter::once(None).chain(modes.vertices().map(Some));
            let found = strategies.map(|strategy| reached(&modes, &steps, &row, strategy));
            *largest = found.fold(*largest, f64::max);
        }
    }
    Ok(largest)
}

/// The maps of the ticks, each with its choices, and true if the additional force acts.
type Step = (Vec<DMatrix<f64>>, bool);

fn steps(modes: &Modes, phases: Phases, events: usize, rng: &mut ChaCha8Rng) -> Vec<Step> {
    let each = |map: &dyn Fn(usize) -> DMatrix<f64>| -> Vec<DMatrix<f64>> { modes.vertices().map(map).collect() };
    let teleoperation = each(&|vertex| modes.teleoperation(vertex));
    let frozen: Vec<DMatrix<f64>> = modes
        .vertices()
        .flat_map(|vertex| modes.shares().iter().map(move |&share| modes.frozen(vertex, share)))
        .collect();
    let release = each(&|vertex| modes.release(vertex));
    let mut steps = vec![];
    for _ in 0..events {
        let extra = EXTRA_TICKS[rng.random_range(0..EXTRA_TICKS.len())];
        for _ in 0..phases.refractory + rng.random_range(0..=extra) {
            steps.push((teleoperation.clone(), true));
        }
        steps.push((teleoperation.clone(), true));
        steps.push((vec![modes.freeze()], false));
        for _ in 0..rng.random_range(phases.held.0..=phases.held.1) {
            steps.push((frozen.clone(), true));
        }
        steps.push((release.clone(), false));
        // The gap shrinks at any rate; it is closed before the time of teleoperation begins.
        let closes_in = rng.random_range(0..2 * phases.blend + 1);
        for tick in 0..phases.blend.max(closes_in) {
            let weight = cross_fade(((tick + 1) as f64 / phases.blend as f64).min(1.0));
            let share = if tick < closes_in && rng.random_bool(0.9) { 1.0 } else { rng.random_range(0.0..1.0) };
            let shrink = |map: DMatrix<f64>| modes.closed() * &map * (1.0 - share) + map * share;
            steps.push((each(&|vertex| shrink(modes.blend(vertex, weight))), true));
        }
        steps.push((vec![modes.closed()], false));
    }
    let last = rng.random_range(0..phases.refractory + 400);
    steps.extend((0..last).map(|_| (teleoperation.clone(), true)));
    steps
}

fn reached(modes: &Modes, steps: &[Step], row: &DMatrix<f64>, constant: Option<usize>) -> f64 {
    let n = modes.places_all();
    let input = modes.selection(Space::All, Space::Input).transpose();
    let mut p = row.clone();
    let mut sum = 0.0;
    for (choices, is_driven) in steps.iter().rev() {
        // A map without a choice has one entry, and a law with a floor two for each spring.
        let next = match constant {
            Some(vertex) => choices.get(vertex * choices.len() / modes.vertices().len()).map(|map| &p * map),
            None => choices.iter().map(|map| &p * map).max_by(|a, b| size(a, &input).total_cmp(&size(b, &input))),
        };
        p = next.unwrap_or_else(|| DMatrix::zeros(1, n));
        if *is_driven {
            sum += (&p * &input)[(0, 0)].abs();
        }
        // The force of another tick is another input.
        p -= &p * &input * input.transpose();
    }
    sum
}

/// The size of `p` without the force, and the effect of the force.
fn size(p: &DMatrix<f64>, input: &DMatrix<f64>) -> f64 {
    p.norm() + (p * input)[(0, 0)].abs()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LinearLoop, Peaks, TissueRange};
    use trocar_scenario::{Scenario, Source};

    fn settings(given: &[&str], stiffness_n_per_m: (f64, f64), most_n_s_per_m: f64) -> SwitchingSettings {
        let given: Vec<String> = given.iter().map(|&one| one.to_owned()).collect();
        let scenario = Scenario::load(&Source::parse("builtin:paper/augmented.toml"), &given).expect("loads");
        let of_loop = LinearLoop::of(&scenario, TissueRange::spring(stiffness_n_per_m.1, 0.0)).expect("analysed");
        let settings = SwitchingSettings::of(&scenario, of_loop, stiffness_n_per_m).expect("covered");
        SwitchingSettings { damping_n_s_per_m: (0.0, most_n_s_per_m), ..settings }
    }

    #[test]
    fn no_sequence_of_events_springs_and_forces_exceeds_the_bounds() {
        for (given, stiffness, damping) in [
            (&[][..], (0.0, 800.0), 10.0),
            (&["augmentation.reengage=snap", "channel.forward_delay_s=0.003"][..], (0.0, 600.0), 5.0),
            (&["augmentation.force_law=amplify"][..], (50.0, 400.0), 0.0),
            (&["augmentation.hold=none", "augmentation.force_law=damp"][..], (0.0, 500.0), 5.0),
            (&["controller.kind=local-force"][..], (0.0, 500.0), 5.0),
        ] {
            let settings = settings(given, stiffness, damping);
            let peaks = Peaks::of(&settings).expect("analysed").unwrap_or_else(|| panic!("not certified: {given:?}"));
            assert!(peaks.certificate.verify().is_ok(), "{given:?}");
            let found = adversary(&settings, (6, 3), 1).expect("analysed");
            for (found, bound) in found.into_iter().zip([peaks.needle_m_per_n, peaks.hand_m_per_n]) {
                assert!(found <= bound, "{given:?}: {found} beyond {bound}");
                // The adversary is no weakling: events interrupt the motion without them.
                assert!(found > 0.5 * peaks.found_m_per_n[0].min(peaks.found_m_per_n[1]), "{given:?}: {found}");
            }
        }
    }

    #[test]
    fn a_certificate_with_a_changed_map_is_not_verified() {
        let peaks = Peaks::of(&settings(&[], (0.0, 600.0), 5.0)).expect("analysed").expect("certified");
        let mut changed = peaks.certificate;
        let map = changed.maps.iter_mut().find(|map| map.name == "teleoperation_1").expect("there");
        map.matrix[(0, 0)] *= 1.05;
        assert!(changed.verify().is_err());
    }
}
