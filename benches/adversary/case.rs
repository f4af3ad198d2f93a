//! A random scenario with a quiet hand, its run and its verdict.

use std::error::Error;
use std::path::{Path, PathBuf};

use super::draw::Draw;
use super::hand::Hand;
use super::swing::{Motion, motion};
use super::tissue::{KINDS, tissue};
use trocar::metrics::Outcome;
use trocar::run::{empty_trace, observe};
use trocar::scenario::{Scenario, Source};
use trocar::stability::Axis;
use trocar::stability_check::{LoopVerdict, StabilityStudy};

type Failure = Box<dyn Error + Send + Sync>;

/// A random scenario.
pub struct Case {
    /// The kind of the tissue.
    pub kind: &'static str,
    /// The scenario in TOML.
    pub toml: String,
    csv: String,
    hand: Hand,
    number: u64,
}

/// The result of a case.
pub struct Judged {
    pub case: Case,
    pub motion: Motion,
    pub is_stable: Option<bool>,
    pub sentence: String,
}

impl Case {
    /// Draws a case.
    pub fn new(number: u64, is_augmented: bool) -> Self {
        let draw = &mut Draw::new(number);
        let kind = KINDS[(number % KINDS.len() as u64) as usize];
        let hand = Hand::draw(draw);
        // Without delays the paper's loop is stable up to 2.5 kN/m, as the product of both scales and the stiffness.
        let (product, position, force) = (draw.log(200.0, 15000.0), draw.log(0.3, 3.0), draw.log(0.1, 30.0));
        let stiffness = product / position / force;
        let (tick_s, control) = (draw.one(&[5e-4, 1e-3, 2e-3]), draw.one(&["continuous", "sampled"]));
        // The certificate covers whole ticks.
        let [forward_s, backward_s] = [(); 2].map(|()| match draw.zero_or_log(0.3, 5e-4, 0.05) {
            delay_s if is_augmented => (0.2 * delay_s / tick_s).round() * tick_s,
            delay_s => delay_s,
        });
        let is_plain = draw.chance(0.7);
        let others = ["position-position", "four-channel", "local-force"];
        let architecture = if is_plain { "position-force" } else { draw.one(&others) };
        let mut toml = format!(
            "simulation.tick_s = {tick_s}\nsimulation.duration_s = {}\nsimulation.control = \"{control}\"\n\
             scaling.force = {force}\nscaling.position = {position}\nchannel.forward_delay_s = {forward_s}\n\
             channel.backward_delay_s = {backward_s}\ncontroller.kind = \"{architecture}\"\n\
             recording.file = \"{number}.csv\"\naugmentation.enabled = {is_augmented}\n",
            hand.duration_s()
        );
        if draw.chance(0.2) {
            toml += &format!("slave.compliance_m_per_n = {}\n", draw.log(0.01, 1.0) / stiffness);
        } else if is_plain && draw.chance(0.15) {
            let (mass_kg, stiff, damped) = (draw.log(0.1, 0.5), draw.log(2e3, 1e4), draw.log(20.0, 60.0));
            toml += &format!(
                "slave.model = \"mass-damper\"\nslave.mass_kg = {mass_kg}\nslave.controller = \"pid\"\n\
                 slave.proportional_gain = {stiff}\nslave.derivative_gain = {damped}\nslave.velocity_gain = 0\n\
                 slave.coulomb_friction_n = {}\n",
                draw.zero_or_log(0.5, 0.05, 0.5)
            );
        } else if is_plain && draw.chance(0.05) {
            let friction_n = draw.log(0.05, 2.0);
            toml += &format!("master.model = \"mass-damper\"\nmaster.coulomb_friction_n = {friction_n}\n");
        }
        if is_augmented {
            let (reengage, law) = (draw.one(&["ramp", "snap"]), draw.one(&["decay", "amplify"]));
            toml += &format!(
                "augmentation.reengage = \"{reengage}\"\naugmentation.force_law = \"{law}\"\n\
                 augmentation.refractory_s = {}\n",
                draw.log(0.05, 0.5)
            );
        }
        let (tissue, recording) = tissue(draw, kind, stiffness);
        Self { kind, toml: toml + "\n" + &tissue, csv: hand.csv(position, recording.as_ref()), hand, number }
    }

    /// Writes the scenario and the recording of its hand into a folder.
    pub fn write(&self, folder: &Path) -> std::io::Result<PathBuf> {
        std::fs::write(folder.join(format!("{}.csv", self.number)), &self.csv)?;
        let path = folder.join(format!("{}.toml", self.number));
        std::fs::write(&path, &self.toml)?;
        Ok(path)
    }

    /// Runs the scenario and judges it.
    pub fn judge(self, folder: &Path) -> Result<Judged, Failure> {
        let scenario = Scenario::load(&Source::Disk(self.write(folder)?), &[])?;
        let mut trace = empty_trace(&scenario);
        let metrics = observe(&scenario, &mut trace.recorder())?;
        let motion = if metrics.outcome == Outcome::Completed {
            motion(&trace.slave_position_m, scenario.grid.tick_s(), &self.hand.holds_s())
        } else {
            Motion::Swings
        };
        let (is_stable, sentence) = claim(&scenario)?;
        Ok(Judged { motion, is_stable, sentence, case: self })
    }
}

/// The verdict on the loop, or with augmentation the certificate of its events.
fn claim(scenario: &Scenario) -> Result<(Option<bool>, String), Failure> {
    if !scenario.augmentation.enabled {
        let verdict = LoopVerdict::of(scenario)?;
        return Ok((verdict.is_stable(), verdict.sentence()));
    }
    let axes = (Axis::parse("scaling.force=0.5:2:2")?, Axis::parse("scaling.position=0.5:2:2")?);
    let study = StabilityStudy::of(scenario, axes, None)?;
    Ok((study.is_certified(), study.verdict.sentence()))
}
