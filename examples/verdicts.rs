//! Counts wrong verdicts: random scenarios of 60 s, each analysed and run.
//!
//! ```text
//! cargo run --release --example verdicts -- 2000
//! cargo run --release --example verdicts -- map 200
//! cargo run --release --example verdicts -- delays 1000
//! ```
//! The first command counts the scenarios that `stability` calls stable or certified although the run oscillates or
//! diverges, and the runs that settle although they are called oscillating. This program judges independently whether
//! a run oscillates or settles: from its last 30 s, with another rule than `trocar`, on a copy without noise and
//! tremor, because a stable loop forgets its disturbances.
//!
//! Noise can cause repeated false alarms, so that the needle oscillates from one event to the next although the loop
//! is stable; such runs do not settle and are counted separately. Noise can also end an oscillation, for example if
//! it leaves the needle in softer tissue; such runs are not counted. The analysis takes nearly all of the time, so
//! only oscillating runs are analysed.
//!
//! `map` runs every point of two stability maps of 200 by 200 points. It counts the stable points that are called
//! oscillating or diverged, and the unstable points that are called completed.
//!
//! `delays` counts like the first command on loops with varying delays: with jitter, and with delays that jump
//! between the ends of the same range.

use std::process::ExitCode;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use trocar::channel::{Irregularity, Schedule};
use trocar::metrics::Outcome;
use trocar::run::{Run, run};
use trocar::scenario::{Scenario, Source};
use trocar::stability::{Axis, ClosedLoop, LeftOut, left_out, map};
use trocar::stability_check::{StabilityStudy, linear_loop};

/// Distance of a spectral radius from 1 below which a run is too short to show whether an oscillation grows or
/// decays.
const NEAR: f64 = 2e-4;

/// The behaviour of a run at its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Truth {
    /// The run diverged, or the amplitude of the last 10 s is above 0.1 mm and not smaller than in the 10 s before.
    Swings,
    /// The amplitude of the last 10 s is below 10 µm, or less than half of the amplitude in the 10 s before.
    Settles,
    /// Neither.
    Between,
}

/// The verdicts on one scenario.
#[derive(Debug, Clone)]
pub struct Judged {
    /// The drawn settings.
    pub settings: Vec<String>,
    /// True if the analysis calls the loop stable.
    pub is_stable: Option<bool>,
    /// True if the analysis calls the events certified.
    pub is_certified: Option<bool>,
    /// True if the run is called oscillating or diverged.
    pub is_called_unstable: bool,
    /// The behaviour without noise and tremor.
    pub truth: Truth,
    /// The behaviour with noise and tremor, if the run settles without them.
    pub with_events: Truth,
}

