//! Runs a rig's controller in a 1 kHz loop on this machine, and measures the time of a step and the wake-up latency.
//!
//! ```sh
//! cargo run --release --example rig_loop                                  # 10 s at 1 kHz
//! cargo run --release --example rig_loop -- --free-running --steps 1e8    # without pause
//! cargo run --release --example rig_loop -- --free-running --steps 1e8 --signal motionless
//! ```
//! The samples come from the shipped augmented insertion, played forwards and backwards in turn, or from an
//! artificial signal (`motionless`, `tiny-depth`, `huge-depth`, `sine`) with noise that leaves the estimator's dead
//! zone.

use std::error::Error;
use std::hint::black_box;
use std::process::ExitCode;
use std::thread;
use std::time::{Duration, Instant};

use trocar::rig::{HapticController, Sample, Settings};
use trocar::scenario::{Scenario, Source};

/// Number of samples generated in advance.
const BLOCK: usize = 10_000;
/// Number of steps between two readings of the clock, for the mean time of a step.
const INTERVAL: usize = 100;
/// Number of blocks of which one also times its intervals.
const MEAN_EVERY: u64 = 10;
/// Times from this value on fall into the last bin, in ns.
const LONGEST_NS: usize = 1_000_000;

/// A histogram of times in ns.
struct Histogram {
    counts: Vec<u64>,
    worst_ns: u64,
    total: u64,
}

impl Histogram {
    fn new() -> Self {
        Self { counts: vec![0; LONGEST_NS + 1], worst_ns: 0, total: 0 }
    }

    fn add(&mut self, time: Duration) {
        let ns = time.as_nanos() as u64;
        self.counts[(ns as usize).min(LONGEST_NS)] += 1;
        self.worst_ns = self.worst_ns.max(ns);
        self.total += 1;
    }

    /// Returns the quantile of the times, in ns.
    fn quantile_ns(&self, share: f64) -> u64 {
        let target = (share * self.total as f64).ceil().max(1.0) as u64;
        let mut counted = 0;
        let index = self.counts.iter().position(|count| {
            counted += count;
            counted >= target
        });
        // The last bin has no resolution, so return the longest time as a bound.
        index.filter(|ns| *ns < LONGEST_NS).map_or(self.worst_ns, |ns| ns as u64)
    }

    /// Prints a line of the table, in µs or in ns.
    fn print(&self, name: &str, unit_ns: f64) {
        let cell = |ns: u64| format!("{:>10.*}", if unit_ns > 1.0 { 2 } else { 0 }, ns as f64 / unit_ns);
        let quantiles = [0.0, 0.5, 0.99, 0.999, 0.99999].map(|share| cell(self.quantile_ns(share))).concat();
        println!("{name:<28}{quantiles}{}", cell(self.worst_ns));
    }
}

fn print_head(title: &str) {
    println!(
        "{title:<28}{:>10}{:>10}{:>10}{:>10}{:>10}{:>10}",
        "best", "median", "99 %", "99.9 %", "99.999 %", "worst"
    );
}

/// An endless source of samples.
enum Signal {
    /// The insertion, played forwards and backwards in turn, with the index of the present sample.
    Insertion { samples: Vec<Sample>, at: usize, is_forward: bool },
    /// A needle in a Kelvin-Voigt tissue, at a depth (m) with a 1 Hz oscillation (m) and bounded noise (N).
    Needle { depth_m: f64, swing_m: f64, offset_n: f64, noise_n: f64, tick: u64, random: u64 },
}

const NEEDLE_STIFFNESS_N_PER_M: f64 = 300.0;
const NEEDLE_DAMPING_N_S_PER_M: f64 = 10.0;

