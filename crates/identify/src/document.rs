//! The document of an identification.

use std::fmt::Write as _;

use trocar_base::names::distinct;
use trocar_document::figure::{
    Axis, COMPUTED, Figure, HAND, Panel, Row, Sample, Series, TISSUE, X_TICKS, Y_TICKS, extent,
};
use trocar_document::{
    Cell, DataTable, Digits, Document, Number, Section, Study, Table, TextFile, Verdict, json_of, shortest, significant,
};

use crate::estimate::{Fit, Identification, Role};
use crate::file::{FitEntry, IdentificationFile, ParameterEntry, StructureEntry};
use crate::structure::Parameter;

/// The identified machine, in files.
const MACHINE: &str = "slave";

/// The first line and the base of the scenario with the identified slave.
const SCENARIO_QUESTION: &str = "What does the identified slave do at the ruptures of skin and muscle?";
const SCENARIO_BASE: &str = "layers/skin-augmented";

/// A prediction with at least this fit supports the machine.
const GOOD_PERCENT: f64 = 90.0;

impl Study for Identification {
    fn document(&self) -> Document<'_> {
        let mut parameters = Section::new("parameters", "Parameters");
        parameters.table(self.parameter_table());
        let mut fits = Section::new("fits", "Fits");
        fits.table(self.fit_table());
        fits.figures(self.names(), vec![]);
        let mut structures = Section::new("structures", "Structures");
        structures.table(self.structure_table());
        structures.text(
            "Each structure is fitted to the first two thirds of the training recordings and simulates the rest. The simplest \
             structure within 0.05 points of the best is chosen.",
        );
        let mut document = Document {
            name: "identification",
            title: format!("identification of the {MACHINE}"),
            verdict: self.verdict(),
            warnings: self.warnings.clone(),
            sections: vec![parameters, fits, structures],
            json: json_of(&self.file()),
            ..Document::default()
        };
        for (fit, name) in self.fits.iter().zip(self.names()) {
            document.figures.push((name.clone().into(), figure(fit)));
            document.data.push(data(fit, name));
        }
        document.files.push(TextFile { name: "machine.toml".into(), text: self.toml() });
        document.files.extend(self.scenario().map(|text| TextFile { name: "slave.toml".into(), text }));
        document
    }
}

impl Identification {
    fn verdict(&self) -> Verdict {
        let value = |parameter: &Parameter| {
            let (_, bounded) = self.parameters.iter().find(|(own, _)| own == parameter)?;
            Some(format!("{} {} {}", parameter.name(), significant(bounded.value), self.unit(*parameter)))
        };
        let listed =
            [Parameter::Mass, Parameter::Viscous, Parameter::Coulomb, Parameter::PositionGain, Parameter::VelocityGain];
        let values: Vec<String> = listed.iter().filter_map(value).collect();
        let mut sentences = vec![format!("Identified: {}.", values.join(", "))];
        let trained = self.mean_fit_percent(Role::Training);
        let predicted = self.fits.iter().filter(|fit| fit.role == Role::Prediction);
        let worst =
            predicted.min_by(|a, b| a.fit_percent.unwrap_or(f64::MIN).total_cmp(&b.fit_percent.unwrap_or(f64::MIN)));
        let percent = |fit: Option<f64>| fit.map_or_else(|| "no".to_owned(), |fit| format!("{fit:.1} %"));
        sentences.push(match worst {
            None => format!(
                "It follows the training recordings with a mean fit of {}. No recording tests it: give --predict.",
                percent(trained)
            ),
            Some(worst) => format!(
                "It predicts the recordings that took no part with a mean fit of {}, at worst {} ({}); the training recordings \
                 have {}.",
                percent(self.mean_fit_percent(Role::Prediction)),
                percent(worst.fit_percent),
                worst.measured.name,
                percent(trained)
            ),
        });
        if worst.is_some_and(|worst| worst.fit_percent.is_none_or(|fit| fit < GOOD_PERCENT)) {
            sentences.push(
                "A fit below 90 % means that the machine has a part which this structure or these training recordings lack.".into(),
            );
        }
        let mut left_out = self.questions.open();
        let unknown = self.parameters.iter().filter(|(_, bounded)| bounded.low == 0.0 || !bounded.high.is_finite());
        let unknown: Vec<&str> = unknown.map(|(parameter, _)| parameter.name()).collect();
        if !unknown.is_empty() {
            left_out.push(format!("The recordings cannot tell from zero: {}.", unknown.join(", ")));
        }
        let coloured = self.fits.iter().any(|fit| fit.whiteness.is_some_and(|whiteness| !whiteness.is_white()));
        if coloured {
            left_out.push(
                "The errors of the simulation are correlated in time: the machine has parts beyond this structure. The intervals allow for \
                 the correlation, but not for parts that only other motions excite."
                    .into(),
            );
        }
        Verdict { sentences, left_out }
    }

