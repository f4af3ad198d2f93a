//! Limits are finite for any data; ticks are few round numbers.

pub const Y_TICKS: usize = 5;
pub const X_TICKS: usize = 6;

/// Larger sums could overflow.
const MAX_MAGNITUDE: f64 = 1e30;

#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    pub low: f64,
    pub high: f64,
    /// Limits and ticks are exponents of ten.
    pub log: bool,
    max_ticks: usize,
    /// Instead of numbers, at 0, -1, -2, ….
    names: Vec<String>,
}

/// In the coordinate of the axis, with labels.
pub type Ticks = Vec<(f64, String)>;

impl Axis {
    /// Without labels if there are 0 ticks.
    pub fn exact(range: (f64, f64), max_ticks: usize) -> Self {
        let (low, high) = sane(range);
        Self { low, high, log: false, max_ticks, names: vec![] }
    }

    /// A line for each name, from the top down at 0, -1, -2, ….
    pub fn of_names(names: impl IntoIterator<Item = String>) -> Self {
        let names: Vec<String> = names.into_iter().collect();
        let low = 0.5 - names.len().max(1) as f64;
        Self { names, ..Self::exact((low, 0.5), 0) }
    }

    /// The margin is larger above, for the marks of alarms.
    pub fn padded(range: (f64, f64), max_ticks: usize) -> Self {
        let (low, high) = sane(range);
        let margin = 0.05 * (high - low);
        Self::exact((low - margin, high + 2.2 * margin), max_ticks)
    }

    /// For quantities that cannot be negative.
    pub fn from_zero(high: f64, max_ticks: usize) -> Self {
        let high = if high.is_finite() && high > 0.0 { high } else { 1.0 };
        Self::exact((0.0, 1.14 * high), max_ticks)
    }

    pub fn log10(range: (f64, f64)) -> Self {
        let (low, high) = sane((range.0.max(1e-300).log10(), range.1.max(1e-300).log10()));
        Self { low, high, log: true, max_ticks: X_TICKS, names: vec![] }
    }

    pub fn over(range: (f64, f64), is_log: bool, max_ticks: usize) -> Self {
        if is_log { Self::log10(range) } else { Self::exact(range, max_ticks) }
    }

    pub fn all_ticks(&self) -> Ticks {
        self.ticks(|_| true)
    }

    pub fn within(&self, place: f64) -> f64 {
        place.max(self.low).min(self.high)
    }

    pub fn place(&self, value: f64) -> f64 {
        if self.log && value.is_finite() { if value > 0.0 { value.log10() } else { self.low - 1.0 } } else { value }
    }

    pub fn ticks(&self, fits: impl Fn(&Ticks) -> bool) -> Ticks {
        if !self.names.is_empty() {
            return self.names.iter().enumerate().map(|(line, name)| (-(line as f64), name.clone())).collect();
        }
        if self.max_ticks == 0 {
            return vec![];
        }
        let all: Vec<Ticks> =
            if self.log { self.powers() } else { (1..=self.max_ticks).rev().map(|n| self.steps(n)).collect() };
        let fitting =
            all.iter().position(|ticks| ticks.len() > 1 && fits(ticks)).or_else(|| all.iter().position(&fits));
        fitting.map_or(vec![], |index| all[index].clone())
    }

    fn steps(&self, count: usize) -> Ticks {
        let step = nice_step((self.high - self.low) / count as f64);
        let first = (self.low / step - 1e-9).ceil();
        let count = ((self.high - first * step) / step + 1e-9).floor().clamp(0.0, 50.0) as usize;
        (0..=count).map(|k| (first + k as f64) * step).map(|tick| (tick, self.label(tick, step))).collect()
    }

