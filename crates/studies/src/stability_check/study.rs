use std::sync::atomic::AtomicBool;

use super::event_limits::EventLimit;
use super::statement::Statement;
use super::verdict::LoopVerdict;
use super::{Check, CheckError, check, linear_loop, worst_events};
use crate::run::delays_rounded;
use trocar_base::warning::{Code, Warning};
use trocar_scenario::{Scenario, ScenarioError, Source};
use trocar_stability::{
    AbsoluteOver, Analysis, Axis, Bounded, Locus, LoopResponse, MeasuredLoop, MeasuredSides, Population, StabilityMap,
    Switching, SwitchingSettings, Terminations, TissueRange, ZWidth, map,
};

pub const MAX_STIFFNESS_N_PER_M: f64 = 1e6;

/// Standard deviations of the sensor's noise that a bound of the motion contains.
pub const DEVIATIONS: f64 = 4.0;

#[derive(Debug, Clone)]
pub struct StabilityStudy {
    pub name: String,
    pub verdict: LoopVerdict,
    /// At the worst stiffness of the tissue.
    pub analysis: Analysis,
    pub map: StabilityMap,
    pub switching: Result<Switching, String>,
    pub measured: Option<MeasuredLoop>,
    pub z_width: Option<ZWidth>,
    pub population: Option<Population>,
    /// By default any passive hand, and the tissues of the switching analysis.
    pub bounded: Bounded,
    pub absolute: Option<AbsoluteOver>,
    pub check: Option<Check>,
    pub response: LoopResponse,
    pub locus: Option<Locus>,
    /// Half a step, and [`DEVIATIONS`] of the noise.
    pub sensor_force_n: f64,
    /// Empty unless computed.
    pub event_limits: Vec<EventLimit>,
    pub worst_events: Option<Scenario>,
    rounded: Vec<Warning>,
}

impl StabilityStudy {
    /// `sector` is a range of stiffness (N/m); the default is the scenario's.
    pub fn of(scenario: &Scenario, (x, y): (Axis, Axis), sector: Option<(f64, f64)>) -> Result<Self, CheckError> {
        let settings = linear_loop(scenario)?;
        let sector = sector.unwrap_or_else(|| settings.tissue.sector_n_per_m());
        let population = &scenario.population;
        let over_people = || Population::of(&settings, population, scenario.seed, (&x, &y));
        let terminations = Terminations {
            hand_n_s_per_m: (0.0, f64::INFINITY),
            stiffness_n_per_m: sector,
            damping_n_s_per_m: settings.tissue.springs.damping_n_s_per_m,
        };
        let linear = || -> Result<_, CheckError> {
            let population = population.varies().then(over_people).transpose()?;
            let (analysis, map) = (Analysis::of(&settings)?, map(&settings, x, y)?);
            let verdict = LoopVerdict::with_loop(scenario, settings.clone())?;
            let (bounded, response) = (Bounded::of(&settings, &terminations)?, LoopResponse::of(&settings)?);
            Ok((verdict, analysis, map, population, bounded, response))
        };
        let of_events = || match SwitchingSettings::of(scenario, settings.clone(), sector) {
            Ok(settings) => Switching::of(&settings).map(Ok),
            Err(reason) => Ok(Err(reason)),
        };
        let (linear, switching) = rayon::join(linear, of_events);
        let ((verdict, analysis, map, population, bounded, response), switching) = (linear?, switching?);
        Ok(Self {
            name: scenario.name.clone(),
            verdict,
            analysis,
            map,
            switching,
            measured: None,
            z_width: None,
            population,
            bounded,
            absolute: None,
            check: None,
            response,
            locus: None,
            sensor_force_n: 0.5 * scenario.sensor.force_resolution_n + DEVIATIONS * scenario.sensor.force_noise_std_n,
            event_limits: vec![],
            worst_events: None,
            rounded: delays_rounded(scenario),
        })
    }

    pub fn compute_measured(&mut self, sides: &MeasuredSides) -> Result<(), CheckError> {
        self.measured = Some(MeasuredLoop::of(&self.analysis.settings, sides)?);
        Ok(())
    }

