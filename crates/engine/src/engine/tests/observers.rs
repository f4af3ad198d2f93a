//! Traces, energies, and combined observers.

use std::sync::Arc;

use super::super::{
    Additional, COLUMNS, ColumnValues, EventObserver, Observer, PortEnergies, ScheduledAlarms, SelectedSignals,
    Signals, TRACE_COLUMNS, TRUST_COLUMNS, Trace, TrustColumns,
};
use trocar_core::augmentation::{Mode, Modes};
use trocar_core::detector::{Decision, Detector, DetectorInput};
use trocar_core::estimation::Confidence;
use trocar_core::time::TickGrid;

fn signals(tick: u64) -> Signals<f64> {
    let mut number = 100.0 * tick as f64;
    let mut next = || {
        number += 1.0;
        number
    };
    Signals {
        tick,
        desired_position_m: next(),
        master_position_m: next(),
        master_velocity_m_per_s: next(),
        operator_force_n: next(),
        slave_reference_m: next(),
        slave_position_m: next(),
        slave_velocity_m_per_s: next(),
        tissue_force_n: next(),
        measured_force_n: next(),
        feedback_force_n: next(),
        stiffness_n_per_m: next(),
        damping_n_s_per_m: next(),
        residual_n: next(),
        distance: next(),
        decision: next(),
        intended_position_m: next(),
        extra_parameter: next(),
        commanded_force_n: next(),
        allowed_force_step_n: next(),
        mode: Modes::splat(Mode::Reengaging),
        ruptured: tick == 1,
        noticed: false,
        alarm: tick == 2,
        alarm_taken: false,
    }
}

fn grid(ticks: u64) -> TickGrid {
    TickGrid::new(1e-3, 1e-3 * ticks as f64).expect("a grid")
}

#[test]
fn the_columns_of_a_trace_are_the_signals_of_the_same_names_in_file_order() {
    let mut trace = Trace::new(grid(10)).with_extra_parameter(Some("friction_n"));
    (0..3).for_each(|tick| trace.observe(&signals(tick)));
    assert_eq!(
        COLUMNS[..6],
        [
            "time_s",
            "desired_position_m",
            "master_position_m",
            "master_velocity_m_per_s",
            "operator_force_n",
            "slave_reference_m"
        ]
    );
    assert_eq!(COLUMNS[16..], ["mode", "hand_energy_j", "master_energy_j", "reference_energy_j", "needle_energy_j"]);
    for (place, values) in trace.columns().into_iter().enumerate() {
        match (place, values) {
            (0, ColumnValues::Numbers(values)) => assert_eq!(values, [0.0, 0.001, 0.002]),
            (1..16, ColumnValues::Numbers(values)) => {
                assert_eq!(values, [0.0, 100.0, 200.0].map(|first| first + place as f64), "{}", COLUMNS[place]);
            }
            (16, ColumnValues::Codes(values)) => assert_eq!(values, [2, 2, 2]),
            (17.., ColumnValues::Numbers(values)) => assert_eq!(values[0], 0.0),
            (_, values) => panic!("{}: {values:?}", COLUMNS[place]),
        }
    }
    assert_eq!(trace.extra_parameter, Some(("friction_n", vec![17.0, 117.0, 217.0])));
    assert_eq!((trace.len(), trace.is_empty(), trace.numbers().len()), (3, false, COLUMNS.len() - 1));
    assert!(Trace::new(grid(10)).is_empty());
    let taken = trace.take_columns();
    assert_eq!(taken[1], ColumnValues::Numbers(vec![1.0, 101.0, 201.0]));
    assert!(trace.is_empty());
}

#[test]
fn the_unit_of_a_column_matches_its_name() {
    for column in TRACE_COLUMNS.iter().chain(&TRUST_COLUMNS) {
        let suffix = match column.unit {
            "m" => "_m",
            "m/s" => "_m_per_s",
            "s" => "_s",
            "N" => "_n",
            "N/m" => "_n_per_m",
            "N·s/m" => "_n_s_per_m",
            "J" => "_j",
            "N²" | "" => "",
            unit => panic!("{unit}"),
        };
        assert!(column.name.ends_with(suffix) && column.meaning.ends_with('.'), "{column:?}");
    }
}

