//! The value of every key, with its place in the file.

use std::collections::{BTreeMap, HashMap};
use std::fmt::Write as _;
use std::path::PathBuf;
use std::sync::Arc;

use trocar_core::settings::{self, ActsFor, Fallback, Key, KeySource as _, Kind};

use super::document::{Entry, Source, drop_replaced_layers, gather};
use super::error::{Place, ScenarioError};
use super::key_table::{KEYS, SECTIONS};
use super::keys::{KeyAt, find, is_section, nearest, nearest_of};
use super::layers::{ANY, field, is_name, is_of_layer, key_of, split};
use super::quantity;
use super::value::Value;
use trocar_base::names;
use trocar_core::detector::DistanceKind;
use trocar_core::error::InvalidValue;
use trocar_engine::channel::DelaySettings;
use trocar_engine::operator::MotionSettings;
use trocar_engine::tissue::{LAYER_KEYS, LAYER_LIST, ReplayIndex, ReplaySettings, TissueSettings, path_in_layer};

pub(super) const STATED: [&str; 2] = ["tissue.stiffness_n_per_m", "tissue.damping_n_s_per_m"];

const TISSUE: &str = "tissue";

const TICK: &str = "simulation.tick_s";

/// Any other written detector key selects another detector.
const OF_ADAPTIVE: [&str; 5] = [
    "detector.false_alarms_per_min",
    "detector.motion",
    "detector.withdrawal_speed_m_per_s",
    "detector.insertion_speed_m_per_s",
    "detector.minimum_depth_m",
];

const OF_RECORDINGS: [&str; 4] = ["estimator.", "detector.", "sensor.", "recording."];

#[derive(Debug, Clone)]
struct Given {
    value: Value,
    place: Option<Place>,
    /// Paths are relative to it.
    source: Option<Source>,
    /// See [`Entry::layer`].
    layer: usize,
}

impl Given {
    fn default_of(value: Value) -> Self {
        Self { value, place: None, source: None, layer: 0 }
    }
}

/// A written list of layers, from the surface down.
#[derive(Debug, Clone)]
struct LayerList {
    names: Vec<Arc<str>>,
    place: Place,
    /// See [`Entry::layer`].
    layer: usize,
}

/// Keys without a value are absent.
#[derive(Debug, Clone, Default)]
pub struct Values {
    given: HashMap<&'static str, Given>,
    of_layers: BTreeMap<Arc<str>, HashMap<&'static str, Given>>,
    list: Option<LayerList>,
    /// From the surface down: as written, or the default of the kind.
    names: Vec<Arc<str>>,
    visited: Option<Arc<str>>,
}

impl Values {
    /// The settings override the file.
    pub fn load(source: &Source, settings: &[String]) -> Result<Self, ScenarioError> {
        Self::load_changed(source, &[settings])
    }

    /// A later list may change kinds.
    pub fn load_changed(source: &Source, settings: &[&[String]]) -> Result<Self, ScenarioError> {
        Self::of_entries(source, gather(source, settings)?)
    }

    /// The nearest entries come first.
    pub(super) fn of_entries(source: &Source, mut entries: Vec<Entry>) -> Result<Self, ScenarioError> {
        let mut values = Self::default();
        drop_replaced_layers(&mut entries);
        let refused = entries.into_iter().filter_map(|entry| values.take_or_refuse(entry).err());
        // Suggestions compare with all keys, so they are sought only for the errors that are shown.
        ScenarioError::all_by(refused.collect(), Refused::place, Refused::error)?;
        if !values.is_given("name") {
            values.derive("name", Value::Text(harmless_name(&source.stem())));
        }
        values.fill_defaults();
        Ok(values)
    }

    /// For the detection on a recording, which needs no scenario file.
    pub fn from_settings(name: &str, settings: &[String]) -> Result<Self, ScenarioError> {
        let mut values = Self::default();
        for setting in settings.iter().rev() {
            for entry in super::document::parse_setting(setting)? {
                if find(&entry.path).is_some() && !OF_RECORDINGS.iter().any(|begin| entry.path.starts_with(begin)) {
                    let message = format!("{} has no effect on a recording", entry.path);
                    let error = ScenarioError::new(message).at(Some(entry.key_place));
                    let acting = OF_RECORDINGS.map(|begin| format!("{begin}…")).join(", ");
                    return Err(error.remedy(format!("leave it out; these keys have one: {acting}")));
                }
                values.take(entry)?;
            }
        }
        values.derive("name", Value::Text(harmless_name(name)));
        values.fill_defaults();
        Ok(values)
    }

