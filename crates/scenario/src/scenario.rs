//! A scenario, and the table of its groups of keys.
//!
//! A new group needs its settings in a file beside the part, a field of [`Scenario`] with its value in
//! [`Scenario::unread`], and a row of [`GROUPS`].

use std::ops::Range;
use std::sync::{Arc, OnceLock};

use trocar_core::error::InvalidValue;
use trocar_core::settings::Key;

use super::clutch::{ClutchSettings, clutch};
use super::engine_kind::EngineKind;
use super::error::ScenarioError;
use super::link::link_settings;
use super::machine_file::{MasterFileSettings, SlaveFileSettings, read_master, read_slave};
use super::replay::RecordingSpec;
use super::resolve::{DelayTicks, delays, waits_for_tick};
use super::run_settings::RunSettings;
use super::schedule::{events, schedules};
use super::schedule_settings::{EventSettings, ScheduleSettings};
use super::settings::{actuators, arm, master};
use super::spared::{AimSettings, check_spared};
use super::specs::{OperatorSpec, TissueSpec, operator, stated_tissue, tissue};
use super::steps::Steps;
use super::values::Values;
use crate::population::PopulationSettings;
use trocar_core::augmentation::AugmentationSettings;
use trocar_core::detector::DetectorSettings;
use trocar_core::estimation::{ContactSettings, RlsSettings};
use trocar_core::rig;
use trocar_core::safety::SafetySettings;
use trocar_core::time::TickGrid;
use trocar_engine::channel::{DelaySettings, Irregularity, Schedule};
use trocar_engine::operator::{
    MotionSettings, Perception, ReflexSettings, StiffeningSettings, StretchSettings, TremorSettings,
};
use trocar_engine::plant::{
    ActuatorLimits, ArmParameters, ArmRoles, ControlTiming, Grip, MasterModelSettings, MasterParameters,
    SlaveParameters,
};
use trocar_engine::sensor::SensorSettings;
use trocar_engine::teleoperation::{
    ComplianceSettings, ControllerSettings, EncoderSettings, LinkSettings, Machines, PassivitySettings,
    RecoverySettings, Scales,
};
use trocar_engine::tissue::{LAYER_KEYS, OrganMotion, ReplayIndex, TissueSettings};
use trocar_recording::{ColumnSettings, FileSettings, Limits, OffsetSettings, Resampled, ScaleSettings, SignSettings};

#[derive(Debug, Clone)]
pub struct Scenario {
    /// Also the name of the output folder.
    pub name: String,
    pub grid: TickGrid,
    /// How the plants are stepped.
    pub engine: EngineKind,
    pub timing: ControlTiming,
    pub seed: u64,
    pub master: MasterParameters,
    /// The model of a master other than the appendix'.
    pub master_model: MasterModelSettings,
    pub encoder: EncoderSettings,
    pub clutch: Arc<[Range<u64>]>,
    pub arm: ArmParameters,
    pub slave: SlaveParameters,
    pub actuators: ActuatorLimits,
    pub link: LinkSettings,
    /// Master to slave.
    pub forward: DelayTicks,
    /// Slave to master.
    pub backward: DelayTicks,
    /// In s.
    pub delays: DelaySettings,
    pub irregularity: Irregularity,
    /// Master to slave.
    pub forward_schedule: Schedule,
    /// Slave to master.
    pub backward_schedule: Schedule,
    pub operator: OperatorSpec,
    pub tremor: TremorSettings,
    /// The stretch reflexes of the operator's arm.
    pub stretch: StretchSettings,
    /// The stiffening of the operator's arm under load.
    pub stiffening: StiffeningSettings,
    /// The operator's reaction to a drop of the felt force.
    pub reflex: ReflexSettings,
    /// The operator's perception of a drop of the felt force.
    pub perception: Perception,
    pub tissue: TissueSpec,
    /// Spring (N/m) and damper (N·s/m) for a recorded force in the stability analysis. They do not affect a run.
    pub stated_tissue: Option<(f64, f64)>,
    /// The motion of the tissue with breathing and heartbeat.
    pub organ_motion: OrganMotion,
    pub sensor: SensorSettings,
    pub estimator: RlsSettings,
    /// The estimator's contact position.
    pub contact_m: f64,
    pub detector: DetectorSettings,
    pub augmentation: AugmentationSettings,
    /// For samples of a rig; they do not affect a run.
    pub rig_limits: rig::Limits,
    /// Of the commands to the motors.
    pub safety: SafetySettings,
    /// Ticks, increasing.
    pub events: Arc<[u64]>,
    /// For the limits of `trocar stability`; it does not affect a run.
    pub population: PopulationSettings,
    /// Shared by the scenarios of a [`Template`](super::Template).
    pub(super) values: Arc<Values>,
    /// Computed at the first use.
    pub(super) steps: Arc<OnceLock<Steps>>,
}