#[test]
fn a_recorder_writes_the_same_trace_as_an_observer() {
    for ticks in [1, 63, 64, 65, 200] {
        let mut observed = Trace::new(grid(200)).with_extra_parameter(Some("friction_n"));
        let mut recorded = observed.clone();
        {
            let mut recorder = recorded.recorder();
            for tick in 0..ticks {
                observed.observe(&signals(tick));
                recorder.observe(&signals(tick));
            }
        }
        assert_eq!(observed, recorded, "{ticks}");
    }
}

#[test]
fn the_energies_of_the_ports_are_the_work_at_the_ports() {
    let mut energies = PortEnergies::default();
    let mut at = |hand: (f64, f64, f64), needle: (f64, f64, f64)| {
        let (master_position_m, operator_force_n, feedback_force_n) = hand;
        let (slave_reference_m, slave_position_m, tissue_force_n) = needle;
        energies.add(&Signals {
            master_position_m,
            operator_force_n,
            feedback_force_n,
            slave_reference_m,
            slave_position_m,
            tissue_force_n,
            ..signals(0)
        });
        [energies.hand_j, energies.master_j, energies.reference_j, energies.needle_j]
    };
    assert_eq!(at((1.0, 2.0, 3.0), (4.0, 5.0, 6.0)), [0.0; 4]);
    // Hand: (2 + 4) / 2 over 2 m. Feedback force of the last tick: 3 over 2 m. Reference: the present force 8 over 1 m.
    // Needle: (6 + 8) / 2 over 0.5 m.
    assert_eq!(at((3.0, 4.0, 9.0), (5.0, 5.5, 8.0)), [6.0, 6.0, 8.0, 3.5]);
    // Back: (4 + 0) / 2 and 9 over -1 m; 2 over -2 m; (8 + 2) / 2 over -1 m.
    assert_eq!(at((2.0, 0.0, 0.0), (3.0, 4.5, 2.0)), [4.0, -3.0, 4.0, -1.5]);
}

#[test]
fn the_confidence_of_a_trace_requires_the_contact_and_counts_from_it() {
    let mut trace = Trace::new(grid(400));
    for tick in 0..400 {
        let t = 1e-3 * tick as f64;
        trace.observe(&Signals {
            slave_position_m: 0.01 * (9.0 * t).sin(),
            slave_velocity_m_per_s: 0.09 * (9.0 * t).cos(),
            residual_n: if tick % 2 == 0 { 0.01 } else { -0.01 },
            stiffness_n_per_m: 300.0,
            damping_n_s_per_m: -5.0,
            ..signals(tick)
        });
    }
    assert_eq!(trace.trust(), None);
    let trust = trace.with_contact(0.002).trust().expect("the contact is known");
    let mut confidence = Confidence::new(1e-3);
    let mut in_contact = 0;
    for tick in 0..400 {
        let t = 1e-3 * f64::from(tick);
        let depth_m = 0.01 * (9.0 * t).sin() - 0.002;
        if depth_m > 0.0 {
            confidence.add(depth_m, 0.09 * (9.0 * t).cos(), if tick % 2 == 0 { 0.01 } else { -0.01 });
            in_contact += 1;
        }
        let (now, k) = (confidence.trust(), tick as usize);
        assert_eq!(trust.stiffness_std_n_per_m[k], now.stiffness_std_n_per_m);
        assert_eq!(trust.damping_std_n_s_per_m[k], now.damping_std_n_s_per_m);
        assert_eq!(trust.excitation[k], now.excitation);
        let out = if depth_m > 0.0 { 0 } else { 8 };
        assert_eq!(trust.estimate_flags[k], now.flags(300.0, -5.0) | out);
        assert_ne!(trust.estimate_flags[k] & 4, 0, "a negative damping");
    }
    assert!((100..390).contains(&in_contact), "{in_contact}");
    let [k, b, excitation, flags] = trust.columns();
    assert_eq!(
        (k, b),
        (ColumnValues::Numbers(&*trust.stiffness_std_n_per_m), ColumnValues::Numbers(&*trust.damping_std_n_s_per_m))
    );
    assert_eq!(
        (excitation, flags),
        (ColumnValues::Numbers(&*trust.excitation), ColumnValues::Codes(&*trust.estimate_flags))
    );
    assert!(TrustColumns::of((0.0, 1e-3), (&[], &[]), &[], (&[], &[])).excitation.is_empty());
}