    pub(super) fn take(&mut self, entry: Entry) -> Result<(), ScenarioError> {
        self.take_or_refuse(entry).map_err(Refused::error)
    }

    fn take_or_refuse(&mut self, entry: Entry) -> Result<(), Refused> {
        if entry.path == LAYER_LIST {
            return Ok(self.take_layers(&entry)?);
        }
        let Some(key) = find(&entry.path) else { return Err(Refused::Unknown(Box::new(entry))) };
        let Some(value) = Value::of_key(&key, &entry.value) else {
            let unit = quantity::unit_of(&key.path).filter(|_| matches!(key.kind, Kind::Number(_)));
            let reason = match (entry.value.as_str(), unit) {
                (Some(text), Some(unit)) => quantity::parse(text, &unit).err(),
                _ => None,
            };
            let message = format!("{} is {}, must be {}", key.path, entry.written, key.kind);
            let mut error = ScenarioError::new(message).at(Some(entry.value_place));
            if let Some(reason) = reason {
                error = error.remedy(reason);
            }
            if let (Kind::Choice(words), Some(word)) = (key.kind, entry.value.as_str()) {
                let best = words.iter().max_by(|a, b| similarity(word, a).total_cmp(&similarity(word, b)));
                if let Some(best) = best.filter(|best| similarity(word, best) > 0.7) {
                    error = error.remedy(format!("did you mean \"{best}\"?"));
                }
            }
            return Err(error.into());
        };
        // The nearest layer comes first.
        let both = self.given.get(DelaySettings::BOTH);
        if DelaySettings::is_one_way(key.key.path) && both.is_some_and(|both| both.layer < entry.layer) {
            return Ok(());
        }
        let given = Given { value, place: Some(entry.value_place), source: Some(entry.source), layer: entry.layer };
        self.keep_first(&key, given);
        Ok(())
    }

    fn slot(&self, path: &str) -> Option<&Given> {
        match split(path) {
            None => self.given.get(path),
            Some((ANY, _)) => self.of_layers.get(self.visited.as_deref()?)?.get(path),
            Some((name, wanted)) => self.of_layers.get(name)?.get(key_of(wanted)?.path),
        }
    }

    fn slot_mut(&mut self, path: &str) -> Option<&mut Given> {
        let Some((name, wanted)) = split(path) else { return self.given.get_mut(path) };
        self.of_layers.get_mut(name)?.get_mut(key_of(wanted)?.path)
    }

    fn keep_first(&mut self, key: &KeyAt, given: Given) {
        let slots = match split(&key.path) {
            Some((name, _)) => self.of_layers.entry(name.into()).or_default(),
            None => &mut self.given,
        };
        slots.entry(key.key.path).or_insert(given);
    }

    fn take_layers(&mut self, entry: &Entry) -> Result<(), ScenarioError> {
        let items = entry.value.as_array().filter(|items| !items.is_empty());
        let name = |item: &toml::Value| item.as_str().filter(|name| is_name(name)).map(Arc::from);
        let Some(names) = items.and_then(|items| items.iter().map(name).collect::<Option<Vec<_>>>()) else {
            let message = format!("{LAYER_LIST} is {}, must be a list of layers", entry.written);
            let remedy = format!("write [[{LAYER_LIST}]] and its keys below, for each layer");
            return Err(ScenarioError::new(message).at(Some(entry.key_place.clone())).remedy(remedy));
        };
        let list = LayerList { names, place: entry.key_place.clone(), layer: entry.layer };
        self.list.get_or_insert(list);
        Ok(())
    }

    /// The keys of the tissue's layers, layer by layer from the surface down; empty for a tissue without
    /// layers.
    pub fn layer_keys(&self) -> impl Iterator<Item = KeyAt> {
        let acting = || LAYER_KEYS.iter().filter(|key| self.is_acting(key));
        self.names.iter().flat_map(move |name| acting().map(|key| KeyAt::of_layer(name, key)))
    }

