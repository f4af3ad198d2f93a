use super::DesignStudy;
use crate::design::bootstrap::Estimate;
use crate::design::goals::{Direction, Limit};
use crate::design::nsga::Gene;
use crate::design::quantity::Quantity;
use crate::design::search::front_of;
use crate::design::sensitivity::{EQUAL, as_good_as, sensitivities};
use crate::design::validation::Shipped;
use crate::sweep::{Axis, number};
use std::collections::HashSet;
use trocar_document::{Cell, DataTable, Number, Table, plain, show};
use trocar_scenario::Value;

/// Maximum distance from the limit, as a share.
const BINDS: f64 = 0.02;

fn interval(estimate: Option<Estimate>, quantity: &Quantity) -> Cell {
    estimate.map_or(Cell::Undefined, |Estimate { value, low, high }| {
        Cell::Interval(Number::new(value, quantity.unit), [low, high])
    })
}

pub(super) fn word(value: &Value) -> String {
    match value {
        Value::Number(number) => plain(*number),
        other => other.to_toml().to_string().trim_matches('"').to_owned(),
    }
}

fn marked(name: &str, is_knee: bool) -> String {
    format!("{name}{}", if is_knee { " *" } else { "" })
}

pub(super) fn designs(study: &DesignStudy<'_>) -> Table {
    let goals = &study.problem.goals;
    let mut columns = vec![("design".to_owned(), "design".to_owned())];
    for (objective, suffix) in
        goals.objectives.iter().flat_map(|objective| [(objective, "training"), (objective, "validation")])
    {
        columns.push((format!("{}_{suffix}", objective.name), format!("{}, {suffix}", objective.name)));
    }
    let mut table = Table::new("designs", "Designs: the same settings in the search and on other patients", columns);
    for design in &study.validation.designs {
        let mut cells = vec![Cell::from(marked(&design.name, design.is_knee))];
        for (index, objective) in goals.objectives.iter().enumerate() {
            cells.push(interval(design.training[index], &objective.quantity));
            cells.push(interval(design.validation[index], &objective.quantity));
        }
        table.row(cells);
    }
    table
}

pub(super) fn settings(study: &DesignStudy<'_>) -> Table {
    let problem = study.problem;
    let designs = &study.validation.designs;
    let columns = std::iter::once(("key".to_owned(), "free key".to_owned()))
        .chain(designs.iter().map(|design| (design.name.clone(), marked(&design.name, design.is_knee))));
    let mut table = Table::new("settings", "Settings of the designs", columns);
    let values: Vec<Vec<Value>> = designs.iter().map(|design| problem.values(&design.candidate.coordinates)).collect();
    for (key, axis) in problem.free.iter().enumerate() {
        let cells = std::iter::once(Cell::from(axis.key.path.as_ref()))
            .chain(values.iter().map(|values| Cell::from(word(&values[key]))));
        table.row(cells);
    }
    table
}

/// Numbers of objectives in which the knee is better and worse, with 95 % confidence.
pub(super) fn relation(study: &DesignStudy<'_>, shipped: &Shipped) -> Option<(usize, usize)> {
    let (mut better, mut worse) = (0, 0);
    if shipped.differences.is_empty() {
        return None;
    }
    for (objective, difference) in study.problem.goals.objectives.iter().zip(&shipped.differences) {
        let Some(Estimate { low, high, .. }) = difference else { continue };
        let (best, worst) = match objective.direction {
            Direction::Minimise => (*low, *high),
            Direction::Maximise => (-high, -low),
        };
        better += usize::from(worst < 0.0);
        worse += usize::from(best > 0.0);
    }
    Some((better, worse))
}