impl Scenario {
    pub(super) fn unread(
        name: String,
        grid: TickGrid,
        (engine, timing): (EngineKind, ControlTiming),
        seed: u64,
    ) -> Self {
        Self {
            name,
            grid,
            engine,
            timing,
            seed,
            master: MasterParameters::DEFAULT,
            master_model: MasterModelSettings::default(),
            encoder: EncoderSettings::DEFAULT,
            clutch: Arc::default(),
            arm: ArmParameters::DEFAULT,
            slave: SlaveParameters::default(),
            actuators: ActuatorLimits::DEFAULT,
            link: LinkSettings {
                controller: ControllerSettings::DEFAULT,
                machines: Machines::UNCOUPLED,
                recovery: RecoverySettings::DEFAULT,
                passivity: PassivitySettings::DEFAULT,
            },
            forward: DelayTicks::default(),
            backward: DelayTicks::default(),
            delays: DelaySettings::DEFAULT,
            irregularity: Irregularity::DEFAULT,
            forward_schedule: Schedule::default(),
            backward_schedule: Schedule::default(),
            operator: OperatorSpec::Recording(Arc::default()),
            tremor: TremorSettings::DEFAULT,
            stretch: StretchSettings::DEFAULT,
            stiffening: StiffeningSettings::DEFAULT,
            reflex: ReflexSettings::DEFAULT,
            perception: Perception::DEFAULT,
            tissue: TissueSpec::Recording { force_n: Arc::default(), rupture_ticks: Arc::default() },
            stated_tissue: None,
            organ_motion: OrganMotion::DEFAULT,
            sensor: SensorSettings::DEFAULT,
            estimator: RlsSettings::DEFAULT,
            contact_m: ContactSettings::DEFAULT.contact_m,
            detector: DetectorSettings::default(),
            augmentation: AugmentationSettings::DEFAULT,
            rig_limits: rig::Limits::DEFAULT,
            safety: SafetySettings::DEFAULT,
            events: Arc::default(),
            population: PopulationSettings::DEFAULT,
            values: Arc::default(),
            steps: Arc::default(),
        }
    }
}

impl Scenario {
    /// True if the master or the slave is another machine than the appendix'. The controllers of both then run on the
    /// tick, but for an appendix' master with continuous control.
    pub fn has_general_machine(&self) -> bool {
        self.master_model.is_general() || self.slave.is_general()
    }
}

/// Or a relation between groups, which has no keys.
#[derive(Debug)]
pub(super) struct Group {
    pub(super) sections: &'static [(&'static str, &'static str)],
    pub(super) keys: &'static [Key],
    also: &'static [&'static [Key]],
    /// Keys whose change needs the whole scenario resolved again.
    whole: &'static [Key],
    pub(super) read: fn(&mut ScenarioUpdate<'_>) -> Result<(), ScenarioError>,
}

impl Group {
    pub(super) fn depends_on(&self, key: &Key) -> bool {
        has(self.keys, key) || self.also.iter().any(|keys| has(keys, key))
    }

