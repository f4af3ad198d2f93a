//! The signals of a file, and their possible roles: time, position, velocity and force.

use super::{Column, Quantity};

/// A signal of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Signal {
    /// Name, as accepted by flags and keys.
    pub name: String,
    /// Description in the file.
    pub label: Option<String>,
    /// Unit, as stated by the file or the name.
    pub unit: Option<String>,
    /// Size of the array.
    pub shape: Vec<usize>,
    /// Number of samples.
    pub samples: usize,
    /// The minimum and maximum sample; `None` without a finite sample.
    pub range: Option<(f64, f64)>,
    /// Number of samples that are not finite.
    pub undefined: usize,
    /// Time from the first sample to the last in the signal's unit, if it increases strictly.
    pub increase: Option<f64>,
    /// The quantity indicated by name and unit.
    pub role: Option<Quantity>,
}

/// Streaming statistics of the samples of a signal.
#[derive(Debug, Clone, Default)]
pub(super) struct Statistics {
    samples: usize,
    undefined: usize,
    range: Option<(f64, f64)>,
    ends: Option<(f64, f64)>,
    falls: bool,
}

impl Statistics {
    pub(super) fn push(&mut self, value: f64) {
        self.samples += 1;
        if !value.is_finite() {
            self.undefined += 1;
            return;
        }
        let (low, high) = self.range.unwrap_or((value, value));
        self.range = Some((low.min(value), high.max(value)));
        let (first, last) = self.ends.unwrap_or((value, f64::NEG_INFINITY));
        self.falls |= value <= last;
        self.ends = Some((first, value));
    }

    pub(super) fn has_number(&self) -> bool {
        self.range.is_some()
    }
}

impl Signal {
    pub(super) fn new(
        name: String,
        label: Option<String>,
        unit: Option<String>,
        shape: Vec<usize>,
        statistics: Statistics,
    ) -> Self {
        let unit = unit.or_else(|| unit_of(&name)).or_else(|| label.as_deref().and_then(unit_in_text));
        let Statistics { samples, undefined, range, ends, falls } = statistics;
        let increases = !falls && undefined == 0 && samples > 1;
        let increase = ends.filter(|_| increases).map(|(first, last)| last - first);
        let role = role(&name, label.as_deref(), unit.as_deref(), increase.is_some());
        Self { name, label, unit, shape, samples, range, undefined, increase, role }
    }

    /// The signal as a column, with its unit if that is a unit of its quantity.
    #[must_use]
    pub fn column(&self) -> String {
        let unit = self.unit.as_deref().filter(|unit| self.role.is_some_and(|role| is_unit(unit, role)));
        match unit {
            Some(unit) => format!("{}:{unit}", self.name),
            // The text after the last colon must not be read as a factor.
            None => Column::new(&self.name, 1.0).map_or_else(|_| self.name.clone(), |column| column.to_string()),
        }
    }
}

/// Other words for a quantity, in lower case, separated by spaces.
fn words(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Time => "t times timestamp seconds sec zeit temps tiempo tempo",
        Quantity::Position => "x z xs pos positions depth displacement disp distance stroke insertion travel weg tiefe",
        Quantity::Velocity => "v vs vel velocities speed geschwindigkeit vitesse",
        Quantity::Force => "f fz forces load kraft effort fuerza forza",
    }
}

/// Returns true if a text is a unit of a quantity, one of [`Quantity::units`].
fn is_unit(text: &str, quantity: Quantity) -> bool {
    quantity.units().split([',', ' ']).any(|unit| unit != "or" && !unit.is_empty() && unit == text)
}

/// Returns true if a text is a unit as files write it below or beside the name of a column: `mm`, `[N]`, `(s)`.
pub(super) fn is_known_unit(text: &str) -> bool {
    let text = text.trim().trim_matches(['[', ']', '(', ')']);
    Quantity::ALL.into_iter().any(|quantity| is_unit(text, quantity))
        || ["rad", "deg", "Nm", "V", "mV", "A"].contains(&text)
}

/// The unit in brackets in a text: "Lever positions (rad), master".
fn unit_in_text(text: &str) -> Option<String> {
    let inside = text.split(['(', '[']).skip(1).filter_map(|rest| rest.split([')', ']', ' ', ',']).next());
    inside.map(str::to_owned).find(|unit| is_known_unit(unit))
}

