//! The true certificate is verified, and forged ones are refused.

use std::sync::LazyLock;

use serde_json::{Value as Json, json};

use super::*;
use crate::stability_check::linear_loop;
use trocar_scenario::Source;
use trocar_stability::Switching;

const SCENARIO: &str = "strategies/snap";
/// Short freezes, with few powers.
const SHORT: [&str; 2] = ["augmentation.min_hold_s=0.05", "augmentation.max_hold_s=0.08"];
const NAMES: [&str; 3] = ["shortest_dwell", "growth_at_refractory", "statement"];

fn scenario(settings: &[&str]) -> Scenario {
    let settings: Vec<String> = SHORT.iter().chain(settings).map(|&setting| setting.to_owned()).collect();
    Scenario::load(&Source::parse(SCENARIO), &settings).expect("loads")
}

/// The content of the true file, for a wider range of the tissue than the scenario's.
static TRUE: LazyLock<Json> = LazyLock::new(|| {
    let scenario = scenario(&[]);
    let settings = SwitchingSettings::of(&scenario, linear_loop(&scenario).expect("a loop"), (0.0, 1000.0));
    let switching = Switching::of(&settings.expect("covered")).expect("analysed");
    serde_json::to_value(CertificateFile::of(&switching).expect("certified")).expect("JSON")
});

fn refusal(file: &Json, settings: &[&str]) -> String {
    match verify(&file.to_string(), &scenario(settings)) {
        Ok(_) => "verified".to_owned(),
        Err(error) => error.to_string(),
    }
}

/// Multiplies a number, or every number of a list of lists.
fn multiply(value: &mut Json, factor: f64) {
    match value {
        Json::Array(all) => all.iter_mut().for_each(|value| multiply(value, factor)),
        value => *value = json!(value.as_f64().expect("a number") * factor),
    }
}

fn remove(list: &mut Json, index: usize) {
    list.as_array_mut().expect("a list").remove(index);
}

/// The index of the first entry of a list that has a name or a part.
fn place(list: &Json, is: impl Fn(&Json) -> bool) -> usize {
    list.as_array().expect("a list").iter().position(is).expect("an entry")
}

type Forge = fn(&mut Json);

