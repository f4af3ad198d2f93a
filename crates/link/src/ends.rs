//! A side of the insertion with its connection.

use super::counters::Counters;
use super::endpoint::{Endpoint, Trip};
use super::packet::{PACKET_BYTES, Role};
use super::seal::Session;
use trocar_core::safety::SafetySettings;
use trocar_engine::engine::{EngineError, MasterSide, Observer, Signals, SlaveSide, Trace};
use trocar_scenario::{Scenario, ScenarioError, empty_trace};

/// The energies of both ports, with the last reported energy of the other side. A passivity scheme's limit also holds
/// for these, because the energy on the way is never negative.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Meter {
    /// Largest `E_s - E_m` so far: delivered minus received energy of the ports.
    pub generated_j: f64,
    /// The limit of the passivity scheme in J; `None` without a limit.
    pub promised_j: Option<f64>,
}

impl Meter {
    fn add(&mut self, slave_j: f64, master_j: f64) {
        self.generated_j = self.generated_j.max(slave_j - master_j);
    }
}

#[derive(Debug)]
pub struct MasterEnd {
    side: MasterSide,
    endpoint: Endpoint<5>,
    trace: Trace,
    meter: Meter,
    safety: SafetySettings,
}

impl MasterEnd {
    pub const COLUMNS: &'static [&'static str] = &[
        "time_s",
        "desired_position_m",
        "master_position_m",
        "master_velocity_m_per_s",
        "operator_force_n",
        "feedback_force_n",
        "hand_energy_j",
        "master_energy_j",
    ];

    pub fn new(scenario: &Scenario, session: Session) -> Result<Self, ScenarioError> {
        let side = scenario.master_side()?;
        let endpoint = Endpoint::new(Role::Master, session, scenario.grid.ticks(), side.initial());
        let meter = Meter { generated_j: 0.0, promised_j: side.promised_j() };
        Ok(Self { side, endpoint, trace: empty_trace(scenario), meter, safety: scenario.safety })
    }

    /// Runs the first half of a tick. Returns the packet for the slave at a time (ns since tick 0).
    pub fn send(&mut self, now_ns: i64) -> [u8; PACKET_BYTES] {
        let message = self.side.send();
        self.endpoint.seal((self.side.tick(), now_ns), &message, self.side.energy_j())
    }

    /// Computes the ticks before `tick` as if without messages, for a side that joins a running link. Afterwards
    /// `safety.*` bounds its commands, unless `safety.acts` is `nowhere`.
    pub fn skip_to(&mut self, tick: u64) -> Result<(), EngineError> {
        while self.side.tick() < tick {
            self.side.send();
            self.step()?;
        }
        self.bound_if_joined();
        Ok(())
    }

    pub fn step(&mut self) -> Result<(), EngineError> {
        self.meter.add(self.endpoint.other_energy_j(), self.side.energy_j());
        let received = self.endpoint.at_next_tick();
        self.side.step(&received, &mut self.trace)
    }

    pub fn has_ended(&self) -> bool {
        self.side.has_ended()
    }
}

#[derive(Debug)]
pub struct SlaveEnd {
    side: SlaveSide,
    endpoint: Endpoint<4>,
    trace: Trace,
    meter: Meter,
    safety: SafetySettings,
    events: Events,
}

#[derive(Debug, Default)]
struct Events {
    ruptures: Vec<u64>,
    alarms: Vec<u64>,
}

impl Observer<f64> for Events {
    fn observe(&mut self, signals: &Signals<f64>) {
        if signals.ruptured {
            self.ruptures.push(signals.tick);
        }
        if signals.alarm_taken {
            self.alarms.push(signals.tick);
        }
    }
}