    fn written_of_layers(&self) -> impl Iterator<Item = (KeyAt, &Given)> {
        self.of_layers.iter().flat_map(|(name, slots)| {
            let written = |key: &'static Key| slots.get(key.path).filter(|given| given.place.is_some());
            LAYER_KEYS.iter().filter_map(move |key| Some((KeyAt::of_layer(name, key), written(key)?)))
        })
    }

    pub(super) fn check_layers(&self) -> Result<(), ScenarioError> {
        // A nearer change of the kind gives different layers or none.
        let kind = self.given.get(TissueSettings::KEY.path).filter(|given| given.place.is_some());
        let is_replaced = |given: &Given| kind.is_some_and(|kind| kind.layer < given.layer);
        let is_stray =
            |key: &KeyAt| split(&key.path).is_some_and(|(name, _)| !self.names.iter().any(|known| **known == *name));
        let Some((key, given)) = self.written_of_layers().find(|(key, given)| is_stray(key) && !is_replaced(given))
        else {
            return Ok(());
        };
        let (name, _) = split(&key.path).unwrap_or_default();
        let error = ScenarioError::new(format!("there is no layer {name} in [[{LAYER_LIST}]]")).at(given.place.clone());
        Err(error.remedy(format!("the layers are {}", self.names.join(", "))))
    }

    /// A key that acts only for other kinds is an error, unless a nearer file has changed the kind, or the command line
    /// sets the key for several scenarios and it `acts_elsewhere`.
    pub(super) fn check_acting(&self, acts_elsewhere: impl Fn(&KeyAt) -> bool) -> Result<(), ScenarioError> {
        let layer = |path: &str| self.slot(path).filter(|given| given.place.is_some()).map(|given| given.layer);
        let unmet_at = |key: &Key, written: usize| {
            let is_nearer = |acts: &ActsFor| layer(acts.key).is_some_and(|kind| kind < written);
            self.unmet(key).find(|acts| !is_nearer(acts))
        };
        let of_layers = self.written_of_layers().map(|(key, _)| key);
        let keys = KEYS.iter().map(KeyAt::from).chain(of_layers);
        let inert = keys.filter_map(|key| {
            let acts = |layer: usize| self.is_acting(&key) || layer == 0 && acts_elsewhere(&key);
            let written = layer(&key.path).filter(|layer| !acts(*layer))?;
            Some(self.without_effect(&key.path, self.place(&key.path), &unmet_at(&key, written)?))
        });
        let inert_list = self.list.iter().filter_map(|list| {
            let unmet = unmet_at(LAYER_KEYS.first()?, list.layer)?;
            Some(self.without_effect(LAYER_LIST, Some(list.place.clone()), &unmet))
        });
        // Not each key in the list.
        let list: Vec<_> = inert_list.collect();
        let is_listed = |error: &ScenarioError| !list.is_empty() && is_of_layer(&error.message);
        ScenarioError::all(inert.filter(|error| !is_listed(error)).chain(list.clone()).collect())
    }

    fn without_effect(&self, path: &str, place: Option<Place>, unmet: &ActsFor) -> ScenarioError {
        let is_switch = find(unmet.key).is_some_and(|choice| choice.kind == Kind::Flag);
        let quoted = |word: &str| if is_switch { word.to_owned() } else { format!("{word:?}") };
        let words: Vec<String> = unmet.words().iter().map(|word| quoted(word)).collect();
        let present = quoted(self.kind(unmet.key).unwrap_or_default());
        let message = format!(
            "{path} has no effect: it acts for {} = {}, which is {present} here",
            unmet.key,
            words.join(" or ")
        );
        ScenarioError::new(message).at(place).remedy(format!("remove it, or change {}", unmet.key))
    }

    pub fn is_acting(&self, key: &Key) -> bool {
        let is_stated = STATED.contains(&key.path) && self.states_tissue();
        is_stated || self.unmet(key).next().is_none()
    }

