//! Timelines of an insertion, for the tests of metrics.

use super::{Metrics, MetricsObserver, RunMetric};
use trocar_core::augmentation::{Mode, Modes};
use trocar_core::time::TickGrid;
use trocar_engine::engine::{Observer as _, Signals};
use trocar_engine::operator::OperatorTraits;

pub(super) const TICK_S: f64 = 1e-3;

type Edit = Box<dyn Fn(&mut Signals<f64>)>;

/// An insertion, tick by tick: the hand moves in at 10 mm/s, the slave follows without lag, both forces are 2 N.
/// Methods add edits; a later one overrides an earlier one.
pub(super) struct Insertion {
    ticks: u64,
    operator: OperatorTraits,
    edits: Vec<Edit>,
}

impl Insertion {
    pub(super) fn of_ticks(ticks: u64) -> Self {
        Self { ticks, operator: OperatorTraits::UNKNOWN, edits: vec![] }
    }

    /// Sets the known traits of the operator: the slave's motion per intended motion (`None` if unknown), and whether
    /// changes of the felt force are noticed.
    pub(super) fn by(mut self, intended_scale: Option<f64>, notices: bool) -> Self {
        self.operator = OperatorTraits { intended_scale, notices };
        self
    }

    pub(super) fn with(mut self, edit: impl Fn(&mut Signals<f64>) + 'static) -> Self {
        self.edits.push(Box::new(edit));
        self
    }

    pub(super) fn from(self, tick: u64, edit: impl Fn(&mut Signals<f64>) + 'static) -> Self {
        self.with(move |s| {
            if s.tick >= tick {
                edit(s);
            }
        })
    }

    pub(super) fn at(self, tick: u64, edit: impl Fn(&mut Signals<f64>) + 'static) -> Self {
        self.with(move |s| {
            if s.tick == tick {
                edit(s);
            }
        })
    }

    pub(super) fn rupture_at(self, tick: u64) -> Self {
        self.at(tick, |s| {
            s.ruptured = true;
            s.tissue_force_n += 1e-9;
        })
    }

    pub(super) fn alarm_at(self, tick: u64) -> Self {
        self.at(tick, |s| (s.alarm, s.alarm_taken) = (true, true))
    }

    pub(super) fn ignored_alarm_at(self, tick: u64) -> Self {
        self.at(tick, |s| s.alarm = true)
    }

    pub(super) fn noticed_at(self, tick: u64) -> Self {
        self.at(tick, |s| s.noticed = true)
    }

    pub(super) fn event(self, [alarm, released, ended]: [u64; 3]) -> Self {
        self.alarm_at(alarm).with(move |s| {
            if (alarm..released).contains(&s.tick) {
                s.mode = Modes::splat(Mode::Augmented);
            } else if (released..ended).contains(&s.tick) {
                s.mode = Modes::splat(Mode::Reengaging);
            }
        })
    }

    pub(super) fn signals(&self, tick: u64) -> Signals<f64> {
        let position_m = 1e-5 * tick as f64;
        let mut signals = Signals {
            tick,
            desired_position_m: position_m,
            intended_position_m: position_m,
            master_position_m: position_m,
            master_velocity_m_per_s: 0.01,
            operator_force_n: 2.0,
            slave_reference_m: position_m,
            slave_position_m: position_m,
            slave_velocity_m_per_s: 0.01,
            tissue_force_n: 2.0,
            measured_force_n: 2.0,
            feedback_force_n: 2.0,
            stiffness_n_per_m: 0.0,
            damping_n_s_per_m: 0.0,
            extra_parameter: 0.0,
            residual_n: 0.0,
            distance: 0.0,
            decision: 0.0,
            mode: Modes::splat(Mode::Teleoperation),
            ruptured: false,
            noticed: false,
            alarm: false,
            alarm_taken: false,
            commanded_force_n: 2.0,
            allowed_force_step_n: 0.0,
        };
        self.edits.iter().for_each(|edit| edit(&mut signals));
        signals
    }

    pub(super) fn ticks(&self) -> u64 {
        self.ticks
    }

    pub(super) fn operator(&self) -> OperatorTraits {
        self.operator
    }

    pub(super) fn metrics(&self) -> Metrics {
        let grid = TickGrid::new(TICK_S, TICK_S * self.ticks as f64).expect("a grid");
        let mut observer = MetricsObserver::<f64>::new(grid, 4).of_operators(|_| self.operator);
        for tick in 0..self.ticks {
            observer.observe(&self.signals(tick));
            if observer.is_done() {
                break;
            }
        }
        observer.metrics(0)
    }

    /// Checks metrics by their keys; `None` is an undefined metric.
    #[track_caller]
    pub(super) fn expect<const N: usize>(&self, expected: [(&str, Option<f64>); N]) {
        let metrics = self.metrics();
        for (key, expected) in expected {
            assert_close(RunMetric::named(key).expect(key).read(&metrics), expected, key);
        }
    }
}

#[track_caller]
pub(super) fn assert_close(value: Option<f64>, expected: Option<f64>, what: &str) {
    let is_close = match (value, expected) {
        (Some(value), Some(expected)) => (value - expected).abs() <= 1e-12 + 1e-9 * expected.abs(),
        _ => value == expected,
    };
    assert!(is_close, "{what}: {value:?} instead of {expected:?}");
}

#[cfg(target_arch = "x86_64")]
pub(super) fn side_by_side<L: trocar_core::lane::Lane>(all: &[Signals<f64>; 8]) -> Signals<L> {
    macro_rules! gathered {
        (numbers { $($number:ident)* } masks { $($mask:ident)* }) => {
            Signals {
                tick: all[0].tick,
                mode: Modes::from_codes(L::from_lanes(|lane| all[lane].mode.codes())),
                $($number: L::from_lanes(|lane| all[lane].$number),)*
                $($mask: trocar_core::lane::gather_mask::<L>(std::array::from_fn(|lane| all[lane].$mask)),)*
            }
        };
    }
    gathered! {
        numbers { desired_position_m intended_position_m master_position_m master_velocity_m_per_s operator_force_n
            slave_reference_m slave_position_m slave_velocity_m_per_s tissue_force_n measured_force_n feedback_force_n
            stiffness_n_per_m damping_n_s_per_m extra_parameter residual_n distance decision commanded_force_n
            allowed_force_step_n }
        masks { ruptured noticed alarm alarm_taken }
    }
}
