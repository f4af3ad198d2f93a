//! The excess advance for several horizons, from one run.

use std::ops::Range;

use trocar_core::lane::{Lane, Mask};
use trocar_engine::engine::{EventObserver, SelectedSignals};
use trocar_engine::operator::OperatorTraits;
use trocar_metrics::Pursuit;
use trocar_run::RunObserver;
use trocar_scenario::Scenario;

/// The metric "excess advance" uses 2 s.
pub const WINDOWS_S: [f64; 4] = [0.5, 1.0, 2.0, 3.0];

/// Sum and number of the excess advances, for each window.
pub(super) type OfWindows = [(f64, u64); WINDOWS_S.len()];

pub(super) struct Windows<'a>(pub(super) &'a [Scenario]);

pub(super) struct WindowsOverLanes<L: Lane> {
    pursuits: Vec<Pursuit<L>>,
    sums: Vec<OfWindows>,
    ruptures: usize,
}

impl RunObserver for Windows<'_> {
    type OverLanes<L: Lane> = WindowsOverLanes<L>;
    type Finding = OfWindows;

    fn over_lanes<L: Lane>(&self, places: Range<usize>) -> WindowsOverLanes<L> {
        let traits: Vec<OperatorTraits> = self.0[places].iter().map(Scenario::operator_traits).collect();
        let tick_s = self.0.first().map_or(1e-3, |scenario| scenario.grid.tick_s());
        let pursuit = |window_s: &f64| {
            let mut pursuit = Pursuit::new(tick_s, *window_s);
            pursuit.set_operators(|lane| traits[lane.min(traits.len() - 1)]);
            pursuit
        };
        WindowsOverLanes {
            pursuits: WINDOWS_S.iter().map(pursuit).collect(),
            sums: vec![OfWindows::default(); L::WIDTH],
            ruptures: 0,
        }
    }

    fn finding<L: Lane>(observer: &WindowsOverLanes<L>, lane: usize) -> OfWindows {
        observer.sums[lane]
    }
}

impl<L: Lane> EventObserver<L> for WindowsOverLanes<L> {
    #[inline(always)]
    fn observe(&mut self, s: &SelectedSignals<L>) {
        let ruptured = s.ruptured.any();
        for (window, pursuit) in self.pursuits.iter_mut().enumerate() {
            let is_due = pursuit.follow(s.tick, s.intended_position_m, s.slave_position_m);
            if !(is_due | ruptured) {
                continue;
            }
            for lane in 0..L::WIDTH {
                let ruptures_again = s.ruptured.lane(lane);
                let closed = pursuit.close(lane, s.tick, ruptures_again);
                if let Some((excess_m, _)) = closed.and_then(|(_, aftermath)| aftermath.beyond_intent_m) {
                    let (sum, count) = &mut self.sums[lane][window];
                    (*sum, *count) = (*sum + excess_m, *count + 1);
                }
                if ruptures_again {
                    self.ruptures += 1;
                    pursuit.open(lane, s.tick, self.ruptures);
                }
            }
        }
    }
}
