mod figure;
mod json;
mod scenarios;
mod tables;
mod verdict;

pub use json::DesignResultFile;

use super::certify::Front;
use super::patients::Patients;
use super::problem::Problem;
use super::search::State;
use super::validation::Validation;
use trocar_document::{Document, Section, Shown, Study, TextFile, Unit, counted, json_of, show};

#[derive(Debug)]
pub struct DesignStudy<'a> {
    pub problem: &'a Problem,
    pub state: &'a State,
    pub front: &'a Front,
    pub validation: &'a Validation,
    pub fresh: &'a Patients,
    pub patients: usize,
}

impl Study for DesignStudy<'_> {
    fn document(&self) -> Document<'_> {
        let mut front = Section::new("front", "Front");
        front.figure("front");
        if !self.validation.designs.is_empty() {
            front.table(tables::designs(self));
            front.text(
                "* the knee: the smallest distance to the ideal point, with every objective as a share of its range on the \
                 front. Chosen by the values in the search (training), so the values on other patients (validation) are not \
                 biased by the choice. Intervals: 95 %, bootstrap over patients.",
            );
            front.table(tables::settings(self));
        }
        let mut shipped = Section::new("shipped", "Shipped strategies");
        shipped.table(tables::shipped(self));
        if let Some(text) = tables::about_shipped(self) {
            shipped.text(text);
        }
        let mut constraints = Section::new("constraints", "Constraints");
        constraints.table(tables::constraints(self));
        constraints.text(
            "binds: number of shown designs within 2 % of the limit in the search, of all shown. A constraint that binds \
             decides the designs: relax it, and they change.",
        );
        let mut sensitivity = Section::new("sensitivity", "Sensitivity");
        sensitivity.table(tables::sensitivity(self));
        sensitivity.text(
            "Share of the variance of an objective's ranks that the key alone explains, over the feasible candidates; + and - \
             are the direction. The search visits good candidates more often than others, so this describes the \
             neighbourhood of the front.",
        );
        if let Some(table) = tables::flat(self) {
            sensitivity.table(table);
            sensitivity.text(tables::about_flat(self));
        }
        let mut about = Section::new("search", "Search");
        about.text(self.about());
        let mut document = Document {
            name: "design",
            title: self.problem.name.clone(),
            verdict: verdict::verdict(self),
            sections: vec![front, shipped, constraints, sensitivity, about.shown(Shown::Everywhere)],
            data: vec![tables::candidates(self)],
            files: scenarios::files(self)
                .into_iter()
                .map(|(name, text)| TextFile { name: name.into(), text })
                .collect(),
            json: json_of(&DesignResultFile::of(self)),
            ..Document::default()
        };
        if self.problem.goals.constraints.is_empty() && self.problem.goals.certified.is_none() {
            document.sections.retain(|section| section.id != "constraints");
        }
        document.figure("front", figure::front(self));
        document
    }
}

impl DesignStudy<'_> {
    fn about(&self) -> String {
        let Self { problem, state, .. } = self;
        let persons = match problem.persons.len() {
            0 => String::new(),
            count => format!(
                ", {} ({})",
                counted(count as u64, "person"),
                problem.persons.iter().map(|person| person.name).collect::<Vec<_>>().join(", ")
            ),
        };
        let mut sentences = vec![format!(
            "Search: {} of {} candidates, {} in all, on {} with {} each{persons}; {} runs. All candidates have the same \
             patients and noise.",
            counted(state.generations, "generation"),
            problem.search.candidates,
            state.archive.len() as u64 + state.stopped + state.refused,
            counted(self.patients as u64, "patient"),
            counted(problem.training.seeds, "seed"),
            state.runs,
        )];
        if let Some(share) = state.settled_share(problem) {
            sentences.push(format!(
                "After three quarters of the generations the front had {} of its final hypervolume.",
                show(Some(share), Unit::Share)
            ));
        }
        if state.stopped > 0 {
            sentences.push(format!(
                "{} stopped early: after a quarter or a half of the patients a constraint was violated, or a parent was better \
                 in every objective, by more than three standard errors, while no dominated child could survive.",
                counted(state.stopped, "candidate")
            ));
        }
        if let Some(reason) = &state.first_refusal {
            sentences.push(format!(
                "{} no valid scenario, the first because {}.",
                if state.refused == 1 {
                    "1 candidate is".to_owned()
                } else {
                    format!("{} candidates are", state.refused)
                },
                reason.lines().next().unwrap_or_default()
            ));
        }
        if problem.goals.certified.is_some() {
            sentences.push(format!(
                "Certificates were searched for {} of the shown designs only, each for all patients together; during the search \
                 a candidate had to have a stable linear loop for every patient, no kept gap, and a kind of event that the \
                 certificate covers.",
                match self.front.uncertified.len() {
                    0 => "the candidates".to_owned(),
                    count => format!("the candidates ({count} had none and are not shown)"),
                }
            ));
        }
        sentences.join(" ")
    }
}
