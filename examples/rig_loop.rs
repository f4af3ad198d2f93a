//! Runs a rig's controller in a 1 kHz loop on this machine, and measures the time of a step and the wake-up latency.
//!
//! ```sh
//! cargo run --release --example rig_loop                                  # 10 s at 1 kHz
//! cargo run --release --example rig_loop -- --free-running --steps 1e8    # without pause
//! ```
//! The samples come from the shipped augmented insertion, played forwards and backwards in turn.

use std::error::Error;
use std::hint::black_box;
use std::process::ExitCode;
use std::thread;
use std::time::{Duration, Instant};

use trocar::engine::Trace;
use trocar::rig::{HapticController, Sample};
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

/// The insertion, played forwards and backwards in turn, with the index of the present sample.
struct Signal {
    samples: Vec<Sample>,
    at: usize,
    is_forward: bool,
}

impl Signal {
    fn of(trace: &Trace) -> Self {
        let sample = |k: usize| Sample {
            master_position_m: trace.master_position_m[k],
            slave_position_m: trace.slave_position_m[k],
            slave_velocity_m_per_s: trace.slave_velocity_m_per_s[k],
            force_n: trace.measured_force_n[k],
        };
        Self { samples: (0..trace.len()).map(sample).collect(), at: 0, is_forward: true }
    }

    fn next(&mut self) -> Sample {
        let mut sample = self.samples[self.at];
        if self.is_forward {
            self.is_forward = self.at + 1 < self.samples.len();
            self.at = (self.at + 1).min(self.samples.len() - 1);
        } else {
            sample.slave_velocity_m_per_s = -sample.slave_velocity_m_per_s;
            self.is_forward = self.at == 0;
            self.at = self.at.saturating_sub(1);
        }
        sample
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
        let sample = signal.next();
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
fn free_running(controller: &mut HapticController, signal: &mut Signal, steps: u64) -> Outcome {
    let (mut one, mut intervals, mut clock) = (Histogram::new(), Histogram::new(), Histogram::new());
    let mut outcome = Outcome::default();
    let mut samples = Vec::with_capacity(BLOCK);
    let mut commands = Vec::with_capacity(BLOCK);
    let mut done = 0;
    while done < steps {
        let count = (steps - done).min(BLOCK as u64) as usize;
        samples.clear();
        samples.extend((0..count).map(|_| signal.next()));
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
    let (mut steps, mut is_free) = (None, false);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--free-running" => is_free = true,
            "--steps" => {
                let number: f64 = arguments.next().ok_or("--steps needs a number")?.parse()?;
                steps = Some(number as u64);
            }
            _ => return Err(format!("{argument} is not an option; there are --steps N, --free-running").into()),
        }
    }
    let scenario = Scenario::load(&Source::parse("paper/augmented"), &[])?;
    let settings = scenario.rig_settings();
    let mut signal = Signal::of(&trocar::run::run(scenario)?.trace);
    let tick_s = settings.tick_s;
    let mut controller = HapticController::new(&settings)?;
    let steps = steps.unwrap_or(if is_free { 100_000_000 } else { 10_000 });
    println!("{steps} steps");
    let outcome = if is_free {
        free_running(&mut controller, &mut signal, steps)
    } else {
        paced(&mut controller, &mut signal, tick_s, steps)
    };
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
