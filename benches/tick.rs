//! The cost of a tick, and of the exact step compared with numerical integration.
//!
//! `full` is a run with its metrics, `bare` a run without an observer, and `baseline` only the two matrix products.
//! The ratio full / baseline shows the cost of the rest of the tick, independent of the machine. Criterion reports
//! the throughput in ticks (elements) per second; `cargo bench --bench table` reports ns.

#[path = "table/shipped.rs"]
mod shipped;

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use trocar::engine::{ExactPlants, IntegratedPlants, Plants, TissueForce, Wired};
use trocar::metrics::MetricsObserver;
use trocar::plant::{
    ArmParameters, ControlTiming, MASTER_STATES, MasterParameters, MasterStep, SLAVE_STATES, SlaveParameters, SlaveStep,
};

use shipped::scenario;

const TICK_S: f64 = 1e-3;
/// Layers, force noise, closed loop.
const LAYERED: &str = "layers/through-the-skin";

fn steps() -> (MasterStep, SlaveStep) {
    let timing = ControlTiming::Continuous;
    let master = MasterStep::new(&MasterParameters::default(), &ArmParameters::default(), timing, TICK_S);
    let slave = SlaveStep::new(&SlaveParameters::default(), timing, TICK_S);
    (master.expect("valid"), slave.expect("valid"))
}

fn full(engine: &mut Wired<f64, ExactPlants<f64>>, observer: &mut MetricsObserver<f64>) {
    engine.run_compiled(observer).expect("runs");
}

/// The plants alone: two matrices times their states and inputs, in plain code.
struct Baseline {
    /// Rows; the columns are the states, `x_d` now and at the next tick, and `F_ed`.
    master: [[f64; MASTER_STATES + 3]; MASTER_STATES],
    /// Rows; the columns are the states and `x_ref`.
    slave: [[f64; SLAVE_STATES + 1]; SLAVE_STATES],
}

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
                |engine| engine.run_compiled(&mut ()).expect("runs"),
                criterion::BatchSize::LargeInput,
            );
        });
    }
    let (baseline, ticks) = (Baseline::new(), scenario("classical").grid.ticks());
    group.bench_function("baseline", |bencher| bencher.iter(|| black_box(baseline.run(black_box(ticks)))));
    group.finish();
}

fn plants(criterion: &mut Criterion) {
    fn drive(plants: &mut impl Plants<f64>, ticks: u64) -> f64 {
        for tick in 0..ticks {
            let (now, next) = (1e-5 * tick as f64, 1e-5 * (tick + 1) as f64);
            let (force, reference) = (100.0 * plants.slave().position_m, plants.master().position_m);
            plants.step(now, next, force, reference, 0.0, TissueForce::zero()).expect("steps");
        }
        plants.slave().position_m
    }
    const TICKS: u64 = 200;
    let (master, slave) = steps();
    let parameters = (&MasterParameters::default(), &ArmParameters::default(), &SlaveParameters::default());
    let exact = ExactPlants::<f64>::new(&master, &slave, 0.0, 0.0);
    let integrated = IntegratedPlants::new(parameters, ControlTiming::Continuous, TICK_S, 0.0, 0.0);
    let mut group = criterion.benchmark_group("plants");
    group.throughput(Throughput::Elements(TICKS));
    group.bench_function("exact", |bencher| bencher.iter(|| drive(&mut exact.clone(), black_box(TICKS))));
    group.bench_function("dop853", |bencher| bencher.iter(|| drive(&mut integrated.clone(), black_box(TICKS))));
    group.finish();
}

criterion_group!(benches, ticks, plants);
criterion_main!(benches);