    fn unit(&self, parameter: Parameter) -> String {
        let per_mass = self.questions.only_ratios() && !matches!(parameter, Parameter::Mass | Parameter::Delay);
        if per_mass { format!("{} per kg", parameter.unit()) } else { parameter.unit().to_owned() }
    }

    fn parameter_table(&self) -> Table {
        let columns = [("parameter", "parameter"), ("value", "value"), ("low", "95 % from"), ("high", "to")];
        let mut table = Table::new("parameters", "Parameters", columns);
        for (parameter, bounded) in &self.parameters {
            let cell = |value: f64| {
                if !value.is_finite() {
                    return Cell::Undefined;
                }
                match parameter {
                    Parameter::Delay | Parameter::Lag => Number::milliseconds(value).into(),
                    _ => Number::si(value, self.unit(*parameter)).into(),
                }
            };
            table.row([parameter.name().into(), cell(bounded.value), cell(bounded.low), cell(bounded.high)]);
        }
        table
    }

    fn fit_table(&self) -> Table {
        let columns = [
            ("recording", "recording"),
            ("role", "role"),
            ("fit", "fit"),
            ("zero", "sensor zero"),
            ("error", "RMS error"),
            ("white", "white error"),
        ];
        let mut table = Table::new("fits", "Fits", columns);
        for (fit, name) in self.fits.iter().zip(self.names()) {
            let role = match fit.role {
                Role::Training => "training",
                Role::Prediction => "prediction",
            };
            let percent = |value| Number::si(value, "%").digits(Digits::Decimals(1)).into();
            let rms_m = fit
                .fit_percent
                .map(|percent| (1.0 - percent / 100.0) * fit.measured.motion_m() / (fit.measured.len() as f64).sqrt());
            table.row([
                name.into(),
                role.into(),
                fit.fit_percent.map_or(Cell::Undefined, percent),
                Number::si(fit.sensor_zero_n, "N").into(),
                Cell::of(rms_m, trocar_document::Unit::Metre),
                Cell::flag(fit.whiteness.map(|whiteness| whiteness.is_white())),
            ]);
        }
        table
    }

    fn structure_table(&self) -> Table {
        let columns = [("structure", "structure"), ("fit", "held-out fit"), ("chosen", "")];
        let mut table = Table::new("structures", "Structures", columns);
        for (structure, fit) in &self.candidates {
            let percent = |value| Number::si(value, "%").digits(Digits::Decimals(2)).into();
            let chosen = if *structure == self.structure { "chosen".into() } else { Cell::empty() };
            table.row([structure.name().into(), fit.map_or(Cell::Undefined, percent), chosen]);
        }
        table
    }

    /// Returns a name for the files of each recording: the stem of its file, with a number if it repeats.
    fn names(&self) -> Vec<String> {
        let stem = |fit: &Fit| {
            let stem = std::path::Path::new(&fit.measured.name).file_stem();
            stem.map_or_else(|| "recording".into(), |stem| stem.to_string_lossy().into_owned())
        };
        distinct(&self.fits.iter().map(stem).collect::<Vec<_>>(), &[])
    }

