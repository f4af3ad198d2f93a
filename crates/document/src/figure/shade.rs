//! What an interval of time is shaded for, and its colour.

use super::{Color, GREY, ORANGE, SKY};

/// What an interval of time is shaded for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shade {
    /// An event, during which the slave is frozen.
    Frozen,
    /// An event, during which a speed limit or a region holds the slave back.
    Held,
    /// An event, during which the slave follows the hand.
    Event,
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
    pub const ALL: [Self; 7] =
        [Self::Frozen, Self::Held, Self::Event, Self::Reengaging, Self::Insertion, Self::Hold, Self::Withdrawal];

    /// Returns its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Frozen => "frozen",
            Self::Held => "held",
            Self::Event => "event",
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
            Self::Held => ORANGE.pale(0.24),
            Self::Event => GREY.pale(0.2),
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
