#[derive(Debug, Clone)]
pub struct Centred {
    values: Vec<f64>,
    variance: f64,
}

impl Centred {
    /// `None` if the values are constant.
    pub fn of(values: &[f64]) -> Option<Self> {
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count.max(1.0);
        let values: Vec<f64> = values.iter().map(|value| value - mean).collect();
        let variance = moment(&values, 2);
        // A constant minus its mean is rounding error.
        (variance > (1e-12 * mean).powi(2)).then_some(Self { values, variance })
    }

    /// Power 2 gives the variance.
    pub fn moment(&self, power: i32) -> f64 {
        moment(&self.values, power)
    }

    /// The correlation of each value with the one `lag` values later, -1 to 1; `lag` is below the number of values.
    pub fn correlation(&self, lag: usize) -> f64 {
        let products = self.values.iter().zip(&self.values[lag..]).map(|(a, b)| a * b);
        products.sum::<f64>() / (self.values.len() as f64 * self.variance)
    }
}

fn moment(values: &[f64], power: i32) -> f64 {
    values.iter().map(|value| value.powi(power)).sum::<f64>() / values.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn alternating_values_have_a_negative_correlation_with_the_next() {
        let centred = Centred::of(&[3.0, 1.0, 3.0, 1.0]).expect("varies");
        assert_eq!([2, 3, 4].map(|power| centred.moment(power)), [1.0, 0.0, 1.0]);
        assert_eq!([0, 1, 2].map(|lag| centred.correlation(lag)), [1.0, -0.75, 0.5]);
    }

    #[test]
    fn constants_are_not_centred() {
        assert!(Centred::of(&[]).is_none() && Centred::of(&[1.0; 200]).is_none());
        // The mean of these is not exactly 0.3.
        assert!(Centred::of(&[0.3; 500]).is_none());
    }
}
