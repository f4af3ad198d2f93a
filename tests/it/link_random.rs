//! A thousand random links, each with an insertion and a rupture: all values are finite, a frozen slave stays in
//! place, and the return to the hand respects its speed limit.

use std::fmt::Write as _;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use trocar::engine::{COLUMNS, Trace};
use trocar::metrics::Outcome;
use trocar::run::run;
use trocar::scenario::{Scenario, Source};
use trocar::teleoperation::{ControllerKind, Recovery, Scheme};

const LINKS: usize = 1000;
const TICK_S: f64 = 1e-3;
const TELEOPERATION: u8 = 0;
const FROZEN: u8 = 1;

struct Random(ChaCha8Rng);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * ((self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64)
    }
    fn one<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.between(0.0, of.len() as f64) as usize]
    }
    /// Returns 0 with a probability of 1/4, otherwise a number up to `max`.
    fn up_to(&mut self, max: f64) -> f64 {
        self.one(&[0.0, 1.0, 1.0, 1.0]) * self.between(0.0, max)
    }
}

/// Returns an insertion at 15 mm/s into a spring of 300 N/m that loses 70 % of its force at `rupture_s`.
fn insertion(rupture_s: f64) -> String {
    let mut text = String::from("time_s,position_m,velocity_m_per_s,force_n\n");
    for tick in 0..=1500 {
        let time_s = f64::from(tick) * TICK_S;
        let lost_n = if time_s > rupture_s { 0.7 * 4.5 * rupture_s } else { 0.0 };
        writeln!(text, "{time_s:.3},{},0.015,{}", 0.015 * time_s, 4.5 * time_s - lost_n).expect("written");
    }
    text
}

/// Returns a delay trace and the range of its delays in ticks. The delays are a random walk from 0 to 200 ms, and one
/// sample in ten is lost.
fn logged_delays(random: &mut Random) -> (String, RangeInclusive<u64>) {
    let mut text = String::from("time_s,forward_delay_s,backward_delay_s\n");
    let (mut delay_s, mut min, mut max) = (random.between(0.0, 0.2), u64::MAX, 0);
    for row in 0..150 {
        delay_s = (delay_s + random.between(-0.03, 0.03)).clamp(0.0, 0.2);
        let forward = if row > 0 && random.one(&[true, false, false, false, false, false, false, false, false, false]) {
            "lost".to_owned()
        } else {
            let ticks = (delay_s / TICK_S).round() as u64;
            (min, max) = (min.min(ticks), max.max(ticks));
            delay_s.to_string()
        };
        writeln!(text, "{},{forward},{}", f64::from(row) * 0.01, 0.2 - delay_s).expect("written");
    }
    (text, min..=max)
}

/// The files of the random scenarios.
struct Tables {
    folder: tempfile::TempDir,
    /// The range of the forward delay of each trace, in ticks.
    logged: Vec<RangeInclusive<u64>>,
}

impl Tables {
    const RUPTURES_S: [f64; 3] = [0.45, 0.7, 0.9];

    fn write(random: &mut Random) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let write = |name: String, text: String| std::fs::write(folder.path().join(name), text).expect("written");
        for (index, rupture_s) in Self::RUPTURES_S.into_iter().enumerate() {
            write(format!("insertion_{index}.csv"), insertion(rupture_s));
        }
        let mut logged = vec![];
        for index in 0..8 {
            let (text, ticks) = logged_delays(random);
            write(format!("delays_{index}.csv"), text);
            logged.push(ticks);
        }
        Self { folder, logged }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }
}

/// A random link: its settings, and the range of its logged delays before jitter if it has a delay trace.
struct RandomLink {
    settings: Vec<String>,
    logged: Option<RangeInclusive<u64>>,
}