impl Signal {
    /// Returns the signal with a name, and the settings of a controller for it.
    fn named(name: &str) -> Result<(Self, Settings), Box<dyn Error>> {
        let scenario = Scenario::load(&Source::parse("paper/augmented"), &[])?;
        let settings = scenario.rig_settings();
        let needle = |depth_m, swing_m, offset_n| {
            let depth_settings = Settings { contact_m: 0.0, start_m: depth_m, ..settings };
            let noise_n = 0.05;
            (Self::Needle { depth_m, swing_m, offset_n, noise_n, tick: 0, random: 1 }, depth_settings)
        };
        Ok(match name {
            "insertion" => {
                let trace = trocar::run::run(scenario)?.trace;
                let sample = |k: usize| Sample {
                    master_position_m: trace.master_position_m[k],
                    slave_position_m: trace.slave_position_m[k],
                    slave_velocity_m_per_s: trace.slave_velocity_m_per_s[k],
                    force_n: trace.measured_force_n[k],
                };
                let samples = (0..trace.len()).map(sample).collect();
                (Self::Insertion { samples, at: 0, is_forward: true }, settings)
            }
            "motionless" => needle(0.02, 0.0, 0.0),
            "tiny-depth" => needle(1e-9, 0.0, 0.5),
            "huge-depth" => needle(0.9, 0.0, -265.0),
            "sine" => needle(0.02, 0.01, 0.0),
            _ => {
                return Err(format!(
                    "{name} is not a signal; there are insertion, motionless, tiny-depth, huge-depth, sine"
                )
                .into());
            }
        })
    }

    fn next(&mut self, tick_s: f64) -> Sample {
        match self {
            Self::Insertion { samples, at, is_forward } => {
                let mut sample = samples[*at];
                if *is_forward {
                    *is_forward = *at + 1 < samples.len();
                    *at = (*at + 1).min(samples.len() - 1);
                } else {
                    sample.slave_velocity_m_per_s = -sample.slave_velocity_m_per_s;
                    *is_forward = *at == 0;
                    *at = at.saturating_sub(1);
                }
                sample
            }
            Self::Needle { depth_m, swing_m, offset_n, noise_n, tick, random } => {
                // Xorshift (Marsaglia 2003) is sufficient for this noise.
                *random ^= *random << 13;
                *random ^= *random >> 7;
                *random ^= *random << 17;
                let noise = *noise_n * (2.0 * (*random >> 11) as f64 / (1_u64 << 53) as f64 - 1.0);
                let rate = std::f64::consts::TAU;
                let (sine, cosine) = (rate * (*tick as f64 * tick_s)).sin_cos();
                *tick += 1;
                let (depth, velocity) = (*depth_m + *swing_m * sine, *swing_m * rate * cosine);
                let force = NEEDLE_STIFFNESS_N_PER_M * depth + NEEDLE_DAMPING_N_S_PER_M * velocity + *offset_n;
                Sample {
                    master_position_m: depth,
                    slave_position_m: depth,
                    slave_velocity_m_per_s: velocity,
                    force_n: force + noise,
                }
            }
        }
    }
}

/// Counts of the commands, and the range of the estimator's gain.
#[derive(Default)]
struct Outcome {
    alarms: u64,
    faults: u64,
    not_finite: u64,
    min_eigenvalue: Option<f64>,
    max_eigenvalue: f64,
}

impl Outcome {
    fn record(&mut self, command: &trocar::rig::Command) {
        self.alarms += u64::from(command.alarm);
        self.faults += u64::from(command.faults.any());
        let sum = command.slave_reference_m
            + command.master_force_n
            + command.stiffness_n_per_m
            + command.damping_n_s_per_m
            + command.residual_n
            + command.distance
            + command.decision;
        self.not_finite += u64::from(!sum.is_finite());
    }

    fn record_gain(&mut self, [f00, f01, f11]: [f64; 3]) {
        let greater = f64::midpoint(f00, f11) + f64::midpoint(f00, -f11).hypot(f01);
        let smaller = (f00 * f11 - f01 * f01) / greater;
        self.min_eigenvalue = Some(self.min_eigenvalue.map_or(smaller, |min| min.min(smaller)));
        self.max_eigenvalue = self.max_eigenvalue.max(greater);
    }
}