pub(super) fn shipped(study: &DesignStudy<'_>) -> Table {
    let goals = &study.problem.goals;
    let columns = std::iter::once(("strategy".to_owned(), "strategy".to_owned()))
        .chain(goals.objectives.iter().map(|objective| (objective.name.clone(), objective.name.clone())))
        .chain(goals.constraints.iter().map(|constraint| (constraint.name.clone(), constraint.name.clone())))
        .chain([("feasible".to_owned(), "feasible".to_owned()), ("knee".to_owned(), "the knee is".to_owned())]);
    let mut table = Table::new("shipped", "Shipped strategies on the same other patients", columns);
    for shipped in &study.validation.shipped {
        let relation = relation(study, shipped).map_or(Cell::Undefined, |(better, worse)| {
            Cell::from(match (better, worse) {
                (0, 0) => "not different".to_owned(),
                (better, 0) => format!("better in {better}"),
                (0, worse) => format!("worse in {worse}"),
                (better, worse) => format!("better in {better}, worse in {worse}"),
            })
        });
        let of_constraints = goals.objectives.len()..;
        let objectives = goals.objectives.iter().zip(&shipped.validation);
        let constraints = goals.constraints.iter().zip(shipped.validation.get(of_constraints).unwrap_or_default());
        table.row(
            std::iter::once(Cell::from(shipped.name))
                .chain(objectives.map(|(objective, estimate)| interval(*estimate, &objective.quantity)))
                .chain(constraints.map(|(constraint, estimate)| {
                    Cell::of(estimate.map(|estimate| estimate.value), constraint.quantity.unit)
                }))
                .chain([Cell::from(if shipped.is_feasible { "yes" } else { "no" }), relation]),
        );
    }
    table
}

pub(super) fn about_shipped(study: &DesignStudy<'_>) -> Option<String> {
    let mut sentences = vec![];
    if study.validation.designs.iter().any(|design| design.is_knee) {
        sentences.push(
            "The knee is better or worse in an objective if the 95 % interval of the paired difference excludes 0. feasible: \
             the constraints on metrics; certificates are not computed for shipped strategies."
                .to_owned(),
        );
    }
    for (name, reason) in &study.validation.left_out {
        sentences.push(format!("{name} cannot be combined with the scenario: {reason}."));
    }
    (!sentences.is_empty()).then(|| sentences.join(" "))
}

pub(super) fn constraints(study: &DesignStudy<'_>) -> Table {
    let goals = &study.problem.goals;
    let designs = &study.validation.designs;
    let columns = [
        ("constraint", "constraint"),
        ("metric", "metric"),
        ("limit", "limit"),
        ("training", "knee, training"),
        ("validation", "knee, validation"),
        ("binds", "binds"),
    ];
    let mut table = Table::new("constraints", "Constraints", columns);
    let knee = designs.iter().find(|design| design.is_knee);
    for (index, constraint) in goals.constraints.iter().enumerate() {
        let index = goals.objectives.len() + index;
        let (side, limit) = match constraint.limit {
            Limit::AtLeast(limit) => ("at least", limit),
            Limit::AtMost(limit) => ("at most", limit),
        };
        let binding = designs.iter().filter(|design| {
            design.candidate.values[index].is_some_and(|value| constraint.limit.excess(value) > -BINDS)
        });
        table.row([
            Cell::from(constraint.name.as_str()),
            Cell::from(format!("{}, {}", constraint.quantity.label, constraint.aggregate.word())),
            Cell::from(format!("{side} {}", show(Some(limit), constraint.quantity.unit))),
            knee.map_or(Cell::Undefined, |knee| interval(knee.training[index], &constraint.quantity)),
            knee.map_or(Cell::Undefined, |knee| interval(knee.validation[index], &constraint.quantity)),
            Cell::from(format!("{} of {}", binding.count(), designs.len())),
        ]);
    }
    if let Some(name) = &goals.certified {
        table.row([
            Cell::from(name.as_str()),
            Cell::from("every motion decays"),
            Cell::from("certified"),
            Cell::Undefined,
            Cell::from(if knee.is_some() { "certified" } else { "—" }),
            Cell::from(format!("{} refused", study.front.uncertified.len())),
        ]);
    }
    table
}

pub(super) fn sensitivity(study: &DesignStudy<'_>) -> Table {
    let problem = study.problem;
    let columns = std::iter::once(("key".to_owned(), "free key".to_owned()))
        .chain(problem.goals.objectives.iter().map(|objective| (objective.name.clone(), objective.name.clone())));
    let mut table = Table::new("sensitivity", "Sensitivity of the objectives to the free keys", columns);
    for (axis, of_key) in problem.free.iter().zip(sensitivities(problem, &study.state.archive)) {
        let cells = of_key.iter().map(|of| {
            let sign = match of.rank_correlation {
                Some(correlation) if correlation < 0.0 => "- ",
                Some(_) => "+ ",
                None => "",
            };
            of.share
                .map_or(Cell::Undefined, |share| Cell::from(format!("{sign}{} %", plain((1e3 * share).round() / 10.0))))
        });
        table.row(std::iter::once(Cell::from(axis.key.path.as_ref())).chain(cells));
    }
    table
}

