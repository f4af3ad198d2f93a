//! Reads entries from files: a scenario, its bases, and the settings of the command line.

use std::collections::HashSet;
use std::fs::File;
use std::io::{ErrorKind, Read};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::Deserialize;
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};

use super::builtin;
use super::error::{Place, ScenarioError};
use super::kept_files::{KeptFiles, canonical_path};
use super::keys::{find, is_section};
use super::layers::{NAME_RULE, is_name, is_of_layer};
use trocar_engine::tissue::LAYER_LIST;
use trocar_recording::MEMORY;

/// A real file has a few thousand bytes.
const MAX_BYTES: u64 = 1 << 20;

const MAX_BASES: usize = 32;

const MAX_LAYERS: usize = 1000;

const LISTED: &str = "`trocar scenarios` lists the shipped scenarios";

#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Source {
    Disk(PathBuf),
    /// An embedded file by its full name, for example `layers/skin-augmented.toml`.
    Builtin(String),
    /// A text in memory; paths in it are relative to the working directory.
    Text {
        name: Arc<str>,
        text: Arc<str>,
    },
    /// By the name that `trocar_recording::keep` returned.
    Memory(String),
    /// With the kept content of it and of the files that it names.
    Kept(Box<Source>, KeptFiles),
}

impl Source {
    /// `builtin:` and the name of a shipped file; a path; or, if there is no such file, the name of a shipped scenario.
    pub fn parse(text: &str) -> Self {
        match text.strip_prefix(builtin::PREFIX) {
            Some(name) => Self::Builtin(builtin::find(name).unwrap_or(name).to_owned()),
            None if text.starts_with(MEMORY) => Self::Memory(text.to_owned()),
            None => Self::disk_or_shipped(PathBuf::from(text), text),
        }
    }

    pub fn relative(&self, text: &str) -> Self {
        if let Self::Kept(source, files) = self {
            let relative = source.relative(text);
            return if relative.disk_path().is_some() { relative.keeping(files.clone()) } else { relative };
        }
        if [builtin::PREFIX, MEMORY].iter().any(|prefix| text.starts_with(prefix)) || Path::new(text).is_absolute() {
            return Self::parse(text);
        }
        match self {
            Self::Disk(here) => Self::disk_or_shipped(here.parent().unwrap_or(Path::new("")).join(text), text),
            // Beside this one, or else by its name among the shipped ones.
            Self::Builtin(here) => {
                let beside = joined(here, text);
                let found = builtin::find(&beside).or_else(|| builtin::find(text));
                Self::Builtin(found.map_or(beside, str::to_owned))
            }
            Self::Text { .. } | Self::Memory(_) | Self::Kept(..) => Self::parse(text),
        }
    }

    /// Files that are read later are added.
    pub fn keeping(&self, files: KeptFiles) -> Self {
        Self::Kept(Box::new(self.plain().clone()), files)
    }

    pub fn plain(&self) -> &Self {
        if let Self::Kept(source, _) = self { source.plain() } else { self }
    }

    pub fn kept(&self) -> Option<&KeptFiles> {
        if let Self::Kept(_, files) = self { Some(files) } else { None }
    }

    pub fn disk_path(&self) -> Option<&Path> {
        if let Self::Disk(path) = self.plain() { Some(path) } else { None }
    }

    /// A text with an ending is always a path, so a missing file is an error.
    fn disk_or_shipped(path: PathBuf, text: &str) -> Self {
        let is_name = Path::new(text).extension().is_none() && !path.is_file();
        match builtin::find(text).filter(|_| is_name) {
            Some(name) => Self::Builtin(name.to_owned()),
            None => Self::Disk(path),
        }
    }

    pub fn display(&self) -> String {
        match self {
            Self::Disk(path) => path.display().to_string(),
            Self::Builtin(name) => format!("{}{name}", builtin::PREFIX),
            Self::Text { name, .. } => name.to_string(),
            Self::Memory(name) => name.clone(),
            Self::Kept(source, _) => source.display(),
        }
    }