/// Draws the settings of a scenario.
fn drawn(random: &mut ChaCha8Rng) -> Vec<String> {
    let mut all = vec!["simulation.duration_s=60".to_owned()];
    let mut set = |key: &str, value: String| all.push(format!("{key}={value}"));
    macro_rules! log {
        ($low:expr, $high:expr) => {{
            let (low, high): (f64, f64) = ($low, $high);
            low * (high / low).powf(random.random::<f64>())
        }};
    }
    macro_rules! maybe {
        ($share:expr) => {
            random.random::<f64>() < $share
        };
    }
    macro_rules! one {
        ($words:expr) => {{
            let words = $words;
            words[random.random_range(0..words.len())]
        }};
    }
    let architecture = one!(["position-force", "position-force", "position-position", "local-force", "four-channel"]);
    set("controller.kind", architecture.into());
    set("simulation.control", one!(["continuous", "sampled"]).into());
    set("simulation.tick_s", one!(["0.0005", "0.001", "0.001", "0.002"]).into());
    set("simulation.seed", format!("{}", random.random_range(1..1000)));
    set("scaling.force", format!("{:.4}", log!(0.2, 6.0)));
    set("scaling.position", format!("{:.4}", log!(0.4, 2.0)));
    set("arm.grip", one!(["paper", "relaxed", "firm"]).into());
    if maybe!(0.4) {
        set("channel.forward_delay_s", format!("{:.4}", log!(1e-3, 0.2)));
        set("channel.backward_delay_s", format!("{:.4}", log!(1e-3, 0.2)));
    }
    if maybe!(0.1) {
        set("channel.jitter_s", format!("{:.4}", log!(1e-3, 0.03)));
    }
    if maybe!(0.1) {
        set("channel.loss", format!("{:.3}", random.random::<f64>() * 0.5));
    }
    if maybe!(0.15) && architecture == "position-force" {
        set("passivity.scheme", one!(["wave-variables", "time-domain", "energy-tank"]).into());
    }
    let kind = one!(["ramp", "minimum-jerk", "insertion-extraction"]);
    set("operator.kind", kind.into());
    set("operator.end_m", format!("{:.4}", log!(0.005, 0.04)));
    if kind == "ramp" {
        set("operator.speed_m_per_s", format!("{:.4}", log!(0.002, 0.1)));
    } else {
        set("operator.movement_s", format!("{:.2}", log!(0.5, 10.0)));
    }
    set("perception.reflex", if maybe!(0.2) { one!(["stop", "withdraw"]) } else { "none" }.into());
    if maybe!(0.2) {
        set("operator.tremor_amplitude_m", format!("{:.6}", log!(1e-5, 3e-4)));
    }
    let tissue = one!(["kelvin-voigt", "kelvin-voigt", "hunt-crossley", "layers", "layers"]);
    set("tissue.kind", tissue.into());
    match tissue {
        "kelvin-voigt" => {
            set("tissue.stiffness_n_per_m", format!("{:.2}", log!(20.0, 4000.0)));
            set("tissue.damping_n_s_per_m", format!("{:.3}", log!(0.1, 20.0)));
        }
        "layers" => {
            set("tissue.layer.skin.rupture_force_n", format!("{:.3}", log!(1.0, 12.0)));
            set("tissue.layer.skin.stiffening_n_per_m2", format!("{:.0}", log!(5e3, 2e5)));
        }
        _ => {}
    }
    if maybe!(0.3) {
        set("sensor.force_noise_std_n", format!("{:.4}", log!(1e-3, 0.1)));
    }
    if maybe!(0.1) {
        set("sensor.position_resolution_m", format!("{:e}", log!(1e-6, 1e-4)));
    }
    if maybe!(0.2) {
        set("sensor.force_bandwidth_hz", format!("{:.1}", log!(10.0, 300.0)));
    }
    set("augmentation.enabled", format!("{}", maybe!(0.5)));
    set("augmentation.reengage", one!(["ramp", "clutch", "snap"]).into());
    set("detector.threshold", format!("{:e}", log!(2e-3, 0.1)));
    all
}

/// Returns the larger peak-to-peak motion (m) of hand and needle between two times, in seconds of a run of 60 s.
fn swing_m(run: &Run, from: usize, to: usize) -> f64 {
    let ticks = run.trace.len();
    [&run.trace.slave_position_m, &run.trace.master_position_m]
        .map(|column| {
            let part = &column[ticks * from / 60..ticks * to / 60];
            let (low, high) = part.iter().fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(*x), high.max(*x)));
            high - low
        })
        .into_iter()
        .fold(0.0, f64::max)
}

fn truth(run: &Run) -> Truth {
    if matches!(run.metrics.outcome, Outcome::Diverged { .. }) {
        return Truth::Swings;
    }
    let (before_m, last_m) = (swing_m(run, 40, 50), swing_m(run, 50, 60));
    if last_m > 1e-4 && last_m >= 0.9 * before_m {
        Truth::Swings
    } else if last_m < 1e-5 || last_m < 0.5 * before_m {
        Truth::Settles
    } else {
        Truth::Between
    }
}

