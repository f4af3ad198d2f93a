//! What a tick costs, and what the exact step is worth.
//!
//! `full` is a run with its metrics, `bare` one that nobody observes, `baseline` the two matrix products alone: the
//! ratio full / baseline says how much the rest of the tick costs, whatever the machine. Criterion gives the throughput
//! in ticks (elements) a second; the table before it gives the best of many runs in ns a tick.

use std::hint::black_box;
use std::time::Instant;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use trocar::engine::{Engine, ExactSides, IntegratedSides, Sides};
use trocar::metrics::MetricsObserver;
use trocar::plant::{
    ArmParameters, ControlTiming, MASTER_STATES, MasterParameters, MasterStep, SLAVE_STATES, SlaveParameters, SlaveStep,
};
use trocar::scenario::{Scenario, Source};

const TICK_S: f64 = 1e-3;
/// Layers, noise on the force, the loop closed.
const LAYERED: &str = "01_through_the_skin";
const MOST_TIMED: usize = 300;

fn scenario(name: &str) -> Scenario {
    scenario_with(name, &[])
}

fn scenario_with(name: &str, settings: &[String]) -> Scenario {
    let path = format!("{}/scenarios/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    Scenario::load(&Source::parse(&path), settings).expect("loads")
}

fn steps() -> (MasterStep, SlaveStep) {
    let timing = ControlTiming::Continuous;
    let master = MasterStep::new(&MasterParameters::default(), &ArmParameters::default(), timing, TICK_S);
    let slave = SlaveStep::new(&SlaveParameters::default(), timing, TICK_S);
    (master.expect("valid"), slave.expect("valid"))
}

fn full(engine: &mut Engine<f64, ExactSides<f64>>, observer: &mut MetricsObserver<f64>) {
    engine.run(observer).expect("runs");
}

/// The sides without anything around them: two matrices times their states and inputs, as anyone would write it.
struct Baseline {
    /// Row by row: states, then `x_d` now and next, and `F_ed`.
    master: [[f64; MASTER_STATES + 3]; MASTER_STATES],
    /// Row by row: states, then `x_ref`.
    slave: [[f64; SLAVE_STATES + 1]; SLAVE_STATES],
}

/// A matrix times a vector.
#[inline(always)]
fn times<const ROWS: usize, const COLUMNS: usize>(
    matrix: &[[f64; COLUMNS]; ROWS],
    inputs: [f64; COLUMNS],
) -> [f64; ROWS] {
    let mut product = [0.0; ROWS];
    for j in 0..COLUMNS {
        for i in 0..ROWS {
            product[i] += matrix[i][j] * inputs[j];
        }
    }
    product
}

impl Baseline {
    fn new() -> Self {
        let (master, slave) = steps();
        let inputs = [master.desired_now, master.desired_next, master.feedback];
        let states = |i: usize, j: usize| master.transition[i][j];
        Self {
            master: std::array::from_fn(|i| {
                std::array::from_fn(|j| if j < MASTER_STATES { states(i, j) } else { inputs[j - MASTER_STATES][i] })
            }),
            slave: std::array::from_fn(|i| {
                std::array::from_fn(|j| if j < SLAVE_STATES { slave.transition[i][j] } else { slave.reference[i] })
            }),
        }
    }

    fn run(&self, ticks: u64) -> f64 {
        let (mut master, mut slave) = ([0.0; MASTER_STATES], [0.0; SLAVE_STATES]);
        let mut desired = 0.0;
        for tick in 0..ticks {
            let desired_next = 1e-5 * (tick + 1) as f64;
            let force = 100.0 * slave[0];
            let ([x_h, v_h, x_a, v_a, integral], [x_e, v_e, third]) = (master, slave);
            master = times(&self.master, [x_h, v_h, x_a, v_a, integral, desired, desired_next, force]);
            slave = times(&self.slave, [x_e, v_e, third, x_h]);
            desired = desired_next;
        }
        master[0] + slave[0]
    }
}

/// The shortest and the median of many runs, in ns a tick.
fn time_ns(ticks: u64, mut run: impl FnMut() -> f64) -> (f64, f64) {
    let mut times: Vec<f64> = (0..MOST_TIMED).map(|_| 1e9 * run() / ticks as f64).collect();
    times.sort_by(f64::total_cmp);
    (times[0], times[MOST_TIMED / 2])
}

fn elapsed_s(run: impl FnOnce()) -> f64 {
    let start = Instant::now();
    run();
    start.elapsed().as_secs_f64()
}

/// Prints ns a tick and the ratio to the baseline, all measured in the same minute.
fn table(_: &mut Criterion) {
    println!("{:<22} {:>12} {:>12} {:>16}", "ns per tick", "best", "median", "best / baseline");
    let baseline = Baseline::new();
    let ticks = scenario("classical").grid.ticks();
    let reference = time_ns(ticks, || {
        elapsed_s(|| {
            black_box(baseline.run(black_box(ticks)));
        })
    });
    let row = |name: &str, (best, median): (f64, f64)| {
        println!("{name:<22} {best:>12.2} {median:>12.2} {:>16.2}", best / reference.0);
    };
    row("baseline", reference);
    for name in ["classical", "augmented", LAYERED] {
        let scenario = scenario(name);
        let engine = scenario.exact_engine::<f64>(0).expect("builds");
        let ticks = scenario.grid.ticks();
        let with_metrics = time_ns(ticks, || {
            let (mut engine, mut observer) = (engine.clone(), MetricsObserver::new(scenario.grid, 4));
            elapsed_s(|| full(&mut engine, &mut observer))
        });
        row(&format!("full/{name}"), with_metrics);
        let bare = time_ns(ticks, || {
            let mut engine = engine.clone();
            elapsed_s(|| engine.run(&mut ()).expect("runs"))
        });
        row(&format!("bare/{name}"), bare);
    }
    for (name, key) in [
        ("exponential forgetting", "forgetting=exponential"),
        ("with friction", "parameters=stiffness-damping-friction"),
        ("least residual", "parameters=least-residual"),
        ("Hunt-Crossley", "parameters=hunt-crossley"),
    ] {
        let scenario = scenario_with("classical", &[format!("estimator.{key}")]);
        let engine = scenario.exact_engine::<f64>(0).expect("builds");
        let with_metrics = time_ns(scenario.grid.ticks(), || {
            let (mut engine, mut observer) = (engine.clone(), MetricsObserver::new(scenario.grid, 4));
            elapsed_s(|| full(&mut engine, &mut observer))
        });
        row(name, with_metrics);
    }
}

fn ticks(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("tick");
    for name in ["classical", "augmented", LAYERED] {
        let scenario = scenario(name);
        let engine = scenario.exact_engine::<f64>(0).expect("builds");
        group.throughput(Throughput::Elements(scenario.grid.ticks()));
        group.bench_function(format!("full/{name}"), |bencher| {
            bencher.iter_batched_ref(
                || (engine.clone(), MetricsObserver::new(scenario.grid, 4)),
                |(engine, observer)| full(engine, observer),
                criterion::BatchSize::LargeInput,
            );
        });
        group.bench_function(format!("bare/{name}"), |bencher| {
            bencher.iter_batched_ref(
                || engine.clone(),
                |engine| engine.run(&mut ()).expect("runs"),
                criterion::BatchSize::LargeInput,
            );
        });
    }
    let (baseline, ticks) = (Baseline::new(), scenario("classical").grid.ticks());
    group.bench_function("baseline", |bencher| bencher.iter(|| black_box(baseline.run(black_box(ticks)))));
    group.finish();
}

fn sides(criterion: &mut Criterion) {
    fn drive(sides: &mut impl Sides<f64>, ticks: u64) -> f64 {
        for tick in 0..ticks {
            let (now, next) = (1e-5 * tick as f64, 1e-5 * (tick + 1) as f64);
            let (force, reference) = (100.0 * sides.slave().position_m, sides.master().position_m);
            sides.step(now, next, force, reference).expect("steps");
        }
        sides.slave().position_m
    }
    const TICKS: u64 = 200;
    let (master, slave) = steps();
    let parameters = (&MasterParameters::default(), &ArmParameters::default(), &SlaveParameters::default());
    let exact = ExactSides::<f64>::new(&master, &slave, 0.0, 0.0);
    let integrated = IntegratedSides::new(parameters, ControlTiming::Continuous, TICK_S, 0.0, 0.0);
    let mut group = criterion.benchmark_group("sides");
    group.throughput(Throughput::Elements(TICKS));
    group.bench_function("exact", |bencher| bencher.iter(|| drive(&mut exact.clone(), black_box(TICKS))));
    group.bench_function("dop853", |bencher| bencher.iter(|| drive(&mut integrated.clone(), black_box(TICKS))));
    group.finish();
}

criterion_group!(benches, table, ticks, sides);
criterion_main!(benches);
