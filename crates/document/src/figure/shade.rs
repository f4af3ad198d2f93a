//! The kinds of shaded time intervals, and their colours.

use super::{Color, GREY, ORANGE, SKY};

/// The kind of a shaded time interval.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shade {
    /// An event with a frozen slave.
    Frozen,
    /// An event in which a speed limit or a region restrains the slave.
    Held,
    /// An event in which the slave follows the hand.
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

    /// The name.
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

    /// The colour on white paper.
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

    /// The colour as CSS for a page.
    #[must_use]
    pub fn css(self) -> String {
        self.color().css()
    }
}