    pub fn stem(&self) -> String {
        let path = match self {
            Self::Disk(path) => path.as_path(),
            Self::Builtin(name) | Self::Memory(name) => Path::new(name),
            Self::Text { name, .. } => Path::new(&**name),
            Self::Kept(source, _) => return source.stem(),
        };
        path.file_stem().map_or_else(|| "scenario".into(), |stem| stem.to_string_lossy().into_owned())
    }

    /// The canonical form, for comparison and for the echo.
    pub fn canonical(&self) -> Self {
        match self {
            Self::Disk(path) => Self::Disk(canonical_path(path)),
            Self::Builtin(name) => Self::Builtin(builtin::find(name).unwrap_or(name).to_owned()),
            Self::Text { .. } | Self::Memory(_) => self.clone(),
            Self::Kept(source, files) => match source.disk_path() {
                Some(path) => Self::Disk(files.canonical(path)).keeping(files.clone()),
                None => self.clone(),
            },
        }
    }

    pub fn read(&self) -> Result<String, ScenarioError> {
        self.read_relative_to("the file that contains it")
    }

    pub(crate) fn read_argument(&self) -> Result<String, ScenarioError> {
        self.read_relative_to("the current folder")
    }

    fn read_relative_to(&self, here: &str) -> Result<String, ScenarioError> {
        let refuse = |reason: String| ScenarioError::new(format!("{}: {reason}", self.display()));
        let bytes = match self {
            // Text in memory needs no size limit.
            Self::Text { text, .. } => return Ok(text.to_string()),
            Self::Kept(source, files) => match source.disk_path() {
                Some(path) => files.bytes(path, || source.read_relative_to(here).map(String::into_bytes))?.to_vec(),
                None => return source.read_relative_to(here),
            },
            Self::Memory(_) => return Err(refuse("is a recording, not a scenario".into())),
            Self::Builtin(name) => builtin::content(name).map(<[u8]>::to_vec).ok_or_else(|| {
                let did_you_mean = builtin::nearest(name).map(|near| format!("did you mean {near}? "));
                refuse("there is no such shipped file".into())
                    .remedy(format!("{}{LISTED}", did_you_mean.unwrap_or_default()))
            })?,
            Self::Disk(path) => {
                let cannot = |error: std::io::Error| {
                    let near =
                        builtin::nearest(&path.to_string_lossy()).filter(|_| error.kind() == ErrorKind::NotFound);
                    let first = near.map_or_else(
                        || format!("a path is relative to {here}; "),
                        |near| format!("did you mean {near}? "),
                    );
                    refuse(format!("cannot be read: {error}")).remedy(format!("{first}{LISTED}"))
                };
                let metadata = path.metadata().map_err(cannot)?;
                if !metadata.is_file() {
                    return Err(refuse("is not a regular file; give the path of a scenario file".into()));
                }
                let mut bytes = Vec::new();
                let file = File::open(path).map_err(cannot)?;
                file.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(cannot)?;
                bytes
            }
        };
        if bytes.len() as u64 > MAX_BYTES {
            return Err(refuse(format!("is larger than the {MAX_BYTES} bytes that a scenario may have")));
        }
        String::from_utf8(bytes).map_err(|_| refuse("is not UTF-8 text; save it as UTF-8".into()))
    }
}

fn joined(here: &str, path: &str) -> String {
    let mut parts: Vec<&str> = here.split('/').collect();
    parts.pop();
    for part in path.split('/') {
        match part {
            "." => {}
            ".." => drop(parts.pop()),
            name => parts.push(name),
        }
    }
    parts.join("/")
}