    /// True if a spring or a damper is written beside a recorded force, for the stability analysis.
    pub fn states_tissue(&self) -> bool {
        let is_written = |path: &str| self.given.get(path).is_some_and(|given| given.place.is_some());
        replays_over_time(self) && STATED.into_iter().any(is_written)
    }

    /// The conditions of a key that the present kinds do not meet.
    pub fn unmet(&self, key: &Key) -> impl Iterator<Item = ActsFor> {
        let is_met = |acts: &ActsFor| self.kind(acts.key).is_some_and(|word| acts.words().contains(&word));
        conditions(key).filter(move |acts| !is_met(acts))
    }

    fn kind(&self, path: &str) -> Option<&str> {
        match self.get(path)? {
            Value::Text(word) => Some(word),
            Value::Flag(true) => Some("true"),
            Value::Flag(false) => Some("false"),
            _ => None,
        }
    }

    pub(super) fn fill_defaults(&mut self) {
        for key in KEYS {
            if let Fallback::Value(value) = key.fallback {
                self.given.entry(key.path).or_insert_with(|| Given::default_of(value.into()));
            }
        }
        self.fill_layers();
    }

    /// Sets the layers' default values, which may be specific to a layer. Removes those of an earlier kind.
    pub(super) fn fill_layers(&mut self) {
        let of_kind = TissueSettings::default_layers(self.kind(TissueSettings::KEY.path).unwrap_or_default());
        let default_names = || of_kind.iter().map(|(name, _)| Arc::from(*name)).collect();
        self.names = self.list.as_ref().map_or_else(default_names, |list| list.names.clone());
        for slots in self.of_layers.values_mut() {
            slots.retain(|_, given| given.place.is_some());
        }
        for name in &self.names {
            let slots = self.of_layers.entry(name.clone()).or_default();
            let listed = of_kind.iter().filter(|(known, _)| self.list.is_none() && **name == **known);
            for (path, value) in listed.flat_map(|(_, values)| values) {
                slots.entry(*path).or_insert_with(|| Given::default_of(Value::Number(*value)));
            }
            for key in LAYER_KEYS {
                if let Fallback::Value(value) = key.fallback {
                    slots.entry(key.path).or_insert_with(|| Given::default_of(value.into()));
                }
            }
        }
    }

    pub(super) fn derive(&mut self, path: &'static str, value: Value) {
        self.given.insert(path, Given::default_of(value));
    }

    pub(super) fn derive_if_missing(&mut self, path: &'static str, value: Value) {
        if !self.is_given(path) {
            self.derive(path, value);
        }
    }

    /// Selects the adaptive detector, unless a written detector key requires another one: the kind, a number in its
    /// unit, or a setting that the adaptive detector does not use.
    pub fn with_adaptive_detector(mut self) -> Self {
        let written = |key: &&Key| self.place(key.path).is_some();
        if keys_of("detector").filter(written).all(|key| OF_ADAPTIVE.contains(&key.path)) {
            self.derive(DistanceKind::KEY.path, Value::Text(DistanceKind::Adaptive.word().to_owned()));
        }
        self
    }

    pub(super) fn derive_keeping_place(&mut self, path: &'static str, value: Value) {
        let place = self.place(path);
        self.given.insert(path, Given { value, place, source: None, layer: 0 });
    }

    pub(super) fn give(&mut self, key: &KeyAt, value: Value, place: Place) {
        self.keep_first(key, Given { value, place: Some(place), source: None, layer: 0 });
    }

    pub(super) fn replace(&mut self, path: &str, value: Value) {
        if let Some(given) = self.slot_mut(path) {
            given.value = value;
        }
    }

    pub(super) fn remove(&mut self, path: &str) {
        self.given.remove(path);
    }

    pub fn name(&self) -> &str {
        self.text("name").unwrap_or("scenario")
    }

    pub fn is_given(&self, path: &str) -> bool {
        self.slot(path).is_some()
    }

    pub fn get(&self, path: &str) -> Option<&Value> {
        self.slot(path).map(|given| &given.value)
    }

    pub fn place(&self, path: &str) -> Option<Place> {
        self.slot(path)?.place.clone()
    }

    pub fn error(&self, path: &str, message: impl Into<String>) -> ScenarioError {
        ScenarioError::new(message).at(self.place(path))
    }

