use super::RunReport;
use trocar_base::warning::{Code, Warning};
use trocar_document::{counted, significant};

/// Relative, above the rounding of the limit.
const AT_LIMIT: f64 = 1e-9;

fn is_at(value: f64, limit: f64) -> bool {
    value >= limit * (1.0 - AT_LIMIT)
}

impl RunReport<'_> {
    pub(super) fn acting_limits(self) -> Vec<Warning> {
        let run = self.run;
        let safety = &run.scenario.safety;
        if !safety.acts_in_simulation() {
            return vec![];
        }
        let tick_s = run.scenario.grid.tick_s();
        let (force_n, reference_m) = (&run.trace.feedback_force_n, &run.trace.slave_reference_m);
        let steps = |column: &[f64], limit: f64| {
            column.windows(2).filter(|pair| is_at((pair[1] - pair[0]).abs(), limit * tick_s)).count()
        };
        let ahead = reference_m.iter().zip(&run.trace.slave_position_m);
        let counts = [
            (
                "safety.force_limit_n",
                safety.force_limit_n,
                force_n.iter().filter(|force_n| is_at(force_n.abs(), safety.force_limit_n)).count(),
            ),
            ("safety.force_rate_n_per_s", safety.force_rate_n_per_s, steps(force_n, safety.force_rate_n_per_s)),
            (
                "safety.reference_speed_m_per_s",
                safety.reference_speed_m_per_s,
                steps(reference_m, safety.reference_speed_m_per_s),
            ),
            (
                "safety.lead_m",
                safety.lead_m,
                ahead.filter(|(reference_m, slave_m)| is_at((*reference_m - *slave_m).abs(), safety.lead_m)).count(),
            ),
        ];
        let warning = |(key, limit, ticks): (&'static str, f64, usize)| {
            (ticks > 0).then(|| {
                let message = format!("{key} = {} acts at {}", significant(limit), counted(ticks as u64, "tick"));
                Warning::new(Code::LimitActs, message).at(key).remedy("raise the limit if the command is wanted")
            })
        };
        counts.into_iter().filter_map(warning).collect()
    }
}
