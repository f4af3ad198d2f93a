use crate::machine::Machine;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Structure {
    /// The force sensor is exact.
    Plain,
    /// With a scale and an offset of the force sensor.
    Sensor,
    /// Also a lag.
    LaggingSensor,
}

impl Structure {
    pub(crate) const ALL: [Self; 3] = [Self::Plain, Self::Sensor, Self::LaggingSensor];

    pub fn key(self) -> &'static str {
        match self {
            Self::Plain => "plain",
            Self::Sensor => "sensor",
            Self::LaggingSensor => "lagging-sensor",
        }
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::Plain => "exact force sensor",
            Self::Sensor => "scale and offset of the sensor",
            Self::LaggingSensor => "scale, offset and lag of the sensor",
        }
    }

    pub(crate) fn sensor(self) -> &'static [Parameter] {
        match self {
            Self::Plain => &[],
            Self::Sensor => &[Parameter::Scale, Parameter::Offset],
            Self::LaggingSensor => &[Parameter::Scale, Parameter::Offset, Parameter::Lag],
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Parameter {
    Mass,
    Viscous,
    Coulomb,
    PositionGain,
    VelocityGain,
    Delay,
    Scale,
    Offset,
    Lag,
}

impl Parameter {
    pub(crate) fn key(self) -> &'static str {
        match self {
            Self::Mass => "mass_kg",
            Self::Viscous => "viscous_n_s_per_m",
            Self::Coulomb => "coulomb_n",
            Self::PositionGain => "position_gain_n_per_m",
            Self::VelocityGain => "velocity_gain_n_s_per_m",
            Self::Delay => "controller_delay_s",
            Self::Scale => "force_scale",
            Self::Offset => "force_offset_n",
            Self::Lag => "force_lag_s",
        }
    }

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Mass => "moving mass",
            Self::Viscous => "viscous friction",
            Self::Coulomb => "Coulomb friction",
            Self::PositionGain => "position gain",
            Self::VelocityGain => "velocity gain",
            Self::Delay => "delay of the controller",
            Self::Scale => "true force per measured force",
            Self::Offset => "constant force against the motion",
            Self::Lag => "lag of the force sensor",
        }
    }

    /// `1` for a plain number.
    pub(crate) fn unit(self) -> &'static str {
        match self {
            Self::Mass => "kg",
            Self::Viscous | Self::VelocityGain => "N·s/m",
            Self::Coulomb | Self::Offset => "N",
            Self::PositionGain => "N/m",
            Self::Delay | Self::Lag => "s",
            Self::Scale => "1",
        }
    }

    pub(crate) fn is_positive(self) -> bool {
        !matches!(self, Self::Scale | Self::Offset | Self::Lag)
    }

    pub(crate) fn of(self, machine: &Machine) -> f64 {
        match self {
            Self::Mass => machine.mass_kg,
            Self::Viscous => machine.viscous_n_s_per_m,
            Self::Coulomb => machine.coulomb_n,
            Self::PositionGain => machine.position_gain_n_per_m,
            Self::VelocityGain => machine.velocity_gain_n_s_per_m,
            Self::Delay => machine.delay_s,
            Self::Scale => machine.load.scale,
            Self::Offset => machine.load.offset_n,
            Self::Lag => machine.load.lag_s,
        }
    }

    pub(crate) fn set(self, machine: &mut Machine, value: f64) {
        *match self {
            Self::Mass => &mut machine.mass_kg,
            Self::Viscous => &mut machine.viscous_n_s_per_m,
            Self::Coulomb => &mut machine.coulomb_n,
            Self::PositionGain => &mut machine.position_gain_n_per_m,
            Self::VelocityGain => &mut machine.velocity_gain_n_s_per_m,
            Self::Delay => &mut machine.delay_s,
            Self::Scale => &mut machine.load.scale,
            Self::Offset => &mut machine.load.offset_n,
            Self::Lag => &mut machine.load.lag_s,
        } = value;
    }
}