fn range(axis: &Axis, gene: Gene, coordinates: &[f64]) -> String {
    if let Gene::Choice(count) = gene {
        let chosen: HashSet<u64> = coordinates.iter().map(|coordinate| gene.choice(*coordinate)).collect();
        let words = (0..count).filter(|choice| chosen.contains(choice));
        return words
            .map(|choice| word(&axis.value((choice as f64 + 0.5) / count as f64)))
            .collect::<Vec<_>>()
            .join(", ");
    }
    let by_value = |a: &&f64, b: &&f64| {
        let of = |coordinate: f64| number(&axis.value(coordinate)).unwrap_or(0.0);
        of(**a).total_cmp(&of(**b))
    };
    let ends = coordinates.iter().min_by(by_value).zip(coordinates.iter().max_by(by_value));
    ends.map_or_else(String::new, |(low, high)| {
        let (low, high) = (word(&axis.value(*low)), word(&axis.value(*high)));
        if low == high { low } else { format!("{low} to {high}") }
    })
}

fn similar(study: &DesignStudy<'_>) -> Option<Vec<usize>> {
    let points = study.state.points(study.problem);
    let refused: HashSet<usize> = study.front.uncertified.iter().copied().collect();
    let front = front_of(&points, &refused);
    let similar = as_good_as(&points, &front, study.front.knee?);
    Some(similar.into_iter().filter(|index| !refused.contains(index)).collect())
}

pub(super) fn flat(study: &DesignStudy<'_>) -> Option<Table> {
    let similar = similar(study).filter(|similar| similar.len() > 1)?;
    let columns =
        [("key", "free key"), ("searched", "searched"), ("front", "on the front"), ("similar", "as good as the knee")];
    let mut table = Table::new("flat", "Where the front is flat", columns);
    let coordinates = |indices: &[usize], key: usize| -> Vec<f64> {
        indices.iter().map(|&index| study.state.archive[index].coordinates[key]).collect()
    };
    for (key, (axis, gene)) in study.problem.free.iter().zip(study.problem.genes()).enumerate() {
        table.row([
            Cell::from(axis.key.path.as_ref()),
            Cell::from(range(axis, gene, &axis.ends())),
            Cell::from(range(axis, gene, &coordinates(&study.front.shown, key))),
            Cell::from(range(axis, gene, &coordinates(&similar, key))),
        ]);
    }
    Some(table)
}

pub(super) fn about_flat(study: &DesignStudy<'_>) -> String {
    let count = similar(study).map_or(0, |similar| similar.len());
    format!(
        "{count} candidates are as good as the knee: in the search, no objective is worse by more than {} % of its range on the \
         front. A key with a wide range there may be chosen for other reasons.",
        plain(100.0 * EQUAL)
    )
}

pub(super) fn candidates(study: &DesignStudy<'_>) -> DataTable<'static> {
    let (problem, archive) = (study.problem, &study.state.archive);
    let points = study.state.points(problem);
    let generation = |index: usize| study.state.archived.partition_point(|archived| *archived <= index) as u64;
    let mut data = DataTable::new("candidates").whole("generation", (0..archive.len()).map(generation));
    for (key, axis) in problem.free.iter().enumerate() {
        let values = archive.iter().map(|evaluation| axis.value(evaluation.coordinates[key]));
        data = match problem.genes()[key] {
            Gene::Number => data.optional(axis.key.path.to_string(), values.map(|value| number(&value))),
            Gene::Choice(_) => data.texts(axis.key.path.to_string(), values.map(|value| word(&value))),
        };
    }
    let goals = &problem.goals;
    let names =
        goals.objectives.iter().map(|objective| &objective.name).chain(goals.constraints.iter().map(|of| &of.name));
    for (index, name) in names.enumerate() {
        data = data.optional(name.clone(), archive.iter().map(|evaluation| evaluation.values[index]));
    }
    data.optional("violation", points.iter().map(|point| Some(point.violation)))
}