    /// Possible ticks, the densest first. Below three powers of ten they include 2 and 5 times each power.
    fn powers(&self) -> Vec<Ticks> {
        let of_step = |step: i32| -> Ticks {
            let (first, last) =
                ((self.low / f64::from(step)).ceil() as i32, (self.high / f64::from(step)).floor() as i32);
            (first..=last).map(|k| k * step).map(|k| (f64::from(k), format!("10{}", superscript(k)))).collect()
        };
        let with = |factors: &[f64]| -> Ticks {
            let powers = self.low.floor() as i32..=self.high.ceil() as i32;
            let all = powers.flat_map(|k| factors.iter().map(move |factor| f64::from(k) + factor.log10()));
            all.filter(|tick| (self.low..=self.high).contains(tick)).map(|tick| (tick, plain(tick))).collect()
        };
        let min_step = ((self.high - self.low) / 6.0).ceil().clamp(1.0, 100.0) as i32;
        let mut all = vec![];
        if of_step(1).len() < 3 {
            all.extend([with(&[1.0, 2.0, 5.0]), with(&[1.0, 3.0]), with(&[1.0])]);
        }
        all.extend([1, 2, 3, 5].map(|factor| of_step(factor * min_step)));
        all
    }

    fn label(&self, tick: f64, step: f64) -> String {
        let largest = self.low.abs().max(self.high.abs());
        if largest >= 1e6 || step < 1e-4 {
            return scientific(tick, step);
        }
        let decimals = (-step.log10() - 1e-9).ceil().clamp(0.0, 6.0) as usize;
        let scaled = step * 10_f64.powi(decimals as i32);
        let decimals = if (scaled - scaled.round()).abs() > 1e-6 { decimals + 1 } else { decimals };
        minus(&format!("{:.decimals$}", tick + 0.0))
    }
}

fn plain(tick: f64) -> String {
    let exponent = (tick + 1e-9).floor();
    if (-3.0..4.0).contains(&exponent) {
        format!("{:.*}", (-exponent).max(0.0) as usize, 10_f64.powf(tick))
    } else {
        format!("{:.0}·10{}", 10_f64.powf(tick - exponent), superscript(exponent as i32))
    }
}

pub fn extent(values: impl IntoIterator<Item = f64>) -> Option<(f64, f64)> {
    values.into_iter().filter(|v| v.abs() <= MAX_MAGNITUDE).fold(None, |range, v| match range {
        None => Some((v, v)),
        Some((low, high)) => Some((low.min(v), high.max(v))),
    })
}

/// Without outliers: the quantiles `1 - level` and `level` of the finite values.
pub fn quantile_extent(values: impl IntoIterator<Item = f64>, level: f64) -> Option<(f64, f64)> {
    let mut kept: Vec<f64> = values.into_iter().filter(|v| v.abs() <= MAX_MAGNITUDE).collect();
    let last = kept.len().checked_sub(1)?;
    let high_rank = ((level * last as f64).ceil() as usize).min(last);
    let low_rank = last - high_rank;
    let low = *kept.select_nth_unstable_by(low_rank, f64::total_cmp).1;
    let high = *kept.select_nth_unstable_by(high_rank, f64::total_cmp).1;
    Some((low, high))
}

pub fn union(a: Option<(f64, f64)>, b: Option<(f64, f64)>) -> Option<(f64, f64)> {
    match (a, b) {
        (Some(a), Some(b)) => Some((a.0.min(b.0), a.1.max(b.1))),
        (a, b) => a.or(b),
    }
}

fn sane((low, high): (f64, f64)) -> (f64, f64) {
    if !(low.is_finite() && high.is_finite()) {
        return (0.0, 1.0);
    }
    let (low, high) = (low.clamp(-MAX_MAGNITUDE, MAX_MAGNITUDE), high.clamp(-MAX_MAGNITUDE, MAX_MAGNITUDE));
    let (low, high) = (low.min(high), low.max(high));
    let min_width = 1e-9 * low.abs().max(high.abs()).max(1e-3);
    if high - low > min_width {
        return (low, high);
    }
    let half = if low == 0.0 { 0.5 } else { 0.1 * low.abs() + 1e-9 };
    (low - half, high + half)
}

fn nice_step(raw: f64) -> f64 {
    let power = 10_f64.powi(raw.log10().floor() as i32);
    [1.0, 2.0, 2.5, 5.0].into_iter().map(|m| m * power).find(|&step| step >= raw * (1.0 - 1e-9)).unwrap_or(10.0 * power)
}

fn minus(text: &str) -> String {
    let is_zero = !text.chars().any(|c| c.is_ascii_digit() && c != '0');
    if is_zero { text.trim_start_matches('-').to_owned() } else { text.replace('-', "−") }
}