impl SlaveEnd {
    pub const COLUMNS: &'static [&'static str] = &[
        "time_s",
        "slave_reference_m",
        "slave_position_m",
        "slave_velocity_m_per_s",
        "tissue_force_n",
        "measured_force_n",
        "stiffness_n_per_m",
        "damping_n_s_per_m",
        "residual_n",
        "distance",
        "decision",
        "mode",
        "reference_energy_j",
        "needle_energy_j",
    ];

    pub fn new(scenario: &Scenario, session: Session) -> Result<Self, ScenarioError> {
        let side = scenario.slave_side()?;
        let endpoint = Endpoint::new(Role::Slave, session, scenario.grid.ticks(), side.initial());
        let meter = Meter { generated_j: 0.0, promised_j: side.promised_j() };
        Ok(Self {
            side,
            endpoint,
            trace: empty_trace(scenario),
            meter,
            safety: scenario.safety,
            events: Events::default(),
        })
    }

    pub fn skip_to(&mut self, tick: u64) -> Result<(), EngineError> {
        while self.side.tick() < tick {
            let received = self.endpoint.at_next_tick();
            self.side.step(&received, &mut (&mut self.trace, &mut self.events))?;
        }
        self.bound_if_joined();
        Ok(())
    }

    /// Runs a tick with the received messages. Returns the packet for the master at a time (ns since tick 0).
    pub fn step(&mut self, now_ns: i64) -> Result<[u8; PACKET_BYTES], EngineError> {
        let tick = self.side.tick();
        let received = self.endpoint.at_next_tick();
        let message = self.side.step(&received, &mut (&mut self.trace, &mut self.events))?;
        self.meter.add(self.side.energy_j(), self.endpoint.other_energy_j());
        Ok(self.endpoint.seal((tick, now_ns), &message, self.side.energy_j()))
    }

    pub fn has_ended(&self) -> bool {
        self.side.has_ended()
    }

    pub fn ruptures(&self) -> &[u64] {
        &self.events.ruptures
    }

    pub fn alarms(&self) -> &[u64] {
        &self.events.alarms
    }
}

macro_rules! both {
    ($($End:ident)*) => {$(
        impl $End {
            /// Returns the travel times if the packet is a new message of the other side; any other only changes a
            /// counter.
            pub fn take(&mut self, bytes: &[u8], now_ns: i64) -> Option<Trip> {
                self.endpoint.take(bytes, now_ns);
                self.endpoint.last_trip()
            }

            /// Continues with the other side, which has started anew. `safety.*` then bounds the commands, unless
            /// `safety.acts` is `nowhere`.
            pub fn rejoin(&mut self, session: Session) {
                self.endpoint.rejoin(session, self.side.energy_j());
                self.side.peer_restarts();
                self.side.bound(&self.safety);
                // The other side adds its half of the scheme's initial energy again.
                if let (Some(promised_j), Some(initial_j)) = (&mut self.meter.promised_j, self.side.promised_j()) {
                    *promised_j += 0.5 * initial_j;
                }
            }

            fn bound_if_joined(&mut self) {
                if self.side.tick() > 0 {
                    self.side.bound(&self.safety);
                }
            }

            pub fn tick(&self) -> u64 {
                self.side.tick()
            }

            pub fn counters(&self) -> Counters {
                self.endpoint.counters()
            }

            pub fn delays(&self) -> &[u32] {
                self.endpoint.delays()
            }

            /// The other side's signals are 0.
            pub fn trace(&self) -> &Trace {
                &self.trace
            }

            pub fn meter(&self) -> Meter {
                self.meter
            }
        }
    )*};
}

both! { MasterEnd SlaveEnd }

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use trocar_engine::engine::COLUMNS;

    #[test]
    fn every_column_belongs_to_a_side() {
        let of_both: BTreeSet<_> = MasterEnd::COLUMNS.iter().chain(SlaveEnd::COLUMNS).copied().collect();
        assert_eq!(of_both, COLUMNS.into_iter().collect());
        assert_eq!(MasterEnd::COLUMNS.len() + SlaveEnd::COLUMNS.len(), COLUMNS.len() + 1, "only the time is of both");
    }
}