/// The unit in a name: `x (mm)`, `x [mm]`, `x_mm`, `v_mm_per_s`.
fn unit_of(name: &str) -> Option<String> {
    for (open, close) in [('(', ')'), ('[', ']')] {
        let inside = name.trim_end().strip_suffix(close).and_then(|rest| rest.rsplit_once(open));
        if let Some((_, unit)) = inside.filter(|(_, unit)| unit.chars().next().is_some_and(char::is_alphabetic)) {
            return Some(unit.trim().to_owned());
        }
    }
    // A rate such as rad_s is not in seconds.
    let (base, per) = match name.strip_suffix("_per_s").or_else(|| name.strip_suffix("_s")) {
        Some(rest) => (rest, true),
        None => (name, false),
    };
    let last = |text: &str| text.rsplit_once('_').map(|(_, last)| last.to_owned());
    let lengths = ["m", "cm", "mm", "um"];
    if per {
        return match last(base) {
            Some(unit) if lengths.contains(&unit.as_str()) => Some(format!("{unit}/s")),
            Some(unit) if ["rad", "deg"].contains(&unit.as_str()) => Some(format!("{unit}/s")),
            _ => Some("s".into()),
        };
    }
    let unit = last(base)?;
    let forces = ["N", "kN", "cN", "mN", "gf", "kgf"];
    let known = ["ms", "us", "ns", "min"].iter().chain(&lengths).chain(&forces).find(|known| **known == unit);
    match (known, unit.as_str()) {
        (Some(known), _) => Some((*known).to_owned()),
        (None, "n") => Some("N".into()),
        (None, "rad" | "deg" | "Nm" | "V") => Some(unit),
        _ => None,
    }
}

/// The quantity indicated by the words of a name or label and by the unit. Only a strictly increasing signal can be a
/// time.
fn role(name: &str, label: Option<&str>, unit: Option<&str>, increases: bool) -> Option<Quantity> {
    let of_unit = unit.and_then(|unit| Quantity::ALL.into_iter().find(|quantity| is_unit(unit, *quantity)));
    let own = name.rsplit(['.', '/', '!']).next().unwrap_or(name);
    let of_text = |text: &str| {
        let text = text.to_lowercase();
        if text == "x_value" || text.starts_with("time(") {
            return Some(Quantity::Time);
        }
        let is_word = |quantity: &Quantity| {
            text.split(|character: char| !character.is_alphanumeric())
                .any(|word| word == quantity.name() || words(*quantity).split(' ').any(|known| known == word))
        };
        // "force over time" is a force, so time is tried last.
        [Quantity::Force, Quantity::Velocity, Quantity::Position, Quantity::Time].into_iter().find(is_word)
    };
    let of_words = if name.starts_with("time(") { Some(Quantity::Time) } else { of_text(own) };
    let of_words = of_words.or_else(|| label.and_then(of_text));
    let role = match (of_words, of_unit) {
        (Some(words), Some(unit)) if words == unit => words,
        // A unit of another quantity, such as an angle or a torque, needs a factor.
        (Some(words), None) if unit.is_none() => words,
        (_, Some(unit)) => unit,
        _ => return None,
    };
    (role != Quantity::Time || increases).then_some(role)
}

/// Creates signals from names alone, with the roles that names and units indicate; each could be a time. They allow
/// reading a file with invalid samples, to report the error in them.
#[must_use]
pub fn signals_by_name(names: &[String]) -> Vec<Signal> {
    let of = |name: &String| {
        let mut statistics = Statistics::default();
        [0.0, 1.0].into_iter().for_each(|value| statistics.push(value));
        Signal::new(name.clone(), None, None, vec![2], statistics)
    };
    names.iter().map(of).collect()
}

/// The signals by their possible roles.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Roles {
    /// For each quantity, in the order of [`Quantity::ALL`], the indices of its candidates with as many samples as the
    /// first time.
    pub candidates: [Vec<usize>; Quantity::ALL.len()],
}

