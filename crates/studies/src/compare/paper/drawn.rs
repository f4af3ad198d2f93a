use super::measures::terms;
use super::{PAPER_VARIANCE_N2, PaperStudy, quiet_residual_n};
use crate::run::{Run, RunReport};
use trocar_document::Figure;
use trocar_figures::{self as figures, EstimationView, FigureError, RunView};

/// Time of the puncture in figures 4 and 5 of the paper (3.2.1).
pub(super) const PUNCTURE_S: f64 = 4.6;

/// Forces that resist insertion become negative.
pub(super) fn in_the_papers_terms(run: &Run, shift_s: f64) -> Run {
    let mut run = run.clone();
    let trace = &mut run.trace;
    let forces = [
        &mut trace.operator_force_n,
        &mut trace.tissue_force_n,
        &mut trace.measured_force_n,
        &mut trace.feedback_force_n,
        &mut trace.residual_n,
    ];
    forces.into_iter().flatten().for_each(|force_n| *force_n = -*force_n);
    trace.time_s.iter_mut().for_each(|time_s| *time_s += shift_s);
    run.metrics.ruptures.iter_mut().for_each(|rupture| rupture.time_s += shift_s);
    run.metrics.alarms.iter_mut().for_each(|alarm| alarm.time_s += shift_s);
    run
}

fn estimation(run: &Run) -> EstimationView<'_> {
    EstimationView { standard_errors: None, ..RunReport::of(run).estimation() }
}

fn view(run: &Run) -> RunView<'_> {
    RunReport::of(run).view()
}

impl PaperStudy {
    pub(super) fn drawn(&self, number: u8) -> Result<Figure<'_>, FigureError> {
        let Self { noisy, drawn: [direct, classical, augmented], .. } = self;
        let parameters = |run, of| figures::parameters_with_terms(&estimation(run), terms(of));
        match number {
            1 => Ok(figures::insertion_phases()),
            4 => figures::estimation(&estimation(direct)),
            5 => parameters(direct, &self.direct),
            6 => figures::estimation(&estimation(classical)),
            7 => parameters(classical, &self.classical),
            8 => figures::force(&view(classical)),
            9 => figures::distance(&view(noisy), "Squared change of the force (N²)", &*self.noisy_changes_n2),
            10 => Ok(figures::principle()),
            11 => Ok(self.distribution_drawn()),
            12 => figures::distance(&view(noisy), "Squared prediction error (N²)", &*noisy.trace.distance),
            13 => figures::decision(&estimation(classical)),
            14 => Ok(figures::augmented_controller()),
            15 => figures::comparison(&[view(classical)], None),
            16 => figures::comparison(&[view(augmented)], None),
            _ => Err(FigureError::Empty { figure: "paper" }),
        }
    }

    fn distribution_drawn(&self) -> Figure<'static> {
        let residual_n: Vec<f64> = quiet_residual_n(&self.quiet).iter().map(|e| -e).collect();
        let count = residual_n.len().max(1) as f64;
        let std_n = (residual_n.iter().map(|e| e * e).sum::<f64>() / count).sqrt();
        let paper = PAPER_VARIANCE_N2.sqrt();
        let gaussians = [
            (std_n, format!("zero-mean Gaussian of the same power, σ = {std_n:.3} N")),
            (paper, format!("the paper's, σ = {paper:.3} N")),
        ];
        figures::distribution("classical, quiet stretches", &residual_n, &gaussians)
    }
}

#[cfg(test)]
mod tests {
    use super::super::measures::{range, ruptures_s};
    use super::*;

    #[test]
    fn the_runs_are_drawn_with_the_papers_signs_and_the_puncture_at_its_time() {
        let study = PaperStudy::new().expect("runs");
        let [direct, classical, _] = &study.drawn;
        assert!((ruptures_s(direct)[0] - 4.6).abs() < 1e-9);
        assert_eq!(ruptures_s(classical), [5.52, 8.85]);
        let (low, high) = range(&direct.trace.measured_force_n);
        assert!(low < -1.0 && high < 0.5, "resistance is negative: {low} to {high}");
        for (ours, papers) in [(&study.direct, direct), (&study.classical, classical)] {
            let (a, b) = (&ours.trace, &papers.trace);
            assert!(a.measured_force_n.iter().zip(&b.measured_force_n).all(|(a, b)| *a == -*b));
            assert_eq!(
                a.stiffness_n_per_m, b.stiffness_n_per_m,
                "K resists with a positive sign in the paper, too (eq. 3)"
            );
        }
    }
}
