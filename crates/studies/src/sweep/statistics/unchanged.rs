use super::Summary;
use trocar_base::warning::{Code, Warning};

impl Summary {
    /// Equal in all cases, or defined in none.
    pub fn is_unchanged(&self, cases: u64) -> bool {
        let is_one_value = self.defined == cases && self.spread.is_some_and(|spread| spread.min == spread.max);
        cases > 1 && (self.defined == 0 || is_one_value)
    }
}

pub(super) fn warning(summaries: &[Summary], cases: u64) -> Option<Warning> {
    let warning = || {
        Warning::new(Code::UnchangedMetrics, format!("no metric differs between the {cases} cases"))
            .at("axes")
            .remedy("vary a key that acts in this scenario, or record other metrics")
    };
    summaries.iter().all(|summary| summary.is_unchanged(cases)).then(warning)
}