    pub fn out_of_range(&self, error: &InvalidValue) -> ScenarioError {
        let layer = error.item.and_then(|index| self.names.get(index));
        let named = |text: &'static str| path_in_layer(text, layer.map(|name| &**name));
        let (name, requirement) = (named(error.name), named(error.requirement));
        let message = format!("{name} is {}, must be {requirement}", error.value);
        // If only the other key of a relation was written, the error is at that key.
        let of_layer = layer.into_iter().flat_map(|name| LAYER_KEYS.iter().map(|key| KeyAt::of_layer(name, key)));
        let mut related = KEYS.iter().map(KeyAt::from).chain(of_layer).filter(|key| requirement.contains(&*key.path));
        let place = self.place(&name).or_else(|| related.find_map(|key| self.place(&key.path)));
        if self.place(&name).is_none() && requirement.contains(TICK) && self.place(TICK).is_some() {
            let tick_s = settings::KeySource::optional_number(self, TICK).unwrap_or_default();
            let message = format!("{TICK} is {tick_s}, too long: {message}");
            return ScenarioError::new(message).at(place).remedy(format!("shorten the tick, or give {name}"));
        }
        ScenarioError::new(message).at(place)
    }

    /// The place of the first written key of a section.
    pub fn section_place(&self, section: &str) -> Option<Place> {
        keys_of(section).find_map(|key| self.place(key.path))
    }

    pub(super) fn text(&self, path: &str) -> Result<&str, ScenarioError> {
        match self.get(path) {
            Some(Value::Text(value)) => Ok(value),
            _ => Err(self.missing(path)),
        }
    }

    pub(super) fn file(&self, path: &str) -> Option<Source> {
        let given = self.given.get(path)?;
        let Value::Text(text) = &given.value else { return None };
        Some(given.source.as_ref().map_or_else(|| Source::parse(text), |source| source.relative(text)))
    }

    fn missing(&self, path: &str) -> ScenarioError {
        let must = find(path).map_or_else(String::new, |key| format!(", {}", key.kind));
        self.error(path, format!("{path} is missing{must}"))
    }

    /// The files on disk in the values, each as a new name and its path. The values then name files of a folder with
    /// the new names.
    pub fn take_files(&mut self) -> Vec<(String, PathBuf)> {
        let mut files = vec![];
        let acting: Vec<_> = KEYS.iter().filter(|key| matches!(key.kind, Kind::File) && self.is_acting(key)).collect();
        for key in acting {
            if let Some(path) = self.file(key.path).as_ref().and_then(Source::disk_path) {
                let name = path.file_name().unwrap_or_default().to_string_lossy();
                let name = format!("{}_{name}", key.path.replace('.', "_"));
                self.replace(key.path, Value::Text(name.clone()));
                files.push((name, path.to_owned()));
            }
        }
        files
    }

    /// The values of one section by the keys' last names.
    pub fn section_json(&self, section: &str) -> serde_json::Value {
        let entry = |key: &'static Key| {
            let name = key.path.rsplit('.').next().unwrap_or(key.path);
            let value = self.get(key.path)?;
            Some((name.to_owned(), serde_json::to_value(value.to_toml()).unwrap_or_default()))
        };
        serde_json::Value::Object(keys_of(section).filter_map(entry).collect())
    }

    /// The written values of some sections as `section.key=value` settings.
    pub fn written_settings(&self, sections: &[&str]) -> Vec<String> {
        let written = |key: &&Key| self.place(key.path).is_some();
        let setting = |key: &Key| Some(format!("{}={}", key.path, self.get(key.path)?.to_toml()));
        sections.iter().flat_map(|section| keys_of(section).filter(written).filter_map(setting)).collect()
    }

    /// The document resolves to the same values.
    pub fn to_toml(&self) -> String {
        self.sections_toml(std::iter::once("").chain(SECTIONS.iter().map(|(name, _)| *name)))
    }

    /// `""` contains the keys without a section.
    pub fn sections_toml<'a>(&self, sections: impl IntoIterator<Item = &'a str>) -> String {
        let mut text = String::new();
        for section in sections {
            let lines: Vec<String> = keys_of(section)
                .filter(|key| self.is_acting(key))
                .filter_map(|key| {
                    let name = key.path.rsplit('.').next().unwrap_or(key.path);
                    self.get(key.path).map(|value| format!("{name} = {}\n", value.to_toml()))
                })
                .collect();
            if lines.is_empty() {
                continue;
            }
            if !section.is_empty() {
                let _ = write!(text, "\n[{section}]\n");
            }
            text.extend(lines);
            if section == TISSUE {
                self.write_layers(&mut text);
            }
        }
        text
    }

    fn write_layers(&self, text: &mut String) {
        let mut last = "";
        let keys: Vec<KeyAt> = self.layer_keys().collect();
        for key in &keys {
            let Some((name, field)) = split(&key.path) else { continue };
            if name != last {
                let _ = write!(text, "\n[[{LAYER_LIST}]]\nname = {name:?}\n");
                last = name;
            }
            if let Some(value) = self.get(&key.path) {
                let _ = writeln!(text, "{field} = {}", value.to_toml());
            }
        }
    }
}

