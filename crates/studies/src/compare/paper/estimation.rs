//! Figures 1 and 4 to 7, section 2.

use super::measures::{
    Errors, Terms, jumps, largest_change_elsewhere, mean_and_variance, range, ruptures_s, terms, tick,
};
use super::statement::{Judgement, is_within};
use super::variations::{OfSettings, SETTINGS_TEXT, Varied};
use super::{PaperStudy, Statement, TRANSIENT_S};
use crate::run::Run;
use trocar_engine::tissue::TissueSettings;

/// Minimum ratio of a sudden change to the change before it.
const DISCONTINUITY: f64 = 3.0;
/// Minimum ratio of a clear change to the largest one elsewhere.
const CLEAR: f64 = 2.0;
const WITHIN: &str = "within a factor of 1.5 with each setting of the estimator";

const INPUT: &str = "Input: this number is a parameter of the simulated tissue.";
const GENERATED: &str = "Input: the recording was generated from this number.";

fn force_range(run: &Run) -> (f64, f64) {
    let (low, high) = range(&run.trace.measured_force_n);
    (-high, -low)
}

fn range_text((low, high): (f64, f64)) -> String {
    format!("{low:.2} to {high:.2} N")
}

/// Viscous share of the true force at the entry into the first layer.
fn true_viscous_share(run: &Run, velocity: f64) -> Option<f64> {
    let Some(TissueSettings::Layers(tissue)) = run.scenario.tissue.settings() else { return None };
    // A layer's force is its spring force times `1 + damping v`.
    let factor = tissue.layers.first()?.1.damping_s_per_m * velocity;
    Some(factor / (1.0 + factor))
}

