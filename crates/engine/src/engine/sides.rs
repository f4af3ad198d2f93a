//! With the other side's messages, a side's signals have the same bits as in [`Parts`](super::Parts).

use super::signals::{AtMasterSide, AtSlaveSide, at_rest};
use super::{Any, Engine, EngineError, Observer, Plants, Signals, TissueForce, Wiring};
use crate::teleoperation::{AtMaster, Connection as _, Received, ToMaster, ToSlave};
use trocar_core::safety::{CommandLimits, SafetySettings};

pub type SideEngine = Engine<Box<dyn Plants<f64> + Send>, Any<f64>>;

pub struct MasterSide {
    engine: SideEngine,
    initial: [f64; 5],
    at_rest: AtSlaveSide<f64>,
    desired_m: f64,
    at_master: AtMaster<f64>,
    force_n: f64,
    tick: u64,
}

impl MasterSide {
    /// `initial` is the sample before the first message.
    pub fn new(mut engine: SideEngine, initial: [f64; 5]) -> Self {
        let desired_m = engine.parts.begin();
        let at_master = AtMaster { position_m: 0.0, velocity_m_per_s: 0.0, hand_force_n: 0.0 };
        Self { engine, initial, at_rest: at_rest().1, desired_m, at_master, force_n: 0.0, tick: 0 }
    }

    /// Force, position, velocity, acceleration, mode.
    pub fn initial(&self) -> [f64; 5] {
        self.initial
    }

    pub fn tick(&self) -> u64 {
        self.tick
    }

    pub fn has_ended(&self) -> bool {
        self.tick >= self.engine.grid.ticks()
    }

    /// Once before each [`MasterSide::step`].
    pub fn send(&mut self) -> ToSlave<f64> {
        let Engine { plants, parts, .. } = &mut self.engine;
        self.at_master = parts.read_master(self.tick, &plants.master());
        parts.link.master_sends(&self.at_master)
    }

    /// The other side's signals are 0.
    pub fn step(&mut self, received: &Received<f64, 5>, observer: &mut dyn Observer<f64>) -> Result<(), EngineError> {
        let Engine { plants, parts, .. } = &mut self.engine;
        let master = plants.master();
        let at_master = self.at_master;
        let (mode, force_n) = parts.link.master_receives(received, &at_master);
        let fed_back = parts.feed_back(mode, force_n, &at_master);
        let desired = parts.desired(self.desired_m);
        observer.observe(&Signals::of_both(self.tick, &(desired, master, fed_back), &self.at_rest));
        let next_m = parts.next_desired_m(self.tick, mode, &master);
        plants.step(self.desired_m, next_m, fed_back.force_n, 0.0, 0.0, TissueForce::zero())?;
        (self.desired_m, self.force_n, self.tick) = (next_m, fed_back.force_n, self.tick + 1);
        Ok(())
    }

    /// May add half of the passivity scheme's promise to the generated energy.
    pub fn peer_restarts(&mut self) {
        self.engine.parts.link.peer_restarts();
    }

    /// Applies `safety.*` from the next tick on, beginning at the present commands.
    pub fn bound(&mut self, safety: &SafetySettings) {
        let Engine { parts, grid, plants } = &mut self.engine;
        if parts.safety.is_none() {
            parts.safety = CommandLimits::continuing(safety, grid.tick_s(), self.force_n, plants.slave().position_m);
        }
    }

    /// `Σ F_ed Δx_h`
    pub fn energy_j(&self) -> f64 {
        self.engine.parts.link.master_energy_j()
    }

    pub fn promised_j(&self) -> Option<f64> {
        self.engine.parts.link.promised_j()
    }
}

pub struct SlaveSide {
    engine: SideEngine,
    initial: [f64; 4],
    at_rest: AtMasterSide<f64>,
    reference_m: Option<f64>,
    tick: u64,
}

impl SlaveSide {
    pub fn new(engine: SideEngine, initial: [f64; 4]) -> Self {
        Self { engine, initial, at_rest: at_rest().0, reference_m: None, tick: 0 }
    }

    /// Position, velocity, acceleration, hand force.
    pub fn initial(&self) -> [f64; 4] {
        self.initial
    }

    pub fn tick(&self) -> u64 {
        self.tick
    }

    pub fn has_ended(&self) -> bool {
        self.tick >= self.engine.grid.ticks()
    }

    pub fn step(
        &mut self,
        received: &Received<f64, 4>,
        observer: &mut dyn Observer<f64>,
    ) -> Result<ToMaster<f64>, EngineError> {
        let Engine { plants, parts, .. } = &mut self.engine;
        let slave = plants.slave();
        let measured = parts.sense(self.tick, &slave);
        let hand_m = parts.link.slave_receives(received, &measured.at_slave);
        let command = parts.command_slave(self.tick, hand_m, &measured);
        let sent = parts.link.slave_sends(command.mode, &measured.at_slave);
        observer.observe(&Signals::of_both(self.tick, &self.at_rest, &(slave, measured, command)));
        let (deflection_m, force) = (parts.link.deflection_m(measured.reaction.force_n), measured.tissue_force());
        plants.step(0.0, 0.0, 0.0, command.slave_reference_m, deflection_m, force)?;
        self.reference_m = Some(command.slave_reference_m);
        self.tick += 1;
        Ok(sent)
    }

    pub fn peer_restarts(&mut self) {
        self.engine.parts.link.peer_restarts();
    }

    pub fn bound(&mut self, safety: &SafetySettings) {
        let Engine { parts, grid, plants } = &mut self.engine;
        if parts.safety.is_none() {
            parts.safety = CommandLimits::continuing(
                safety,
                grid.tick_s(),
                0.0,
                self.reference_m.unwrap_or(plants.slave().position_m),
            );
        }
    }

    pub fn promised_j(&self) -> Option<f64> {
        self.engine.parts.link.promised_j()
    }

    /// `∫ f_e dx_e`, scaled to the master.
    pub fn energy_j(&self) -> f64 {
        self.engine.parts.link.slave_energy_j()
    }
}

impl std::fmt::Debug for MasterSide {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("MasterSide").field("tick", &self.tick).finish_non_exhaustive()
    }
}

impl std::fmt::Debug for SlaveSide {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SlaveSide").field("tick", &self.tick).finish_non_exhaustive()
    }
}