impl settings::KeySource for Values {
    type Error = ScenarioError;

    fn number(&self, path: &str) -> Result<f64, ScenarioError> {
        self.optional_number(path).ok_or_else(|| self.missing(path))
    }

    fn optional_number(&self, path: &str) -> Option<f64> {
        // Building an error would dominate the time.
        match self.get(path) {
            Some(Value::Number(value)) => Some(*value),
            _ => None,
        }
    }

    fn number_or(&mut self, path: &'static str, derived: impl FnOnce() -> f64) -> f64 {
        self.optional_number(path).unwrap_or_else(|| {
            let value = derived();
            self.derive(path, Value::Number(value));
            value
        })
    }

    fn whole(&self, path: &str) -> Result<u64, ScenarioError> {
        match self.get(path) {
            Some(Value::Whole(value)) => Ok(*value),
            _ => Err(self.missing(path)),
        }
    }

    fn flag(&self, path: &str) -> Result<bool, ScenarioError> {
        match self.get(path) {
            Some(Value::Flag(value)) => Ok(*value),
            _ => Err(self.missing(path)),
        }
    }

    fn numbers(&self, path: &str) -> Result<&[f64], ScenarioError> {
        match self.get(path) {
            Some(Value::Numbers(value)) => Ok(value),
            _ => Err(self.missing(path)),
        }
    }

    fn word(&self, path: &str) -> Result<&str, ScenarioError> {
        self.text(path)
    }

    fn optional_word(&self, path: &str) -> Option<&str> {
        match self.get(path) {
            Some(Value::Text(value)) if !value.is_empty() => Some(value),
            _ => None,
        }
    }

    fn unknown_word(&self, path: &str) -> ScenarioError {
        self.missing(path)
    }

    fn visit_items(
        &mut self,
        _list: &str,
        mut visit: impl FnMut(&str, &mut Self) -> Result<(), ScenarioError>,
    ) -> Result<(), ScenarioError> {
        let visited = self.names.clone().into_iter().try_for_each(|name| {
            self.visited = Some(name.clone());
            visit(&name, self)
        });
        self.visited = None;
        visited
    }
}

/// Makes a name valid for a folder: letters, digits and `-_.+ `, not hidden, and not the name of a comparison's file.
pub fn harmless_name(name: &str) -> String {
    let harmless = |c: char| if c.is_alphanumeric() || "-_.+ ".contains(c) { c } else { '_' };
    let name: String = name.chars().take(100).map(harmless).collect();
    let name = name.trim_matches([' ', '.']);
    match name {
        "" => "scenario".into(),
        taken if ["comparison.", "overlay.", "report."].iter().any(|file| taken.starts_with(file)) => {
            taken.replace('.', "_")
        }
        free => free.to_owned(),
    }
}

fn conditions(key: &Key) -> impl Iterator<Item = ActsFor> {
    let choice = |acts: &ActsFor| find(acts.key).and_then(|choice| choice.acts_for);
    std::iter::successors(key.acts_for, choice).flat_map(ActsFor::conditions)
}