    pub(super) fn is_whole(&self, key: &Key) -> bool {
        has(self.whole, key)
    }
}

fn has(keys: &[Key], key: &Key) -> bool {
    keys.iter().any(|one| one.path == key.path)
}

pub(super) struct ScenarioUpdate<'a> {
    pub(super) scenario: &'a mut Scenario,
    pub(super) values: &'a mut Values,
    /// `None` if only some keys have changed: the scenario keeps its samples.
    pub(super) replay: Option<&'a (RecordingSpec, Resampled)>,
}

impl ScenarioUpdate<'_> {
    fn set<T>(
        &mut self,
        read: fn(&mut Values) -> Result<T, ScenarioError>,
        check: impl FnOnce(&T) -> Result<(), InvalidValue>,
        field: fn(&mut Scenario) -> &mut T,
    ) -> Result<(), ScenarioError> {
        let settings = read(self.values)?;
        check(&settings).map_err(|error| self.values.out_of_range(&error))?;
        *field(self.scenario) = settings;
        Ok(())
    }
}

const PLAIN: Group = Group { sections: &[], keys: &[], also: &[], whole: &[], read: |_| Ok(()) };

const OF_MACHINES: &[&[Key]] = &[
    MasterParameters::KEYS,
    MasterModelSettings::KEYS,
    Grip::KEYS,
    ArmRoles::KEYS,
    ArmParameters::KEYS,
    SlaveParameters::KEYS,
    ControllerSettings::KEYS,
];

const OF_LINK: &[&[Key]] = &[
    MasterParameters::KEYS,
    MasterModelSettings::KEYS,
    SlaveParameters::KEYS,
    ComplianceSettings::KEYS,
    Scales::KEYS,
    ControllerSettings::KEYS,
    RecoverySettings::KEYS,
    PassivitySettings::KEYS,
];