/// Changes of a certificate, with a part of the reason of the refusal.
const FORGERIES: &[(&str, Forge)] = &[
    ("is missing", |one| one["inequalities"].as_array_mut().expect("a list").truncate(1)),
    ("is missing", |one| one["inequalities"] = json!([])),
    ("inequality 2 is not", |one| remove(&mut one["inequalities"], 2)),
    ("inequality 1 is not", |one| {
        let same = one["inequalities"][0].clone();
        one["inequalities"][1] = same;
    }),
    ("is not one of", |one| {
        let more = one["inequalities"][0].clone();
        one["inequalities"].as_array_mut().expect("a list").push(more);
    }),
    ("is not the scenario's teleoperation_0", |one| {
        let at = place(&one["maps"], |map| map["name"] == "teleoperation_0");
        multiply(&mut one["maps"][at]["matrix"], 0.99);
    }),
    ("is not the scenario's entry_1", |one| {
        let other = one["maps"][place(&one["maps"], |map| map["name"] == "entry_0")]["matrix"].clone();
        let at = place(&one["maps"], |map| map["name"] == "entry_1");
        one["maps"][at]["matrix"] = other;
    }),
    ("is not the scenario's", |one| multiply(&mut one["inequalities"][9]["terms"][0]["factor"], 1.001)),
    ("is not the scenario's", |one| remove(&mut one["inequalities"][9]["terms"], 1)),
    ("is not the scenario's entering", |one| {
        let at = place(&one["inequalities"], |inequality| inequality["powers"].is_array());
        one["inequalities"][at]["powers"][1] = one["inequalities"][at]["powers"][0].clone();
    }),
    ("is not the scenario's entering", |one| {
        let at = place(&one["inequalities"], |inequality| inequality["powers"].is_array());
        one["inequalities"][at]["powers"] = json!([0, u64::MAX]);
    }),
    ("is not verified", |one| multiply(&mut one["functions"][1]["p"], 1e-3)),
    ("is not verified", |one| multiply(&mut one["functions"][0]["p"], -1.0)),
    ("is not verified", |one| multiply(&mut one["functions"][0]["p"], 0.0)),
    ("is not verified", |one| multiply(&mut one["functions"][0]["p"], 1e300)),
    ("is not the scenario's", |one| multiply(&mut one["choice"]["contraction"], 0.99)),
    ("outside its range", |one| one["choice"]["contraction"] = json!(1.5)),
    ("outside its range", |one| one["choice"]["contraction"] = json!(0.0)),
    ("outside its range", |one| one["choice"]["dwell_ticks"] = json!(0)),
    ("choice.dwell_ticks", |one| one["choice"]["dwell_ticks"] = json!(u64::MAX)),
    ("is not the scenario's", |one| one["choice"]["rate_per_s"] = json!(1e-3)),
    ("outside its range", |one| one["choice"]["rate_per_s"] = json!(-1.0)),
    ("outside its range", |one| one["choice"]["hold_s"] = json!(0.0)),
    ("outside its range", |one| one["choice"]["pieces"] = json!(0)),
    ("outside its range", |one| one["choice"]["pieces"] = json!(u64::MAX)),
    ("another certificate", |one| {
        one["choice"]["is_driven"] = json!(!one["choice"]["is_driven"].as_bool().expect("a truth"));
    }),
    ("is not the scenario's", |one| one["functions"][0]["name"] = json!("other")),
    ("is not the scenario's", |one| remove(&mut one["functions"], 0)),
    ("is missing", |one| one["functions"] = json!([])),
    ("is missing", |one| one["maps"] = json!([])),
    ("is not the scenario's", |one| one["functions"][0]["space"] = json!("Nowhere")),
    ("is not the scenario's", |one| one["spaces"]["Loop"]["states"][0]["unit"] = json!("mm")),
    ("is not the scenario's", |one| {
        let space = one["spaces"].as_object_mut().expect("spaces").remove("Loop").expect("a space");
        one["spaces"]["Loop2"] = space;
    }),
    ("is not the scenario's", |one| one["inequalities"][3]["terms"][0]["function"] = json!(u32::MAX)),
    ("is not the scenario's", |one| one["inequalities"][3]["terms"][0]["maps"][0]["map"] = json!(u32::MAX)),
    ("at_events", |one| one["at_events"] = json!(1000)),
    ("not a symmetric matrix", |one| multiply(&mut one["functions"][0]["p"][0][1], 2.0)),
    ("not a symmetric matrix", |one| one["functions"][0]["p"] = json!([[1.0]])),
    ("not a symmetric matrix", |one| one["functions"][0]["p"] = json!([])),
    ("not a symmetric matrix", |one| one["functions"][0]["p"] = json!([vec![0.5; 100_000]])),
    ("not a lower triangular matrix", |one| one["spaces"]["Loop"]["scale"][0][1] = json!(1.0)),
    ("not a lower triangular matrix", |one| one["spaces"]["Loop"]["scale"][0][0] = json!(0.0)),
    ("not a lower triangular matrix", |one| one["spaces"]["Loop"]["scale"] = json!([[1.0]])),
    ("is not verified", |one| multiply(&mut one["spaces"]["Loop"]["scale"], 1e-300)),
    ("not a certificate file", |one| one["functions"][0]["p"][0] = json!([])),
    ("not a certificate file", |one| one["functions"][0]["p"][0][0] = Json::Null),
    ("not a certificate file", |one| one["dwell_s"] = json!(0.001)),
    ("not a certificate file", |one| one["at_events"] = json!(-1)),
];

/// Settings of another scenario, with a part of the reason of the refusal.
const OTHERS: &[(&str, &str)] = &[
    ("scaling.force=2", "is not the scenario's entry_1"),
    ("slave.velocity_gain=200", "is not the scenario's frozen"),
    ("channel.delay_s=0.002", "delay_ticks is 0, and the scenario's is 4"),
    ("simulation.tick_s=0.002", "tick_s is 0.001, and the scenario's is 0.002"),
    ("augmentation.max_hold_s=0.2", "is not the scenario's entering"),
    ("augmentation.min_hold_s=0.06", "is not the scenario's entering"),
    ("augmentation.blend_s=0.3", "is not the scenario's cross_fade"),
    ("augmentation.refractory_s=0.05", "choice.dwell_ticks is 200, and the scenario enforces 50"),
    ("augmentation.reengage=ramp", "space 3 is not the scenario's Gap"),
    ("augmentation.reengage=clutch", "a gap that is kept"),
    ("augmentation.decay_time_constant_s=0.5", "is not the scenario's frozen"),
    ("augmentation.force_law=amplify", "is not the scenario's Frozen"),
    ("controller.kind=position-position", "is not the scenario's"),
    ("channel.delay_s=0.1", "the scenario has no certificates: the certificate covers delays of up to 24 ticks"),
    ("tissue.shaft_damping_n_s_per_m2=100", "damping_n_s_per_m is 0 to 11.37, and the scenario's is 0 to 18.30"),
    ("tissue.shaft_stiffness_n_per_m=2000", "stiffness_n_per_m is 0 to 1000, and the scenario's is"),
];