    fn file(&self) -> IdentificationFile<'_> {
        let entry = |(parameter, bounded): &(Parameter, crate::actuator::Bounded)| {
            let finite = |value: f64| value.is_finite().then_some(value);
            let (low, high) = (finite(bounded.low), finite(bounded.high));
            (parameter.key(), ParameterEntry { value: bounded.value, low, high, unit: self.unit(*parameter) })
        };
        IdentificationFile {
            trocar_version: env!("CARGO_PKG_VERSION"),
            machine: MACHINE,
            warnings: self.warnings.clone(),
            parameters: self.parameters.iter().map(entry).collect(),
            fits: self.fits.iter().map(fit_entry).collect(),
            structure: self.structure,
            structures: self
                .candidates
                .iter()
                .map(|(structure, fit)| StructureEntry { structure: *structure, held_out_fit_percent: *fit })
                .collect(),
            force_scaled_up_to_n: self.machine.load.scaled_up_to_n,
            only_ratios: self.questions.only_ratios(),
            open: self.verdict().left_out,
        }
    }

    /// Returns the parameters as a TOML table.
    fn toml(&self) -> String {
        let mut text = format!("# Identified by trocar {}.\n", env!("CARGO_PKG_VERSION"));
        for fit in self.fits.iter().filter(|fit| fit.role == Role::Training) {
            let _ = writeln!(text, "# Training recording: {:?}", fit.measured.name);
        }
        let _ = writeln!(text, "[machine.{MACHINE}]");
        for (parameter, bounded) in &self.parameters {
            let interval = if bounded.low.is_finite() && bounded.high.is_finite() {
                format!("95 % interval {:.4e} to {:.4e}", bounded.low, bounded.high)
            } else {
                "not determined by the recordings".to_owned()
            };
            let (key, value, unit) = (parameter.key(), shortest(bounded.value), self.unit(*parameter));
            let _ = writeln!(text, "{key} = {value} # {unit}, {interval}");
        }
        let largest_n = shortest(self.machine.load.scaled_up_to_n);
        let _ =
            writeln!(text, "force_scaled_up_to_n = {largest_n} # N, the largest reading in the training recordings");
        text
    }

    /// Returns a scenario with the identified slave; `None` if only ratios are known, which are no forces.
    fn scenario(&self) -> Option<String> {
        let value = |parameter: Parameter| {
            let found = self.parameters.iter().find(|(own, _)| *own == parameter);
            found.map_or(0.0, |(_, bounded)| bounded.value.max(0.0))
        };
        if self.questions.only_ratios() {
            return None;
        }
        let mut text = format!("# {SCENARIO_QUESTION}\nbase = \"{SCENARIO_BASE}\"\n\n[slave]\n");
        let delay_s = value(Parameter::Delay);
        if delay_s > 0.0 {
            let _ = writeln!(
                text,
                "# The controller computes on the tick; its identified delay of {delay_s:.3e} s is left out."
            );
        }
        text.push_str("model = \"mass-damper\"\ncontroller = \"pid\"\n");
        for (key, parameter) in [
            ("mass_kg", Parameter::Mass),
            ("damping_n_s_per_m", Parameter::Viscous),
            ("coulomb_friction_n", Parameter::Coulomb),
            ("proportional_gain", Parameter::PositionGain),
            ("derivative_gain", Parameter::VelocityGain),
        ] {
            let _ = writeln!(text, "{key} = {}", shortest(value(parameter)));
        }
        text.push_str("velocity_gain = 0.0\n");
        Some(text)
    }
}

fn fit_entry(fit: &Fit) -> FitEntry<'_> {
    let Fit { measured, role, sensor_zero_n, fit_percent, whiteness, .. } = fit;
    let (role, sensor_zero_n, fit_percent) = (*role, *sensor_zero_n, *fit_percent);
    FitEntry { recording: &measured.name, role, sensor_zero_n, fit_percent, whiteness: *whiteness }
}

fn times(fit: &Fit) -> Vec<f64> {
    (0..fit.measured.len()).map(|sample| sample as f64 * fit.measured.interval_s).collect()
}

/// Draws measured and simulated positions (above) and their difference (below).
fn figure(fit: &Fit) -> Figure<'static> {
    let measured = &fit.measured;
    let time_s = times(fit);
    let simulated_m = fit.simulated_m.clone().unwrap_or_else(|| vec![f64::NAN; time_s.len()]);
    let error_m: Vec<f64> = simulated_m.iter().zip(&measured.slave_m).map(|(a, b)| a - b).collect();
    let time = Axis::exact((0.0, time_s.last().copied().unwrap_or(1.0)), X_TICKS);
    let axis = |values: &mut dyn Iterator<Item = f64>| {
        Axis::padded(extent(values.map(|m| 1e3 * m)).unwrap_or((0.0, 1.0)), Y_TICKS - 1)
    };
    let both = axis(&mut measured.slave_m.iter().chain(&measured.master_m).chain(&simulated_m).copied());
    let series = |values: &[f64], stroke| Series::new(time_s.clone(), values.to_vec(), stroke).times(1e3);
    let positions = Panel {
        series: vec![
            series(&measured.master_m, HAND),
            series(&measured.slave_m, TISSUE),
            series(&simulated_m, COMPUTED),
        ],
        legend: [(HAND, "master"), (TISSUE, "slave, measured"), (COMPUTED, "slave, simulated")]
            .map(|(line, name)| (Sample::Line(line), name.to_owned()))
            .into(),
        ..Panel::over_time(time.clone(), both, "Position (mm)")
    };
    let errors = Panel {
        series: vec![series(&error_m, COMPUTED)],
        ..Panel::over_time(time, axis(&mut error_m.iter().copied()), "Simulated - measured (mm)")
    };
    let fit_text = fit.fit_percent.map_or_else(String::new, |percent| format!(", fit {percent:.1} %"));
    Figure {
        name: format!("{}{fit_text}", measured.name),
        legend: vec![],
        rows: vec![Row::of(140.0, positions), Row::of(95.0, errors)],
    }
}

fn data(fit: &Fit, name: String) -> DataTable<'static> {
    let measured = &fit.measured;
    let simulated = fit.simulated_m.clone();
    DataTable::new(name)
        .sampled()
        .numbers("time_s", times(fit))
        .numbers("master_m", measured.master_m.iter().copied())
        .numbers("slave_m", measured.slave_m.iter().copied())
        .optional("simulated_m", (0..measured.len()).map(|k| simulated.as_ref().map(|simulated| simulated[k])))
        .numbers("force_n", measured.force_n.iter().copied())
}