#[derive(Debug, Clone)]
pub struct Entry {
    pub path: String,
    pub value: toml::Value,
    /// The text of the value, for messages.
    pub written: String,
    pub key_place: Place,
    pub value_place: Place,
    /// Paths in the value are relative to this file.
    pub source: Source,
    /// Distance from the last list of settings: 0 in that list, or in a single file; then one more for each earlier
    /// list, file and base.
    pub layer: usize,
}

/// The last list comes first. The first entry of a path takes effect.
pub fn gather(source: &Source, settings: &[&[String]]) -> Result<Vec<Entry>, ScenarioError> {
    let mut entries = of_settings(settings)?;
    let earlier_lists = settings.len().saturating_sub(1);
    let files = of_files(source)?.into_iter();
    entries.extend(files.map(|entry| Entry { layer: entry.layer + earlier_lists, ..entry }));
    Ok(entries)
}

fn of_settings(settings: &[&[String]]) -> Result<Vec<Entry>, ScenarioError> {
    let mut entries = Vec::new();
    for (layer, list) in settings.iter().rev().enumerate() {
        for setting in list.iter().rev() {
            entries.extend(parse_setting(setting)?.into_iter().map(|entry| Entry { layer, ..entry }));
        }
    }
    Ok(entries)
}

fn of_files(source: &Source) -> Result<Vec<Entry>, ScenarioError> {
    let mut entries = Vec::new();
    let mut visited: Vec<Source> = vec![];
    let mut next = Some((source.clone(), None));
    while let Some((source, place)) = next {
        if visited.contains(&source.canonical()) {
            let message = format!("{} is based on itself", source.display());
            return Err(ScenarioError::new(message).at(place).remedy("base must name another file"));
        }
        visited.push(source.canonical());
        if visited.len() > MAX_BASES {
            let message = format!("the chain of bases is longer than {MAX_BASES}");
            return Err(ScenarioError::new(message).at(place).remedy("use fewer bases"));
        }
        let text = if place.is_some() { source.read() } else { source.read_argument() };
        let text = text.map_err(|error| error.at(place))?;
        let file = parse(&source.display(), &text, &source)?;
        let of_other_file = file.iter().find_map(|entry| Some((entry, kind_of_file(entry)?)));
        if let Some((entry, kind)) = of_other_file {
            let message = format!("{} is a {kind} file, not a scenario", source.display());
            let error = ScenarioError::new(message).at(Some(entry.key_place.clone()));
            return Err(error.remedy(format!("run it with `trocar {kind} {}`", source.display())));
        }
        let (bases, rest): (Vec<_>, Vec<_>) = file.into_iter().partition(|entry| entry.path == "base");
        let layer = visited.len();
        entries.extend(rest.into_iter().map(|entry| Entry { layer, ..entry }));
        next = bases.into_iter().next().map(|entry| based_on(&source, entry)).transpose()?;
    }
    Ok(entries)
}

pub(super) fn drop_replaced_layers(entries: &mut Vec<Entry>) {
    let lists = entries.iter().filter(|entry| entry.path == LAYER_LIST);
    if let Some(nearest) = lists.map(|entry| entry.layer).min() {
        entries.retain(|entry| !is_of_layer(&entry.path) || entry.layer <= nearest);
    }
}

/// The kind of another file than a scenario that an entry shows, which is also its command.
fn kind_of_file(entry: &Entry) -> Option<&'static str> {
    if is_axis(entry) {
        return Some("sweep");
    }
    is_design_goal(entry).then_some("design")
}

pub fn is_design_goal(entry: &Entry) -> bool {
    matches!(entry.path.split('.').next(), Some("free" | "objectives"))
}

/// True if an entry is in the section of a sweep's axes.
pub fn is_axis(entry: &Entry) -> bool {
    entry.path.split('.').next() == Some("axes")
}

/// Returns every entry of a file in the syntax of a scenario, sorted by path.
pub fn entries(source: &Source) -> Result<Vec<Entry>, ScenarioError> {
    parse(&source.display(), &source.read_argument()?, source)
}