/// Judges a run with noise and tremor that settles without them, by comparison with the same run without
/// augmentation. The events make it oscillate if its amplitude is more than twice the amplitude that the noise
/// causes.
fn truth_with_events(run: &Run, plain: &Run) -> Truth {
    if swing_m(run, 50, 60) > 2.0 * swing_m(plain, 50, 60) { truth(run) } else { Truth::Settles }
}

/// Judges a run whose copy without noise and tremor oscillates. Events can leave the needle at a place where the loop
/// is stable.
fn truth_of_swinging(run: &Run, quiet: &Run) -> Truth {
    let diverged = |run: &Run| matches!(run.metrics.outcome, Outcome::Diverged { .. });
    let is_stilled = !diverged(quiet) && !diverged(run) && swing_m(run, 50, 60) < swing_m(quiet, 50, 60) / 3.0;
    if is_stilled { Truth::Between } else { truth(run) }
}

/// Draws the settings of a scenario in which only the delays vary.
fn drawn_with_jitter(random: &mut ChaCha8Rng) -> Vec<String> {
    let mut all = drawn(random);
    let jitter_s = 1e-3 * 50.0_f64.powf(random.random::<f64>());
    let only = [
        ("channel.jitter_s", format!("{jitter_s:.4}")),
        ("channel.loss", "0".to_owned()),
        ("passivity.scheme", "none".to_owned()),
        ("perception.reflex", "none".to_owned()),
        ("sensor.position_resolution_m", "0".to_owned()),
        ("augmentation.enabled", "false".to_owned()),
        ("augmentation.reengage", String::new()),
    ];
    all.retain(|setting| only.iter().all(|(key, _)| setting.split('=').next() != Some(key)));
    all.extend(only.iter().filter(|(_, value)| !value.is_empty()).map(|(key, value)| format!("{key}={value}")));
    all
}

/// Returns the scenario with delays that jump between the ends of its jitter, with a separate phase for each
/// direction.
fn jumping(scenario: &Scenario, random: &mut ChaCha8Rng) -> Scenario {
    let tick_s = scenario.grid.tick_s();
    let jitter = scenario.irregularity.jitter_ticks(tick_s) as u32;
    let period = (0.004 * 250.0_f64.powf(random.random::<f64>()) / tick_s) as usize;
    let mut delays = |least: u64| {
        let phase = random.random_range(0..period.max(1));
        let late = |tick: usize| (tick + phase) % period.max(1) < period / 2;
        let ticks = 0..scenario.grid.ticks() as usize;
        let delays = ticks.map(|tick| least as u32 + if late(tick) { jitter } else { 0 });
        Schedule::new(delays.collect(), std::sync::Arc::default())
    };
    let mut other = scenario.clone();
    other.irregularity = Irregularity::default();
    (other.forward_schedule, other.backward_schedule) =
        (delays(scenario.forward.whole), delays(scenario.backward.whole));
    other
}

/// Analyses and runs a random scenario with jitter and with jumping delays; `None` if the settings are refused.
fn judged_with_jitter(seed: u64) -> Option<Judged> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let settings = drawn_with_jitter(&mut random);
    let load = |settings: &[String]| Scenario::load(&Source::parse("hand/reflex"), settings);
    let scenario = load(&settings).ok()?;
    let axes = (Axis::parse("scaling.force=0.5:2:2").ok()?, Axis::parse("scaling.position=0.5:2:2").ok()?);
    let study = StabilityStudy::of(&scenario, axes, None).ok()?;
    let called = run(scenario).ok()?;
    let quiet =
        [&settings[..], &["sensor.force_noise_std_n=0".into(), "operator.tremor_amplitude_m=0".into()]].concat();
    let quiet = load(&quiet).ok()?;
    let jumps = truth(&run(jumping(&quiet, &mut random)).ok()?);
    let drawn = truth(&run(quiet).ok()?);
    Some(Judged {
        is_stable: study.verdict.is_stable(),
        is_certified: study.is_certified(),
        is_called_unstable: called.metrics.outcome != Outcome::Completed,
        truth: if drawn == Truth::Settles { jumps } else { drawn },
        with_events: Truth::Settles,
        settings,
    })
}

