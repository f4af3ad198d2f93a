//! Nothing is allocated from a run's first tick to its last.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use trocar::metrics::MetricsObserver;
use trocar::scenario::{Scenario, Source};

/// The system's allocator, counting what this thread asks of it.
struct Counting;

thread_local! {
    static COUNT: Cell<u64> = const { Cell::new(0) };
}

fn count() {
    COUNT.with(|count| count.set(count.get() + 1));
}

#[allow(unsafe_code, reason = "an allocator is unsafe by its trait")]
// SAFETY: every request goes to the system's allocator as it came.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        unsafe { System.alloc(layout) }
    }
    unsafe fn realloc(&self, old: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        unsafe { System.realloc(old, layout, size) }
    }
    unsafe fn dealloc(&self, old: *mut u8, layout: Layout) {
        unsafe { System.dealloc(old, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn a_run_with_metrics_allocates_nothing() {
    for name in ["classical", "augmented", "01_through_the_skin", "05_trembling_hand", "12_sensor_not_ideal"] {
        let path = format!("{}/scenarios/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        let scenario = Scenario::load(&Source::parse(&path), &[]).expect("loads");
        let mut engine = scenario.exact_engine::<f64>(0).expect("builds");
        let mut observer = MetricsObserver::<f64>::new(scenario.grid, 4);
        let before = COUNT.with(Cell::get);
        engine.run(&mut observer).expect("runs");
        let after = COUNT.with(Cell::get);
        assert!(before > 0, "the allocator counts");
        assert_eq!(after - before, 0, "{name}");
        assert!(observer.metrics(0).ticks > 0);
    }
}