fn based_on(source: &Source, entry: Entry) -> Result<(Source, Option<Place>), ScenarioError> {
    let Some(path) = entry.value.as_str().filter(|path| !path.is_empty()) else {
        let message = format!("base is {}, must be the path of a scenario file", entry.written);
        return Err(ScenarioError::new(message).at(Some(entry.value_place)));
    };
    Ok((source.relative(path), Some(entry.value_place)))
}

fn parse(name: &str, text: &str, source: &Source) -> Result<Vec<Entry>, ScenarioError> {
    let (file, text): (Arc<str>, Arc<str>) = (name.into(), text.into());
    let place = |span: Range<usize>| Place { file: file.clone(), text: text.clone(), span };
    let table = DeTable::parse(&text).map_err(|error| {
        ScenarioError::new(error.message().to_owned()).at(error.span().map(place)).remedy("scenarios are TOML files")
    })?;
    let mut entries = Vec::new();
    flatten("", table.get_ref(), &mut |path, key: Range<usize>, value: &Spanned<DeValue<'_>>| {
        let raw = text.get(value.span()).unwrap_or_default();
        if let Some(items) = layer_items(&path, value) {
            let names = names_of_layers(items, &place)?;
            entries.push(Entry {
                path,
                value: toml::Value::Array(names.into_iter().map(toml::Value::from).collect()),
                written: shorten(raw),
                key_place: place(key),
                value_place: place(value.span()),
                source: source.clone(),
                layer: 0,
            });
            return Ok(());
        }
        if let DeValue::Array(items) = value.get_ref()
            && raw.starts_with("[[")
            && items.iter().all(|item| matches!(item.get_ref(), DeValue::Table(_)))
        {
            return Err(list_of_tables(&path).at(Some(place(key))));
        }
        let read = || match value.get_ref() {
            // The text of a section is its header, not its value.
            DeValue::Table(_) => Ok(toml::Value::Table(toml::Table::new())),
            _ => ValueDeserializer::parse(raw).and_then(toml::Value::deserialize),
        };
        let parsed = read().map_err(|error| {
            let error = if is_digits(raw) {
                let max = i64::MAX;
                ScenarioError::new(format!("{path} is {raw}, must be at most {max}, the maximum of whole numbers"))
            } else {
                ScenarioError::new(format!("{path} cannot be read: {}", error.message()))
                    .remedy("write a section as [name], a value as name = value")
            };
            error.at(Some(place(key.clone())))
        })?;
        entries.push(Entry {
            path,
            value: parsed,
            written: shorten(raw),
            key_place: place(key),
            value_place: place(value.span()),
            source: source.clone(),
            layer: 0,
        });
        Ok(())
    })?;
    Ok(entries)
}

fn layer_items<'a, 'de>(path: &str, value: &'a Spanned<DeValue<'de>>) -> Option<&'a [Spanned<DeValue<'de>>]> {
    let DeValue::Array(items) = value.get_ref() else { return None };
    let are_tables = items.iter().all(|item| matches!(item.get_ref(), DeValue::Table(_)));
    (path == LAYER_LIST && are_tables && !items.is_empty()).then_some(&items[..])
}

fn name_of<'a>(item: &'a Spanned<DeValue<'_>>) -> Option<&'a str> {
    let DeValue::Table(table) = item.get_ref() else { return None };
    table.iter().find(|(key, _)| key.get_ref() == "name").and_then(|(_, name)| name.get_ref().as_str())
}

