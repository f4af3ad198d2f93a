mod absolute;
mod data;
mod figures;
mod json;
mod measured;
mod population;
mod response;
mod switching;
mod tables;
pub(super) mod verdict;
mod z_width;

pub use json::StabilityFile;
pub use verdict::LoopPart;

use super::{CertificateFile, StabilityStudy};
use trocar_document::{DataTable, Document, Section, Study, TextFile, Verdict};
use trocar_stability::LeftOut;

impl Study for StabilityStudy {
    fn document(&self) -> Document<'_> {
        let unreached = self.verdict.unreached.iter().map(tables::unreached);
        let listed = |what: &str, parts: &[LeftOut]| {
            let parts: Vec<String> = parts.iter().map(LeftOut::to_string).collect();
            (!parts.is_empty()).then(|| format!("{what}: {}", parts.join("; ")))
        };
        let passive = listed("assumed passive", &self.verdict.assumed_passive);
        let inputs = listed("inputs, which do not change the verdict", &self.verdict.inputs);
        let left_out = passive.into_iter().chain(inputs).chain(unreached).collect();
        let mut document = Document {
            name: "stability",
            title: self.name.clone(),
            verdict: Verdict {
                sentences: vec![format!("{}.", self.verdict.sentence()), tables::limits_line(&self.analysis)],
                left_out,
            },
            warnings: self.warnings(),
            sections: sections(self),
            data: data_tables(self),
            files: files(self),
            json: json::json(self),
            ..Document::default()
        };
        figures::add(self, &mut document);
        document
    }
}

fn sections(study: &StabilityStudy) -> Vec<Section> {
    let StabilityStudy { analysis, map, check, .. } = study;
    let mut of_loop = Section::new("metrics", "Closed loop");
    of_loop.table(tables::loop_table(analysis));
    of_loop.figure("loop");
    if study.locus.is_some() {
        of_loop.figure("locus");
    }
    let mut of_map = Section::new("map", "Stability map");
    of_map.figure("stability");
    of_map.text(tables::map_line(map));
    if let Some(check) = check {
        let not_simulated = [&study.verdict.left_out[..], &study.verdict.assumed_passive].concat();
        of_map.text(tables::checked_line(check, &not_simulated));
        if let Some((table, more)) = tables::unconfirmed(map, check) {
            of_map.table(table);
            of_map.text(more.unwrap_or_default());
        }
    }
    let mut limits = Section::new("limits", "Limits and sensitivities");
    limits.table(tables::limit_table(analysis));
    if !study.event_limits.is_empty() {
        limits.table(tables::event_limit_table(&study.event_limits));
    }
    limits.table(tables::sensitivity_table(analysis));
    // The map answers the question.
    let mut sections = vec![of_map, of_loop, limits];
    if let Some(measured) = &study.measured {
        let mut section = Section::new("measured", "Measured responses");
        measured::lines(measured, analysis).into_iter().for_each(|line| section.text(line));
        section.figure("measured");
        sections.push(section);
    }
    if let Some(population) = &study.population {
        let mut section = Section::new("population", "Population");
        let [stable, smallest] = population::lines(population);
        section.text(stable);
        section.table(population::table(population));
        section.text(smallest);
        section.figure("population");
        sections.push(section);
    }
    let mut ports = Section::new("ports", "Ports over frequency");
    ports.table(tables::port_table(analysis));
    ports.text(tables::port_passivity(analysis));
    ports.text(absolute::bounded_line(analysis, &study.bounded));
    ports.text(tables::sampled(analysis));
    if !analysis.ports.is_empty() {
        ports.figure("ports");
    }
    sections.push(ports);
    if let Some(absolute) = &study.absolute {
        let mut section = Section::new("absolute", "Absolute stability");
        section.text(absolute::line(absolute));
        section.figure("absolute");
        sections.push(section);
    }
    if let Some(z_width) = &study.z_width {
        let mut section = Section::new("z_width", "Z-width");
        z_width::lines(z_width).into_iter().for_each(|line| section.text(line));
        section.figure("z_width");
        sections.push(section);
    }
    let mut events = Section::new("events", "Events");
    match &study.switching {
        Ok(switching) => {
            events.text(switching::statement(study));
            switching::lines(switching).into_iter().for_each(|line| events.text(line));
            events.table(switching::event_table(&switching.events));
            events.figure("switching");
        }
        Err(_) => events.text(switching::statement(study)),
    }
    sections.push(events);
    sections
}

fn data_tables(study: &StabilityStudy) -> Vec<DataTable<'_>> {
    let StabilityStudy { analysis, map, check, response, .. } = study;
    let mut tables = vec![
        data::sensitivities(analysis),
        data::map(map, check.as_ref()),
        data::boundary(map),
        data::ports(analysis),
        absolute::hand_damping(analysis, &study.bounded),
        response::poles(response),
        response::loop_gain("loop_gain", &response.gain),
    ];
    tables.extend(response::step(response));
    let measured = study.measured.as_ref();
    tables.extend(measured.map(|measured| response::loop_gain("measured_loop_gain", &measured.gain)));
    tables.extend(study.absolute.as_ref().map(absolute::table));
    tables.extend(study.locus.as_ref().map(|locus| response::locus(locus, analysis.settings.tick_s)));
    tables.extend(study.z_width.as_ref().map(z_width::table));
    tables.extend(study.population.iter().flat_map(|all| [population::members(all), population::map(all)]));
    if let Ok(switching) = &study.switching {
        tables.push(switching::growth(switching));
        tables.push(switching::released(&switching.events));
    }
    tables
}

fn files(study: &StabilityStudy) -> Vec<TextFile> {
    let certificate = study.switching.as_ref().ok().and_then(CertificateFile::of);
    let certificate = certificate.and_then(|content| serde_json::to_string(&content).ok());
    let certificate = certificate.map(|text| TextFile { name: "certificate.json".into(), text: text + "\n" });
    let worst = study.worst_events.as_ref();
    let worst = worst.map(|scenario| TextFile { name: "worst_events.toml".into(), text: scenario.echo() });
    certificate.into_iter().chain(worst).collect()
}
