use schemars::JsonSchema;
use serde::Serialize;

/// The result of comparing a statement with the simulation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Judgement {
    /// The result meets the stated condition, and was not an input.
    Reproduced,
    /// The result does not meet the stated condition.
    Contradicted,
    /// There is no independent result: the number was an input, it depends on details that the paper does not state,
    /// the simulation lacks the subject of the statement, or the statement names no criterion.
    NotCheckable,
}

impl Judgement {
    pub const ALL: [Self; 3] = [Self::Reproduced, Self::Contradicted, Self::NotCheckable];

    pub fn words(self) -> &'static str {
        match self {
            Self::Reproduced => "reproduced",
            Self::Contradicted => "contradicted",
            Self::NotCheckable => "not checkable",
        }
    }
}

impl From<bool> for Judgement {
    fn from(is_met: bool) -> Self {
        if is_met { Self::Reproduced } else { Self::Contradicted }
    }
}

impl Judgement {
    /// Not checkable if only some variations meet the condition.
    pub(super) fn over(met: impl IntoIterator<Item = bool>) -> Self {
        let met: Vec<bool> = met.into_iter().collect();
        if met.iter().all(|met| *met) {
            Self::Reproduced
        } else if met.iter().any(|met| *met) {
            Self::NotCheckable
        } else {
            Self::Contradicted
        }
    }
}

/// A statement of the paper, the corresponding result, and the judgement.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Statement {
    /// Number: the figure and a letter, as in `5b`; `A` instead of a figure for statements that no figure shows.
    pub number: String,
    /// Section, and the equation if the statement is about one.
    pub section: &'static str,
    /// The subject.
    pub what: &'static str,
    /// The paper's number or words.
    pub paper: &'static str,
    /// Condition for *reproduced*; empty if no result can meet it.
    pub condition: &'static str,
    /// The result.
    pub ours: String,
    /// The judgement.
    pub judgement: Judgement,
    /// Reason, in one sentence.
    pub why: String,
}

impl Statement {
    /// Strings: section, subject, the paper's number, condition for *reproduced*.
    pub(super) fn checked(
        [section, what, paper, condition]: [&'static str; 4],
        ours: impl Into<String>,
        judgement: impl Into<Judgement>,
        why: impl Into<String>,
    ) -> Self {
        let judgement = judgement.into();
        let (number, ours, why) = (String::new(), ours.into(), why.into());
        Self { number, section, what, paper, condition, ours, judgement, why }
    }

    /// Strings: section, subject, the paper's number.
    pub(super) fn open(
        [section, what, paper]: [&'static str; 3],
        ours: impl Into<String>,
        why: impl Into<String>,
    ) -> Self {
        Self::checked([section, what, paper, ""], ours, Judgement::NotCheckable, why)
    }
}

/// Maximum ratio, in either direction, of a reproduced number to the paper's.
const FACTOR: f64 = 1.5;

pub(super) fn is_within(ours: f64, paper: f64) -> bool {
    (paper / FACTOR..=paper * FACTOR).contains(&ours)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_reproduced_within_the_factor_on_both_sides() {
        assert!([0.0201, 0.03, 0.0449].into_iter().all(|ours| is_within(ours, 0.03)));
        assert!([0.0199, 0.0451, f64::NAN].into_iter().all(|ours| !is_within(ours, 0.03)));
    }

    #[test]
    fn a_statement_that_cannot_be_checked_has_no_condition_and_no_tick() {
        let open = Statement::open(["4.6", "what", "5 s"], "6 s", "why");
        assert_eq!((open.judgement, open.condition), (Judgement::NotCheckable, ""));
        let met = |is_met: bool| Statement::checked(["4.6", "what", "5 s", "equal"], "6 s", is_met, "why").judgement;
        assert_eq!([met(true), met(false)], [Judgement::Reproduced, Judgement::Contradicted]);
    }

    #[test]
    fn a_condition_that_only_some_variations_meet_is_not_checkable() {
        let over = |met: [bool; 3]| Judgement::over(met);
        assert_eq!(over([true; 3]), Judgement::Reproduced);
        assert_eq!(over([false; 3]), Judgement::Contradicted);
        assert_eq!([over([true, true, false]), over([false, false, true])], [Judgement::NotCheckable; 2]);
    }
}