impl Roles {
    /// Sorts signals by their roles. A position, a velocity or a force needs as many samples as the time.
    #[must_use]
    pub fn of(signals: &[Signal]) -> Self {
        let mut roles = Self::default();
        let with = |quantity: Quantity| {
            signals.iter().enumerate().filter(move |(_, signal)| signal.role == Some(quantity) && signal.undefined == 0)
        };
        // The first time with a position and a force of the same length.
        let serves = |samples: usize| {
            [Quantity::Position, Quantity::Force]
                .into_iter()
                .all(|quantity| with(quantity).any(|(_, s)| s.samples == samples))
        };
        let Some(samples) = with(Quantity::Time)
            .map(|(_, time)| time.samples)
            .find(|samples| serves(*samples))
            .or_else(|| with(Quantity::Time).map(|(_, time)| time.samples).next())
        else {
            return roles;
        };
        for quantity in Quantity::ALL {
            let same = with(quantity).filter(|(_, signal)| signal.samples == samples);
            roles.candidates[quantity as usize] = same.map(|(index, _)| index).collect();
        }
        roles
    }

    /// The first candidate of a quantity.
    #[must_use]
    pub fn first(&self, quantity: Quantity) -> Option<usize> {
        self.candidates[quantity as usize].first().copied()
    }

    /// Returns true if time, position and force have exactly one candidate each, and the velocity at most one.
    #[must_use]
    pub fn are_unique(&self) -> bool {
        Quantity::ALL.into_iter().all(|quantity| match self.candidates[quantity as usize].len() {
            0 => quantity == Quantity::Velocity,
            count => count == 1,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn signal(name: &str, unit: Option<&str>, values: &[f64]) -> Signal {
        let mut statistics = Statistics::default();
        values.iter().for_each(|value| statistics.push(*value));
        Signal::new(name.into(), None, unit.map(Into::into), vec![values.len()], statistics)
    }

    #[test]
    fn names_and_units_give_roles() {
        let rising = [0.0, 1.0, 2.0];
        for (name, unit, role, column) in [
            ("time_s", None, Some(Quantity::Time), "time_s:s"),
            ("t (ms)", None, Some(Quantity::Time), "t (ms):ms"),
            ("position_m", None, Some(Quantity::Position), "position_m:m"),
            ("x_mm", None, Some(Quantity::Position), "x_mm:mm"),
            ("velocity_m_per_s", None, Some(Quantity::Velocity), "velocity_m_per_s:m/s"),
            ("force_n", None, Some(Quantity::Force), "force_n:N"),
            ("/needle/Force [N]", None, Some(Quantity::Force), "/needle/Force [N]:N"),
            ("channel 3", Some("mN"), Some(Quantity::Force), "channel 3:mN"),
            ("xs_rad", None, None, "xs_rad"),
            ("vs_rad_s", None, None, "vs_rad_s"),
            ("tau_e_Nm", None, None, "tau_e_Nm"),
            ("scope.time", None, Some(Quantity::Time), "scope.time"),
            ("force", None, Some(Quantity::Force), "force"),
            ("note", None, None, "note"),
        ] {
            let signal = signal(name, unit, &rising);
            assert_eq!((signal.role, signal.column().as_str()), (role, column), "{name}");
        }
        assert_eq!(signal("time_s", None, &[0.0, 0.0]).role, None, "a time increases");
    }

    #[test]
    fn statistics_ignore_values_that_are_not_finite() {
        let signal = signal("a", None, &[1.0, f64::NAN, -2.0]);
        assert_eq!((signal.samples, signal.undefined, signal.range, signal.increase), (3, 1, Some((-2.0, 1.0)), None));
    }

    #[test]
    fn roles_are_unique_if_each_has_one_candidate() {
        let rising = [0.0, 1.0, 2.0];
        let mut signals = vec![signal("t", None, &rising), signal("x", None, &rising), signal("f", None, &rising)];
        assert!(Roles::of(&signals).are_unique());
        signals.push(signal("force", None, &rising[..2]));
        assert!(Roles::of(&signals).are_unique(), "another length is another clock");
        signals.push(signal("force", None, &rising));
        let roles = Roles::of(&signals);
        assert!(!roles.are_unique());
        assert_eq!(roles.candidates[Quantity::Force as usize], [2, 4]);
        assert!(!Roles::of(&signals[..2]).are_unique());
    }
}