pub(super) fn replays_position(values: &Values) -> bool {
    values.word(MotionSettings::KEY.path).is_ok_and(|word| word == MotionSettings::Recording.word())
}

pub(super) fn replays_force(values: &Values) -> bool {
    values
        .word(TissueSettings::KEY.path)
        .is_ok_and(|word| word == TissueSettings::Recording(ReplaySettings::DEFAULT).word())
}

fn replays_over_time(values: &Values) -> bool {
    replays_force(values) && values.word(ReplayIndex::KEY.path).is_ok_and(|word| word == ReplayIndex::Time.word())
}

pub(super) fn keys_of(section: &str) -> impl Iterator<Item = &'static Key> {
    KEYS.iter().filter(move |key| key.path.rsplit_once('.').map_or("", |(parent, _)| parent) == section)
}

fn similarity(a: &str, b: &str) -> f64 {
    names::similarity(a, b)
}

fn named_layer(path: &str) -> Option<String> {
    let (name, misspelt) = split(path)?;
    let fields = || LAYER_KEYS.iter().map(|key| field(key.path));
    match nearest_of(misspelt, fields()).filter(|_| is_name(name)) {
        Some(near) => Some(format!("did you mean {LAYER_LIST}.{name}.{near}?")),
        None => Some(format!("the keys of a layer are name, {}", fields().collect::<Vec<_>>().join(", "))),
    }
}

fn layer(path: &str) -> Option<String> {
    if is_of_layer(path) {
        return named_layer(path);
    }
    let (name, misspelt) = path.strip_prefix("tissue.")?.split_once('.').unwrap_or((&path["tissue.".len()..], ""));
    let Some(near) = nearest_of(misspelt, LAYER_KEYS.iter().map(|key| field(key.path))) else {
        let is_default = TissueSettings::WORDS.iter().flat_map(|word| TissueSettings::default_layers(word));
        let mut known = is_default.map(|(known, _)| known);
        return known
            .any(|known| known == name)
            .then(|| format!("a layer is an item of the list: write [[{LAYER_LIST}]] and name = {name:?}"));
    };
    if !is_name(name) || is_section(&format!("tissue.{name}")) {
        return None;
    }
    Some(format!(
        "a layer is an item of the list: write [[{LAYER_LIST}]] with name = {name:?}, or change one value of a layer as {LAYER_LIST}.{name}.{near}"
    ))
}

enum Refused {
    Unknown(Box<Entry>),
    Other(ScenarioError),
}

impl From<ScenarioError> for Refused {
    fn from(error: ScenarioError) -> Self {
        Self::Other(error)
    }
}

impl Refused {
    fn place(&self) -> Option<&Place> {
        match self {
            Self::Unknown(entry) => Some(&entry.key_place),
            Self::Other(error) => error.place.as_ref(),
        }
    }

    fn error(self) -> ScenarioError {
        match self {
            Self::Unknown(entry) => unknown(&entry),
            Self::Other(error) => error,
        }
    }
}

fn unknown(entry: &Entry) -> ScenarioError {
    let path = &entry.path;
    let place = Some(entry.key_place.clone());
    if is_section(path) {
        let message = format!("{path} is {}, must be a section of keys", entry.written);
        return ScenarioError::new(message).at(place).remedy(format!("write [{path}] and its keys below"));
    }
    let error = ScenarioError::new(format!("there is no key {}", names::shortened(path))).at(place);
    if let Some(remedy) = layer(path) {
        return error.remedy(remedy);
    }
    let section = SECTIONS.iter().map(|(section, _)| *section).find(|section| similarity(path, section) > 0.85);
    match nearest(path).or(section) {
        Some(known) => error.remedy(format!("did you mean {known}?")),
        None => error.remedy("`trocar init --all` writes a scenario with every key"),
    }
}

#[cfg(test)]
mod tests {
    use super::super::Scenario;
    use super::*;

    const LAYERS: &str = "operator.kind = \"ramp\"\n[tissue]\nkind = \"layers\"\n";

    fn load(text: &str, settings: &[&str]) -> Result<Scenario, ScenarioError> {
        let source = Source::Text { name: "mine.toml".into(), text: text.into() };
        let settings: Vec<String> = settings.iter().map(|setting| (*setting).to_owned()).collect();
        Scenario::load(&source, &settings)
    }

