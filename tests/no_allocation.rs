//! Neither a run, from its first to its last tick, nor the controller of a rig allocates memory.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use trocar::engine::EngineError;
use trocar::metrics::MetricsObserver;
use trocar::rig::{HapticController, Sample, Settings, VelocitySource};
use trocar::scenario::{Scenario, Source};

/// The system allocator with a count of this thread's allocations.
struct Counting;

thread_local! {
    static COUNT: Cell<u64> = const { Cell::new(0) };
}

fn count() {
    COUNT.with(|count| count.set(count.get() + 1));
}

#[allow(unsafe_code, reason = "an allocator is unsafe by its trait")]
// SAFETY: every request is passed unchanged to the system allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }
    unsafe fn realloc(&self, old: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        // SAFETY: the caller keeps the contract of `realloc`; `old` comes from the same allocator.
        unsafe { System.realloc(old, layout, size) }
    }
    unsafe fn dealloc(&self, old: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps the contract of `dealloc`; `old` comes from the same allocator.
        unsafe { System.dealloc(old, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn allocations(scenario: &Scenario, run: impl FnOnce(&mut MetricsObserver<f64>) -> Result<(), EngineError>) -> u64 {
    let mut observer = MetricsObserver::<f64>::new(scenario.grid, 4);
    let before = COUNT.with(Cell::get);
    run(&mut observer).expect("runs");
    let after = COUNT.with(Cell::get);
    assert!(before > 0, "the allocator counts");
    assert!(observer.metrics(0).ticks > 0);
    after - before
}

fn scenario(name: &str) -> Scenario {
    scenario_with(name, &[])
}

fn scenario_with(name: &str, settings: &[String]) -> Scenario {
    let path = format!("builtin:{name}");
    Scenario::load(&Source::parse(&path), settings).expect("loads")
}

#[test]
fn no_estimator_allocates() {
    for parameters in ["stiffness", "stiffness-damping-friction", "hunt-crossley", "least-residual"] {
        for forgetting in ["resetting", "exponential"] {
            let settings = [format!("estimator.parameters={parameters}"), format!("estimator.forgetting={forgetting}")];
            let scenario = scenario_with("layers/through-the-skin", &settings);
            let mut engine = scenario.exact_engine::<f64>(0).expect("builds");
            assert_eq!(allocations(&scenario, |observer| engine.run(observer)), 0, "{settings:?}");
        }
    }
}

#[test]
fn a_run_with_metrics_allocates_nothing() {
    for name in [
        "classical",
        "augmented",
        "layers/through-the-skin",
        "hand/trembling-hand",
        "sensing/sensor-not-ideal",
        "tearing/yellow-ligament",
        "tearing/firm-phantom",
    ] {
        let scenario = scenario(name);
        let mut engine = scenario.exact_engine::<f64>(0).expect("builds");
        assert_eq!(allocations(&scenario, |observer| engine.run(observer)), 0, "{name}");
    }
    let saturating = scenario("link/saturating-master");
    let mut engine = saturating.limited_engine::<f64>(0).expect("builds");
    assert_eq!(allocations(&saturating, |observer| engine.run(observer)), 0);
}

#[test]
fn a_step_of_the_rig_allocates_nothing() {
    let velocity = VelocitySource::Filtered { resolution_m: 1e-6, acceleration_std_m_per_s2: 1.0 };
    let mut events = 0;
    let before = COUNT.with(Cell::get);
    let mut controller = HapticController::new(&Settings { velocity, ..Settings::default() }).expect("valid");
    // An insertion with a rupture every two seconds and one missing sample in four hundred.
    for k in 0..20_000_u32 {
        let depth = 1e-5 * f64::from(k % 2000);
        let sample = Sample {
            master_position_m: depth,
            slave_position_m: depth,
            slave_velocity_m_per_s: f64::NAN,
            force_n: if k % 2000 < 1500 { 300.0 * depth } else { 1.0 },
        };
        let command = controller.step(if k % 400 == 50 { &Sample::MISSING } else { &sample });
        events += u32::from(command.alarm_taken);
    }
    assert_eq!(COUNT.with(Cell::get), before);
    assert!(events > 0, "steps of every kind");
}
