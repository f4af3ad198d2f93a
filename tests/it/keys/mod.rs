//! Every key of the schema has an effect for every kind of every choice, or is declared to have an effect for others
//! only.
//!
//! A pair is a key and a kind of a choice, or a position of a switch, of any section. The key has an effect if
//! another value of the key changes an output in one of the scenarios.

mod outputs;
mod scenarios;
mod trials;

use std::collections::BTreeMap;

use rayon::prelude::*;
use trocar::scenario::{KEYS, Key, KeyAt, Kind, find_key};
use trocar::tissue::LAYER_KEYS;

use scenarios::Scenarios;
use trials::trial_values;

/// A kind of a choice, or a position of a switch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Chosen {
    key: &'static str,
    word: &'static str,
}

/// The effect of a key for a kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Effect {
    /// An output changes in a scenario.
    Acts,
    Nothing,
    /// Each other value is an error that names a remedy.
    Refused,
    /// The kind excludes the kinds that the key needs.
    Excluded,
}

const GENERAL: &[&str] = &["mass-damper", "transfer-function", "state-space"];

const SCHEMES: &[&str] = &["wave-variables", "time-domain", "energy-tank"];

/// Keys, each with a choice and its kinds.
type OfKinds = &'static [(&'static str, &'static str, &'static [&'static str])];

/// Keys whose other values are errors for some kinds of a choice, because key and kind exclude each other.
const REFUSED: OfKinds = &[
    ("actuator.", "simulation.control", &["continuous"]),
    ("master.coupling", "controller.kind", &["local-force", "position-position", "four-channel"]),
    ("controller.kind", "master.coupling", &["as-printed"]),
    ("slave.damping", "controller.kind", &["four-channel"]),
    // Four channels and the passivity schemes compute with the appendix' machines.
    ("master.model", "controller.kind", &["four-channel"]),
    ("slave.model", "controller.kind", &["four-channel"]),
    ("slave.controller", "controller.kind", &["four-channel"]),
    ("master.model", "passivity.scheme", SCHEMES),
    ("slave.model", "passivity.scheme", SCHEMES),
    ("slave.controller", "passivity.scheme", SCHEMES),
    ("passivity.scheme", "master.model", GENERAL),
    ("passivity.scheme", "slave.model", GENERAL),
    ("passivity.scheme", "slave.controller", &["pid"]),
    ("actuator.slave_lag_s", "master.model", GENERAL),
    ("actuator.slave_lag_s", "slave.model", GENERAL),
    ("actuator.slave_lag_s", "slave.controller", &["pid"]),
    ("actuator.master_lag_s", "master.model", GENERAL),
    // The passivity schemes presume sides that start and move together.
    ("slave.start_m", "passivity.scheme", SCHEMES),
    ("operator.clutch_s", "passivity.scheme", SCHEMES),
];

/// Keys that are accepted without effect. Some settings of the decision make no difference in such short runs. A
/// sensor at the tip has no effect if the needle's shaft has no friction, but is accepted so that `strategies` has
/// the same strategies for every tissue.
const ACCEPTED: OfKinds = &[
    ("perception.lapse_rate", "operator.kind", &["recording", "ramp"]),
    ("perception.memory_s", "master.coupling", &["as-printed"]),
    // Beside a general master both controllers run on the tick anyway.
    ("simulation.control", "master.model", GENERAL),
    // Only `[perception]` feels it.
    ("augmentation.cue", "perception.kind", &["none"]),
    // On a rig only.
    ("safety.force_limit_n", "safety.acts", &["on-rigs"]),
    ("safety.force_rate_n_per_s", "safety.acts", &["on-rigs"]),
    ("safety.reference_speed_m_per_s", "safety.acts", &["on-rigs"]),
    ("safety.lead_m", "safety.acts", &["on-rigs"]),
    ("sensor.at_tip", "tissue.kind", &["recording", "kelvin-voigt", "hunt-crossley", "generalised"]),
];

/// The limits on a recording, whose only effect is to refuse it. Without its first line the recording has no names.
const LIMITS: [&str; 4] =
    ["recording.max_gap_s", "recording.max_bytes", "recording.max_samples", "recording.skip_lines"];

/// The keys of the safety stage that also act in the simulation. The others, and those of `rig.`, act on a rig only;
/// the tests of the rig cover them.
const SIMULATED: [&str; 5] = [
    "safety.acts",
    "safety.force_limit_n",
    "safety.force_rate_n_per_s",
    "safety.reference_speed_m_per_s",
    "safety.lead_m",
];

fn is_of_rigs(key: &Key) -> bool {
    key.path.starts_with("rig.") || (key.path.starts_with("safety.") && !SIMULATED.contains(&key.path))
}

/// The key of the engine, which affects only the plants.
const ENGINE: &str = "simulation.engine";

/// Returns true if a key affects the plants, which the engine steps.
fn is_of_plants(key: &Key) -> bool {
    ["simulation.", "master.", "arm.", "slave.", "actuator."].iter().any(|section| key.path.starts_with(section))
}

/// Returns the kinds of all choices except the key itself. The kinds of the engine, one of which is slow, are tried
/// only with keys of the plants.
fn kinds(key: &KeyAt) -> impl Iterator<Item = Chosen> {
    let words = |choice: &'static Key| match choice.kind {
        Kind::Choice(words) => words,
        Kind::Flag => &["true", "false"],
        _ => &[],
    };
    let are_tried = move |one: &Key, other: &Key| one.path != ENGINE || is_of_plants(other);
    let key = key.key;
    let others = KEYS.iter().filter(|choice| choice.path != key.path && !is_of_rigs(choice));
    let others = others.filter(move |choice| are_tried(key, choice) && are_tried(choice, key));
    others.flat_map(move |choice| words(choice).iter().map(|word| Chosen { key: choice.path, word }))
}

