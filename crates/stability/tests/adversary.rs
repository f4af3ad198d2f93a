//! The bounds of the certificate of events compared with motions that a greedy adversary finds.

use trocar_scenario::{Scenario, Source};
use trocar_stability::{LinearLoop, Peaks, SwitchingSettings, TissueRange, adversary};

fn settings(given: &[&str], stiffness_n_per_m: (f64, f64), most_n_s_per_m: f64) -> SwitchingSettings {
    let given: Vec<String> = given.iter().map(|&one| one.to_owned()).collect();
    let scenario = Scenario::load(&Source::parse("builtin:paper/augmented.toml"), &given).expect("loads");
    let of_loop = LinearLoop::of(&scenario, TissueRange::spring(stiffness_n_per_m.1, 0.0)).expect("analysed");
    let settings = SwitchingSettings::of(&scenario, of_loop, stiffness_n_per_m).expect("covered");
    SwitchingSettings { damping_n_s_per_m: (0.0, most_n_s_per_m), ..settings }
}

#[test]
#[ignore = "two minutes of processor time: certificates"]
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
        assert!(peaks.certificate.verify(&settings).is_ok(), "{given:?}");
        let found = adversary(&settings, (6, 3), 1).expect("analysed");
        for (found, bound) in found.into_iter().zip([peaks.needle_m_per_n, peaks.hand_m_per_n]) {
            assert!(found <= bound, "{given:?}: {found} beyond {bound}");
            // The adversary is no weakling: events interrupt the motion without them.
            assert!(found > 0.5 * peaks.found_m_per_n[0].min(peaks.found_m_per_n[1]), "{given:?}: {found}");
        }
    }
}