fn names_of_layers(
    items: &[Spanned<DeValue<'_>>],
    place: &impl Fn(Range<usize>) -> Place,
) -> Result<Vec<String>, ScenarioError> {
    let mut names: Vec<String> = vec![];
    let mut known = HashSet::new();
    if let Some(beyond) = items.get(MAX_LAYERS) {
        let message = format!("[[{LAYER_LIST}]] has {} layers, at most {MAX_LAYERS}", items.len());
        return Err(ScenarioError::new(message).at(Some(place(beyond.span()))));
    }
    for item in items {
        let refuse = |message: String| Err(ScenarioError::new(message).at(Some(place(item.span()))));
        let Some(written) = name_of(item) else {
            return refuse(format!("a layer of [[{LAYER_LIST}]] has no name, as in name = \"dura\""));
        };
        if !is_name(written) {
            return refuse(format!("the name of a layer is {written:?}, must be {NAME_RULE}"));
        }
        if !known.insert(written) {
            return refuse(format!("two layers of [[{LAYER_LIST}]] are called {written}"));
        }
        names.push(written.to_owned());
    }
    Ok(names)
}

fn list_of_tables(path: &str) -> ScenarioError {
    let error = ScenarioError::new(format!("{path} is a list of tables, [[{path}]]"));
    if path.starts_with("tissue.") {
        return error.remedy(format!("the list of layers is [[{LAYER_LIST}]]"));
    }
    error.remedy(format!("write a section once, as [{path}]"))
}

fn is_digits(text: &str) -> bool {
    let digits = text.strip_prefix(['+', '-']).unwrap_or(text);
    !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit() || byte == b'_')
}

fn shorten(raw: &str) -> String {
    const MAX_CHARS: usize = 60;
    let line = raw.split_whitespace().collect::<Vec<_>>().join(" ");
    if line.chars().count() <= MAX_CHARS { line } else { line.chars().take(MAX_CHARS).chain(['…']).collect() }
}

type Leaf<'a> = dyn FnMut(String, Range<usize>, &Spanned<DeValue<'_>>) -> Result<(), ScenarioError> + 'a;

/// Visits every value that is not a section, and empty tables without a section, which are reported. In the list of
/// layers it visits the list, then the values of its items, by their names.
fn flatten(prefix: &str, table: &DeTable<'_>, leaf: &mut Leaf<'_>) -> Result<(), ScenarioError> {
    for (key, value) in table {
        if is_of_layer(prefix) && key.get_ref() == "name" {
            continue;
        }
        // A quoted key with a dot is not a path.
        let name = key.get_ref();
        let name = if name.contains('.') { format!("{name:?}") } else { name.to_string() };
        let path = if prefix.is_empty() { name } else { format!("{prefix}.{name}") };
        match value.get_ref() {
            DeValue::Table(inner) if find(&path).is_none() && (is_section(&path) || !inner.is_empty()) => {
                flatten(&path, inner, leaf)?;
            }
            _ => {
                leaf(path.clone(), key.span(), value)?;
                for item in layer_items(&path, value).unwrap_or_default() {
                    if let (Some(name), DeValue::Table(inner)) = (name_of(item), item.get_ref()) {
                        flatten(&format!("{path}.{name}"), inner, leaf)?;
                    }
                }
            }
        }
    }
    Ok(())
}

pub(super) fn parse_setting(setting: &str) -> Result<Vec<Entry>, ScenarioError> {
    let remedy = "write --set section.key=value, as in --set scaling.force=2";
    let Some((key, value)) = setting.split_once('=') else {
        return Err(ScenarioError::new(format!("--set {setting}: there is no '='")).remedy(remedy));
    };
    let (key, value) = (key.trim(), value.trim());
    // Reject too large whole numbers instead of reading them as text.
    let is_toml = is_digits(value) || ValueDeserializer::parse(value).and_then(toml::Value::deserialize).is_ok();
    let value = if is_toml { value.to_owned() } else { toml::Value::String(value.to_owned()).to_string() };
    // Paths on the command line are relative to the working directory.
    let here = Source::Disk(PathBuf::new());
    let entries = parse("--set", &format!("{key} = {value}"), &here)?;
    if entries.iter().any(|entry| entry.path == "base") {
        return Err(ScenarioError::new("base cannot be set on the command line").remedy("name another scenario"));
    }
    Ok(entries)
}
