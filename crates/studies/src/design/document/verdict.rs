use super::DesignStudy;
use super::tables::relation;
use crate::design::bootstrap::Estimate;
use crate::design::validation::Designed;
use trocar_document::{Verdict, counted, show};

pub(super) fn verdict(study: &DesignStudy<'_>) -> Verdict {
    let mut sentences = vec![];
    match study.validation.designs.iter().find(|design| design.is_knee) {
        Some(knee) => {
            sentences.push(of_knee(study, knee));
            sentences.extend(comparison(study));
            sentences.extend(violated(study, knee));
        }
        None => sentences.push(none(study)),
    }
    let mut left_out = vec![
        "a front is the best that the search has found; another seed of the search may find a better one".to_owned(),
    ];
    if !study.front.left_out.is_empty() && !study.validation.designs.is_empty() {
        left_out.push(format!("the certificates leave out {}", study.front.left_out.join(", ")));
    }
    if study.problem.goals.certified.is_none() {
        left_out.push("no certificate is required: stability is a result of these runs, not a proof".to_owned());
    }
    Verdict { sentences, left_out }
}

fn of_knee(study: &DesignStudy<'_>, knee: &Designed) -> String {
    let goals = &study.problem.goals;
    let results: Vec<String> = goals
        .objectives
        .iter()
        .zip(&knee.validation)
        .map(|(objective, estimate)| {
            let unit = objective.quantity.unit;
            match estimate {
                Some(Estimate { value, low, high }) => format!(
                    "{} {} ({} to {})",
                    objective.name,
                    show(Some(*value), unit),
                    show(Some(*low), unit),
                    show(Some(*high), unit)
                ),
                None => format!("{} undefined", objective.name),
            }
        })
        .collect();
    let certified = if goals.certified.is_some() { ", certified to decay for all of them," } else { "" };
    format!(
        "Design {} of {} on the front is its knee: on {} with {} each it has{certified} {}.",
        knee.name,
        study.validation.designs.len(),
        counted(study.fresh.population().patients() as u64, "other patient"),
        counted(study.problem.validation.seeds, "seed"),
        results.join(", ")
    )
}

fn comparison(study: &DesignStudy<'_>) -> Option<String> {
    let feasible = study.validation.shipped.iter().filter(|shipped| shipped.is_feasible);
    let related: Vec<(&str, (usize, usize))> =
        feasible.filter_map(|shipped| Some((shipped.name, relation(study, shipped)?))).collect();
    if related.is_empty() {
        return None;
    }
    let names = |is_named: &dyn Fn(usize, usize) -> bool| -> Vec<&str> {
        related.iter().filter(|(_, (better, worse))| is_named(*better, *worse)).map(|(name, _)| *name).collect()
    };
    let dominated = names(&|better, worse| better > 0 && worse == 0);
    let dominating = names(&|better, worse| better == 0 && worse > 0);
    let mixed = names(&|better, worse| better > 0 && worse > 0);
    let mut parts = vec![];
    if !dominated.is_empty() {
        parts.push(format!("better than {} in at least one objective and worse in none", dominated.join(", ")));
    }
    if !mixed.is_empty() {
        parts.push(format!("better than {} in one objective and worse in another one", mixed.join(", ")));
    }
    if !dominating.is_empty() {
        parts.push(format!("worse than {} in at least one objective and better in none", dominating.join(", ")));
    }
    if parts.is_empty() {
        return Some(
            "With 95 % confidence it is not different from any shipped strategy that meets the constraints.".to_owned(),
        );
    }
    let of = if study.problem.goals.constraints.is_empty() { "" } else { " that meet the constraints" };
    Some(format!("Of the shipped strategies{of}, it is {} (95 % confidence).", parts.join("; ")))
}

fn violated(study: &DesignStudy<'_>, knee: &Designed) -> Option<String> {
    let goals = &study.problem.goals;
    let of_constraints = knee.validation.get(goals.objectives.len()..).unwrap_or_default();
    let mut violated: Vec<String> = goals
        .constraints
        .iter()
        .zip(of_constraints)
        .filter(|(constraint, estimate)| estimate.is_none_or(|estimate| constraint.limit.excess(estimate.value) > 0.0))
        .map(|(constraint, estimate)| {
            let unit = constraint.quantity.unit;
            let value = show(estimate.map(|estimate| estimate.value), unit);
            format!("{} ({value}, limit {})", constraint.name, show(Some(constraint.limit.value()), unit))
        })
        .collect();
    if knee.diverged > 0.0 {
        violated.push(format!("divergence ({} of the runs)", show(Some(knee.diverged), trocar_document::Unit::Share)));
    }
    (!violated.is_empty()).then(|| format!("On the other patients it violates {}.", violated.join(", ")))
}

fn none(study: &DesignStudy<'_>) -> String {
    let (problem, state) = (study.problem, study.state);
    if state.archive.is_empty() {
        let reason = state.first_refusal.as_ref().map_or_else(String::new, |reason| format!(": {reason}"));
        return format!("No candidate is a valid scenario{reason}.");
    }
    let uncertified = study.front.uncertified.len();
    if uncertified > 0 {
        let reason = study.front.reason.as_ref().map_or_else(String::new, |reason| format!(": {reason}"));
        return format!(
            "No certificate was found for any of the {uncertified} candidates on the front for which it was searched{reason}."
        );
    }
    let points = state.points(problem);
    let least = (0..points.len()).min_by(|a, b| points[*a].violation.total_cmp(&points[*b].violation));
    let short: Vec<String> = least.map_or_else(Vec::new, |index| {
        let values = &state.archive[index].values;
        problem
            .goals
            .constraints
            .iter()
            .zip(values.iter().skip(problem.goals.objectives.len()))
            .filter(|(constraint, value)| value.is_none_or(|value| constraint.limit.excess(value) > 0.0))
            .map(|(constraint, value)| format!("{} ({})", constraint.name, show(*value, constraint.quantity.unit)))
            .collect()
    });
    let closest =
        if short.is_empty() { String::new() } else { format!(" The closest one violates {}.", short.join(", ")) };
    format!("None of {} candidates meets all constraints.{closest}", state.archive.len())
}
