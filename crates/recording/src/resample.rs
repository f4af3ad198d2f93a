use super::Recording;

/// At the times `k * tick_s` after the first sample, all of the same length.
#[derive(Clone, Debug, PartialEq)]
pub struct Resampled {
    pub position_m: Vec<f64>,
    pub velocity_m_per_s: Option<Vec<f64>>,
    pub force_n: Vec<f64>,
}

#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ResampleError {
    #[error("tick_s is {0}, must be finite and above 0")]
    Tick(f64),
    #[error("{values} values for {samples} samples, must be one each")]
    Length { values: usize, samples: usize },
}

impl Recording {
    pub fn resample(&self, tick_s: f64, ticks: usize) -> Result<Resampled, ResampleError> {
        let on_grid = |values| self.resample_values(values, tick_s, ticks);
        Ok(Resampled {
            position_m: on_grid(self.position_m())?,
            velocity_m_per_s: self.velocity_m_per_s().map(on_grid).transpose()?,
            force_n: on_grid(self.force_n())?,
        })
    }

    /// Interpolates `values`, one per sample, linearly at the times `k * tick_s` (`k = 0, …, ticks - 1`) after the
    /// first sample. After the last sample its value is held.
    ///
    /// `y(t) = y_i + (y_{i+1} - y_i) (t - t_i) / (t_{i+1} - t_i)` for `t_i < t < t_{i+1}`
    ///
    /// A grid time that differs from a sample's time only by rounding (1e-9 of the interval, or two units in the last
    /// place of the recorded times) takes the value of that sample: a recording resampled on its original grid is
    /// unchanged, bit for bit. There is no anti-aliasing filter.
    pub fn resample_values(&self, values: &[f64], tick_s: f64, ticks: usize) -> Result<Vec<f64>, ResampleError> {
        check_tick(tick_s)?;
        let (values_given, samples) = (values.len(), self.len());
        if values_given != samples {
            let values = values_given;
            return Err(ResampleError::Length { values, samples });
        }
        let time_s = self.time_s();
        let start_s = time_s[0];
        let mut left = 0;
        let value_at = |k: usize| {
            let grid_s = k as f64 * tick_s;
            while left + 1 < samples && time_s[left + 1] - start_s <= grid_s {
                left += 1;
            }
            if left + 1 == samples {
                return values[left];
            }
            let (left_s, right_s) = (time_s[left] - start_s, time_s[left + 1] - start_s);
            let interval_s = right_s - left_s;
            let written_s = start_s.abs().max(time_s[left + 1].abs());
            let same_s = (1e-9 * interval_s + 2.0 * f64::EPSILON * written_s).min(0.5 * interval_s);
            if grid_s - left_s <= same_s {
                values[left]
            } else if right_s - grid_s <= same_s {
                values[left + 1]
            } else {
                values[left] + (values[left + 1] - values[left]) * ((grid_s - left_s) / interval_s)
            }
        };
        Ok((0..ticks).map(value_at).collect())
    }

    /// Number of grid points within the recording, including the last sample if it is on the grid up to rounding. At
    /// least 1.
    pub fn ticks_covered(&self, tick_s: f64) -> Result<usize, ResampleError> {
        check_tick(tick_s)?;
        // Times ascend, so one end has the largest magnitude.
        let [first_s, .., last_s] = *self.time_s() else { return Ok(1) };
        let written_s = first_s.abs().max(last_s.abs());
        let same_s = (1e-9 * tick_s + 2.0 * f64::EPSILON * written_s).min(0.5 * tick_s);
        let last = ((self.duration_s() + same_s) / tick_s).floor();
        // The cast saturates for a tick far below the interval.
        Ok((last as usize).saturating_add(1))
    }
}

fn check_tick(tick_s: f64) -> Result<(), ResampleError> {
    if tick_s.is_finite() && tick_s > 0.0 { Ok(()) } else { Err(ResampleError::Tick(tick_s)) }
}

#[cfg(test)]
mod tests {
    use super::super::fixtures::recording;
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn values_between_samples_are_interpolated_and_the_last_is_held() {
        let recording = recording(&[10.0, 10.5, 12.0], &[0.0, 1.0, 4.0]);
        let grid = recording.resample(0.25, 11).expect("a grid");
        let expected = [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 4.0, 4.0];
        assert_eq!(grid.position_m, expected);
        assert_eq!(grid.force_n, expected.map(|x| 2.0 * x));
        assert_eq!(grid.velocity_m_per_s, None);
        assert_eq!(recording.ticks_covered(0.25), Ok(9));
        assert_eq!(recording.ticks_covered(0.3), Ok(7));
        assert_eq!(recording.ticks_covered(5.0), Ok(1));
        assert_eq!(recording.ticks_covered(f64::MIN_POSITIVE), Ok(usize::MAX));
    }

    #[test]
    fn useless_grids_are_refused() {
        let recording = recording(&[0.0, 1.0], &[0.0, 1.0]);
        for tick_s in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(recording.resample(tick_s, 2), Err(ResampleError::Tick(_))), "{tick_s}");
            assert!(recording.ticks_covered(tick_s).is_err(), "{tick_s}");
        }
        let error = recording.resample_values(&[1.0], 1.0, 2).expect_err("too few");
        assert_eq!(error.to_string(), "1 values for 2 samples, must be one each");
    }

    /// Times as written in files: `start + k * tick`, rounded to `digits` decimals.
    fn written_grid(start: f64, tick: f64, digits: usize, len: usize) -> Vec<f64> {
        let time = |k: usize| format!("{:.digits$}", start + k as f64 * tick);
        (0..len).map(|k| time(k).parse().expect("a number")).collect()
    }

    proptest! {
        #[test]
        fn resampling_on_the_original_grid_keeps_the_bits(
            position_m in prop::collection::vec(-1.0..1.0, 2..400),
            start in 0_u32..100_000,
            tick_ms in prop::sample::select(vec![0.1, 0.5, 1.0, 3.0, 10.0]),
        ) {
            let tick_s = tick_ms * 1e-3;
            let time_s = written_grid(f64::from(start), tick_s, 4, position_m.len());
            let recording = recording(&time_s, &position_m);
            prop_assert_eq!(recording.ticks_covered(tick_s), Ok(position_m.len()));
            let grid = recording.resample(tick_s, position_m.len()).expect("a grid");
            prop_assert_eq!(&grid.position_m, recording.position_m());
            prop_assert_eq!(&grid.force_n, recording.force_n());
        }

        #[test]
        fn a_line_stays_a_line(
            steps in prop::collection::vec(1e-4..1e-1, 2..200),
            tick_s in 1e-3..1e-1,
            slope in -1.0..1.0,
        ) {
            let time_s: Vec<f64> = steps.iter().scan(0.0, |t, step| { *t += step; Some(*t) }).collect();
            let position_m: Vec<f64> = time_s.iter().map(|t| 0.5 + slope * (t - time_s[0])).collect();
            let recording = recording(&time_s, &position_m);
            let ticks = recording.ticks_covered(tick_s).expect("a tick");
            let grid = recording.resample(tick_s, ticks).expect("a grid");
            for (k, &x) in grid.position_m.iter().enumerate() {
                let exact: f64 = 0.5 + slope * (k as f64 * tick_s);
                prop_assert!((x - exact).abs() < 1e-9 * 1e-1 + 1e-12, "{} {} {}", k, x, exact);
                let on_sample = time_s.iter().any(|t| (t - time_s[0] - k as f64 * tick_s).abs() < 1e-9);
                prop_assert!(on_sample || (x - exact).abs() < 1e-12, "{} {} {}", k, x, exact);
            }
        }
    }
}
