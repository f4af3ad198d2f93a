//! The exact step of master and slave compared with numerical integration.
//!
//! Criterion reports the throughput in ticks (elements) per second; `cargo bench --bench table` reports ns for the other
//! parts of a tick.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use trocar::engine::{ExactPlants, IntegratedPlants, Plants, TissueForce};
use trocar::plant::{ArmParameters, ControlTiming, MasterParameters, MasterStep, SlaveParameters, SlaveStep};

const TICK_S: f64 = 1e-3;

fn steps() -> (MasterStep, SlaveStep) {
    let timing = ControlTiming::Continuous;
    let master = MasterStep::new(&MasterParameters::default(), &ArmParameters::default(), timing, TICK_S);
    let slave = SlaveStep::new(&SlaveParameters::default(), timing, TICK_S);
    (master.expect("valid"), slave.expect("valid"))
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

criterion_group!(benches, plants);
criterion_main!(benches);
