//! The two sides of a link as two processes.

use std::sync::Arc;

use super::super::{Any, Engine, ExactPlants, MasterSide, Plants, ScheduledAlarms, SideEngine, SlaveSide, Trace};
use crate::channel::Delay;
use crate::operator::{HumanOperator, Motion, Ramp};
use crate::plant::{ArmParameters, ControlTiming, MasterParameters, MasterStep, SlaveParameters, SlaveStep};
use crate::sensor::{AnySensor, SensorSettings};
use crate::teleoperation::{
    ControllerSettings, Lines, Link, LinkSettings, Machines, PassivitySettings, Received, RecoverySettings, Scheme,
};
use crate::tissue::{AnyTissue, KelvinVoigt, KelvinVoigtSettings};
use trocar_core::augmentation::{AugmentationSettings, Supervisor};
use trocar_core::chain::Chain;
use trocar_core::detector::{CusumDetector, DetectorSettings};
use trocar_core::estimation::{AnyEstimator, RlsSettings};
use trocar_core::time::TickGrid;

const TICK_S: f64 = 1e-3;

/// A hand that moves at 20 mm/s to 20 mm, in a spring and a damper, with delays each way in ticks, a scheme, and an
/// alarm at tick 600.
struct Case {
    delays: [u64; 2],
    scheme: Scheme,
}

impl Case {
    fn plants(&self) -> ExactPlants<f64> {
        let (master, arm, slave) = (MasterParameters::default(), ArmParameters::default(), SlaveParameters::default());
        let master = MasterStep::new(&master, &arm, ControlTiming::Continuous, TICK_S).expect("valid");
        ExactPlants::new(&master, &self.slave(&slave), 0.0, 0.0)
    }

    fn slave(&self, slave: &SlaveParameters) -> SlaveStep {
        SlaveStep::new(slave, ControlTiming::Continuous, TICK_S).expect("valid")
    }

    fn parts(&self) -> Any<f64> {
        let slave = SlaveParameters::default();
        let (drag, inertia) = slave.slow_motion().expect("valid");
        let machines = Machines {
            master_mass_kg: MasterParameters::DEFAULT.mass_kg,
            master_damping_n_s_per_m: MasterParameters::DEFAULT.damping_n_s_per_m,
            proportional_gain: slave.proportional_gain,
            velocity_gain: slave.velocity_gain,
            slave_drag: drag,
            slave_inertia: inertia,
            compliance_m_per_n: 0.0,
            position_scale: 1.0,
            force_scale: 1.0,
        };
        let settings = LinkSettings {
            controller: ControllerSettings::DEFAULT,
            machines,
            recovery: RecoverySettings::DEFAULT,
            passivity: PassivitySettings { scheme: self.scheme, ..PassivitySettings::DEFAULT },
        };
        let [forward, backward] = self.delays;
        let lines = Lines {
            forward: Delay::new(forward, [0.0; 4]),
            backward: Delay::new(backward, [0.0; 5]),
            forward_payload: Delay::new(forward, [0.0; 4]),
            backward_payload: Delay::new(backward, [0.0; 4]),
        };
        let link = Link::new(&settings, lines, &self.slave(&slave), TICK_S, 0.0).expect("valid");
        let detector = DetectorSettings::default();
        let spring = KelvinVoigtSettings { stiffness_n_per_m: 300.0, ..Default::default() };
        super::super::Parts {
            operator: HumanOperator::new(Motion::Ramp(Ramp::new(0.0, 0.02, 0.02, TICK_S).expect("finite"))),
            tissue: AnyTissue::from(KelvinVoigt::new(&spring).expect("valid")),
            sensor: AnySensor::new(&SensorSettings::default(), TICK_S, (1, 0)).expect("valid"),
            chain: Chain {
                contact_m: 0.0,
                estimator: AnyEstimator::new(&RlsSettings::DEFAULT),
                detector: ScheduledAlarms::new(CusumDetector::new(&detector, TICK_S), Arc::from([600])),
            },
            supervisor: Supervisor::new(&AugmentationSettings::default(), detector.cusum.threshold, TICK_S, 0.0),
            link,
            safety: None,
            master_reading: None,
        }
    }

    fn grid(&self) -> TickGrid {
        TickGrid::new(TICK_S, 1.5).expect("a grid")
    }

    fn side(&self) -> SideEngine {
        let plants: Box<dyn Plants<f64> + Send> = Box::new(self.plants());
        Engine { grid: self.grid(), plants, parts: self.parts() }
    }

    fn trace(&self) -> Trace {
        let mut trace = Trace::new(self.grid());
        let mut engine = Engine { grid: self.grid(), plants: self.plants(), parts: self.parts() };
        engine.run(&mut trace).expect("a run");
        trace
    }
}

#[test]
fn two_sides_in_two_processes_equal_one_engine() {
    for (delays, scheme) in [([1, 1], Scheme::None), ([4, 2], Scheme::None), ([3, 5], Scheme::TimeDomain)] {
        let case = Case { delays, scheme };
        let together = case.trace();
        let (mut master, mut slave) = (MasterSide::new(case.side(), [0.0; 5]), SlaveSide::new(case.side(), [0.0; 4]));
        let (mut of_master, mut of_slave) = (Trace::new(case.grid()), Trace::new(case.grid()));
        let (mut forward, mut forward_payload) = (Delay::new(delays[0], [0.0; 4]), Delay::new(delays[0], [0.0; 4]));
        let (mut backward, mut backward_payload) = (Delay::new(delays[1], [0.0; 5]), Delay::new(delays[1], [0.0; 4]));
        for tick in 0..1500 {
            assert!(!master.has_ended() && !slave.has_ended());
            assert_eq!((master.tick(), slave.tick()), (tick, tick));
            let sent = master.send();
            let (arrival, payload) = (forward.exchange(sent.sample), forward_payload.exchange(sent.payload));
            let received = Received { sample: arrival.sample, payload: payload.sample, is_fresh: arrival.is_fresh };
            let sent = slave.step(&received, &mut of_slave).expect("a step");
            let (arrival, payload) = (backward.exchange(sent.sample), backward_payload.exchange(sent.payload));
            let received = Received { sample: arrival.sample, payload: payload.sample, is_fresh: arrival.is_fresh };
            master.step(&received, &mut of_master).expect("a step");
        }
        assert!(master.has_ended() && slave.has_ended());
        assert_eq!(of_master.master_position_m, together.master_position_m, "{delays:?}");
        assert_eq!(of_master.operator_force_n, together.operator_force_n);
        assert_eq!(of_master.feedback_force_n, together.feedback_force_n);
        assert_eq!(of_master.desired_position_m, together.desired_position_m);
        assert_eq!(of_slave.slave_position_m, together.slave_position_m);
        assert_eq!(of_slave.slave_reference_m, together.slave_reference_m);
        assert_eq!(of_slave.mode, together.mode);
        assert_eq!((of_master.slave_position_m[700], of_slave.master_position_m[700]), (0.0, 0.0), "the other side");
        assert_eq!(master.promised_j().is_some(), scheme != Scheme::None);
        assert_eq!(master.promised_j(), slave.promised_j());
        // Energies of the ports, up to the last tick that each side has sent.
        let (e_m, e_s) = (together.master_energy_j[1499], together.needle_energy_j[1499]);
        assert!((master.energy_j() - e_m).abs() < 1e-9, "{} {e_m}", master.energy_j());
        assert!((slave.energy_j() - e_s).abs() < 1e-9, "{} {e_s}", slave.energy_j());
        assert!(format!("{master:?} {slave:?}").contains("MasterSide { tick: 1500"));
    }
}