/// In the order of the keys in files, then the relations between groups.
pub(super) const GROUPS: &[Group] = &[
    Group {
        sections: &[("simulation", "Duration, tick and engine.")],
        keys: RunSettings::KEYS,
        whole: RunSettings::KEYS,
        ..PLAIN
    },
    Group {
        sections: &[("master", "The master (eq. 28, or another machine) and its force controller (eq. 29).")],
        keys: MasterParameters::KEYS,
        also: &[ControllerSettings::KEYS],
        read: |of| {
            of.scenario.master = master(of.values)?;
            Ok(())
        },
        ..PLAIN
    },
    Group {
        keys: MasterModelSettings::KEYS,
        read: |of| of.set(MasterModelSettings::read, MasterModelSettings::validate, |to| &mut to.master_model),
        ..PLAIN
    },
    Group {
        keys: EncoderSettings::KEYS,
        read: |of| of.set(EncoderSettings::read, EncoderSettings::validate, |to| &mut to.encoder),
        ..PLAIN
    },
    Group {
        keys: MasterFileSettings::KEYS,
        also: &[MasterModelSettings::KEYS],
        whole: MasterFileSettings::KEYS,
        read: |of| read_master(of.values, &mut of.scenario.master_model),
        ..PLAIN
    },
    Group {
        sections: &[("arm", "The operator's arm (eq. 32-35), in the paper's symbols.")],
        keys: Grip::KEYS,
        ..PLAIN
    },
    Group { keys: ArmRoles::KEYS, ..PLAIN },
    Group {
        keys: ArmParameters::KEYS,
        also: &[Grip::KEYS, ArmRoles::KEYS],
        read: |of| {
            of.scenario.arm = arm(of.values)?;
            Ok(())
        },
        ..PLAIN
    },
    Group {
        sections: &[("slave", "The slave (eq. 30, or another machine) and its position controller (eq. 31, or PID).")],
        keys: SlaveParameters::KEYS,
        read: |of| {
            of.scenario.slave = SlaveParameters::read(of.values)?;
            Ok(())
        },
        ..PLAIN
    },
    Group {
        keys: SlaveFileSettings::KEYS,
        also: &[SlaveParameters::KEYS],
        whole: SlaveFileSettings::KEYS,
        read: |of| read_slave(of.values, &mut of.scenario.slave),
        ..PLAIN
    },
    Group { keys: ComplianceSettings::KEYS, ..PLAIN },
    Group {
        sections: &[("actuator", "Limits of both motors; they need simulation.control = \"sampled\".")],
        keys: ActuatorLimits::KEYS,
        also: &[MasterModelSettings::KEYS, SlaveParameters::KEYS, ComplianceSettings::KEYS],
        read: |of| {
            let Scenario { timing, master_model, slave, .. } = &*of.scenario;
            of.scenario.actuators = actuators(of.values, *timing, (master_model, slave))?;
            Ok(())
        },
        ..PLAIN
    },
    Group { sections: &[("scaling", "Scale factors between the two sides.")], keys: Scales::KEYS, ..PLAIN },
    Group {
        sections: &[("controller", "The teleoperation architecture: which signals each side receives.")],
        keys: ControllerSettings::KEYS,
        ..PLAIN
    },
    Group { sections: &[("channel", "The link between master and slave.")], keys: DelaySettings::KEYS, ..PLAIN },
    Group {
        keys: Irregularity::KEYS,
        read: |of| {
            let tick_s = of.scenario.grid.tick_s();
            of.set(Irregularity::read, |settings| settings.validate_on_ticks(tick_s), |to| &mut to.irregularity)
        },
        ..PLAIN
    },
    Group {
        keys: ScheduleSettings::KEYS,
        whole: ScheduleSettings::KEYS,
        read: |of| {
            let (forward, backward) = schedules(of.values, &of.scenario.grid)?;
            (of.scenario.forward_schedule, of.scenario.backward_schedule) = (forward, backward);
            Ok(())
        },
        ..PLAIN
    },
    Group {
        keys: ClutchSettings::KEYS,
        also: &[PassivitySettings::KEYS],
        read: |of| {
            of.scenario.clutch = clutch(of.values, &of.scenario.grid)?;
            Ok(())
        },
        ..PLAIN
    },
    Group { keys: RecoverySettings::KEYS, ..PLAIN },
    Group {
        sections: &[("passivity", "The passivity scheme, which keeps the link from generating energy under delay.")],
        keys: PassivitySettings::KEYS,
        ..PLAIN
    },
    Group {
        sections: &[("operator", "The operator's motion.")],
        keys: MotionSettings::KEYS,
        whole: &[MotionSettings::KEY],
        read: |of| {
            if let Some(motion) = operator(of.values, &of.scenario.grid, of.replay)? {
                of.scenario.operator = motion;
                of.scenario.check_reach(of.values)?;
            }
            Ok(())
        },
        ..PLAIN
    },
    Group {
        keys: TremorSettings::KEYS,
        read: |of| {
            let tick_s = of.scenario.grid.tick_s();
            of.set(TremorSettings::read, |settings| settings.validate_on_ticks(tick_s), |to| &mut to.tremor)
        },
        ..PLAIN
    },
    Group {
        keys: StretchSettings::KEYS,
        read: |of| of.set(StretchSettings::read, StretchSettings::validate, |to| &mut to.stretch),
        ..PLAIN
    },
    Group {
        keys: StiffeningSettings::KEYS,
        read: |of| of.set(StiffeningSettings::read, StiffeningSettings::validate, |to| &mut to.stiffening),
        ..PLAIN
    },
    Group {
        sections: &[("perception", "What the operator notices of the felt force, and the reaction to it.")],
        keys: Perception::KEYS,
        read: |of| of.set(Perception::read, Perception::validate, |to| &mut to.perception),
        ..PLAIN
    },
    Group {
        keys: ReflexSettings::KEYS,
        read: |of| of.set(ReflexSettings::read, ReflexSettings::validate_where_reacting, |to| &mut to.reflex),
        ..PLAIN
    },
    Group {
        sections: &[("tissue", "The tissue that the needle enters.")],
        keys: TissueSettings::KEYS,
        also: &[LAYER_KEYS],
        whole: &[TissueSettings::KEY, ReplayIndex::KEY],
        read: |of| {
            tissue(of)?;
            check_spared(of.values, of.scenario)?;
            of.scenario.stated_tissue = stated_tissue(of.values)?;
            Ok(())
        },
    },
    Group { keys: AimSettings::KEYS, whole: AimSettings::KEYS, ..PLAIN },
    Group {
        keys: OrganMotion::KEYS,
        read: |of| of.set(OrganMotion::read, OrganMotion::validate, |to| &mut to.organ_motion),
        ..PLAIN
    },
    Group {
        sections: &[("recording", "The recording that the operator or the tissue replays, and that detect reads.")],
        keys: FileSettings::KEYS,
        whole: FileSettings::KEYS,
        ..PLAIN
    },
    Group { keys: SignSettings::KEYS, whole: SignSettings::KEYS, ..PLAIN },
    Group { keys: Limits::KEYS, whole: Limits::KEYS, ..PLAIN },
    Group {
        sections: &[("recording.columns", "The columns of the recording, by their names in the header of the file.")],
        keys: ColumnSettings::KEYS,
        whole: ColumnSettings::KEYS,
        ..PLAIN
    },
    Group {
        sections: &[("recording.scale", "The factor that converts each column to SI units.")],
        keys: ScaleSettings::KEYS,
        whole: ScaleSettings::KEYS,
        ..PLAIN
    },
    Group {
        sections: &[("recording.offset", "The offset that is added to each scaled column, in SI units.")],
        keys: OffsetSettings::KEYS,
        whole: OffsetSettings::KEYS,
        ..PLAIN
    },
    Group {
        sections: &[("sensor", "How force and position are measured.")],
        keys: SensorSettings::KEYS,
        read: |of| of.set(SensorSettings::read, SensorSettings::validate, |to| &mut to.sensor),
        ..PLAIN
    },
    Group {
        sections: &[("estimator", "The online estimation of the tissue (eq. 12-18).")],
        keys: RlsSettings::KEYS,
        read: |of| of.set(RlsSettings::read, RlsSettings::validate, |to| &mut to.estimator),
        ..PLAIN
    },
    Group {
        keys: ContactSettings::KEYS,
        read: |of| {
            of.scenario.contact_m = ContactSettings::read(of.values)?.contact_m;
            Ok(())
        },
        ..PLAIN
    },
    Group {
        sections: &[("detector", "The detection of ruptures (eq. 19-27).")],
        keys: DetectorSettings::KEYS,
        read: |of| of.set(DetectorSettings::read, DetectorSettings::validate, |to| &mut to.detector),
        ..PLAIN
    },
    Group {
        sections: &[("augmentation", "The response to an alarm (section 5.1).")],
        keys: AugmentationSettings::KEYS,
        read: |of| of.set(AugmentationSettings::read, AugmentationSettings::validate, |to| &mut to.augmentation),
        ..PLAIN
    },
    Group {
        keys: EventSettings::KEYS,
        read: |of| {
            of.scenario.events = events(of.values, &of.scenario.grid)?;
            Ok(())
        },
        ..PLAIN
    },
    Group {
        sections: &[("rig", "The samples of a rig: possible values, and what follows bad ones.")],
        keys: rig::Limits::KEYS,
        read: |of| of.set(rig::Limits::read, rig::Limits::validate, |to| &mut to.rig_limits),
        ..PLAIN
    },
    Group {
        sections: &[("safety", "The limits of the commands to the motors of a rig, and of the simulation if wanted.")],
        keys: SafetySettings::KEYS,
        read: |of| of.set(SafetySettings::read, SafetySettings::validate, |to| &mut to.safety),
        ..PLAIN
    },
    Group {
        sections: &[("population", "The people, tissues and links over which trocar stability computes limits.")],
        keys: PopulationSettings::KEYS,
        read: |of| of.set(PopulationSettings::read, PopulationSettings::validate, |to| &mut to.population),
        ..PLAIN
    },
    // Recompute the steps of the machines on demand.
    Group {
        also: OF_MACHINES,
        read: |of| {
            of.scenario.steps = Arc::default();
            Ok(())
        },
        ..PLAIN
    },
    Group {
        also: OF_LINK,
        read: |of| {
            let Scenario { master, master_model, slave, grid, .. } = &*of.scenario;
            let link = link_settings(of.values, (master, master_model), slave, grid.tick_s())?;
            let position_scale = of.scenario.position_scale();
            of.scenario.link = link;
            // Checking every position is expensive.
            if of.scenario.position_scale() == position_scale { Ok(()) } else { of.scenario.check_reach(of.values) }
        },
        ..PLAIN
    },
    // The controllers that wait for the tick depend on the link.
    Group {
        also: &[
            DelaySettings::KEYS,
            MasterModelSettings::KEYS,
            SlaveParameters::KEYS,
            ComplianceSettings::KEYS,
            ControllerSettings::KEYS,
            PassivitySettings::KEYS,
        ],
        read: |of| {
            let Scenario { timing, link, .. } = &*of.scenario;
            let waits_for_tick = waits_for_tick(*timing, link, of.scenario.has_general_machine());
            let (settings, forward, backward) = delays(of.values, &of.scenario.grid, waits_for_tick)?;
            (of.scenario.delays, of.scenario.forward, of.scenario.backward) = (settings, forward, backward);
            Ok(())
        },
        ..PLAIN
    },
];