/// Runs at 1 kHz. Sleeps until the next deadline on a fixed grid, so that errors of the sleep do not accumulate.
fn paced(controller: &mut HapticController, signal: &mut Signal, tick_s: f64, steps: u64) -> Outcome {
    let (mut steps_taken, mut lateness, mut outcome) = (Histogram::new(), Histogram::new(), Outcome::default());
    let start = Instant::now();
    for k in 1..=steps {
        let deadline = start + Duration::from_secs_f64(k as f64 * tick_s);
        let sample = signal.next(tick_s);
        thread::sleep(deadline.saturating_duration_since(Instant::now()));
        let woken = Instant::now();
        let command = controller.step(black_box(&sample));
        let done = Instant::now();
        lateness.add(woken.saturating_duration_since(deadline));
        steps_taken.add(done - woken);
        outcome.record(&black_box(command));
        outcome.record_gain(controller.estimator_gain());
    }
    print_head("µs");
    steps_taken.print("step, with its clock", 1e3);
    lateness.print("woken after the deadline", 1e3);
    outcome
}

/// Runs without pauses. Times each step, and the clock alone equally often: delays in both come from the machine.
fn free_running(controller: &mut HapticController, signal: &mut Signal, tick_s: f64, steps: u64) -> Outcome {
    let (mut one, mut intervals, mut clock) = (Histogram::new(), Histogram::new(), Histogram::new());
    let mut outcome = Outcome::default();
    let mut samples = Vec::with_capacity(BLOCK);
    let mut commands = Vec::with_capacity(BLOCK);
    let mut done = 0;
    while done < steps {
        let count = (steps - done).min(BLOCK as u64) as usize;
        samples.clear();
        samples.extend((0..count).map(|_| signal.next(tick_s)));
        commands.clear();
        if (done / BLOCK as u64).is_multiple_of(MEAN_EVERY) {
            // Use a copy, so that the controller processes each sample only once.
            let mut copy = controller.clone();
            for interval in samples.chunks(INTERVAL) {
                let start = Instant::now();
                commands.extend(interval.iter().map(|sample| copy.step(sample)));
                intervals.add(start.elapsed() / interval.len() as u32);
            }
            black_box(&mut commands).clear();
        }
        for sample in &samples {
            let start = Instant::now();
            commands.push(controller.step(sample));
            one.add(start.elapsed());
        }
        for _ in 0..count {
            clock.add(Instant::now().elapsed());
        }
        for command in black_box(&commands) {
            outcome.record(command);
        }
        outcome.record_gain(controller.estimator_gain());
        done += count as u64;
    }
    print_head("ns");
    one.print("step, with its clock", 1.0);
    clock.print("the clock alone", 1.0);
    intervals.print(&format!("step, mean of {INTERVAL}"), 1.0);
    outcome
}

fn run() -> Result<(), Box<dyn Error>> {
    let (mut steps, mut is_free, mut name) = (None, false, String::from("insertion"));
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--free-running" => is_free = true,
            "--steps" => {
                let number: f64 = arguments.next().ok_or("--steps needs a number")?.parse()?;
                steps = Some(number as u64);
            }
            "--signal" => name = arguments.next().ok_or("--signal needs a name")?,
            _ => {
                return Err(
                    format!("{argument} is not an option; there are --steps N, --free-running, --signal NAME").into()
                );
            }
        }
    }
    let (mut signal, mut settings) = Signal::named(&name)?;
    if name != "insertion" {
        settings.limits.force_n = 1e3;
    }
    let tick_s = settings.tick_s;
    let mut controller = HapticController::new(&settings)?;
    let steps = steps.unwrap_or(if is_free { 100_000_000 } else { 10_000 });
    println!("{steps} steps of {name}");
    let drive = if is_free { free_running } else { paced };
    let outcome = drive(&mut controller, &mut signal, tick_s, steps);
    println!("alarms {}, bad samples {}, commands not finite {}", outcome.alarms, outcome.faults, outcome.not_finite);
    let min = outcome.min_eigenvalue.unwrap_or(f64::NAN);
    println!("eigenvalues of the gain from {min:.4e} to {:.4e} 1/m²", outcome.max_eigenvalue);
    let (low, high) = (1.0 / settings.estimator.reset_threshold, settings.estimator.initial_gain);
    println!("their bounds            from {low:.4e} to {high:.4e} 1/m²");
    Ok(())
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("rig_loop: {error}");
            ExitCode::from(2)
        }
    }
}
