//! The quantities of a recording.

/// A quantity that a column of a recording holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Time, in s.
    Time,
    /// Position of the needle, in m.
    Position,
    /// Velocity of the needle, in m/s.
    Velocity,
    /// Force on the needle, in N.
    Force,
}

impl Quantity {
    /// All quantities.
    pub const ALL: [Self; 4] = [Self::Time, Self::Position, Self::Velocity, Self::Force];

    /// Its name, which is also the name of its flag on the command line without `--`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::Position => "position",
            Self::Velocity => "velocity",
            Self::Force => "force",
        }
    }

    /// Its SI unit.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        match self {
            Self::Time => "s",
            Self::Position => "m",
            Self::Velocity => "m/s",
            Self::Force => "N",
        }
    }

    /// The units that people write it in.
    #[must_use]
    pub const fn units(self) -> &'static str {
        match self {
            Self::Time => "s, ms, us or min",
            Self::Position => "m, cm, mm or um",
            Self::Velocity => "m/s, cm/s, mm/s or um/s",
            Self::Force => "N, kN, cN, mN, gf or kgf",
        }
    }

    /// The key of a scenario that names its column.
    #[must_use]
    pub(super) const fn key(self) -> &'static str {
        match self {
            Self::Time => "recording.columns.time_s",
            Self::Position => "recording.columns.position_m",
            Self::Velocity => "recording.columns.velocity_m_per_s",
            Self::Force => "recording.columns.force_n",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::ColumnSettings;
    use super::*;

    #[test]
    fn a_quantity_names_the_key_of_its_column() {
        assert!(
            Quantity::ALL.iter().map(|quantity| quantity.key()).eq(ColumnSettings::KEYS.iter().map(|key| key.path))
        );
    }
}
