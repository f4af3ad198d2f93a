//! The components of a tick, each run alone.

use trocar::augmentation::{Supervisor, SupervisorInput};
use trocar::detector::{CusumDetector, Detector, DetectorInput, SquaredResidual};
use trocar::engine::{ExactPlants, Observer, Plants, Signals, TissueForce};
use trocar::estimation::{Estimator, Rls};
use trocar::metrics::MetricsObserver;
use trocar::sensor::ForceSensor;
use trocar::tissue::{AnyTissue, Tissue};

/// A component that runs once per tick.
pub trait Part: Clone {
    type Input: Copy;
    /// Processes a tick's input. Returns bits of the result, so that the compiler removes nothing.
    fn tick(&mut self, input: &Self::Input) -> u64;
}

/// Declares a part by its name, its input and its tick.
macro_rules! part {
    ($(#[$doc:meta])* $Name:ident($Inner:ty), $Input:ty, |$inner:ident, $input:ident| $tick:expr) => {
        $(#[$doc])*
        #[derive(Clone)]
        pub struct $Name(pub $Inner);

        impl Part for $Name {
            type Input = $Input;

            #[inline(always)]
            fn tick(&mut self, $input: &$Input) -> u64 {
                let $inner = &mut self.0;
                $tick
            }
        }
    };
}

part!(
    /// Nothing; measures the cost of the loop.
    Nothing(()), f64, |_nothing, input| input.to_bits()
);
part!(BothPlants(ExactPlants<f64>), [f64; 4], |plants, input| {
    let [desired_m, next_m, force_n, reference_m] = *input;
    let stepped = plants.step(desired_m, next_m, force_n, reference_m, 0.0, TissueForce::zero()).is_ok();
    plants.slave().position_m.to_bits() ^ u64::from(stepped)
});
part!(TissuePart(AnyTissue<f64>), (u64, f64, f64), |tissue, input| {
    let (tick, position_m, velocity_m_per_s) = *input;
    let reaction = tissue.react(tick, position_m, velocity_m_per_s);
    reaction.force_n.to_bits() ^ u64::from(reaction.ruptured)
});
part!(SlaveMeasurement(ForceSensor<f64>), f64, |sensor, force_n| sensor.read_force(*force_n).to_bits());
part!(Estimated(Rls<f64>), [f64; 3], |estimator, input| {
    let [force_n, depth_m, velocity_m_per_s] = *input;
    estimator.update(force_n, depth_m, velocity_m_per_s).residual_n.to_bits()
});
part!(Detected(CusumDetector<f64, SquaredResidual<f64>>), DetectorInput<f64>, |detector, detector_input| {
    let decision = detector.update(detector_input);
    decision.decision.to_bits() ^ u64::from(decision.alarm)
});
part!(Adapting(CusumDetector<f64>), DetectorInput<f64>, |detector, detector_input| {
    let decision = detector.update(detector_input);
    decision.decision.to_bits() ^ u64::from(decision.alarm)
});
part!(Supervised(Supervisor<f64>), (SupervisorInput<f64>, [f64; 2]), |supervisor, input| {
    let command = supervisor.update(&input.0, input.1[0], input.1[1]);
    command.slave_reference_m.to_bits() ^ command.feedback_force_n.to_bits()
});
part!(Observed(MetricsObserver<f64>), Signals<f64>, |observer, signals| {
    observer.observe(signals);
    u64::from(observer.is_done())
});
