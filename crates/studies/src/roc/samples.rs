use trocar_engine::engine::{Observer, Signals};

#[derive(Debug, Clone, Default, PartialEq)]
pub struct Samples {
    pub tick_s: f64,
    pub force_n: Vec<f64>,
    pub position_m: Vec<f64>,
    pub velocity_m_per_s: Vec<f64>,
    /// Labels in s after the first sample, ascending.
    pub ruptures_s: Vec<f64>,
}

impl Observer<f64> for Samples {
    fn observe(&mut self, s: &Signals<f64>) {
        self.force_n.push(s.measured_force_n);
        self.position_m.push(s.slave_position_m);
        self.velocity_m_per_s.push(s.slave_velocity_m_per_s);
    }
}