    /// The axis is [`Parameter::Damping`].
    pub fn compute_z_width(&mut self, axis: &Axis) -> Result<(), CheckError> {
        self.z_width = Some(ZWidth::of(&self.analysis.settings, axis)?);
        Ok(())
    }

    pub fn compute_absolute(&mut self, terminations: &Terminations, axis: Option<&Axis>) -> Result<(), CheckError> {
        let settings = &self.analysis.settings;
        self.bounded = Bounded::of(settings, terminations)?;
        self.absolute = axis.map(|axis| AbsoluteOver::of(settings, axis, terminations)).transpose()?;
        Ok(())
    }

    /// Takes minutes.
    pub fn compute_event_limits(&mut self) -> Result<(), CheckError> {
        if let Ok(Switching { settings, peaks, .. }) = &self.switching {
            self.event_limits = EventLimit::of_each(settings, peaks.as_ref())?;
        }
        Ok(())
    }

    pub fn compute_locus(&mut self, axis: &Axis) -> Result<(), CheckError> {
        self.locus = Some(Locus::of(&self.analysis.settings, axis)?);
        Ok(())
    }

    pub fn make_worst_events(&mut self, source: &Source, settings: &[String]) -> Result<(), ScenarioError> {
        self.worst_events =
            self.switching.as_ref().ok().map(|switching| worst_events(source, settings, switching)).transpose()?;
        Ok(())
    }

    pub fn tissue(&self) -> &TissueRange {
        &self.analysis.settings.tissue
    }

    /// True if the tissue is always a spring and a damper within the certificate's ranges with an additional force.
    pub fn covers_tissue(&self) -> Option<bool> {
        let (low, high) = self.switching.as_ref().ok()?.settings.stiffness_n_per_m;
        let (softest, stiffest) = self.tissue().sector_n_per_m();
        Some(low <= softest && stiffest <= high)
    }

    /// True if every motion decays or stays bounded. `None` if the analysis leaves out a part or does not cover the
    /// tissue.
    pub fn is_certified(&self) -> Option<bool> {
        let is_stated = !matches!(self.statement(), Statement::None(_));
        (self.verdict.left_out.is_empty() && self.covers_tissue()?).then_some(is_stated)
    }

    pub fn warnings(&self) -> Vec<Warning> {
        let left_out = self.verdict.left_out.iter().map(|part| {
            let reached =
                part.bound.map_or_else(String::new, |bound| format!(", which the loop may exceed (bound {bound:.4})"));
            let message = format!("the analysis leaves out {part}{reached}: stability is unknown");
            Warning::new(Code::Unmodelled, message)
                .of(&self.name)
                .at(part.key)
                .remedy("`trocar run` simulates it and warns of a swing that does not decay; no warning is no proof")
        });
        let sector = self.switching.as_ref().ok().map(|switching| switching.settings.stiffness_n_per_m);
        let uncovered = sector.filter(|_| self.covers_tissue() == Some(false)).map(|(low, high)| {
            let (softest, stiffest) = self.tissue().sector_n_per_m();
            let message = format!(
                "the tissue has {softest:.0} to {stiffest:.0} N/m, and the analysis of events covers {low} to {high} N/m"
            );
            Warning::new(Code::TissueNotCovered, message)
                .of(&self.name)
                .at("--tissue")
                .remedy("leave out --tissue: the default is the range of the scenario's tissue")
        });
        self.rounded.iter().cloned().chain(left_out).chain(uncovered).collect()
    }

    /// Calls `done` after each point of the map, until `stop` is set.
    pub fn simulate(
        &mut self,
        scenario: &Scenario,
        stop: &AtomicBool,
        done: impl Fn() + Sync,
    ) -> Result<(), CheckError> {
        self.check = Some(check((scenario, &self.analysis.settings), &self.map, stop, done)?);
        Ok(())
    }
}

/// Ascending, from 0 to [`MAX_STIFFNESS_N_PER_M`].
pub fn is_tissue((low, high): (f64, f64)) -> bool {
    0.0 <= low && low <= high && high <= MAX_STIFFNESS_N_PER_M
}
