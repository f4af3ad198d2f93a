//! The exact steps of the machines, reused because matrix exponentials are expensive.

use super::{LinearLoop, StabilityError};
use trocar_engine::plant::{
    ArmParameters, ArmedStep, ControlTiming, GeneralMaster, MASTER_STATES, MachineStep, MasterModelSettings,
    MasterParameters, MasterStep, MotorStep, PlantError, SLAVE_STATES, SampledGains, SlaveParameters, SlaveStep,
};

#[derive(Debug, Clone, PartialEq)]
struct StepParameters {
    tick_s: f64,
    timing: ControlTiming,
    master: MasterParameters,
    master_model: MasterModelSettings,
    arm: ArmParameters,
    slave: SlaveParameters,
    lags_s: (f64, f64),
    shares: (f64, f64),
}

impl StepParameters {
    fn of(settings: &LinearLoop) -> Self {
        Self {
            tick_s: settings.tick_s,
            timing: settings.timing,
            master: settings.master,
            master_model: settings.master_model.clone(),
            arm: settings.arm,
            slave: settings.slave.clone(),
            lags_s: (settings.actuators.master_lag_s, settings.actuators.slave_lag_s),
            shares: (settings.forward().share, settings.backward().share),
        }
    }
}

/// `late_*`: over the rest of a tick after a sample arrives within it.
#[derive(Debug, Clone)]
pub(super) struct Machines {
    parameters: StepParameters,
    pub(super) master: MasterStep,
    pub(super) slave: SlaveStep,
    pub(super) motors: Option<(MotorStep<MASTER_STATES>, MotorStep<SLAVE_STATES>)>,
    pub(super) late_master: Option<MasterStep>,
    pub(super) late_slave: Option<SlaveStep>,
    /// Replaces `slave` and its motor.
    pub(super) general: Option<(MachineStep, SampledGains)>,
    /// Replaces `master` and its motor; includes the arm.
    pub(super) general_master: Option<ArmedStep>,
}

impl Machines {
    pub(super) fn new(settings: &LinearLoop) -> Result<Self, StabilityError> {
        let parameters = StepParameters::of(settings);
        let StepParameters { tick_s, timing, master, master_model, arm, slave, lags_s, shares } = &parameters;
        let general = settings.has_general_machine().then(|| MachineStep::new(slave, *tick_s)).transpose()?;
        let unused = SlaveParameters::default();
        let of_appendix = if general.is_some() { &unused } else { slave };
        let of_machine = |tick_s| -> Result<(MasterStep, SlaveStep), PlantError> {
            Ok(match timing {
                ControlTiming::Continuous => {
                    (MasterStep::new(master, arm, *timing, tick_s)?, SlaveStep::new(of_appendix, *timing, tick_s)?)
                }
                ControlTiming::Sampled => {
                    (MasterStep::of_machine(master, arm, tick_s)?, SlaveStep::of_machine(of_appendix, tick_s)?)
                }
            })
        };
        let (master_step, slave_step) = of_machine(*tick_s)?;
        let late = |share: f64| -> Result<Option<(MasterStep, SlaveStep)>, PlantError> {
            (share > 0.0).then(|| of_machine((1.0 - share) * tick_s)).transpose()
        };
        Ok(Self {
            motors: match timing {
                ControlTiming::Continuous => None,
                ControlTiming::Sampled => Some((
                    MasterStep::of_motor(master, arm, *tick_s, lags_s.0)?,
                    SlaveStep::of_motor(of_appendix, *tick_s, lags_s.1)?,
                )),
            },
            late_master: late(shares.1)?.map(|(master, _)| master),
            late_slave: late(shares.0)?.map(|(_, slave)| slave),
            master: master_step,
            slave: slave_step,
            general_master: master_model
                .is_general()
                .then(|| ArmedStep::new(&GeneralMaster { parameters: master, model: master_model, arm }, *tick_s))
                .transpose()?,
            general: general.map(|step| (step, SampledGains::of(slave, *tick_s))),
            parameters,
        })
    }

    pub(super) fn matches(&self, settings: &LinearLoop) -> bool {
        let StepParameters { tick_s, timing, master, master_model, arm, slave, lags_s, shares } = &self.parameters;
        let LinearLoop { actuators, .. } = settings;
        *tick_s == settings.tick_s
            && *timing == settings.timing
            && *master == settings.master
            && *master_model == settings.master_model
            && *arm == settings.arm
            && *slave == settings.slave
            && *lags_s == (actuators.master_lag_s, actuators.slave_lag_s)
            && *shares == (settings.forward().share, settings.backward().share)
    }
}
