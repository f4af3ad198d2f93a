//! The document of an identified part.

use trocar_document::figure::{COMPUTED, Figure, Panel, Row, Sample, Series, TISSUE};
use trocar_document::{Cell, DataTable, Document, Number, Section, Study, Table, TextFile, Unit, Verdict, json_of};

use super::estimate::{Criterion, PartFit, PartIdentification};
use super::{Part, Spec};
use crate::actuator::Bounded;
use crate::estimate::Role;
use crate::file::{FitEntry, IdentificationFile, StructureEntry};
use crate::tables::{self, Reported};

impl Study for PartIdentification {
    fn document(&self) -> Document<'_> {
        let mut parameters = Section::new("parameters", "Parameters");
        parameters.table(tables::parameter_table(&self.reported()));
        let mut fits = Section::new("fits", "Fits");
        fits.table(self.fit_table());
        fits.figures(self.names(), vec![]);
        let mut structures = Section::new("structures", "Structures");
        structures.table(self.structure_table());
        structures.text(match self.criterion {
            Criterion::HeldOut => {
                "Each structure is fitted to the first two thirds of the training recordings and simulates the rest. The simplest \
                 structure whose error is within 5 % of the smallest one is chosen, without those with a part that is not told from 0."
            }
            Criterion::Bayes => {
                "The last third of a training recording has too little change to compare the structures. The one with the smallest \
                 information criterion of Bayes is chosen, without those with a part that is not told from 0."
            }
        });
        let word = self.part.word();
        let mut document = Document {
            name: "identification",
            title: format!("identification of the {word}"),
            verdict: self.verdict(),
            warnings: self.warnings.clone(),
            sections: vec![parameters, fits, structures],
            json: json_of(&self.file()),
            ..Document::default()
        };
        for (fit, name) in self.fits.iter().zip(self.names()) {
            document.figures.push((name.clone().into(), self.figure(fit)));
            document.data.push(self.data(fit, name));
        }
        let training = self.fits.iter().filter(|fit| fit.role == Role::Training).map(|fit| fit.signals.name.as_str());
        let machine = tables::toml(word, &self.reported(), training);
        document.files.push(TextFile { name: "machine.toml".into(), text: machine });
        document.files.push(self.file.clone());
        document
    }
}

impl PartIdentification {
    fn reported(&self) -> Vec<Reported> {
        let reported = |(spec, bounded): &(Spec, Bounded)| Reported {
            key: spec.key,
            name: spec.name,
            unit: spec.unit.to_owned(),
            bounded: *bounded,
        };
        self.parameters.iter().map(reported).collect()
    }

    fn verdict(&self) -> Verdict {
        let reported = self.reported();
        let mut sentences = vec![format!("Identified: {}.", tables::listed(&reported))];
        let [trained, predicted] = [Role::Training, Role::Prediction].map(|role| self.mean_fit_percent(role));
        let others = self.fits.iter().filter(|fit| fit.role == Role::Prediction);
        let others: Vec<(&str, Option<f64>)> = others.map(|fit| (fit.signals.name.as_str(), fit.fit_percent)).collect();
        sentences.extend(tables::fit_sentences(trained, predicted, &others));
        let mut left_out = self.open.clone();
        left_out.extend(tables::doubts(&reported, self.fits.iter().map(|fit| fit.whiteness)));
        Verdict { sentences, left_out }
    }

    fn fit_table(&self) -> Table {
        let columns = [
            ("recording", "recording"),
            ("role", "role"),
            ("fit", "fit"),
            ("error", "RMS error"),
            ("white", "white error"),
        ];
        let mut table = Table::new("fits", "Fits", columns);
        for (fit, name) in self.fits.iter().zip(self.names()) {
            let scale = fit.signals.variation(self.part) / (fit.signals.len() as f64).sqrt();
            let rms = |percent: f64| (1.0 - percent / 100.0) * scale;
            let unit = match self.part {
                Part::Tissue | Part::Arm => Unit::Newton,
                Part::Master => Unit::Metre,
            };
            table.row([
                name.into(),
                fit.role.word().into(),
                tables::percent(fit.fit_percent, 1),
                Cell::of(fit.fit_percent.map(rms), unit),
                Cell::flag(fit.whiteness.map(|whiteness| whiteness.is_white())),
            ]);
        }
        table
    }

