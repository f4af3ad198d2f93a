use std::collections::HashSet;

use super::{Column, Quantity, units};

#[derive(Debug, Clone, PartialEq)]
pub struct Signal {
    pub name: String,
    pub label: Option<String>,
    pub unit: Option<String>,
    pub shape: Vec<usize>,
    pub samples: usize,
    pub range: Option<(f64, f64)>,
    pub undefined: usize,
    /// In the signal's unit, if the values increase strictly.
    pub increase: Option<f64>,
    pub role: Option<Quantity>,
}

#[derive(Debug, Clone, Default)]
pub(super) struct Statistics {
    samples: usize,
    undefined: usize,
    range: Option<(f64, f64)>,
    ends: Option<(f64, f64)>,
    falls: bool,
    repeats: bool,
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
        self.falls |= value < last;
        self.repeats |= value == last;
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
        let unit = unit.or_else(|| units::of_name(&name)).or_else(|| label.as_deref().and_then(units::in_text));
        let Statistics { samples, undefined, range, ends, falls, repeats } = statistics;
        let never_falls = !falls && undefined == 0 && samples > 1;
        let increase = ends.filter(|_| never_falls && !repeats).map(|(first, last)| last - first);
        let rises = ends.is_some_and(|(first, last)| last > first);
        let role = role(&name, label.as_deref(), unit.as_deref(), never_falls && rises);
        Self { name, label, unit, shape, samples, range, undefined, increase, role }
    }

    pub fn column(&self) -> String {
        let unit = self.unit.as_deref().filter(|unit| self.role.is_some() && units::quantity(unit) == self.role);
        match unit {
            Some(unit) => format!("{}:{}", self.name, units::accepted(unit)),
            // The text after the last colon must not be read as a factor.
            None => Column::new(&self.name, 1.0).map_or_else(|_| self.name.clone(), |column| column.to_string()),
        }
    }
}

fn words(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Time => "t times timestamp stamp elapsed seconds sec",
        Quantity::Position => "x z xs pos positions depth displacement distance travel extension",
        Quantity::Velocity => "v vs vel velocities speed twist",
        Quantity::Force => "f fx fy fz forces load effort",
    }
}

/// In lower case. A signal with one of them has no role.
const OTHER_WORDS: &str = "torque torques moment moments tau mx my mz angle angles angular rotation orientation \
    quaternion roll pitch yaw accel acceleration covariance temperature current voltage pressure stress strain \
    stiffness energy power index seq frame_id";

/// The rest of the path names the quantity.
const AXES: &str = "x y z data value values";

/// In lower case: `NeedleForce_2` has the words needle and force.
fn words_of(text: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut before_is_small = false;
    for character in text.chars() {
        if !character.is_alphabetic() || before_is_small && character.is_uppercase() {
            words.push(String::new());
        }
        before_is_small = character.is_lowercase();
        if character.is_alphabetic()
            && let Some(word) = words.last_mut()
        {
            word.extend(character.to_lowercase());
        }
    }
    words.retain(|word| !word.is_empty());
    words
}

fn of_text(text: &str) -> Result<Option<Quantity>, ()> {
    let lower = text.to_lowercase();
    if lower == "x_value" || lower.starts_with("time(") {
        return Ok(Some(Quantity::Time));
    }
    // Brackets contain a unit.
    let words_of_text = words_of(text.split(['(', '[']).next().unwrap_or(text));
    let has = |known: &str| words_of_text.iter().any(|word| known.split_whitespace().any(|known| known == word));
    if has(OTHER_WORDS) {
        return Err(());
    }
    // "force over time" is a force, so time is tried last.
    let order = [Quantity::Force, Quantity::Velocity, Quantity::Position, Quantity::Time];
    Ok(order.into_iter().find(|quantity| has(quantity.name()) || has(words(*quantity))))
}

/// The end of the path decides, or the part before it if the end is an axis: `/wrench.force.z` is a force.
fn of_path(name: &str) -> Result<Option<Quantity>, ()> {
    let mut parts = name.rsplit(['.', '/', '!']);
    let last = parts.next().unwrap_or(name);
    let found = of_text(last)?;
    let is_axis = words_of(last).iter().all(|word| AXES.split(' ').any(|axis| axis == word));
    if !is_axis {
        return Ok(found);
    }
    for part in parts {
        if let Some(quantity) = of_text(part)? {
            return Ok(Some(quantity));
        }
    }
    Ok(found)
}

