//! The stability study of a scenario.

use std::sync::atomic::AtomicBool;

use super::own_tissue::TissueRange;
use super::{Check, CheckError, check};
use crate::scenario::Scenario;
use crate::stability::{
    AbsoluteOver, Analysis, Axis, Bounded, LeftOut, LoopLimit, LoopSettings, Parameter, Population, StabilityError,
    StabilityMap, Switching, SwitchingSettings, Terminations, TissueKind, VaryingDelays, ZWidth, left_out_with,
    loop_limits, map, unmodelled,
};
use crate::warning::{Code, Warning};

/// Maximum tissue stiffness of the switching analysis, in N/m.
pub const MAX_STIFFNESS_N_PER_M: f64 = 1e6;

/// A scenario's loop, its map over two parameters, its events, and the comparison with the engine.
#[derive(Debug, Clone)]
pub struct StabilityStudy {
    /// The scenario's name.
    pub name: String,
    /// The parts of the scenario that the analysis leaves out, besides tissue and augmentation.
    pub left_out: Vec<LeftOut>,
    /// The limits of motors and force sensor that the loop never reaches.
    pub unreached: Vec<LoopLimit>,
    /// Delays that vary from tick to tick; `None` if they are constant, or if nothing bounds them.
    pub delays: Option<VaryingDelays>,
    /// The kind of its tissue.
    pub tissue_kind: TissueKind,
    /// The stiffness of the tissue in its run.
    pub tissue: TissueRange,
    /// Everything that the linear loop leaves out, with tissue and augmentation.
    pub unmodelled: Vec<String>,
    /// The loop. Its stiffness is that of the scenario's spring and damper, the largest one of the tissue's own run for
    /// other tissues, and `tissue.stiffness_n_per_m` for a force recorded over time.
    pub analysis: Analysis,
    /// The map.
    pub map: StabilityMap,
    /// The switching analysis, or why there is none.
    pub switching: Result<Switching, &'static str>,
    /// The Z-width, if it was computed.
    pub z_width: Option<ZWidth>,
    /// The limits over the scenario's population, if it has one.
    pub population: Option<Population>,
    /// The absolute stability with bounded hands and tissues: any passive hand and the tissues of the switching analysis, if
    /// no others were given.
    pub bounded: Bounded,
    /// The absolute stability over a parameter, if it was computed.
    pub absolute: Option<AbsoluteOver>,
    /// The comparison of the map with the engine, if it was run.
    pub check: Option<Check>,
}

impl StabilityStudy {
    /// Analyses a scenario, its map over two axes, and its switching with any tissue stiffness (N/m) in the range
    /// `sector`, which must satisfy [`is_tissue`]. Runs the scenario once, for the stiffness of its tissue.
    ///
    /// # Errors
    /// [`CheckError`].
    pub fn of(scenario: &Scenario, (x, y): (Axis, Axis), sector: (f64, f64)) -> Result<Self, CheckError> {
        let mut settings = LoopSettings::of(scenario);
        let (tissue_kind, tissue) = (TissueKind::of(scenario), TissueRange::of(scenario)?);
        if let (TissueKind::Other, Some((_, stiffest))) = (tissue_kind, tissue.sector()) {
            (settings.stiffness_n_per_m, settings.damping_n_s_per_m) = (stiffest.max(0.0), 0.0);
        }
        let population = &scenario.population;
        let over_people = || Population::of(&settings, population, scenario.seed, (&x, &y));
        let terminations = Terminations {
            hand_n_s_per_m: (0.0, f64::INFINITY),
            stiffness_n_per_m: sector,
            damping_n_s_per_m: (settings.damping_n_s_per_m, settings.damping_n_s_per_m),
        };
        let linear = || -> Result<_, StabilityError> {
            let population = population.varies().then(over_people).transpose()?;
            let (analysis, map) = (Analysis::of(&settings)?, map(&settings, x, y)?);
            let delays = VaryingDelays::of(scenario, &settings)?;
            Ok((analysis, map, population, Bounded::of(&settings, &terminations)?, delays))
        };
        let of_events = || match SwitchingSettings::with_loop(scenario, settings.clone(), sector) {
            Ok(settings) => Switching::of(&settings).map(Ok),
            Err(reason) => Ok(Err(reason)),
        };
        let (linear, switching) = rayon::join(linear, of_events);
        let ((analysis, map, population, bounded, delays), switching) = (linear?, switching?);
        let limits = loop_limits(scenario);
        let left_out = left_out_with(scenario, delays.as_ref(), &limits);
        let unreached = limits.into_iter().filter(LoopLimit::is_unreached).collect();
        Ok(Self {
            name: scenario.name.clone(),
            unmodelled: unmodelled(scenario, &left_out),
            left_out,
            unreached,
            delays,
            tissue_kind,
            tissue,
            analysis,
            map,
            switching,
            z_width: None,
            population,
            bounded,
            absolute: None,
            check: None,
        })
    }