fn draw(random: &mut Random, tables: &Tables) -> RandomLink {
    let mut settings = vec![];
    let mut set = |key: &str, value: &dyn std::fmt::Display| settings.push(format!("{key}={value}"));
    let file = |path: &Path| format!("{:?}", path.display().to_string());

    set("simulation.duration_s", &1.5);
    set("simulation.seed", &random.one(&[1, 2, 3, 4, 5]));
    set("simulation.control", &random.one(&["continuous", "continuous", "sampled"]));
    let index = random.one(&[0, 1, 2]);
    set("recording.file", &file(&tables.path(&format!("insertion_{index}.csv"))));
    set("recording.ruptures_s", &format!("[{}]", Tables::RUPTURES_S[index]));
    if random.one(&[true, false, false]) {
        // A tissue that depends on the position of the needle.
        set("operator.kind", &"ramp");
        set("operator.start_m", &-0.002);
        set("operator.end_m", &0.05);
        set("operator.speed_m_per_s", &random.between(0.02, 0.06));
        set("tissue.kind", &"layers");
        set("tissue.layer.skin.rupture_force_n", &2.0);
    }

    // On one link in three, the trace shows the return to the hand.
    let plain = random.one(&[true, false, false]);
    let kinds = ["position-force", "position-force", "local-force", "position-position", "four-channel"];
    let kind = if plain { "position-force" } else { random.one(&kinds) };
    let mut schemes = vec!["none", "none", "time-domain", "energy-tank"];
    if matches!(kind, "position-force" | "local-force") {
        schemes.push("wave-variables");
    }
    set("controller.kind", &kind);
    set("passivity.scheme", &if plain { "none" } else { random.one(&schemes) });

    let mut logged = None;
    if random.one(&[true, false, false, false, false]) {
        let index = random.one(&[0, 1, 2, 3, 4, 5, 6, 7]);
        set("channel.delays_file", &file(&tables.path(&format!("delays_{index}.csv"))));
        logged = Some(tables.logged[index].clone());
    } else {
        set("channel.forward_delay_s", &random.up_to(0.2));
        set("channel.backward_delay_s", &random.up_to(0.2));
    }
    let mut outages: Vec<f64> = (0..2 * random.one(&[0, 1, 1, 2, 3])).map(|_| random.between(0.0, 1.4)).collect();
    outages.sort_by(f64::total_cmp);
    if let Some(first) = outages.first_mut() {
        // Some links have an outage from the start.
        *first *= random.one(&[0.0, 1.0, 1.0]);
    }
    set("channel.outages_s", &format!("{outages:?}"));
    set("channel.jitter_s", &random.up_to(0.2));
    set("channel.loss", &random.up_to(0.5));
    set("channel.outage_s", &random.between(0.005, 0.15));
    let recovery = if plain { "ramp" } else { random.one(&["ramp", "hold", "give-up"]) };
    set("channel.recovery", &recovery);
    let speed_m_per_s = random.between(0.005, 0.1);
    if recovery == "ramp" {
        set("channel.recovery_speed_m_per_s", &speed_m_per_s);
    }

    set("augmentation.min_hold_s", &0.1);
    set("augmentation.max_hold_s", &0.3);
    set("augmentation.freeze", &random.one(&["measured", "reference"]));
    set("augmentation.reengage", &random.one(&["ramp", "fade", "when-still", "clutch", "snap"]));
    set("augmentation.force_law", &random.one(&["decay", "amplify"]));
    RandomLink { settings, logged }
}

/// Returns true if the slave is frozen at any tick. Returns an error if the reference changes, by any bit, between
/// two ticks with a frozen slave.
fn stays_while_frozen(trace: &Trace) -> Result<bool, String> {
    let frozen = |tick: usize| trace.mode[tick] == FROZEN;
    for tick in 1..trace.len() {
        let (before, now) = (trace.slave_reference_m[tick - 1], trace.slave_reference_m[tick]);
        if frozen(tick - 1) && frozen(tick) && before.to_bits() != now.to_bits() {
            return Err(format!("frozen, it moves from {before} to {now} at tick {tick}"));
        }
    }
    Ok((0..trace.len()).any(frozen))
}