/// Counts the received ticks, and is done after a number of ticks.
struct Counting(u64, u64);

impl Observer<f64> for Counting {
    fn observe(&mut self, _signals: &Signals<f64>) {
        self.0 += 1;
    }
    fn is_done(&self) -> bool {
        self.0 >= self.1
    }
}

#[test]
fn the_second_observer_does_not_receive_the_tick_at_which_the_first_is_done() {
    let mut both = (Counting(0, 3), Counting(0, 100));
    let observe = |both: &mut (Counting, Counting)| {
        both.observe(&signals(0));
        both.is_done()
    };
    assert_eq!([observe(&mut both), observe(&mut both), observe(&mut both)], [false, false, true]);
    assert_eq!((both.0.0, both.1.0), (3, 2));
    let mut both = (Counting(0, 100), Counting(0, 1));
    assert!(observe(&mut both), "the second is done");
    let mut one = Counting(0, 1);
    let mut borrowed = &mut one;
    assert!(!borrowed.is_done());
    Observer::observe(&mut borrowed, &signals(0));
    assert!(borrowed.is_done() && one.0 == 1);
}

struct Happened(Vec<SelectedSignals<f64>>);

impl EventObserver<f64> for Happened {
    fn observe(&mut self, selected: &SelectedSignals<f64>) {
        self.0.push(*selected);
    }
}

#[test]
fn an_additional_observer_is_optional() {
    let mut happened = Happened(vec![]);
    let mut additional = Additional(Some(&mut happened as &mut dyn EventObserver<f64>));
    (0..3).for_each(|tick| additional.observe(&signals(tick)));
    assert!(!additional.is_done());
    let (seen, signal) = (happened.0[2], signals(2));
    assert_eq!((seen.tick, seen.intended_position_m, seen.slave_position_m), (2, 216.0, 206.0));
    assert_eq!((seen.residual_n, seen.decision), (signal.residual_n, signal.decision));
    assert_eq!((seen.ruptured, seen.alarm, happened.0[1].ruptured), (false, true, true));
    Additional::<f64>(None).observe(&signal);
}

struct Quiet;

impl Detector<f64> for Quiet {
    fn update(&mut self, _input: &DetectorInput<f64>) -> Decision<f64> {
        Decision { distance: 1.0, decision: 2.0, alarm: false }
    }
}

#[test]
fn scheduled_alarms_are_raised_at_their_ticks_in_addition_to_the_detectors_alarms() {
    let input = DetectorInput {
        force_n: 0.0,
        predicted_force_n: 0.0,
        residual_n: 0.0,
        correction: [0.0; 2],
        depth_m: 0.0,
        velocity_m_per_s: 0.0,
        in_contact: false,
    };
    let alarms = |ticks: &[u64]| -> Vec<usize> {
        let mut detector = ScheduledAlarms::new(Quiet, Arc::from(ticks));
        let mut update = |_: &usize| {
            let decision = detector.update(&input);
            assert_eq!((decision.distance, decision.decision), (1.0, 2.0));
            decision.alarm
        };
        (0..20).filter(&mut update).collect()
    };
    assert_eq!(alarms(&[]), [0_usize; 0]);
    assert_eq!(alarms(&[0, 3, 4, 15, 99]), [0, 3, 4, 15]);
}