/// Returns the effects of a key for all kinds, each with true if the key is declared to have an effect.
fn effects(key: &KeyAt, scenarios: &Scenarios) -> Vec<(Chosen, bool, Effect)> {
    // The scenario that showed the effect for one kind usually shows it for the next.
    let mut first = (0, String::new());
    kinds(key)
        .map(|chosen| {
            let mut effect = Effect::Excluded;
            let mut order: Vec<usize> = (0..scenarios.all.len()).collect();
            order.sort_by_key(|index| *index != first.0);
            for index in order {
                let base = &scenarios.all[index];
                let settings = base.settings_for(key, chosen);
                let Some(before) = base.outputs(&settings) else { continue };
                effect = effect.min(Effect::Refused);
                let mut values = trial_values(key, before.value(&key.path), scenarios);
                values.sort_by_key(|value| *value != first.1);
                for value in values {
                    let changed = [settings.as_slice(), &[format!("{}={value}", key.path)]].concat();
                    let acts = match base.changed(&changed) {
                        Some(after) => before.differ(&after),
                        None if LIMITS.contains(&&*key.path) => true,
                        None => continue,
                    };
                    effect = effect.min(Effect::Nothing);
                    if acts {
                        first = (index, value);
                        return (chosen, scenarios.is_declared(key, chosen), Effect::Acts);
                    }
                }
            }
            (chosen, scenarios.is_declared(key, chosen), effect)
        })
        .collect()
}

#[test]
#[ignore = "minutes of processor time: about 20,000 scenarios"]
fn every_key_has_an_effect_for_every_kind_or_is_declared_without_effect() {
    let scenarios = Scenarios::new();
    let of_layer = LAYER_KEYS.iter().filter_map(|key| find_key(&key.path.replace('*', "skin")));
    let simulated = KEYS.iter().filter(|key| !is_of_rigs(key));
    let keys: Vec<KeyAt> = simulated.map(KeyAt::from).chain(of_layer).collect();
    let all: Vec<_> = keys.par_iter().map(|key| (key, effects(key, &scenarios))).collect();
    let mut counts = BTreeMap::<(bool, Effect), usize>::new();
    let mut wrong = vec![];
    for (key, effects) in &all {
        assert!(effects.iter().any(|(.., effect)| *effect == Effect::Acts), "{} never acts", key.path);
        for (chosen, declared, effect) in effects {
            *counts.entry((*declared, *effect)).or_default() += 1;
            let is_chosen = |choice: &str, words: &[&str]| chosen.key == choice && words.contains(&chosen.word);
            let is_refused =
                REFUSED.iter().any(|(path, choice, words)| key.path.starts_with(path) && is_chosen(choice, words));
            let is_known = ACCEPTED.iter().any(|(path, choice, words)| key.path == *path && is_chosen(choice, words));
            let is_right = match effect {
                Effect::Nothing if is_known => true,
                Effect::Acts => *declared,
                Effect::Nothing => !declared,
                Effect::Refused => is_refused,
                Effect::Excluded => key.acts_for.is_some(),
            };
            if !is_right {
                let declaration = if *declared { "is declared to act" } else { "is declared to have no effect" };
                wrong.push(format!("{} {declaration} for {} = {}: {effect:?}", key.path, chosen.key, chosen.word));
            }
        }
    }
    println!("{} keys, {counts:?}", keys.len());
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
#[ignore = "minutes of processor time: about 20,000 scenarios"]
fn the_echo_of_every_kind_can_be_loaded() {
    let scenarios = Scenarios::new();
    let name = find_key("name").expect("a key");
    let echoed = scenarios.all.par_iter().map(|base| kinds(&name).filter(|chosen| base.is_echoed(*chosen)).count());
    assert!(echoed.sum::<usize>() > 500);
}
