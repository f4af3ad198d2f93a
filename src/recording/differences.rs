//! Velocity from positions.

use std::borrow::Cow;

use super::Recording;

impl Recording {
    /// The recorded velocity in m/s, or where the file has none, central differences of the position:
    ///
    /// `v_k = (x_{k+1} - x_{k-1}) / (t_{k+1} - t_{k-1})`, one-sided at the first and the last sample.
    ///
    /// Exact for constant velocity; on even intervals the error is `x''' dt²/6`, on uneven ones it grows to the order
    /// of `x'' dt`. Differences look one sample ahead and amplify noise: a position resolution `q` becomes velocity
    /// steps of `q / (2 dt)`. Where that matters, a Kalman filter over the position serves better.
    #[must_use]
    pub fn velocity_or_differences(&self) -> Cow<'_, [f64]> {
        match self.velocity_m_per_s() {
            Some(recorded) => Cow::Borrowed(recorded),
            None => Cow::Owned(central_differences(self.time_s(), self.position_m())),
        }
    }
}

fn central_differences(time_s: &[f64], position_m: &[f64]) -> Vec<f64> {
    let last = time_s.len().saturating_sub(1);
    let slope = |k: usize| {
        let (before, after) = (k.saturating_sub(1), (k + 1).min(last));
        (position_m[after] - position_m[before]) / (time_s[after] - time_s[before])
    };
    (0..time_s.len()).map(slope).collect()
}

#[cfg(test)]
mod tests {
    use super::super::fixtures::recording;
    use super::*;

    #[test]
    fn a_line_has_its_slope_everywhere() {
        let time_s = [0.0, 0.5, 0.75, 2.0];
        let velocity = recording(&time_s, &time_s.map(|t| 1.0 - 4.0 * t)).velocity_or_differences().into_owned();
        assert_eq!(velocity, [-4.0; 4]);
    }

    #[test]
    fn a_parabola_is_exact_inside_an_even_grid() {
        let time_s = [0.0, 0.25, 0.5, 0.75];
        let velocity = central_differences(&time_s, &time_s.map(|t| t * t));
        assert_eq!(velocity, [0.25, 0.5, 1.0, 1.25]);
    }

    #[test]
    fn the_recorded_velocity_comes_first() {
        use super::super::{Columns, Limits, fixtures::columns, read_csv};
        let columns = Columns { velocity: "v:-2".parse().ok(), ..columns() };
        let table = "v,f,x,t\n1,0,5,0\n2,0,6,1\n";
        let recording = read_csv("pop.csv", table.as_bytes(), &columns, &Limits::default()).expect("a recording");
        assert_eq!(*recording.velocity_or_differences(), [-2.0, -4.0]);
    }
}