/// A time never decreases. A signal of another quantity, such as a torque, has no role, whatever its axis.
fn role(name: &str, label: Option<&str>, unit: Option<&str>, may_be_time: bool) -> Option<Quantity> {
    let of_unit = unit.and_then(units::quantity);
    let of_words = of_path(name).ok()?;
    let of_words = match (of_words, label) {
        (None, Some(label)) => of_text(label).ok()?,
        (words, _) => words,
    };
    let role = match (of_words, of_unit) {
        // A unit of another quantity needs a factor.
        (Some(words), None) if unit.is_none() => words,
        (_, Some(unit)) => unit,
        _ => return None,
    };
    (role != Quantity::Time || may_be_time).then_some(role)
}

/// Signals from names alone; each could be a time. They allow reading a file with invalid samples, to report the error
/// in them.
pub fn signals_by_name(names: &[String]) -> Vec<Signal> {
    let of = |name: &String| {
        let mut statistics = Statistics::default();
        [0.0, 1.0].into_iter().for_each(|value| statistics.push(value));
        Signal::new(name.clone(), None, None, vec![2], statistics)
    };
    names.iter().map(of).collect()
}

const LOG_TIME: &str = ".log_time";

const PLAUSIBLE: [(Quantity, f64); 2] = [(Quantity::Position, 2.0), (Quantity::Force, 5000.0)];

impl Signal {
    /// True if the range is not that of the role in SI units, and no unit is stated: a position from 0 to 55 is hardly
    /// in metres.
    pub fn needs_unit(&self) -> bool {
        let Some((low, high)) = self.range else { return false };
        self.unit.is_none() && PLAUSIBLE.iter().any(|(role, span)| self.role == Some(*role) && high - low > *span)
    }
}

fn topic_of<'a>(name: &'a str, topics: &HashSet<&str>) -> Option<&'a str> {
    if topics.is_empty() {
        return None;
    }
    let ends = name.match_indices('.').map(|(at, _)| &name[..at]);
    ends.rev().find(|topic| topics.contains(topic))
}

#[derive(Debug, Clone, PartialEq, Default)]
pub struct Roles {
    pub candidates: [Vec<usize>; Quantity::ALL.len()],
}

impl Roles {
    /// Signals by role. A position, a velocity or a force needs the clock of the time: as many samples, and in a log
    /// the same topic. If no topic has both a position and a force, the time is the log time, to which all topics are
    /// joined. Constant signals are candidates only if all are constant.
    pub fn of(signals: &[Signal]) -> Self {
        let mut roles = Self::default();
        let with = |quantity: Quantity| {
            let serves =
                move |signal: &Signal| signal.role == Some(quantity) && signal.undefined == 0 && !signal.needs_unit();
            signals.iter().enumerate().filter(move |(_, signal)| serves(signal))
        };
        let topics: HashSet<&str> = signals.iter().filter_map(|signal| signal.name.strip_suffix(LOG_TIME)).collect();
        let clocks: Vec<(usize, Option<&str>)> =
            signals.iter().map(|signal| (signal.samples, topic_of(&signal.name, &topics))).collect();
        let is_of_clock = |signal: usize, clock: usize| clocks[signal] == clocks[clock];
        let clocks_with = |quantity| with(quantity).map(|(index, _)| clocks[index]).collect::<HashSet<_>>();
        let (positions, forces) = (clocks_with(Quantity::Position), clocks_with(Quantity::Force));
        let serves = |clock: &usize| positions.contains(&clocks[*clock]) && forces.contains(&clocks[*clock]);
        let times = || with(Quantity::Time).map(|(index, _)| index);
        let clock = times().find(serves);
        let is_joined = clock.is_none() && topics.len() > 1;
        let clock = clock
            .or_else(|| times().find(|time| !is_joined || signals[*time].name.ends_with(LOG_TIME)))
            // Without a time, a rate is given.
            .or_else(|| with(Quantity::Position).map(|(index, _)| index).find(serves));
        let Some(clock) = clock else { return roles };
        for quantity in Quantity::ALL {
            let is_candidate = |signal: &usize| match quantity {
                Quantity::Time if is_joined => *signal == clock,
                _ => is_joined || is_of_clock(*signal, clock),
            };
            let mut found: Vec<usize> = with(quantity).map(|(index, _)| index).filter(is_candidate).collect();
            let varies = |index: &usize| signals[*index].range.is_some_and(|(low, high)| low < high);
            if found.iter().any(varies) {
                found.retain(varies);
            }
            // Preferred to the time of logging.
            let is_logged = |index: &usize| signals[*index].name.ends_with(LOG_TIME);
            if quantity == Quantity::Time && !found.iter().all(is_logged) {
                found.retain(|index| !is_logged(index));
            }
            roles.candidates[quantity as usize] = found;
        }
        roles
    }

