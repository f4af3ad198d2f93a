//! Leads a link with the pointer of a page.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use super::MasterArgs;
use crate::cli::error::{CliError, LinkError};
use crate::explore::{Field, serve_field};
use trocar_core::augmentation::{Mode, Modes};
use trocar_link::{MasterEnd, SideSummary};
use trocar_scenario::{Scenario, TissueSpec, Value};
use trocar_studies::animation::DrawnTissue;

/// Interval between checks of the stop flag.
const LOOK: Duration = Duration::from_millis(50);

/// The scenario that repeats a link led by the pointer: its operator replays the trace. The base has every other key.
const LOGGED: &str = "\
base = \"link.toml\"

[operator]
kind = \"recording\"
tremor_amplitude_m = 0.0
stretch_short_gain_n_s_per_m = 0.0
stretch_long_gain_n_per_m = 0.0
stiffening_per_n = 0.0

[perception]
kind = \"none\"
reflex = \"none\"

[recording]
file = \"trace.csv\"
ruptures_s = []
force_sign = 1
position_sign = 1

[recording.columns]
time_s = \"time_s\"
position_m = \"desired_position_m\"
velocity_m_per_s = \"\"
force_n = \"operator_force_n\"

[recording.scale]
time_s = 1.0
position_m = 1.0
force_n = 1.0
";

pub(super) struct Pointer {
    field: Arc<Field>,
    tissue: DrawnTissue,
    tick_s: f64,
    mode: Mode,
    alarms: u32,
}

impl Pointer {
    pub(super) fn open(scenario: &Scenario, args: &MasterArgs) -> Result<Self, CliError> {
        if matches!(scenario.tissue, TissueSpec::Recording { .. } | TissueSpec::Depth { .. }) {
            return Err(LinkError::PointerOnRecording.into());
        }
        let field = Arc::new(Field::new(scenario));
        let page = format!("http://{}/", serve_field(field.clone(), args.port)?);
        if !args.side.quiet {
            anstream::eprintln!("lead the link at {page}; Ctrl-C ends");
        }
        if !args.no_open {
            // Without a browser, the user can copy the printed address.
            let _ = open::that_detached(page);
        }
        let tissue = DrawnTissue::of_scenario(scenario);
        Ok(Self { field, tissue, tick_s: scenario.grid.tick_s(), mode: Mode::Teleoperation, alarms: 0 })
    }

    pub(super) fn wait(&self, stop: &AtomicBool) -> Result<(), CliError> {
        while !self.field.wait(LOOK) {
            if stop.load(Ordering::Relaxed) {
                return Err(CliError::Interrupted { kept: None });
            }
        }
        Ok(())
    }

    pub(super) fn lead(&self, scenario: &Scenario) -> Scenario {
        scenario.clone().held_by(self.field.hand().clone())
    }

    pub(super) fn step(&self) {
        self.field.hand().step(self.tick_s);
    }

    pub(super) fn show(&mut self, end: &MasterEnd) {
        let trace = end.trace();
        let last = |column: &[f64]| column.last().copied().unwrap_or_default();
        let [force_n, position_m, _, _, mode] = end.received();
        let time_s = last(&trace.time_s);
        // Detects an alarm of the slave by the change of its mode.
        let mode = Modes::from_codes(mode).lane(0);
        let is_alarm = self.mode == Mode::Teleoperation && mode != Mode::Teleoperation;
        self.mode = mode;
        if is_alarm {
            self.alarms += 1;
            self.tissue.tear(time_s);
        }
        self.tissue.step(time_s, 1e3 * position_m);
        let row = [
            time_s as f32,
            (1e3 * last(&trace.desired_position_m)) as f32,
            (1e3 * last(&trace.master_position_m)) as f32,
            (1e3 * position_m) as f32,
            force_n as f32,
            last(&trace.feedback_force_n) as f32,
            f32::from(mode.code()),
            last(&trace.operator_force_n) as f32,
        ];
        self.field.add(row, is_alarm.then_some((time_s, "alarm")), &self.tissue);
    }

    /// Returns true if the operator has ended the link or left the page.
    pub(super) fn has_ended(&self) -> bool {
        self.field.has_ended()
    }

    pub(super) fn end(&self, summary: &SideSummary, files: &Path) {
        let (ticks, _) = summary.ticks;
        let text = format!("{ticks} ticks, {} alarms; files: {}", self.alarms, files.display());
        self.field.end(text);
    }

    /// Returns the scenario that repeats the operator's motion; it needs `link.toml` and `trace.csv` in its folder.
    pub(super) fn logged(name: &str) -> String {
        let name = Value::Text(name.to_owned()).to_toml();
        format!("# A link that a person led: the hand is that of trace.csv.\nname = {name}\n{LOGGED}")
    }
}