/// Runs a random scenario, and analyses it if it oscillates; `None` if the settings are refused.
fn judged(seed: u64) -> Option<Judged> {
    let settings = drawn(&mut ChaCha8Rng::seed_from_u64(seed));
    let load = |settings: &[String]| Scenario::load(&Source::parse("hand/reflex"), settings);
    let scenario = load(&settings).ok()?;
    let axes = (Axis::parse("scaling.force=0.5:2:2").ok()?, Axis::parse("scaling.position=0.5:2:2").ok()?);
    let called = run(scenario.clone()).ok()?;
    let with = |without: &str, more: &[&str]| {
        let kept = settings.iter().filter(|setting| !setting.starts_with(without)).cloned();
        let all: Vec<String> = kept.chain(more.iter().map(|&setting| setting.to_owned())).collect();
        run(load(&all).ok()?).ok()
    };
    let quiet_run = with("-", &["sensor.force_noise_std_n=0", "operator.tremor_amplitude_m=0"])?;
    let quiet = match truth(&quiet_run) {
        Truth::Swings => truth_of_swinging(&called, &quiet_run),
        other => other,
    };
    let is_augmented = settings.iter().any(|setting| setting == "augmentation.enabled=true");
    let with_events = if quiet == Truth::Settles && is_augmented {
        truth_with_events(&called, &with("augmentation", &["augmentation.enabled=false"])?)
    } else {
        Truth::Settles
    };
    // Both verdicts are unknown if the analysis leaves out anything other than varying delays.
    let varies = |part: &LeftOut| matches!(part.key, "channel.jitter_s" | "channel.delays_file");
    let study = if quiet == Truth::Swings && left_out(&scenario, None).iter().all(varies) {
        StabilityStudy::of(&scenario, axes, None).ok()
    } else {
        None
    };
    Some(Judged {
        is_stable: study.as_ref().and_then(|study| study.verdict.is_stable()),
        is_certified: study.as_ref().and_then(StabilityStudy::is_certified),
        is_called_unstable: called.metrics.outcome != Outcome::Completed,
        truth: quiet,
        with_events,
        settings,
    })
}

/// Returns the verdicts on `count` scenarios that can be run.
#[must_use]
pub fn verdicts(count: usize, judged: impl Fn(u64) -> Option<Judged> + Sync) -> Vec<Judged> {
    let mut all = vec![];
    let mut next = 0;
    while all.len() < count {
        let more = (next..next + 64).into_par_iter().filter_map(&judged);
        all.par_extend(more);
        next += 64;
    }
    all.truncate(count);
    all
}

/// Compares the outcomes of a map's points with the linear analysis. Prints the counts.
fn compare_map(count: usize, keys: [&str; 2], ranges: [&str; 2], settings: &[&str]) -> Option<()> {
    let base: Vec<String> = settings.iter().map(|&setting| setting.to_owned()).collect();
    let load = |settings: &[String]| Scenario::load(&Source::parse("paper/classical"), settings);
    let axis = |index: usize| Axis::parse(&format!("{}={}:{count}:log", keys[index], ranges[index])).ok();
    let (x, y) = (axis(0)?, axis(1)?);
    let map = map(&linear_loop(&load(&base).ok()?).ok()?, x, y).ok()?;
    let points: Vec<(bool, bool, f64)> = (0..count * count)
        .into_par_iter()
        .filter_map(|point| {
            let (column, row) = (point % count, point / count);
            let set =
                [(keys[0], x.value(column)), (keys[1], y.value(row))].map(|(key, value)| format!("{key}={value:?}"));
            let scenario = load(&[&base[..], &set].concat()).ok()?;
            let radius = ClosedLoop::new(&linear_loop(&scenario).ok()?).ok()?.dominant_mode().ok()?.spectral_radius;
            let outcome = run(scenario).ok()?.metrics.outcome;
            Some((map.is_stable(column, row), outcome == Outcome::Completed, radius))
        })
        .collect();
    let of = |is: &dyn Fn(&&(bool, bool, f64)) -> bool| points.iter().filter(is).count();
    let near = |radius: f64| (radius - 1.0).abs() < NEAR;
    println!("{} over {}: {} points, {} stable", keys[0], keys[1], points.len(), of(&|point| point.0));
    println!(
        "  stable and called oscillating or diverged: {}, of which {} within {NEAR} of a spectral radius of 1",
        of(&|point| point.0 && !point.1),
        of(&|point| point.0 && !point.1 && near(point.2)),
    );
    println!(
        "  unstable and called completed: {}, of which {} within {NEAR} of a spectral radius of 1",
        of(&|point| !point.0 && point.1),
        of(&|point| !point.0 && point.1 && near(point.2)),
    );
    Some(())
}

