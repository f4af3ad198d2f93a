use super::{Axis, Parameter, Spacing};
use trocar_scenario::{Kind, Range, Value, find_key, nearest_of, parse_number, unit_of};

const MAX_VALUES: usize = 2000;

const LOGARITHMIC_RATIO: f64 = 50.0;

const SYNTAX: &str = "write KEY=LOW:HIGH:COUNT, as in scaling.force=0.1:10:200";

impl Axis {
    /// Parses `KEY=LOW:HIGH:COUNT[:log|:linear]`.
    pub fn parse(text: &str) -> Result<Self, String> {
        let (key, range) = text.split_once('=').ok_or_else(|| SYNTAX.to_owned())?;
        let key = key.trim();
        let parameter = Parameter::of_key(key).ok_or_else(|| {
            let known: Vec<&str> = Parameter::all().map(Parameter::key).collect();
            let nearest = nearest_of(key, known.iter().copied());
            let nearest = nearest.map_or(".".to_owned(), |nearest| format!("; did you mean {nearest}?"));
            format!("the loop has no parameter {key}{nearest} The parameters are {}", known.join(", "))
        })?;
        let parts: Vec<&str> = range.split(':').map(str::trim).collect();
        let [low, high, count, spacing @ ..] = parts.as_slice() else {
            return Err(SYNTAX.to_owned());
        };
        let number = |text: &str| {
            let unit = unit_of(parameter.key());
            let value = unit.map_or_else(|| text.parse().ok(), |unit| parse_number(text, &unit).ok());
            let kind = find_key(parameter.key()).map_or(Kind::Number(Range::NON_NEGATIVE), |key| key.kind);
            let is_accepted = |value: &f64| Value::accept(&kind, &toml::Value::Float(*value)).is_some();
            value.filter(is_accepted).ok_or_else(|| format!("{text:?} is not {kind}"))
        };
        let (low, high) = (number(low)?, number(high)?);
        if low >= high {
            return Err(format!("{low} is not below {high}; write the smaller value first"));
        }
        let count: usize =
            count.parse().ok().filter(|count| (2..=MAX_VALUES).contains(count)).ok_or_else(|| {
                format!("{count:?} is not a valid count, must be a whole number from 2 to {MAX_VALUES}")
            })?;
        let spacing = match *spacing {
            [] if low > 0.0 && high >= LOGARITHMIC_RATIO * low => Spacing::Logarithmic,
            [] | ["linear"] => Spacing::Linear,
            ["log"] if low > 0.0 => Spacing::Logarithmic,
            ["log"] => return Err("a logarithmic axis begins above 0".into()),
            _ => return Err("after the count, only :log or :linear is allowed".into()),
        };
        Ok(Axis { parameter, low, high, count, spacing })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_is_parsed_from_its_text() {
        let axis = Axis::parse("scaling.force = 0.1 : 10 : 200").expect("good");
        assert_eq!((axis.low, axis.high, axis.count, axis.spacing), (0.1, 10.0, 200, Spacing::Logarithmic));
        assert_eq!(Axis::parse("scaling.force=0.1:10:200:linear").expect("good").spacing, Spacing::Linear);
        assert_eq!(Axis::parse("scaling.force=1:2:5").expect("good").spacing, Spacing::Linear);
    }

    #[test]
    fn an_invalid_axis_is_rejected_with_the_reason() {
        for (text, reason) in [
            ("scaling.force", SYNTAX),
            ("scaling.force=1:2", SYNTAX),
            ("scaling.force=2:1:5", "not below"),
            ("scaling.force=1:2:1", "from 2 to 2000"),
            ("scaling.force=nan:2:5", "\"nan\" is not"),
            ("channel.forward_delay_s=0:1:5:log", "begins above 0"),
            ("scaling.force=1:2:5:square", ":log or :linear"),
            ("scaling.forse=1:2:5", "did you mean scaling.force?"),
        ] {
            assert!(Axis::parse(text).expect_err(text).contains(reason), "{text}");
        }
    }
}
