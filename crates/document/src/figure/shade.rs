use super::{Color, GREY, ORANGE, SKY};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shade {
    Frozen,
    /// A speed limit or a region restrains the slave.
    Held,
    /// The slave follows the hand.
    Event,
    Reengaging,
    Insertion,
    Hold,
    Withdrawal,
}

impl Shade {
    pub const ALL: [Self; 7] =
        [Self::Frozen, Self::Held, Self::Event, Self::Reengaging, Self::Insertion, Self::Hold, Self::Withdrawal];

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

    /// On white paper.
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

    pub fn css(self) -> String {
        self.color().css()
    }
}