    fn structure_table(&self) -> Table {
        let columns =
            [("structure", "structure"), ("fit", "held-out fit"), ("bayes", "information criterion"), ("chosen", "")];
        let mut table = Table::new("structures", "Structures", columns);
        for one in &self.compared {
            let chosen = if one.key == self.structure { "chosen".into() } else { Cell::empty() };
            let bayes = one.bayes.is_finite().then_some(one.bayes);
            let bayes = bayes.map_or(Cell::Undefined, |bayes| Number::si(bayes, "").into());
            table.row([one.name.into(), tables::percent(one.held_out_percent, 2), bayes, chosen]);
        }
        table
    }

    fn names(&self) -> Vec<String> {
        tables::file_names(self.fits.iter().map(|fit| fit.signals.name.as_str()))
    }

    fn file(&self) -> IdentificationFile<'_> {
        IdentificationFile {
            trocar_version: env!("CARGO_PKG_VERSION"),
            machine: self.part.word(),
            warnings: self.warnings.clone(),
            parameters: tables::parameter_entries(&self.reported()),
            fits: self.fits.iter().map(fit_entry).collect(),
            structure: self.structure,
            structures: self
                .compared
                .iter()
                .map(|one| StructureEntry {
                    structure: one.key,
                    held_out_fit_percent: one.held_out_percent,
                    bayes_information: one.bayes.is_finite().then_some(one.bayes),
                })
                .collect(),
            force_scaled_up_to_n: None,
            only_ratios: false,
            open: self.verdict().left_out,
        }
    }

    /// Draws the measured and the simulated signal (above) and their difference (below).
    fn figure(&self, fit: &PartFit) -> Figure<'static> {
        let measured = fit.signals.predicted(self.part);
        let (factor, quantity, difference) = match self.part {
            Part::Tissue | Part::Arm => (1.0, "Force (N)", "Simulated - measured (N)"),
            Part::Master => (1e3, "Position (mm)", "Simulated - measured (mm)"),
        };
        let time_s = tables::times(fit.signals.len(), fit.signals.interval_s);
        let simulated = fit.simulated.clone().unwrap_or_else(|| vec![f64::NAN; time_s.len()]);
        let errors: Vec<f64> = simulated.iter().zip(measured).map(|(a, b)| a - b).collect();
        let time = tables::time_axis(&time_s);
        let both = tables::value_axis(measured.iter().chain(&simulated), factor);
        let error_axis = tables::value_axis(errors.iter(), factor);
        let series = |values: &[f64], stroke| Series::new(time_s.clone(), values.to_vec(), stroke).times(factor);
        let above = Panel {
            series: vec![series(measured, TISSUE), series(&simulated, COMPUTED)],
            legend: [(TISSUE, "measured"), (COMPUTED, "simulated")]
                .map(|(line, name)| (Sample::Line(line), name.to_owned()))
                .into(),
            ..Panel::over_time(time.clone(), both, quantity)
        };
        let below = Panel { series: vec![series(&errors, COMPUTED)], ..Panel::over_time(time, error_axis, difference) };
        let fit_text = fit.fit_percent.map_or_else(String::new, |percent| format!(", fit {percent:.1} %"));
        Figure {
            name: format!("{}{fit_text}", fit.signals.name),
            legend: vec![],
            rows: vec![Row::of(140.0, above), Row::of(95.0, below)],
        }
    }

    fn data(&self, fit: &PartFit, name: String) -> DataTable<'static> {
        let signals = &fit.signals;
        let simulated = fit.simulated.clone();
        let column = match self.part {
            Part::Tissue | Part::Arm => "simulated_n",
            Part::Master => "simulated_m",
        };
        DataTable::new(name)
            .sampled()
            .numbers("time_s", tables::times(signals.len(), signals.interval_s))
            .numbers("position_m", signals.position_m.iter().copied())
            .numbers("force_n", signals.force_n.iter().copied())
            .optional(column, (0..signals.len()).map(|k| simulated.as_ref().map(|simulated| simulated[k])))
    }
}

fn fit_entry(fit: &PartFit) -> FitEntry<'_> {
    let PartFit { signals, role, fit_percent, whiteness, .. } = fit;
    let (role, fit_percent, whiteness) = (*role, *fit_percent, *whiteness);
    FitEntry { recording: &signals.name, role, sensor_zero_n: None, fit_percent, whiteness }
}