    /// Computes the Z-width over the values of an axis of [`Parameter::Damping`].
    ///
    /// # Errors
    /// [`CheckError`].
    pub fn compute_z_width(&mut self, axis: &Axis) -> Result<(), CheckError> {
        self.z_width = Some(ZWidth::of(&self.analysis.settings, axis)?);
        Ok(())
    }

    /// Computes the absolute stability with these hands and tissues, and over an axis if there is one.
    ///
    /// # Errors
    /// [`CheckError`].
    pub fn compute_absolute(&mut self, terminations: &Terminations, axis: Option<&Axis>) -> Result<(), CheckError> {
        let settings = &self.analysis.settings;
        self.bounded = Bounded::of(settings, terminations)?;
        self.absolute = axis.map(|axis| AbsoluteOver::of(settings, axis, terminations)).transpose()?;
        Ok(())
    }

    /// Whether the scenario's loop is stable, in contact with its tissue and out of it, for every order of delays that vary;
    /// `None` where the analysis leaves out a part of the scenario.
    #[must_use]
    pub fn is_stable(&self) -> Option<bool> {
        let stiffness = self.analysis.limits.iter().find(|limit| limit.parameter == Parameter::Stiffness)?;
        let k = self.analysis.settings.stiffness_n_per_m;
        let is_stable_out_of_contact = stiffness.stable.iter().any(|&(from, to)| from <= 0.0 && k <= to);
        self.left_out.is_empty().then(|| self.analysis.is_stable() && is_stable_out_of_contact)
    }

    /// Whether the certificate's range of stiffness has all that the tissue shows in the scenario's run.
    #[must_use]
    pub fn covers_tissue(&self) -> Option<bool> {
        let (low, high) = self.switching.as_ref().ok()?.settings.stiffness_n_per_m;
        self.tissue.sector().map(|(softest, stiffest)| low <= softest && stiffest <= high)
    }

    /// Whether the switching between the modes is certified for the scenario; `None` where it is not analysed, where the
    /// analysis leaves out a part of the scenario, and where the range of stiffness does not cover the scenario's tissue.
    #[must_use]
    pub fn is_certified(&self) -> Option<bool> {
        let switching = self.switching.as_ref().ok()?;
        (self.left_out.is_empty() && self.covers_tissue() == Some(true)).then(|| switching.is_certified())
    }

    /// The warnings about the analysis.
    #[must_use]
    pub fn warnings(&self) -> Vec<Warning> {
        let left_out = self.left_out.iter().map(|part| {
            let reached =
                part.bound.map_or_else(String::new, |bound| format!(", which the loop may exceed (bound {bound:.4})"));
            let message = format!("the analysis leaves out {part}{reached}: stability is unknown");
            Warning::new(Code::Unmodelled, message)
                .of(&self.name)
                .at(part.key)
                .remedy("`trocar run` simulates it and warns of a swing that does not decay; no warning is no proof")
        });
        let sector = self.switching.as_ref().ok().map(|switching| switching.settings.stiffness_n_per_m);
        let uncovered = (self.covers_tissue() == Some(false)).then(|| self.tissue.sector().zip(sector)).flatten();
        let uncovered = uncovered.map(|((softest, stiffest), (low, high))| {
            let message = format!(
                "the tissue of the run has {softest:.0} to {stiffest:.0} N/m, and the analysis of events covers {low} to {high} N/m"
            );
            let warning = Warning::new(Code::TissueNotCovered, message).of(&self.name).at("--tissue");
            match (softest >= 0.0, stiffest <= MAX_STIFFNESS_N_PER_M) {
                (true, true) => warning.remedy(format!("analyse --tissue {:.0}:{:.0}", softest.floor(), stiffest.ceil())),
                _ => warning.remedy("a force that falls while the needle advances is not a spring; the run tells more"),
            }
        });
        left_out.chain(uncovered).collect()
    }

    /// Runs the engine at every point of the map; calls `done` after each run; runs not begun when `stop` is set are
    /// skipped.
    ///
    /// # Errors
    /// [`CheckError`].
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

/// Whether the switching can be analysed for a tissue between these stiffnesses in N/m: ascending, from 0 to
/// [`MAX_STIFFNESS_N_PER_M`].
#[must_use]
pub fn is_tissue((low, high): (f64, f64)) -> bool {
    0.0 <= low && low <= high && high <= MAX_STIFFNESS_N_PER_M
}