#[test]
fn the_true_certificate_is_verified() {
    let verified = verify(&TRUE.to_string(), &scenario(&[])).expect("verified");
    assert_eq!(verified.iter().map(|one| one.name).collect::<Vec<_>>(), NAMES);
    assert!(verified.iter().all(|one| one.conditions > 50 && one.claim.contains("N/m")), "{verified:?}");
    // A change of a part that is not in the loop, and a longer refractory time.
    for setting in ["detector.threshold=3", "augmentation.refractory_s=0.5"] {
        assert_eq!(refusal(&TRUE, &[setting]), "verified", "{setting}");
    }
}

#[test]
#[ignore = "more than 5 s of processor time"]
fn forged_certificates_are_refused() {
    for name in NAMES {
        for (index, (phrase, forge)) in FORGERIES.iter().enumerate() {
            let mut file = TRUE.clone();
            forge(&mut file["certificates"][name]);
            let refusal = refusal(&file, &[]);
            assert!(refusal.contains(phrase), "{name}, forgery {index}: {phrase:?} is not in {refusal}");
        }
    }
}

#[test]
fn smaller_bounds_are_refused_even_with_maps_that_fit() {
    let mut file = TRUE.clone();
    let one = &mut file["certificates"]["statement"];
    multiply(&mut one["choice"]["bounds_m_per_n"], 0.5);
    let quantities = place(&one["maps"], |map| map["name"] == "quantity_0");
    assert!(refusal(&file, &[]).contains(&format!("map {quantities} is not the scenario's quantity_0")));
    for map in file["certificates"]["statement"]["maps"].as_array_mut().expect("maps") {
        if map["name"].as_str().is_some_and(|name| name.starts_with("quantity")) {
            multiply(&mut map["matrix"], 2.0);
        }
    }
    assert!(refusal(&file, &[]).contains("is not verified"));
}

#[test]
fn a_wider_range_of_the_tissue_is_refused() {
    for (low, high) in [(0.0, 1e9), (0.0, 1100.0), (600.0, 50.0), (1e3, 1e4), (-1.0, 1e3)] {
        let mut file = TRUE.clone();
        file["stiffness_n_per_m"] = json!([low, high]);
        let refusal = refusal(&file, &[]);
        assert!(refusal.contains("stiffness_n_per_m") || refusal.contains("is not the scenario's"), "{refusal}");
    }
    for damping in [json!([0.0, 1e9]), json!([1e3, 1e4]), json!([-1.0, 1e3])] {
        let mut file = TRUE.clone();
        file["damping_n_s_per_m"] = damping;
        let refusal = refusal(&file, &[]);
        assert!(refusal.contains("damping_n_s_per_m") || refusal.contains("is not the scenario's"), "{refusal}");
    }
}

#[test]
#[ignore = "more than 5 s of processor time"]
fn a_certificate_of_another_scenario_is_refused() {
    for (setting, phrase) in OTHERS {
        let refusal = refusal(&TRUE, &[setting]);
        assert!(refusal.contains(phrase), "{setting}: {phrase:?} is not in {refusal}");
    }
}

#[test]
fn a_text_without_certificates_is_refused() {
    let mut none = TRUE.clone();
    none["certificates"] = json!({});
    for text in ["", "{}", "[[[[", &"[".repeat(1_000_000), &none.to_string(), &TRUE.to_string().replace("0.5", "1e999")]
    {
        let refusal = verify(text, &scenario(&[]));
        assert!(matches!(refusal, Err(VerificationError::Form(_))), "{refusal:?}");
    }
}
