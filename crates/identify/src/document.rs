use std::fmt::Write as _;

use trocar_document::figure::{Figure, HAND};
use trocar_document::{Cell, DataTable, Document, Number, Study, Table, TextFile, Verdict, shortest};

use crate::actuator::Bounded;
use crate::estimate::{Fit, Identification, Role};
use crate::figure::Traces;
use crate::file::{FitEntry, IdentificationFile, StructureEntry};
use crate::structure::{Parameter, Structure};
use crate::tables::{self, Contents, Reported};
use crate::twin;

const MACHINE: &str = "slave";

const SCENARIO_QUESTION: &str = "What does the identified slave do at the ruptures of skin and muscle?";
const SCENARIO_BASE: &str = "layers/skin-augmented";

impl Study for Identification {
    fn document(&self) -> Document<'_> {
        let mut document = tables::document(Contents {
            verdict: self.verdict(),
            warnings: &self.warnings,
            parameters: &self.reported(),
            fits: self.fit_table(),
            structures: self.structure_table(),
            comparison: "Each structure is fitted to the first two thirds of the training recordings and simulates the rest. The \
                         simplest structure within 0.05 points of the best is chosen.",
            names: self.names(),
            file: self.file(),
        });
        for (fit, name) in self.fits.iter().zip(self.names()) {
            document.figures.push((name.clone().into(), figure(fit)));
            document.data.push(data(fit, name));
        }
        document.files.push(TextFile { name: "machine.toml".into(), text: self.toml() });
        if let Some(text) = self.scenario() {
            document.files.push(TextFile { name: "slave.toml".into(), text });
            document.files.push(TextFile { name: "twin.toml".into(), text: twin::twin(&self.parameters) });
        }
        document
    }
}

impl Identification {
    fn reported(&self) -> Vec<Reported> {
        let reported = |(parameter, bounded): &(Parameter, Bounded)| Reported {
            key: parameter.key(),
            name: parameter.name(),
            unit: self.unit(*parameter),
            bounded: *bounded,
        };
        self.parameters.iter().map(reported).collect()
    }

    fn verdict(&self) -> Verdict {
        let reported = self.reported();
        let listed =
            [Parameter::Mass, Parameter::Viscous, Parameter::Coulomb, Parameter::PositionGain, Parameter::VelocityGain];
        let is_listed = |one: &Reported| listed.iter().any(|parameter| parameter.key() == one.key);
        let (shown, hidden): (Vec<Reported>, Vec<Reported>) = reported.into_iter().partition(is_listed);
        let mut sentences = vec![format!("Identified: {}.", tables::listed(&shown))];
        let [trained, predicted] = [Role::Training, Role::Prediction].map(|role| self.mean_fit_percent(role));
        let others = self.fits.iter().filter(|fit| fit.role == Role::Prediction);
        let others: Vec<(&str, Option<f64>)> =
            others.map(|fit| (fit.measured.name.as_str(), fit.fit_percent)).collect();
        sentences.extend(tables::fit_sentences(trained, predicted, &others));
        let mut left_out = self.questions.open();
        let reported: Vec<Reported> = shown.into_iter().chain(hidden).collect();
        left_out.extend(tables::doubts(&reported, self.fits.iter().map(|fit| fit.whiteness)));
        Verdict { sentences, left_out }
    }

    fn unit(&self, parameter: Parameter) -> String {
        let per_mass = self.questions.only_ratios() && !matches!(parameter, Parameter::Mass | Parameter::Delay);
        if per_mass { format!("{} per kg", parameter.unit()) } else { parameter.unit().to_owned() }
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
            let rms_m = fit
                .fit_percent
                .map(|percent| (1.0 - percent / 100.0) * fit.measured.motion_m() / (fit.measured.len() as f64).sqrt());
            table.row([
                name.into(),
                fit.role.word().into(),
                tables::percent(fit.fit_percent, 1),
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
            let chosen = if *structure == self.structure { "chosen".into() } else { Cell::empty() };
            table.row([structure.name().into(), tables::percent(*fit, 2), chosen]);
        }
        table
    }

    fn names(&self) -> Vec<String> {
        tables::file_names(self.fits.iter().map(|fit| fit.measured.name.as_str()))
    }

    fn file(&self) -> IdentificationFile<'_> {
        let structure = |(structure, fit): &(Structure, Option<f64>)| StructureEntry {
            structure: structure.key(),
            held_out_fit_percent: *fit,
            bayes_information: None,
        };
        IdentificationFile {
            trocar_version: env!("CARGO_PKG_VERSION"),
            machine: MACHINE,
            warnings: self.warnings.clone(),
            parameters: tables::parameter_entries(&self.reported()),
            fits: self.fits.iter().map(fit_entry).collect(),
            structure: self.structure.key(),
            structures: self.candidates.iter().map(structure).collect(),
            force_scaled_up_to_n: Some(self.machine.load.scaled_up_to_n),
            only_ratios: self.questions.only_ratios(),
            open: self.verdict().left_out,
        }
    }

    fn toml(&self) -> String {
        let training = self.fits.iter().filter(|fit| fit.role == Role::Training).map(|fit| fit.measured.name.as_str());
        let mut text = tables::toml(MACHINE, &self.reported(), training);
        let largest_n = shortest(self.machine.load.scaled_up_to_n);
        let _ =
            writeln!(text, "force_scaled_up_to_n = {largest_n} # N, the largest reading in the training recordings");
        text
    }

    /// `None` if only ratios are known, because these are not forces.
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
        for (key, parameter) in twin::KEYS {
            let _ = writeln!(text, "{key} = {}", shortest(value(parameter)));
        }
        text.push_str("velocity_gain = 0.0\n");
        Some(text)
    }
}

fn fit_entry(fit: &Fit) -> FitEntry<'_> {
    let Fit { measured, role, sensor_zero_n, fit_percent, whiteness, .. } = fit;
    let (role, sensor_zero_n, fit_percent) = (*role, Some(*sensor_zero_n), *fit_percent);
    FitEntry { recording: &measured.name, role, sensor_zero_n, fit_percent, whiteness: *whiteness }
}

fn times(fit: &Fit) -> Vec<f64> {
    tables::times(fit.measured.len(), fit.measured.interval_s)
}

fn figure(fit: &Fit) -> Figure<'static> {
    let Fit { measured, fit_percent, simulated_m, .. } = fit;
    Traces {
        recording: &measured.name,
        fit_percent: *fit_percent,
        time_s: times(fit),
        measured: (&measured.slave_m, "slave, measured"),
        simulated: (simulated_m.as_deref(), "slave, simulated"),
        further: Some((&measured.master_m, HAND, "master")),
        factor: 1e3,
        captions: ["Position (mm)", "Simulated - measured (mm)"],
    }
    .figure()
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