/// Strings: section, subject, the paper's number.
fn of_settings(
    [section, what, text]: [&'static str; 3],
    paper: f64,
    varied: &Varied<OfSettings>,
    read: fn(&OfSettings) -> f64,
) -> Statement {
    let shipped = varied.0.first().map_or(f64::NAN, read);
    let (low, high) = varied.range(read);
    let judgement = varied.judge(|of| is_within(read(of), paper));
    let why = match judgement {
        Judgement::NotCheckable => "The result depends on the settings, and the paper states neither F_0 nor N_0",
        Judgement::Reproduced => "The paper states neither F_0 nor N_0, but the result depends on neither",
        Judgement::Contradicted => "The paper states neither F_0 nor N_0, but none of these settings gives it",
    };
    let why = format!("{why}: {SETTINGS_TEXT} it is {low:.4} to {high:.4} N.");
    Statement::checked([section, what, text, WITHIN], format!("{shipped:.4} N"), judgement, why)
}

impl PaperStudy {
    /// Figure 1.
    pub(super) fn phases(&self) -> Vec<Statement> {
        let run = &self.direct;
        let (trace, deepest) = (&run.trace, deepest_tick(run));
        let in_force = (deepest..trace.len()).rev().find(|&tick| trace.tissue_force_n[tick] != 0.0);
        let leaves_m = in_force.map_or(f64::NAN, |tick| trace.slave_position_m[tick] - run.scenario.contact_m);
        vec![
            Statement::open(
                [
                    "1.2",
                    "three phases: pushing, puncture at a threshold, extraction with friction only",
                    "Simone and others",
                ],
                "the tissue model has them",
                "Input: the layers of the simulated tissue deflect, rupture at a force and hold the shaft by \
                 friction; the paper \
                 cites the phases from earlier work.",
            ),
            Statement::open(
                ["1.2", "position of the needle when it is extracted", "not the initial contact"],
                format!("{:+.2} mm from it", 1e3 * leaves_m),
                "Input: the friction of the shaft lifts the surface in the tissue model, which follows the paper's \
                 figure 1.",
            ),
        ]
    }

    /// Figure 4.
    pub(super) fn direct_access(&self) -> Vec<Statement> {
        let run = &self.direct;
        let errors = Errors::of(run);
        let puncture_s = ruptures_s(run).first().copied().unwrap_or(f64::NAN);
        let after_s = errors.max_at_s - puncture_s;
        let is_at_puncture = |of: &OfSettings| (0.0..=0.02).contains(&(of.both.max_at_s - puncture_s));
        let of = |texts, paper, read| of_settings(texts, paper, &self.direct_settings, read);
        vec![
            Statement::open(
                ["3.2.1", "time of the puncture", "4.6 s"],
                format!("{puncture_s:.2} s"),
                "The result depends on the speed of the hand, which the paper does not state; figures 4 and 5 are \
                 shifted so that the puncture is \
                 at the paper's time.",
            ),
            Statement::open(["3.2.1", "force", "-1.45 to 0.37 N"], range_text(force_range(run)), INPUT),
            of(["3.2.1", "mean of the absolute error", "0.019 N"], 0.019, |of| of.both.mean_n),
            of(["3.2.1", "standard deviation of the absolute error", "0.0136 N"], 0.0136, |of| of.both.std_n),
            of(["3.2.1", "largest transient error", "0.32 N"], 0.32, |of| of.both.max_n),
            Statement::checked(
                [
                    "3.2.1",
                    "time of the largest error",
                    "at the puncture",
                    "within 20 ms after it with each setting of the estimator",
                ],
                format!("{:.0} ms after it", 1e3 * after_s),
                self.direct_settings.judge(is_at_puncture),
                "The prediction lags behind the force where it falls fastest.",
            ),
            Statement::open(
                ["3.2.1", "two more peaks of the error", "ruptures of small vessels"],
                "no vessels",
                "The simulated tissue has a capsule and an organ, and no vessels.",
            ),
        ]
    }

    /// Figure 5.
    pub(super) fn parameters_of_direct_access(&self) -> Vec<Statement> {
        let run = &self.direct;
        let puncture_s = ruptures_s(run).first().copied().unwrap_or(f64::NAN);
        let after = |column: &[f64]| jumps(run, column).first().map_or(f64::NAN, |jump| jump.1);
        let (stiffness, damping) = (&run.trace.stiffness_n_per_m, &run.trace.damping_n_s_per_m);
        let fall = after(stiffness);
        let elsewhere = largest_change_elsewhere(run, stiffness);
        let is_clear = |of: &OfSettings| {
            let stiffness = &of.run.trace.stiffness_n_per_m;
            let falls = jumps(&of.run, stiffness).first().map_or(f64::NAN, |jump| -jump.1);
            falls >= CLEAR * largest_change_elsewhere(&of.run, stiffness)
        };
        let is_elastic = |of: &OfSettings| {
            let terms = Terms::at(&of.run, puncture_s);
            terms.viscous_n.abs() < terms.elastic_n.abs()
        };
        let terms = Terms::at(run, puncture_s);
        let [both, alone] = [run, &self.direct_stiffness].map(Errors::of);
        let velocity = run.trace.slave_velocity_m_per_s[tick(run, puncture_s)];
        let percent = |share: f64| format!("{:.0} %", 100.0 * share);
        let truth = true_viscous_share(run, velocity).map_or_else(|| "unknown".to_owned(), percent);
        let (low, high) = force_range(run);
        let width_n = high - low;
        let of = |texts, paper, read| of_settings(texts, paper, &self.direct_settings, read);
        let [both_n, alone_n] = self.direct_default_n;
        vec![
            Statement::checked(
                [
                    "3.2.1",
                    "stiffness at the puncture",
                    "clearly discontinuous",
                    "it falls in 20 ms by twice any change elsewhere, with each setting of the estimator",
                ],
                format!("{fall:+.1} N/m in 20 ms; elsewhere up to {elsewhere:.1} N/m"),
                self.direct_settings.judge(is_clear),
                format!(
                    "The estimate follows the drop of the force within 20 ms; B falls at the same time, by {:.0} \
                     N·s/m.",
                    -after(damping)
                ),
            ),
            Statement::checked(
                [
                    "3.2.1",
                    "influence of B on the force",
                    "limited; B v negligible",
                    "|B v| is below |K p| at the puncture with each setting of the estimator",
                ],
                format!("K p {:.2} N, B v {:.2} N of {:.2} N", terms.elastic_n, terms.viscous_n, terms.force_n),
                self.direct_settings.judge(is_elastic),
                format!(
                    "K and B are not identifiable here: in the 0.1 s before the puncture depth and velocity are nearly \
                     proportional (cosine {:.3}), so one force does not fix two parameters; with F_0 a multiple of the \
                     identity, which is chosen here, eq. 12 then puts {} of a correction of the force into B, while \
                     the true share of the viscosity is {truth}.",
                    terms.alignment,
                    percent(terms.viscous_share),
                ),
            ),
            Statement {
                ours: format!("{:.4} N ({:.4} N with B)", alone.mean_n, both.mean_n),
                ..of(["3.2.1", "mean of the absolute error, K alone", "0.0612 N (0.019 N with B)"], 0.0612, |of| {
                    of.alone.mean_n
                })
            },
            Statement {
                ours: format!("{:.4} N ({:.4} N with B)", alone.std_n, both.std_n),
                ..of(["3.2.1", "standard deviation of it, K alone", "0.041 N (0.0136 N with B)"], 0.041, |of| {
                    of.alone.std_n
                })
            },
            Statement::open(
                ["3.2.1", "reconstruction with K alone", "quite satisfactory: 3.4 % of 1.82 N"],
                format!("{:.1} % of {width_n:.2} N", 100.0 * alone.mean_n / width_n),
                format!(
                    "The paper names no criterion; with the default estimator, which adapts within a few samples, the \
                     mean error with K alone is {alone_n:.4} N, and {both_n:.4} N with B."
                ),
            ),
            Statement::open(
                ["3.2.1", "viscosity between needle and liver", "low"],
                format!("{truth} of the force"),
                "Input: the damping is a setting of the simulated tissue.",
            ),
        ]
    }

    /// Figure 6.
    pub(super) fn through_the_skin(&self) -> Vec<Statement> {
        let run = &self.classical;
        let (low, high) = force_range(run);
        let (direct_low, direct_high) = force_range(&self.direct);
        let of = |texts, paper, read| of_settings(texts, paper, &self.classical_settings, read);
        vec![
            Statement::open(["3.2.2", "force", "-5.69 to 2.45 N"], range_text((low, high)), GENERATED),
            of(["3.2.2", "mean of the absolute error", "0.0486 N"], 0.0486, |of| of.both.mean_n),
            of(["3.2.2", "standard deviation of the absolute error", "0.056 N"], 0.056, |of| of.both.std_n),
            Statement::open(
                ["3.2.2", "force beside direct access", "higher"],
                format!("{:.1} times", (high - low) / (direct_high - direct_low)),
                "Input: the paper's forces are the parameters of both.",
            ),
            Statement::open(
                ["3.2.2", "origin of most of the force", "skin, fat and muscle"],
                "two unnamed layers",
                "The generated recording has two layers without a name, and no force of each.",
            ),
        ]
    }

    /// Figure 7.
    pub(super) fn parameters_through_the_skin(&self) -> Vec<Statement> {
        let run = &self.classical;
        let trace = &run.trace;
        let settings = &self.classical_settings;
        let columns = [(&trace.stiffness_n_per_m, "N/m"), (&trace.damping_n_s_per_m, "N·s/m")];
        let discontinuous = |what: &'static str, index: usize| {
            let text = |(before, after): &(f64, f64)| format!("{after:+.1} (before {before:+.1})");
            let each: Vec<String> = jumps(run, columns[index].0).iter().map(text).collect();
            let is_jump = |(before, after): &(f64, f64)| after.abs() >= DISCONTINUITY * before.abs();
            Statement::checked(
                [
                    "3.2.2",
                    what,
                    "discontinuous",
                    "it changes in 20 ms by 3 times the change in the 20 ms before, with each setting of the estimator",
                ],
                format!("{} {}", each.join(" and "), columns[index].1),
                settings.judge(|of| {
                    let jumps = jumps(&of.run, parameters(&of.run)[index]);
                    !jumps.is_empty() && jumps.iter().all(is_jump)
                }),
                "A rupture changes the relation of force and motion within a few samples; the estimate follows.",
            )
        };
        let [[k, k_elsewhere], [b, b_elsewhere]] = parameters(run).map(|column| changes(run, column));
        let is_slow = |of: &OfSettings| {
            parameters(&of.run)
                .map(|column| changes(&of.run, column))
                .iter()
                .all(|[least, elsewhere]| *elsewhere <= least / CLEAR)
        };
        let ends = columns.map(|(column, _)| range(column));
        vec![
            discontinuous("stiffness at the ruptures", 0),
            discontinuous("damping at the ruptures", 1),
            Statement::checked(
                [
                    "3.2.2",
                    "parameters away from the transitions",
                    "slowly varying",
                    "they change in 20 ms by at most half of that at any rupture, with each setting of the estimator",
                ],
                format!(
                    "up to {k_elsewhere:.1} N/m and {b_elsewhere:.1} N·s/m in 20 ms; at the ruptures {k:.1} and {b:.1} \
                     or more"
                ),
                settings.judge(is_slow),
                "Contact, rest and the fast extraction are included.",
            ),
            Statement::open(
                ["3.2.2", "size of the parameters", "bounded"],
                format!("{:.0} to {:.0} N/m, {:.0} to {:.0} N·s/m", ends[0].0, ends[0].1, ends[1].0, ends[1].1),
                "Every record of finite length is bounded, and the paper gives no bound.",
            ),
            self.meaning_of_the_parameters(),
        ]
    }

    fn meaning_of_the_parameters(&self) -> Statement {
        let run = &self.classical;
        let trace = &run.trace;
        let between = between_ruptures(run);
        let mean = |values: &[f64]| mean_and_variance(values[between.clone()].iter().map(|value| value.abs())).0;
        let (low, high) = range(&trace.damping_n_s_per_m[between.clone()]);
        let stiffness = range(&trace.stiffness_n_per_m[between.clone()]);
        let [_, viscous] = terms(run);
        let [both, alone] = [run, &self.classical_stiffness].map(|run| Errors::of(run).mean_n);
        Statement::checked(
            [
                "2.1, eq. 3",
                "meaning of K and B",
                "no longer rigorously stiffness and viscous friction",
                "B is below 0 between the ruptures, which no friction is, with each setting of the estimator",
            ],
            format!("B is {:.0} N·s/m between the ruptures", damping_between(run)),
            self.classical_settings.judge(|of| damping_between(&of.run) < 0.0),
            format!(
                "B is not identifiable between the ruptures: at {:.1} mm/s eq. 12 corrects K and leaves B at its \
                 value after rupture 1 ({low:.0} to {high:.0} N·s/m, while K runs from {:.0} to {:.0} N/m), which \
                 hardly changes the estimated force, since B v is {:.2} N of {:.2} N; \
                 the mean absolute error is {alone:.4} N with K alone, and {both:.4} N with K and B.",
                1e3 * mean(&trace.slave_velocity_m_per_s),
                stiffness.0,
                stiffness.1,
                mean(&viscous),
                mean(&trace.measured_force_n),
            ),
        )
    }

    pub(super) fn estimator(&self) -> Vec<Statement> {
        let [with_reset, without] = [&self.classical, &self.no_reset].map(|run| Errors::of(run).mean_n);
        let [with_zone, without_zone] = [&self.classical, &self.no_dead_zone].map(|run| self.wandering(run));
        let rate_hz = 1.0 / self.classical.scenario.grid.tick_s();
        vec![
            Statement::open(
                ["2.2.2, eq. 15", "dead zone at small errors", "noticeable gain in robustness"],
                format!("K changes by {with_zone:.3} N/m a sample, {without_zone:.3} N/m without it"),
                "The paper names no measure; this is the root mean square of the change of K in the quiet stretches of \
                 figure 11.",
            ),
            Statement::checked(
                [
                    "2.2.2, eq. 16-18",
                    "covariance resetting",
                    "needed for varying parameters",
                    "the mean absolute error is at most half of that without",
                ],
                format!("error {with_reset:.4} N, {without:.4} N without"),
                with_reset <= 0.5 * without,
                "Without resetting the gain of eq. 13 goes to zero, and the estimate keeps its first values (insertion \
                 of figure 6).",
            ),
            Statement::open(
                ["3.1", "sampling", "1 kHz"],
                format!("{:.0} kHz", 1e-3 * rate_hz),
                "Input: it is the tick of the shipped scenarios.",
            ),
            Statement::open(
                ["3.1", "velocity from the encoders", "noisy, needs a Kalman filter"],
                "exact velocity",
                "The shipped scenarios have ideal encoders (sensor.position_resolution_m is not set).",
            ),
        ]
    }

    /// Root mean square of the stiffness's changes between samples, in N/m.
    fn wandering(&self, run: &Run) -> f64 {
        let stiffness = &run.trace.stiffness_n_per_m;
        let squares = self.quiet.iter().flat_map(|stretch| {
            let (from_s, to_s) = stretch.from_to_s;
            stiffness[tick(run, from_s)..=tick(run, to_s)].windows(2).map(|pair| (pair[1] - pair[0]).powi(2))
        });
        mean_and_variance(squares).0.sqrt()
    }
}

fn parameters(run: &Run) -> [&[f64]; 2] {
    [&run.trace.stiffness_n_per_m, &run.trace.damping_n_s_per_m]
}

fn changes(run: &Run, column: &[f64]) -> [f64; 2] {
    let least = jumps(run, column).iter().map(|jump| jump.1.abs()).fold(f64::INFINITY, f64::min);
    [least, largest_change_elsewhere(run, column)]
}

fn between_ruptures(run: &Run) -> std::ops::Range<usize> {
    match ruptures_s(run)[..] {
        [first_s, second_s, ..] => tick(run, first_s + TRANSIENT_S)..tick(run, second_s),
        _ => 0..0,
    }
}

fn damping_between(run: &Run) -> f64 {
    mean_and_variance(run.trace.damping_n_s_per_m[between_ruptures(run)].iter().copied()).0
}

fn deepest_tick(run: &Run) -> usize {
    let depths = run.trace.slave_position_m.iter().enumerate();
    depths.max_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |(tick, _)| tick)
}