    pub fn first(&self, quantity: Quantity) -> Option<usize> {
        self.candidates[quantity as usize].first().copied()
    }

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
            ("torque_z", None, None, "torque_z"),
            ("torque_z", Some("N"), None, "torque_z"),
            ("/wrench.wrench.force.z", None, Some(Quantity::Force), "/wrench.wrench.force.z"),
            ("/wrench.wrench.torque.z", None, None, "/wrench.wrench.torque.z"),
            ("/pose.pose.position.z", None, Some(Quantity::Position), "/pose.pose.position.z"),
            ("/pose.pose.orientation.x", None, None, "/pose.pose.orientation.x"),
            ("/force.data", None, Some(Quantity::Force), "/force.data"),
            ("load_g", None, Some(Quantity::Force), "load_g:gf"),
            ("Load (µN)", None, Some(Quantity::Force), "Load (µN):uN"),
            ("Depth (nm)", None, Some(Quantity::Position), "Depth (nm):nm"),
            ("NeedleForce", None, Some(Quantity::Force), "NeedleForce"),
            ("timestamp", None, Some(Quantity::Time), "timestamp"),
            ("timestamp_ns", None, Some(Quantity::Time), "timestamp_ns:ns"),
        ] {
            let signal = signal(name, unit, &rising);
            assert_eq!((signal.role, signal.column().as_str()), (role, column), "{name}");
        }
        assert_eq!(signal("time_s", None, &[0.0, 0.0]).role, None, "a time increases");
        assert_eq!(signal("time_s", None, &[1.0, 0.0]).role, None, "a time increases");
        let repeated = signal("Time (sec)", None, &[0.0, 0.0, 1.0]);
        assert_eq!((repeated.role, repeated.column().as_str()), (Some(Quantity::Time), "Time (sec):s"));
    }

    #[test]
    fn statistics_ignore_values_that_are_not_finite() {
        let signal = signal("a", None, &[1.0, f64::NAN, -2.0]);
        assert_eq!((signal.samples, signal.undefined, signal.range, signal.increase), (3, 1, Some((-2.0, 1.0)), None));
    }

    #[test]
    fn signals_of_two_topics_have_the_log_time() {
        let (slow, fast) = ([0.0, 1.0, 2.0], [0.0, 0.5, 1.0, 1.5]);
        let signals = [
            signal("/a.stamp", None, &slow),
            signal("/a.position.x", None, &[0.0; 3]),
            signal("/a.position.z", None, &slow),
            signal("/a.log_time", Some("s"), &slow),
            signal("/b.force.z", None, &fast),
            signal("/b.log_time", Some("s"), &fast),
        ];
        let roles = Roles::of(&signals);
        assert!(roles.are_unique(), "{roles:?}");
        assert_eq!(roles.candidates, [vec![3], vec![2], vec![], vec![4]]);
    }

    #[test]
    fn a_position_of_many_metres_without_a_unit_is_not_guessed() {
        let time = signal("t", None, &[0.0, 1.0]);
        let signals = |position: Signal| [time.clone(), position, signal("load", None, &[0.0, 9.0])];
        assert!(Roles::of(&signals(signal("extension", None, &[0.0, 0.055]))).are_unique());
        assert!(Roles::of(&signals(signal("extension", Some("mm"), &[0.0, 55.0]))).are_unique());
        assert!(!Roles::of(&signals(signal("extension", None, &[0.0, 55.0]))).are_unique());
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
