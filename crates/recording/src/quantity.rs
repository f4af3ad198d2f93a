use super::ColumnSettings;

/// In the order of [`ColumnSettings::KEYS`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    Time,
    Position,
    Velocity,
    Force,
}

impl Quantity {
    pub const ALL: [Self; 4] = [Self::Time, Self::Position, Self::Velocity, Self::Force];

    /// Also the command-line flag without `--`.
    pub fn name(self) -> &'static str {
        let column = self.key().rsplit('.').next().unwrap_or_default();
        column.split('_').next().unwrap_or_default()
    }

    pub const fn unit(self) -> &'static str {
        match self {
            Self::Time => "s",
            Self::Position => "m",
            Self::Velocity => "m/s",
            Self::Force => "N",
        }
    }

    pub const fn units(self) -> &'static str {
        match self {
            Self::Time => "s, ms, us, ns or min",
            Self::Position => "m, cm, mm, um or nm",
            Self::Velocity => "m/s, cm/s, mm/s or um/s",
            Self::Force => "N, kN, cN, mN, uN, gf or kgf",
        }
    }

    pub(super) fn key(self) -> &'static str {
        ColumnSettings::KEYS[self as usize].path
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quantity_is_in_the_unit_of_its_column() {
        for quantity in Quantity::ALL {
            let unit = quantity.unit().to_lowercase().replace('/', "_per_");
            assert_eq!(quantity.key(), format!("recording.columns.{}_{unit}", quantity.name()));
        }
    }
}