/// Checks that the reference returns to the hand within its speed limit after an outage. Returns the number of
/// checked outages. The return ends when the reference equals, bit for bit, a position of the hand sent after the
/// outage.
fn comes_back_slowly(scenario: &Scenario, trace: &Trace, ticks: &RangeInclusive<u64>) -> Result<usize, String> {
    let numbers = scenario.values();
    let number = |key: &str| match numbers.get(key) {
        Some(trocar::scenario::Value::Number(value)) => *value,
        other => panic!("{key}: {other:?}"),
    };
    let Some(trocar::scenario::Value::Numbers(outages_s)) = numbers.get("channel.outages_s") else { panic!("a list") };
    let jitter = (number("channel.jitter_s") / TICK_S).round() as usize;
    let (min, max) = (*ticks.start() as usize, *ticks.end() as usize + jitter);
    let outage = (number("channel.outage_s") / TICK_S).round() as usize;
    let step_m = number("channel.recovery_speed_m_per_s") * TICK_S;
    let (hand, reference) = (&trace.master_position_m, &trace.slave_reference_m);

    let mut seen = 0;
    for pair in outages_s.chunks(2) {
        let tick = |time_s: f64| (time_s / TICK_S).ceil() as usize;
        let (begin, end) = (tick(pair[0]), tick(pair[1]));
        // Samples sent before the outage arrive until `begin + max`, and samples sent after it arrive from `end +
        // min` on.
        if end + min <= begin + max + outage {
            continue;
        }
        let undisturbed = |tick: &usize| trace.mode[*tick] == TELEOPERATION;
        if (0..end + min).any(|tick| tick >= trace.len() || !undisturbed(&tick)) {
            continue;
        }
        for now in (end + min..trace.len()).take_while(undisturbed) {
            let moved_m = (reference[now] - reference[now - 1]).abs();
            if moved_m > step_m * (1.0 + 1e-9) + 1e-15 {
                return Err(format!(
                    "after the outage to {} s it moves {moved_m} m at tick {now}, {step_m} m allowed",
                    pair[1]
                ));
            }
            let sent = hand.get(end..=now - min).unwrap_or_default();
            if sent.iter().any(|position| position.to_bits() == reference[now].to_bits()) {
                break;
            }
        }
        seen += 1;
    }
    Ok(seen)
}

#[test]
#[ignore = "more than 5 s of processor time"]
fn a_thousand_links_give_finite_values_hold_a_frozen_slave_and_return_slowly() {
    let mut random = Random(ChaCha8Rng::seed_from_u64(4));
    let tables = Tables::write(&mut random);
    let (mut frozen, mut diverged, mut recoveries) = (0, 0, 0);
    for link in 0..LINKS {
        let RandomLink { settings, logged } = draw(&mut random, &tables);
        let about = || format!("link {link}:\n  {}", settings.join("\n  "));
        let scenario = Scenario::load(&Source::parse("builtin:paper/augmented.toml"), &settings);
        let scenario = scenario.unwrap_or_else(|error| panic!("{error:?}\n{}", about()));
        let run = run(scenario).unwrap_or_else(|error| panic!("{error}\n{}", about()));
        let (scenario, trace) = (&run.scenario, &run.trace);
        for (name, column) in COLUMNS.iter().zip(trace.numbers()) {
            let odd = column.iter().position(|value| !value.is_finite());
            assert!(odd.is_none(), "{name} is no number at tick {odd:?}, {}", about());
        }
        diverged += usize::from(run.metrics.outcome != Outcome::Completed);
        // With a passivity scheme, a slave that was held back catches up with the position at which it is frozen.
        if scenario.link.passivity.scheme == Scheme::None {
            frozen += usize::from(stays_while_frozen(trace).unwrap_or_else(|error| panic!("{error}, {}", about())));
        }
        let LinkKind { plain, ramps } = LinkKind::of(scenario);
        if plain && ramps {
            let ticks = logged.unwrap_or(scenario.forward.whole..=scenario.forward.whole);
            let seen = comes_back_slowly(scenario, trace, &ticks);
            recoveries += seen.unwrap_or_else(|error| panic!("{error}, {}", about()));
        }
    }
    println!("{frozen} frozen, {diverged} diverged, {recoveries} recoveries seen");
    assert!(frozen >= LINKS / 4, "only {frozen} have an event to freeze at");
    assert!(recoveries >= LINKS / 20, "only {recoveries} recoveries were checked");
}

/// The properties that determine whether the trace shows the return.
struct LinkKind {
    /// True if the reference is the received position of the hand.
    plain: bool,
    ramps: bool,
}

impl LinkKind {
    fn of(scenario: &Scenario) -> Self {
        let link = &scenario.link;
        Self {
            plain: link.controller.kind == ControllerKind::PositionForce && link.passivity.scheme == Scheme::None,
            ramps: link.recovery.policy == Recovery::Ramp,
        }
    }
}