    /// The names of the layers in an echo, and the value of a field of the first layer.
    fn first_of_echo(scenario: &Scenario, field: &str) -> (Vec<String>, Option<f64>) {
        let echo: toml::Table = scenario.echo().parse().expect("TOML");
        let layers = echo["tissue"]["layer"].as_array().expect("a list").clone();
        let names = layers.iter().filter_map(|layer| layer["name"].as_str().map(str::to_owned)).collect();
        (names, layers[0].get(field).and_then(toml::Value::as_float))
    }

    #[test]
    fn a_section_of_a_single_layer_is_rejected_with_its_line_and_the_form_of_a_list() {
        for (text, remedy) in [
            ("\n[tissue.skin]\nrupture_force_n = 5.0\n", "write [[tissue.layer]] with name = \"skin\""),
            ("\n\ntissue.mine.rupture_force = 5.0\n", "tissue.layer.mine.rupture_force_n"),
            ("\n\n[tissue.organ]\n", "write [[tissue.layer]] and name = \"organ\""),
        ] {
            let error = load(text, &[]).expect_err(text);
            assert_eq!(error.place.as_ref().map(|place| place.line_and_column().0), Some(3), "{error}");
            assert!(error.remedy.as_ref().is_some_and(|told| told.contains(remedy)), "{error}");
        }
    }

    #[test]
    fn without_a_list_one_value_of_a_default_layer_can_be_changed() {
        let scenario = load(&format!("{LAYERS}layer.skin.rupture_force_n = 5.5\n"), &[]).expect("good");
        let names = ["skin", "fat", "muscle", "capsule", "organ"].map(str::to_owned).to_vec();
        assert_eq!(first_of_echo(&scenario, "rupture_force_n"), (names.clone(), Some(5.5)));
        assert_eq!(first_of_echo(&scenario, "stiffening_n_per_m2"), (names, Some(3.5e4)));
        assert_eq!(load(&scenario.echo(), &[]).expect("good").echo(), scenario.echo());
    }

    #[test]
    fn another_kind_has_different_default_layers_and_ignores_values_of_the_others() {
        let text = format!("{LAYERS}layer.skin.rupture_force_n = 5.5\n");
        let scenario = load(&text, &["tissue.kind=tearing"]).expect("good");
        assert_eq!(first_of_echo(&scenario, "stiffness_n_per_m"), (vec!["organ".to_owned()], Some(250.0)));
        let scenario = load(LAYERS, &["tissue.kind=kelvin-voigt"]).expect("good");
        assert!(!scenario.echo().contains(LAYER_LIST));
    }

    #[test]
    fn a_field_that_no_layer_gives_has_the_same_default_in_both_kinds() {
        let list = "[[tissue.layer]]\nname = \"only\"\n";
        for kind in ["layers", "tearing"] {
            let text = format!("operator.kind = \"ramp\"\ntissue.kind = \"{kind}\"\n{list}");
            let scenario = load(&text, &[]).expect("good");
            assert_eq!(first_of_echo(&scenario, "stiffness_n_per_m"), (vec!["only".to_owned()], Some(250.0)), "{kind}");
        }
    }

    #[test]
    fn an_error_between_two_fields_names_the_layer_and_the_place_of_the_written_one() {
        let error = load(&format!("{LAYERS}layer.capsule.cutting_force_n = 2.0\n"), &[]).expect_err("refused");
        let told = "tissue.layer.capsule.rupture_force_n is 1.2, must be at least tissue.layer.capsule.cutting_force_n";
        assert_eq!(error.message, told);
        assert_eq!(error.place.map(|place| place.line_and_column().0), Some(4));
    }

    #[test]
    fn a_layer_that_is_not_listed_is_rejected_with_the_names_of_the_others() {
        let error = load(LAYERS, &["tissue.layer.skn.grip_n=0.1"]).expect_err("refused");
        assert_eq!(error.message, "there is no layer skn in [[tissue.layer]]");
        assert_eq!(error.remedy.as_deref(), Some("the layers are skin, fat, muscle, capsule, organ"));
    }
}
