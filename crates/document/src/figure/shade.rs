//! What an interval of time is shaded for, and its colour.

use super::{Color, GREY, ORANGE, SKY};

/// What an interval of time is shaded for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shade {
    /// The slave is frozen.
    Frozen,
    /// The slave is re-engaging.
    Reengaging,
    /// The needle advances in the tissue.
    Insertion,
    /// The needle rests in the tissue.
    Hold,
    /// The needle leaves the tissue.
    Withdrawal,
}

impl Shade {
    /// All shades.
    pub const ALL: [Self; 5] = [Self::Frozen, Self::Reengaging, Self::Insertion, Self::Hold, Self::Withdrawal];

    /// Returns its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Frozen => "frozen",
            Self::Reengaging => "re-engaging",
            Self::Insertion => "insertion",
            Self::Hold => "hold",
            Self::Withdrawal => "withdrawal",
        }
    }

    /// Returns its colour on white paper.
    #[must_use]
    pub fn color(self) -> Color {
        match self {
            Self::Frozen => ORANGE.pale(0.34),
            Self::Reengaging => ORANGE.pale(0.13),
            Self::Insertion => SKY.pale(0.6),
            Self::Hold => GREY.pale(0.2),
            Self::Withdrawal => SKY.pale(0.25),
        }
    }

    /// Returns its colour as CSS for a page.
    #[must_use]
    pub fn css(self) -> String {
        self.color().css()
    }
}