#[cfg(test)]
mod tests {
    use super::super::{KEYS, Source, find_key};
    use super::*;

    #[test]
    fn every_key_belongs_to_one_group() {
        for key in KEYS {
            assert_eq!(GROUPS.iter().filter(|group| has(group.keys, key)).count(), 1, "{}", key.path);
        }
    }

    #[test]
    fn a_group_depends_on_existing_keys_and_its_whole_keys_belong_to_it() {
        for group in GROUPS {
            for key in group.also.iter().copied().flatten() {
                assert!(has(LAYER_KEYS, key) || has(KEYS, key), "{}", key.path);
            }
            assert!(group.whole.iter().all(|key| has(group.keys, key)));
        }
    }

    #[test]
    fn reading_replaces_every_default_of_an_unread_scenario() {
        let text = "operator.kind = \"ramp\"\ntissue.kind = \"kelvin-voigt\"\nscaling.position = 2.0\nsensor.force_noise_std_n = 0.1";
        let source = Source::Text { name: "changed".into(), text: text.into() };
        let scenario = Scenario::load(&source, &[]).expect("good");
        let unread = Scenario::unread("x".into(), scenario.grid, (scenario.engine, scenario.timing), 1);
        assert_ne!(scenario.position_scale(), unread.position_scale());
        assert_ne!(scenario.sensor, unread.sensor);
        assert_ne!(scenario.operator, unread.operator);
        assert_ne!(scenario.tissue, unread.tissue);
    }

    #[test]
    fn a_scale_affects_the_link_and_a_detector_key_only_the_detector() {
        let affected = |path: &str| {
            let key = find_key(path).expect("a key");
            GROUPS.iter().filter(|group| group.depends_on(&key)).count()
        };
        // The group and the link.
        assert_eq!(affected("scaling.force"), 2);
        assert_eq!(affected("detector.threshold"), 1);
        assert_eq!(affected("tissue.layer.skin.grip_n"), 1);
        // The machine, its file, the motors, the steps, the link and its delays.
        assert_eq!(affected("slave.velocity_gain"), 6);
        assert!(GROUPS.iter().any(|group| group.is_whole(&find_key("operator.kind").expect("a key"))));
    }
}
