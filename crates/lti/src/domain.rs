use super::{Complex64, Error};

mod sealed {
    pub trait Sealed {}
    impl Sealed for super::Continuous {}
    impl Sealed for super::Discrete {}
}

pub trait Domain: Copy + std::fmt::Debug + PartialEq + sealed::Sealed {
    /// Discrete systems must have equal ticks.
    fn shared_with(self, other: Self) -> Result<Self, Error>;

    /// s = 0 or z = 1.
    fn constant_point(self) -> f64;

    /// s = jω or z = exp(jωT).
    fn frequency_point(self, omega_rad_per_s: f64) -> Complex64;

    /// Re s < 0 or |z| < 1.
    fn is_stable_pole(self, pole: Complex64) -> bool;
}

/// `x' = A x + B u`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Continuous;

/// `x_{k+1} = A x_k + B u_k`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Discrete {
    tick_s: f64,
}

impl Discrete {
    pub fn new(tick_s: f64) -> Result<Self, Error> {
        if tick_s.is_finite() && tick_s > 0.0 { Ok(Self { tick_s }) } else { Err(Error::TickNotPositive { tick_s }) }
    }

    pub fn tick_s(self) -> f64 {
        self.tick_s
    }
}

impl Domain for Continuous {
    fn shared_with(self, _: Self) -> Result<Self, Error> {
        Ok(self)
    }

    fn constant_point(self) -> f64 {
        0.0
    }

    fn frequency_point(self, omega_rad_per_s: f64) -> Complex64 {
        Complex64::new(0.0, omega_rad_per_s)
    }

    fn is_stable_pole(self, pole: Complex64) -> bool {
        pole.re < 0.0
    }
}

impl Domain for Discrete {
    fn shared_with(self, other: Self) -> Result<Self, Error> {
        if self.tick_s == other.tick_s {
            Ok(self)
        } else {
            Err(Error::UnequalTicks { first_s: self.tick_s, second_s: other.tick_s })
        }
    }

    fn constant_point(self) -> f64 {
        1.0
    }

    fn frequency_point(self, omega_rad_per_s: f64) -> Complex64 {
        let (sin, cos) = libm::sincos(omega_rad_per_s * self.tick_s);
        Complex64::new(cos, sin)
    }

    fn is_stable_pole(self, pole: Complex64) -> bool {
        pole.norm() < 1.0
    }
}