fn maps(count: usize) -> Option<()> {
    let contact = [
        "simulation.duration_s=30",
        "operator.kind=ramp",
        "operator.end_m=0.02",
        "operator.speed_m_per_s=0.02",
        "tissue.kind=kelvin-voigt",
        "estimator.contact_m=0",
    ];
    let scales = ["scaling.force", "scaling.position"];
    compare_map(count, scales, ["0.2:20", "0.2:20"], &contact)?;
    let delay = ["channel.delay_s", "tissue.stiffness_n_per_m"];
    compare_map(count, delay, ["0.001:0.2", "10:5000"], &contact)
}

fn main() -> ExitCode {
    let mut words = std::env::args().skip(1).peekable();
    let study = words.next_if(|word| word.parse::<usize>().is_err());
    let count = words.next().and_then(|text| text.parse().ok()).unwrap_or(200);
    let all = match study.as_deref() {
        None => verdicts(count, judged),
        Some("delays") => verdicts(count, judged_with_jitter),
        Some("map") => return if maps(count).is_some() { ExitCode::SUCCESS } else { ExitCode::FAILURE },
        Some(other) => {
            eprintln!("{other} is no study of verdicts: give map, delays, or only a number");
            return ExitCode::from(2);
        }
    };
    let of = |is: &dyn Fn(&&Judged) -> bool| all.iter().filter(is).count();
    let settles = |one: &Judged| one.truth == Truth::Settles && one.with_events == Truth::Settles;
    let (swinging, settled) = (of(&|one| one.truth == Truth::Swings), of(&|one| settles(one)));
    let is_kept = |one: &Judged| one.with_events == Truth::Swings;
    let kept = of(&|one| is_kept(one));
    println!(
        "{} scenarios: {swinging} swing or diverge, {kept} are kept swinging by events that noise raises, {settled} settle",
        all.len()
    );
    for (what, verdict) in [("stable", false), ("certified", true)] {
        let says = |one: &Judged| if verdict { one.is_certified } else { one.is_stable };
        let wrong: Vec<&Judged> =
            all.iter().filter(|one| says(one) == Some(true) && one.truth == Truth::Swings).collect();
        let not = of(&|one| says(one) == Some(false) && one.truth == Truth::Swings);
        println!("of those that swing or diverge, called {what}: {}, not {what}: {not}, the rest unknown", wrong.len());
        for one in wrong {
            println!("  {}", one.settings.join(" "));
        }
        let settle = of(&|one| says(one) == Some(true) && one.truth == Truth::Settles);
        println!("  of those that settle, called {what}: {settle}, where they are analysed");
    }
    let oscillating = of(&|one| one.is_called_unstable && settles(one));
    let found = of(&|one| one.is_called_unstable && one.truth == Truth::Swings);
    let kept_found = of(&|one| one.is_called_unstable && is_kept(one));
    println!(
        "called oscillating or diverged: {found} of {swinging} that swing or diverge, {kept_found} of {kept} that events keep swinging, \
         {oscillating} of {settled} that settle"
    );
    ExitCode::SUCCESS
}
