use super::{Damping, SlaveParameters};

trocar_core::choice! {
    /// Controller of the slave.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum SlaveController at "slave.controller" = Appendix {
        "appendix" => Appendix,
        "pid" => Pid,
    }
}

/// With the tick `T`, the measured force `y` and a held `u`:
///
/// ```text
/// e_k = x_ref - x_e
/// u_k = K_p e_k + K_d (e_k - e_{k-1}) / T + I_k - K_v v_e - K_x x_e + K_f y_k
/// I_{k+1} = I_k + K_i T e_k
/// ```
/// `K_x` is the as-printed damping of eq. 31.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SampledGains {
    /// `K_p` in N/m.
    pub proportional: f64,
    /// `K_d / T` in N/m.
    pub difference: f64,
    /// `K_i T` in N/m.
    pub sum: f64,
    /// `K_v` in N·s/m.
    pub velocity: f64,
    /// `K_x` in N/m.
    pub position: f64,
    /// `K_f`.
    pub force: f64,
}

impl SampledGains {
    pub fn of(slave: &SlaveParameters, tick_s: f64) -> Self {
        let proportional = slave.proportional_gain;
        match slave.controller {
            SlaveController::Appendix => {
                let (velocity, position) = match slave.damping {
                    Damping::Velocity => (slave.velocity_gain, 0.0),
                    Damping::AsPrinted => (0.0, slave.velocity_gain),
                };
                Self { proportional, difference: 0.0, sum: 0.0, velocity, position, force: 0.0 }
            }
            SlaveController::Pid => Self {
                proportional,
                difference: slave.derivative_gain / tick_s,
                sum: slave.integral_gain * tick_s,
                velocity: slave.velocity_gain,
                position: 0.0,
                force: slave.force_feed_forward,
            },
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SampledController {
    gains: SampledGains,
    bounds: (f64, f64),
    integral: f64,
    last_error_m: f64,
    command: f64,
}

impl SampledController {
    pub fn at_rest(gains: SampledGains, bounds: (f64, f64), error_m: f64, position_m: f64, command: f64) -> Self {
        let SampledGains { proportional, position, sum, .. } = gains;
        let integral = if sum == 0.0 { 0.0 } else { command - proportional * error_m + position * position_m };
        Self { gains, bounds, integral, last_error_m: error_m, command: command.clamp(-bounds.0, bounds.0) }
    }

    /// While the command is limited, the integral may only change towards it.
    pub fn command(&mut self, error_m: f64, [position_m, velocity_m_per_s]: [f64; 2], measured_n: f64) -> f64 {
        let gains = &self.gains;
        let wanted = gains.proportional * error_m + gains.difference * (error_m - self.last_error_m) + self.integral
            - gains.velocity * velocity_m_per_s
            - gains.position * position_m
            + gains.force * measured_n;
        let (range, change) = self.bounds;
        // Unlike `clamp`, they accept NaN.
        let within = wanted.max(-range).min(range);
        let limited = within.max(self.command - change).min(self.command + change);
        self.command = if wanted.is_nan() { wanted } else { limited };
        if (wanted - self.command) * error_m <= 0.0 {
            self.integral += gains.sum * error_m;
        }
        self.last_error_m = error_m;
        self.command
    }
}
