use super::DesignStudy;
use crate::design::bootstrap::Estimate;
use crate::design::goals::{Direction, Objective};
use trocar_document::{Figure, readable};
use trocar_figures::{DesignView, FigureError, Interval, ParetoView, ShippedView, pareto};

pub(super) fn front(study: &DesignStudy<'_>) -> Result<Figure<'static>, FigureError> {
    let objectives = &study.problem.goals.objectives;
    let pairs: Vec<(usize, usize)> = match objectives.len() {
        1 => vec![(0, 0)],
        2 => vec![(0, 1)],
        3 => vec![(0, 1), (0, 2), (1, 2)],
        count => (1..count).map(|other| (0, other)).collect(),
    };
    let views: Vec<ParetoView> = pairs.into_iter().map(|pair| view(study, pair)).collect();
    pareto(&study.problem.name, &views)
}

fn caption(objective: &Objective) -> String {
    let (_, unit) = readable(objective.quantity.unit);
    let unit = if unit.is_empty() { String::new() } else { format!(" ({})", unit.trim_start()) };
    let better = match objective.direction {
        Direction::Minimise => "less",
        Direction::Maximise => "more",
    };
    format!("{}{unit}, {better} is better", objective.name)
}

fn view(study: &DesignStudy<'_>, (x, y): (usize, usize)) -> ParetoView {
    let objectives = &study.problem.goals.objectives;
    let factor = |index: usize| readable(objectives[index].quantity.unit).0;
    let scaled = |estimates: &[Option<Estimate>], index: usize| -> Option<Interval> {
        let Estimate { value, low, high } = estimates[index]?;
        let factor = factor(index);
        Some((factor * value, [factor * low, factor * high]))
    };
    let both = |estimates: &[Option<Estimate>]| scaled(estimates, x).zip(scaled(estimates, y));
    let design = |design: &crate::design::validation::Designed| DesignView {
        name: design.name.clone(),
        training: both(&design.training).map(|((x, _), (y, _))| (x, y)),
        validation: both(&design.validation),
        is_chosen: design.is_knee,
    };
    let shipped = |shipped: &crate::design::validation::Shipped| {
        let ((x, _), (y, _)) = both(&shipped.validation)?;
        Some(ShippedView { name: shipped.name.to_owned(), at: (x, y), is_feasible: shipped.is_feasible })
    };
    ParetoView {
        captions: (caption(&objectives[x]), caption(&objectives[y])),
        designs: study.validation.designs.iter().map(design).collect(),
        shipped: study.validation.shipped.iter().filter_map(shipped).collect(),
    }
}
