//! Times as numbers or as dates by ISO 8601.

use chrono::{DateTime, NaiveDate, NaiveDateTime, NaiveTime};

use super::error::{Problem, excerpt};
use super::number::trimmed;

/// A time of at least this many seconds, in 1973 as a Unix time, is a time of the calendar.
pub const CALENDAR_S: f64 = 1e8;

/// The Unix time of the year 5138, above which a number has another unit than the stated one.
pub(super) const MAX_CALENDAR_S: f64 = 1e11;

const NANOSECONDS: f64 = 1e9;

/// Times of the calendar count from the first one, exactly: digits that a floating-point number of seconds since 1970
/// does not have are kept.
#[derive(Debug, Clone, Default)]
pub(super) struct Stamps {
    start: Option<Start>,
}

#[derive(Debug, Clone, Copy)]
enum Start {
    /// Numbers from any time that is not of the calendar.
    Plain,
    Decimal(Decimal),
    /// Nanoseconds since 1970.
    Date(i64),
}

/// `digits / 10^decimals`.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Decimal {
    digits: i128,
    decimals: u32,
}

impl Decimal {
    const MAX_DIGITS: usize = 30;

    fn parse(text: &str) -> Option<Self> {
        let (whole, part) = text.split_once('.').unwrap_or((text, ""));
        if whole.len() + part.len() > Self::MAX_DIGITS || !part.bytes().all(|byte| byte.is_ascii_digit()) {
            return None;
        }
        let digits = format!("{whole}{part}").parse().ok()?;
        Some(Self { digits, decimals: part.len() as u32 })
    }

    fn minus(self, other: Self) -> Option<Self> {
        let decimals = self.decimals.max(other.decimals);
        let digits = |number: Self| number.digits.checked_mul(10_i128.checked_pow(decimals - number.decimals)?);
        Some(Self { digits: digits(self)?.checked_sub(digits(other)?)?, decimals })
    }

    /// A scale such as 1e-9 divides, which is exact to the last bit.
    fn times(self, scale: f64) -> f64 {
        let (digits, power) = (self.digits as f64, 10_f64.powi(self.decimals as i32));
        let per = (1.0 / scale).round();
        if 1.0 / per == scale { digits / (power * per) } else { digits / power * scale }
    }
}

impl Stamps {
    /// In s. `number` is the field as a number of the file, if it is one, and `scale` its unit in s.
    pub(super) fn time_s(&mut self, field: &[u8], number: Result<f64, Problem>, scale: f64) -> Result<f64, Problem> {
        let text = str::from_utf8(field).map_err(|_| Problem::NotUtf8)?;
        let text = trimmed(text);
        let number = match number {
            Ok(number) => number,
            Err(problem) => {
                let Some(date_ns) = nanoseconds(text) else { return Err(problem) };
                let start_ns = match self.start {
                    None => date_ns,
                    Some(Start::Date(start_ns)) => start_ns,
                    Some(Start::Plain | Start::Decimal(_)) => return Err(problem),
                };
                self.start = Some(Start::Date(start_ns));
                return Ok(date_ns.saturating_sub(start_ns) as f64 / NANOSECONDS);
            }
        };
        let time_s = number * scale;
        if self.start.is_none() && time_s.abs() > MAX_CALENDAR_S {
            return Err(Problem::TimeBeyondCalendar { time_s });
        }
        let start = *self.start.get_or_insert_with(|| match Decimal::parse(&text.replace(',', ".")) {
            Some(start) if time_s.abs() >= CALENDAR_S => Start::Decimal(start),
            _ => Start::Plain,
        });
        match start {
            Start::Plain => Ok(time_s),
            Start::Date(_) => Err(Problem::NotANumber(excerpt(text).into())),
            Start::Decimal(start) => match Decimal::parse(&text.replace(',', ".")).and_then(|now| now.minus(start)) {
                Some(since) => Ok(since.times(scale)),
                None => Ok(time_s - start.times(scale)),
            },
        }
    }

    pub(super) fn has_dates(&self) -> bool {
        matches!(self.start, Some(Start::Date(_)))
    }

    pub(super) fn origin_s(&self, scale: f64) -> f64 {
        match self.start {
            None | Some(Start::Plain) => 0.0,
            Some(Start::Decimal(start)) => start.times(scale),
            Some(Start::Date(start_ns)) => start_ns as f64 / NANOSECONDS,
        }
    }
}

