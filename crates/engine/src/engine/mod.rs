//! The physics between ticks is linear and stepped exactly; only the sampled channel couples the sides.
//! [`Parts::tick`]:
//!
//! 1. read both plants: `x_h, v_h, F_h`; `x_e, v_e`
//! 2. tissue: `f_e`; sensors: `y`, position and velocity
//! 3. estimator: `e_k`, then its parameters
//! 4. detector: `s_k`, then `g_k` and the alarm
//! 5. link, and supervisor on the slave's side: mode, `x_ref`
//! 6. link, and force law on the master's side: `F_ed`
//! 7. both plants to tick `k + 1`

mod built_in_or;
mod column;
#[cfg(target_arch = "x86_64")]
pub(crate) mod eight;
mod error;
mod exact;
mod general;
mod general_master;
mod instruction_set;
mod integrated;
mod integrated_master;
mod integrated_slave;
#[cfg_attr(not(feature = "dop853"), path = "no_integrator.rs")]
mod integrator;
mod limited;
mod motor;
mod observer;
mod parts;
mod plants;
mod port_energies;
mod scheduled;
mod sides;
mod signals;
mod split;
mod trace;
mod trust;
mod user_defined;
mod wired;

pub use built_in_or::BuiltInOr;
pub use column::{ColumnValues, TraceColumn};
#[cfg(target_arch = "x86_64")]
pub(crate) use eight::{Avx2, Avx512};
pub use error::{EngineError, InvalidPart};
pub use exact::{ExactPlants, GatheredPlants};
pub use general::{GeneralPlants, GeneralSlave, MasterPlants, SlaveMachine};
pub use general_master::ControlledMaster;
pub use instruction_set::{InSet, InstructionSet, Wide};
pub use integrated::IntegratedPlants;
pub use integrated_slave::IntegratedSlave;
pub use limited::LimitedPlants;
pub use observer::{Additional, EventObserver, Observer};
pub use parts::{Parts, Wiring};
pub use plants::{IntegrationError, MasterOutput, Plants, SlaveOutput, TissueForce};
pub use port_energies::PortEnergies;
pub use scheduled::ScheduledAlarms;
pub use sides::{MasterSide, SideEngine, SlaveSide};
pub use signals::{SelectedSignals, Signals};
pub use split::FractionalDelayPlants;
pub use trace::{COLUMNS, TRACE_COLUMNS, Trace, TraceRecorder};
pub use trust::{TRUST_COLUMNS, TrustColumns};
pub use user_defined::{UserDefinedEngine, UserDefinedParts, UserDefinedPlants, UserDefinedWiring};
pub use wired::{Any, AnyChain, AnyDetector, PaperChain, Wired};

use std::ops::ControlFlow;

use trocar_base::interrupt;
use trocar_core::lane::{Gather, LANES, of_each};
use trocar_core::time::TickGrid;

#[derive(Debug, Clone)]
pub struct Engine<P, W> {
    pub grid: TickGrid,
    pub plants: P,
    pub parts: W,
}

impl<P: Plants<W::Lane>, W: Wiring> Engine<P, W> {
    /// Allocates nothing.
    pub fn run<O: Observer<W::Lane>>(&mut self, observer: &mut O) -> Result<(), EngineError> {
        self.run_ticks(observer)
    }

    #[inline(always)]
    fn run_ticks<O: Observer<W::Lane>>(&mut self, observer: &mut O) -> Result<(), EngineError> {
        let mut desired_m = self.parts.begin();
        for tick in 0..self.grid.ticks() {
            interrupt::check_at(tick);
            match self.parts.tick(tick, desired_m, &mut self.plants, observer) {
                ControlFlow::Continue(next) => desired_m = next,
                ControlFlow::Break(outcome) => return outcome,
            }
        }
        Ok(())
    }
}

trait Differential<V> {
    fn system(&self, state: &V, derivative: &mut V);
}

fn gather<L: trocar_core::lane::Lane, P, Q, W: Gather>(
    all: [&Engine<P, W>; LANES],
    plants: impl FnOnce([&P; LANES]) -> Option<Q>,
) -> Option<Engine<Q, W::Of<L>>> {
    let grid = all[0].grid;
    all.iter().all(|one| one.grid == grid).then_some(())?;
    Some(Engine {
        grid,
        plants: plants(of_each!(all, |one| &one.plants))?,
        parts: W::gather(of_each!(all, |one| &one.parts))?,
    })
}

#[cfg(test)]
mod tests;
