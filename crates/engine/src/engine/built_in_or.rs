use super::{IntegrationError, MasterOutput, Plants, SlaveOutput, TissueForce};
use crate::operator::Operator;
use crate::teleoperation::{AtMaster, AtSlave, Connection, LinkReport};
use crate::tissue::{Reaction, Tissue};
use trocar_core::augmentation::{AugmentedTick, ForceLaw, ModeChange, Modes, MotionLaw};
use trocar_core::detector::{Decision, Detector, DetectorInput};
use trocar_core::estimation::{Estimate, Estimator};

/// A built-in part is inlined, a user-defined part called dynamically.
pub enum BuiltInOr<B, D: ?Sized> {
    BuiltIn(B),
    UserDefined(Box<D>),
}

trocar_core::variants!(each of BuiltInOr { BuiltIn, UserDefined });

macro_rules! by_the_part_that_is_there {
    ($Trait:ident { $(fn $name:ident($($reference:tt)+) ($($argument:ident: $Type:ty),*) $(-> $Result:ty)?;)* }) => {
        impl<B: $Trait<f64>> $Trait<f64> for BuiltInOr<B, dyn $Trait<f64> + Send> {
            $(
                #[inline(always)]
                fn $name($($reference)+, $($argument: $Type),*) $(-> $Result)? {
                    by_the_part_that_is_there!(@call $name($($reference)+) ($($argument),*))
                }
            )*
        }
    };
    (@call $name:ident(&mut $self:ident) ($($argument:ident),*)) => {
        each!($self, part => part.$name($($argument),*))
    };
    (@call $name:ident(&$self:ident) ($($argument:ident),*)) => {
        each!($self, part => part.$name($($argument),*))
    };
}

by_the_part_that_is_there!(Operator {
    fn desired_position_m(&mut self)(tick: u64, felt_n: f64) -> f64;
    fn intended_position_m(&self)(desired_m: f64) -> f64;
    fn master(&mut self)(position_m: f64);
    fn cue(&mut self)(is_on: bool);
    fn notices(&self)() -> bool;
});

by_the_part_that_is_there!(Tissue {
    fn react(&mut self)(tick: u64, position_m: f64, velocity_m_per_s: f64) -> Reaction<f64>;
    fn shaft_force_n(&self)() -> f64;
});

by_the_part_that_is_there!(Estimator {
    fn update(&mut self)(force_n: f64, depth_m: f64, velocity_m_per_s: f64) -> Estimate<f64>;
    fn skip(&mut self)();
});

by_the_part_that_is_there!(Detector {
    fn update(&mut self)(input: &DetectorInput<f64>) -> Decision<f64>;
});

by_the_part_that_is_there!(Connection {
    fn position_scale(&self)() -> f64;
    fn force_scale(&self)() -> f64;
    fn to_slave(&mut self)(master: &AtMaster<f64>, slave: &AtSlave<f64>) -> f64;
    fn limit_reference(&mut self)(reference_m: f64, slave: &AtSlave<f64>) -> f64;
    fn to_master(&mut self)(mode: Modes<f64>, slave: &AtSlave<f64>, master: &AtMaster<f64>) -> (Modes<f64>, f64);
    fn limit(&mut self)(force_n: f64, master: &AtMaster<f64>) -> f64;
    fn deflection_m(&self)(tissue_force_n: f64) -> f64;
    fn report(&self)(index: usize) -> Option<LinkReport>;
});

by_the_part_that_is_there!(MotionLaw {
    fn follow(&mut self)(hand_m: f64, slave_m: f64) -> f64;
    fn update(&mut self)(modes: ModeChange<f64>, hand_m: f64, slave_m: f64) -> f64;
    fn sense(&mut self)(force_n: f64);
    fn is_blended(&self)() -> bool;
});

by_the_part_that_is_there!(ForceLaw {
    fn augmented(&mut self)(now: &AugmentedTick<f64>) -> (f64, f64);
});

by_the_part_that_is_there!(Plants {
    fn master(&self)() -> MasterOutput<f64>;
    fn slave(&self)() -> SlaveOutput<f64>;
    fn step(&mut self)(desired: f64, desired_next: f64, feedback: f64, reference: f64, deflection: f64, force: TissueForce<f64>) -> Result<(), IntegrationError>;
});
