//! Reads the matrices of a state-space model of the master or the slave from a file.

use std::collections::BTreeMap;

use serde_json::Value as Json;

use super::document::Source;
use super::error::ScenarioError;
use super::replay::limiting_key;
use super::value::Value;
use super::values::Values;
use trocar_engine::plant::{MasterModel, MasterModelSettings, SlaveModel, SlaveParameters};
use trocar_recording::{Limits, RecordingError, read_file, read_matrices};

trocar_core::settings! {
    /// The file of the master's state-space model.
    #[derive(Debug, Clone, PartialEq)]
    pub(super) struct MasterFileSettings in "master." no const {
        /// File with the matrices A, B, C and D of the state-space model, instead of a, b and c: TOML, JSON or MATLAB.
        file: Option<String> [FILE] for MasterModel::StateSpace,
    }
}

trocar_core::settings! {
    /// The file of the slave's state-space model.
    #[derive(Debug, Clone, PartialEq)]
    pub(super) struct SlaveFileSettings in "slave." no const {
        /// File with the matrices A, B, C and D of the state-space model, instead of a, b and c: TOML, JSON or MATLAB.
        file: Option<String> [FILE] for SlaveModel::StateSpace,
    }
}

/// Keys in the order of the matrices A, B and C.
struct Side {
    file: &'static str,
    matrices: [&'static str; 3],
}

const MASTER: Side = Side { file: MasterFileSettings::KEYS[0].path, matrices: ["master.a", "master.b", "master.c"] };
const SLAVE: Side = Side { file: SlaveFileSettings::KEYS[0].path, matrices: ["slave.a", "slave.b", "slave.c"] };
const REMEDY: &str = "the file has A (n x n), B (n x 2: motor, external force; or n x 1 for both), C (1 x n) and D (0)";

type Rows = Vec<Vec<f64>>;

pub(super) fn read_master(values: &mut Values, master: &mut MasterModelSettings) -> Result<(), ScenarioError> {
    if master.model == MasterModel::StateSpace
        && let Some(matrices) = read(values, &MASTER)?
    {
        [master.a, master.b, master.c] = matrices;
    }
    Ok(())
}

pub(super) fn read_slave(values: &mut Values, slave: &mut SlaveParameters) -> Result<(), ScenarioError> {
    if slave.model == SlaveModel::StateSpace
        && let Some(matrices) = read(values, &SLAVE)?
    {
        [slave.a, slave.b, slave.c] = matrices;
    }
    Ok(())
}

/// A, B and C, each row by row; `None` without a file.
fn read(values: &mut Values, side: &Side) -> Result<Option<[Vec<f64>; 3]>, ScenarioError> {
    let file = side.file;
    let Some(source) = values.file(file) else { return Ok(None) };
    let source = source.canonical();
    let mut found = matrices(values, file, &source)?;
    let refuse = |message: String| values.error(file, format!("{}: {message}", source.display())).remedy(REMEDY);
    if found.remove("D").is_some_and(|rows| rows.iter().flatten().any(|value| *value != 0.0)) {
        return Err(refuse("D is not 0: a force would move the slave at once".into()));
    }
    let mut take = |name: &str| found.remove(name).ok_or_else(|| refuse(format!("it has no matrix {name}")));
    let (a, b, c) = (take("A")?, take("B")?, take("C")?);
    if c.len() != 1 {
        return Err(refuse(format!("C has {} rows, must have one, for the position", c.len())));
    }
    let b = if b.iter().all(|row| row.len() == 1) { b.into_iter().map(|row| vec![row[0]; 2]).collect() } else { b };
    let states = c[0].len();
    for (name, rows, width) in [("A", &a, states), ("B", &b, 2)] {
        let size = (rows.len(), rows.first().map_or(0, Vec::len));
        if size != (states, width) {
            let message =
                format!("{name} is {} x {}, must be {states} x {width} for the C of {states}", size.0, size.1);
            return Err(refuse(message));
        }
    }
    let flat = [a, b, c].map(|rows| rows.concat());
    for ((key, name), list) in side.matrices.into_iter().zip(["A", "B", "C"]).zip(&flat) {
        if list.iter().any(|value| !value.is_finite()) {
            return Err(refuse(format!("{name} has an entry that is no finite number")));
        }
        let is_other = values.get(key) != Some(&Value::Numbers(list.clone()));
        if values.place(key).is_some() && is_other {
            let message = format!("{key} differs from {name} in {file}");
            return Err(values.error(key, message).remedy(format!("leave out {key}, or {file}")));
        }
    }
    for (key, list) in side.matrices.into_iter().zip(&flat) {
        values.derive_keeping_place(key, Value::Numbers(list.clone()));
    }
    values.derive_keeping_place(file, Value::Text(source.display()));
    Ok(Some(flat))
}

fn matrices(values: &mut Values, file: &str, source: &Source) -> Result<BTreeMap<String, Rows>, ScenarioError> {
    let limits = Limits::read(values)?;
    let failed = |error: RecordingError| {
        let place = limiting_key(&error.problem).and_then(|key| values.place(key)).or(values.place(file));
        ScenarioError::new(error.to_string()).at(place)
    };
    let bytes = match source.plain() {
        Source::Disk(path) => match source.kept() {
            Some(files) => files.bytes(path, || read_file(path, &limits)).map(|bytes| bytes.to_vec()),
            None => read_file(path, &limits),
        }
        .map_err(failed)?,
        Source::Text { text, .. } => text.as_bytes().to_vec(),
        Source::Builtin(_) | Source::Memory(_) | Source::Kept(..) => {
            return Err(values.error(file, format!("{} is no file of matrices", source.display())).remedy(REMEDY));
        }
    };
    let name = source.display();
    let refuse = |reason: String| values.error(file, format!("{name}: {reason}")).remedy(REMEDY);
    let is_text = std::str::from_utf8(&bytes).is_ok_and(|text| !text.contains('\0')) && !name.ends_with(".mat");
    if !is_text {
        let found = read_matrices(&name, bytes, &limits).map_err(failed)?;
        // A matrix inside a structure has the name of its field.
        let named = |name: &str| name.rsplit('.').next().unwrap_or(name).to_uppercase();
        return Ok(found.into_iter().map(|matrix| (named(&matrix.name), matrix.rows)).collect());
    }
    let text = String::from_utf8(bytes).map_err(|error| refuse(error.to_string()))?;
    let parsed: Json = if text.trim_start().starts_with('{') {
        serde_json::from_str(&text).map_err(|error| refuse(error.to_string()))?
    } else {
        let table: toml::Table = toml::from_str(&text).map_err(|error| refuse(error.message().to_owned()))?;
        serde_json::to_value(table).map_err(|error| refuse(error.to_string()))?
    };
    let mut found = BTreeMap::new();
    for (name, value) in parsed.as_object().into_iter().flatten() {
        let name = name.to_uppercase();
        if ["A", "B", "C", "D"].contains(&&*name) {
            let rows = rows(value).ok_or_else(|| refuse(format!("{name} is no matrix of finite numbers")))?;
            found.insert(name, rows);
        }
    }
    Ok(found)
}

/// A list of numbers is one row, and a number one entry.
fn rows(value: &Json) -> Option<Rows> {
    let row = |list: &[Json]| list.iter().map(Json::as_f64).collect::<Option<Vec<f64>>>();
    let Some(list) = value.as_array() else { return Some(vec![vec![value.as_f64()?]]) };
    if list.iter().all(Json::is_number) {
        return Some(vec![row(list)?]);
    }
    let rows: Rows = list.iter().map(|part| row(part.as_array()?)).collect::<Option<_>>()?;
    rows.windows(2).all(|two| two[0].len() == two[1].len()).then_some(rows)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::super::{Scenario, Source};

    const TOML: &str = "A = [[0.0, 1.0], [0.0, -5.0]]\nB = [[0, 0], [2.5, 2.5]]\nC = [[1.0, 0.0]]\nD = [[0.0, 0.0]]\n";
    const JSON: &str = r#"{"A": [[0, 1], [0, -5]], "B": [[0], [2.5]], "C": [[1, 0]], "D": [[0]], "dt": 0}"#;

    fn load(name: &str, content: &[u8], more: &[&str]) -> Result<Scenario, String> {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join(name);
        fs::write(&path, content).expect("written");
        let file = format!("slave.file={:?}", path.display().to_string());
        let given = ["slave.model=state-space", &file];
        let settings: Vec<String> = given.iter().chain(more).map(|&text| text.to_owned()).collect();
        Scenario::load(&Source::parse("paper/classical"), &settings).map_err(|error| error.to_string())
    }

    /// A file of MATLAB, version 5: an element is its type, its size, and its content padded to 8 bytes.
    fn mat(matrices: &[(&str, u32, &[f64])]) -> Vec<u8> {
        let element = |kind: u32, content: &[u8]| {
            let padding = vec![0; content.len().next_multiple_of(8) - content.len()];
            [&kind.to_le_bytes()[..], &(content.len() as u32).to_le_bytes(), content, &padding].concat()
        };
        let mut bytes = [&b"MATLAB 5.0 MAT-file"[..], &[b' '; 105], &[0, 1], b"IM"].concat();
        for (name, height, values) in matrices {
            let dims = [*height, values.len() as u32 / height];
            let parts = [
                element(6, &[6, 0, 0, 0, 0, 0, 0, 0]),
                element(5, &dims.map(u32::to_le_bytes).concat()),
                element(1, name.as_bytes()),
                element(9, &values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>()),
            ];
            bytes.extend(element(14, &parts.concat()));
        }
        bytes
    }

    #[test]
    fn every_kind_of_file_gives_the_same_machine() {
        let of_matlab = mat(&[
            ("A", 2, &[0.0, 0.0, 1.0, -5.0]),
            ("B", 2, &[0.0, 2.5, 0.0, 2.5]),
            ("C", 1, &[1.0, 0.0]),
            ("D", 1, &[0.0, 0.0]),
        ]);
        for (name, content) in [("m.toml", TOML.as_bytes()), ("m.json", JSON.as_bytes()), ("m.mat", &of_matlab)] {
            let slave = load(name, content, &[]).expect("loads").slave;
            assert_eq!(slave.a, [0.0, 1.0, 0.0, -5.0], "{name}");
            assert_eq!((slave.b, slave.c), (vec![0.0, 0.0, 2.5, 2.5], vec![1.0, 0.0]), "{name}");
        }
    }

    #[test]
    fn files_that_are_no_machine_are_refused_with_the_reason() {
        let replaced = |from: &str, to: &str| TOML.replace(from, to);
        for (content, reason) in [
            (replaced("C = [[1.0, 0.0]]", ""), "no matrix C"),
            (replaced("[[0.0, 0.0]]", "[[0.0, 1.0]]"), "D is not 0"),
            (replaced("-5.0", "nan"), "A is no matrix"),
            (replaced("[0.0, -5.0]", "[0.0]"), "A is no matrix"),
            (replaced("[[1.0, 0.0]]", "[[1.0, 0.0], [0.0, 1.0]]"), "C has 2 rows"),
            (replaced("[[1.0, 0.0]]", "[[1.0, 0.0, 0.0]]"), "A is 2 x 2, must be 3 x 3"),
            (replaced("-5.0", "5.0"), "unstable"),
            ("{".to_owned(), "EOF"),
            ("A = ".to_owned(), "m.toml"),
        ] {
            let message = load("m.toml", content.as_bytes(), &[]).expect_err("refused");
            assert!(message.contains(reason), "{message} against {reason}");
        }
        let message = load("m.mat", &[0; 30], &[]).expect_err("refused");
        assert!(message.contains("m.mat"), "{message}");
        let message = load("m.toml", TOML.as_bytes(), &["slave.c=[2.0, 0.0]"]).expect_err("two values");
        assert!(message.contains("slave.c differs"), "{message}");
        assert!(load("m.toml", TOML.as_bytes(), &["slave.c=[1.0, 0.0]"]).is_ok(), "equal values");
    }
}
