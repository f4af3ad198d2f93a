use trocar_document::figure::Figure;
use trocar_document::{Cell, DataTable, Document, Number, Study, Table, TextFile, Unit, Verdict};

use super::estimate::{Criterion, PartFit, PartIdentification};
use super::{Part, Spec};
use crate::actuator::Bounded;
use crate::estimate::Role;
use crate::figure::Traces;
use crate::file::{FitEntry, IdentificationFile, StructureEntry};
use crate::tables::{self, Contents, Reported};

impl Study for PartIdentification {
    fn document(&self) -> Document<'_> {
        let reported = self.reported();
        let mut document = tables::document(Contents {
            verdict: self.verdict(),
            warnings: &self.warnings,
            parameters: &reported,
            fits: self.fit_table(),
            structures: self.structure_table(),
            comparison: match self.criterion {
                Criterion::HeldOut => {
                    "Each structure is fitted to the first two thirds of the training recordings and simulates the rest. The simplest \
                     structure whose error is within 5 % of the smallest one is chosen, without those with a part that cannot be \
                     distinguished from 0."
                }
                Criterion::Bayes => {
                    "The last third of a training recording has too little change to compare the structures. The one with the smallest \
                     information criterion of Bayes is chosen, without those with a part that cannot be distinguished from \
                     0."
                }
            },
            names: self.names(),
            file: self.file(),
        });
        for (fit, name) in self.fits.iter().zip(self.names()) {
            document.figures.push((name.clone().into(), self.figure(fit)));
            document.data.push(self.data(fit, name));
        }
        let training = self.fits.iter().filter(|fit| fit.role == Role::Training).map(|fit| fit.signals.name.as_str());
        let machine = tables::toml(self.part.word(), &reported, training);
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

    fn figure(&self, fit: &PartFit) -> Figure<'static> {
        let PartFit { signals, fit_percent, simulated, .. } = fit;
        let (factor, captions) = match self.part {
            Part::Tissue | Part::Arm => (1.0, ["Force (N)", "Simulated - measured (N)"]),
            Part::Master => (1e3, ["Position (mm)", "Simulated - measured (mm)"]),
        };
        Traces {
            recording: &signals.name,
            fit_percent: *fit_percent,
            time_s: tables::times(signals.len(), signals.interval_s),
            measured: (signals.predicted(self.part), "measured"),
            simulated: (simulated.as_deref(), "simulated"),
            further: None,
            factor,
            captions,
        }
        .figure()
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