fn scientific(value: f64, step: f64) -> String {
    if value.abs() < 1e-6 * step {
        return String::from("0");
    }
    let exponent = value.abs().log10().floor() as i32;
    let mantissa = value / 10_f64.powi(exponent);
    minus(&format!("{mantissa:.1}·10{}", superscript(exponent)))
}

fn superscript(exponent: i32) -> String {
    exponent
        .to_string()
        .chars()
        .map(|c| match c {
            '-' => '⁻',
            '0' => '⁰',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            '4' => '⁴',
            '5' => '⁵',
            '6' => '⁶',
            '7' => '⁷',
            '8' => '⁸',
            _ => '⁹',
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis) -> Vec<String> {
        axis.all_ticks().into_iter().map(|(_, label)| label).collect()
    }

    #[test]
    fn an_axis_of_names_lists_the_names_from_the_top_down() {
        let axis = Axis::of_names(["none".to_owned(), "cue".to_owned()]);
        assert_eq!((axis.low, axis.high), (-1.5, 0.5));
        assert_eq!(axis.all_ticks(), [(0.0, "none".to_owned()), (-1.0, "cue".to_owned())]);
    }

    #[test]
    fn ticks_are_round_numbers_within_the_axis() {
        assert_eq!(labels(&Axis::exact((5.12, 7.12), X_TICKS)), ["5.5", "6.0", "6.5", "7.0"]);
        assert_eq!(labels(&Axis::padded((-2.5, 5.7), Y_TICKS)), ["−2", "0", "2", "4", "6"]);
        assert_eq!(labels(&Axis::exact((0.0, 1.0), 0)), [""; 0]);
    }

    #[test]
    fn a_short_logarithmic_axis_has_ticks_between_its_powers() {
        let labels = |low: f64, high: f64| labels(&Axis::log10((low, high)));
        assert_eq!(labels(0.25, 8.0), ["0.5", "1", "2", "5"]);
        assert_eq!(labels(2e-3, 2e-1), ["0.002", "0.005", "0.01", "0.02", "0.05", "0.1", "0.2"]);
        assert_eq!(labels(1e6, 5e6), ["1·10⁶", "2·10⁶", "5·10⁶"]);
        assert_eq!(labels(0.1, 10.0), ["10⁻¹", "10⁰", "10¹"]);
    }

    #[test]
    fn an_axis_without_room_has_fewer_ticks() {
        for axis in [Axis::exact((0.0, 10.0), 6), Axis::log10((1e-3, 1e3)), Axis::log10((2e-3, 2e-1))] {
            let few = axis.ticks(|ticks| ticks.len() <= 3);
            assert!((2..=3).contains(&few.len()), "{few:?}");
            assert!(axis.all_ticks().len() > 3);
        }
    }

    #[test]
    fn limits_ignore_values_that_are_not_finite() {
        let wild = [f64::NAN, 1.0, f64::INFINITY, 1e300, -2.0, f64::NEG_INFINITY];
        assert_eq!(extent(wild), Some((-2.0, 1.0)));
        assert_eq!(extent([f64::NAN]), None);
        assert_eq!(quantile_extent([], 0.995), None);
        let mut many: Vec<f64> = (0..1000).map(f64::from).collect();
        many[7] = 1e12;
        let (low, high) = quantile_extent(many, 0.995).expect("finite values");
        assert!(low < 20.0 && high < 1000.0, "{low} {high}");
    }

    #[test]
    fn every_range_gives_a_valid_axis() {
        let odd = [0.0, -0.0, 1.0, 1e-320, 1e30, -1e300, f64::MAX, f64::NAN, f64::INFINITY];
        for low in odd {
            for high in odd {
                for axis in [
                    Axis::exact((low, high), 6),
                    Axis::padded((low, high), 6),
                    Axis::from_zero(high, 6),
                    Axis::log10((low, high)),
                ] {
                    let ticks = labels(&axis);
                    assert!(axis.low < axis.high && ticks.len() < 60, "{axis:?}");
                    assert!(ticks.iter().all(|label| label.chars().count() < 12), "{ticks:?}");
                }
            }
        }
    }
}