pub(super) fn written(origin_s: f64) -> Option<String> {
    const DAY_S: f64 = 86_400.0;
    let date = DateTime::from_timestamp_millis((1e3 * origin_s).round() as i64)?;
    let form = if (0.0..DAY_S).contains(&origin_s) { "%H:%M:%S%.3f" } else { "%Y-%m-%d %H:%M:%S%.3f UTC" };
    Some(date.format(form).to_string())
}

pub(super) fn is_date(text: &str) -> bool {
    nanoseconds(trimmed(text)).is_some()
}

fn may_be_date(text: &[u8]) -> bool {
    let text = text.trim_ascii();
    text.first().is_some_and(u8::is_ascii_digit) && text.contains(&b':')
}

/// Counts from 1970, or from midnight. A date without a zone counts as UTC.
fn nanoseconds(text: &str) -> Option<i64> {
    if !may_be_date(text.as_bytes()) {
        return None;
    }
    let text = text.replace(',', ".");
    if let Ok(date) =
        DateTime::parse_from_rfc3339(&text).or_else(|_| DateTime::parse_from_str(&text, "%Y-%m-%d %H:%M:%S%.f%#z"))
    {
        return date.timestamp_nanos_opt();
    }
    let of_date = |form: &&str| NaiveDateTime::parse_from_str(&text, form).ok();
    let forms = [
        "%Y-%m-%dT%H:%M:%S%.f",
        "%Y-%m-%d %H:%M:%S%.f",
        "%Y/%m/%d %H:%M:%S%.f",
        "%d.%m.%Y %H:%M:%S%.f",
        "%Y%m%dT%H%M%S%.f",
    ];
    let date = forms.iter().find_map(of_date).or_else(|| {
        let time = NaiveTime::parse_from_str(&text, "%H:%M:%S%.f").ok()?;
        Some(NaiveDate::from_ymd_opt(1970, 1, 1)?.and_time(time))
    })?;
    date.and_utc().timestamp_nanos_opt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times(texts: &[&str], scale: f64) -> (Vec<f64>, f64) {
        let mut stamps = Stamps::default();
        let number = |text: &str| text.parse().map_err(|_| Problem::NotANumber(text.into()));
        let time = |text: &&str| stamps.time_s(text.as_bytes(), number(text), scale).expect("a time");
        (texts.iter().map(time).collect(), stamps.origin_s(scale))
    }

    #[test]
    fn unix_times_count_from_the_first_without_loss_of_digits() {
        assert_eq!(
            times(&["1767225600.000", "1767225600.001", "1767225602"], 1.0),
            (vec![0.0, 0.001, 2.0], 1767225600.0)
        );
        assert_eq!(
            times(&["1767225600000000000", "1767225600001000001"], 1e-9),
            (vec![0.0, 0.001000001], 1767225600.0)
        );
        assert_eq!(times(&["1767225600000", "1767225600500"], 1e-3), (vec![0.0, 0.5], 1767225600.0));
        assert_eq!(times(&["3.5", "4"], 1.0), (vec![3.5, 4.0], 0.0));
    }

    #[test]
    fn dates_count_from_the_first() {
        for dates in [
            ["2026-01-01T00:00:00.000", "2026-01-01T00:00:00.250"],
            ["2026-01-01T00:00:00.000Z", "2026-01-01T01:00:00.250+01:00"],
            ["2026-01-01 00:00:00", "2026-01-01 00:00:00.25"],
            ["2026-01-01 00:00:00+00", "2026-01-01 00:00:00.25+00"],
            ["2026/01/01 00:00:00", "2026/01/01 00:00:00,25"],
            ["01.01.2026 00:00:00,00", "01.01.2026 00:00:00,25"],
        ] {
            assert_eq!(times(&dates, 1.0), (vec![0.0, 0.25], 1767225600.0), "{dates:?}");
        }
        assert_eq!(times(&["10:00:00.5", "10:00:01"], 1.0).0, [0.0, 0.5]);
        assert_eq!(written(1767225600.25).as_deref(), Some("2026-01-01 00:00:00.250 UTC"));
        assert_eq!(written(36000.5).as_deref(), Some("10:00:00.500"));
        assert!(!is_date("2026-01-01") && !is_date("a:b:c") && !is_date("1.5"));
    }

    #[test]
    fn nanoseconds_given_as_seconds_are_refused() {
        let mut stamps = Stamps::default();
        let refusal = stamps.time_s(b"1767225600000000000", Ok(1.7672256e18), 1.0).expect_err("refused").to_string();
        assert!(refusal.contains("give its unit"), "{refusal}");
    }
}
