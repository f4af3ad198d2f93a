//! Builds an FMU from `tests/data/fmu/tissue.c`.

use std::collections::HashMap;
use std::io::{Cursor, Write as _};
use std::process::Command;
use std::sync::{Mutex, PoisonError};

use zip::ZipWriter;
use zip::write::SimpleFileOptions;

use super::file;
use super::test_folder::TestFolder;

/// The faults of `tests/data/fmu/tissue.c`.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub enum Fault {
    None,
    Error,
    NotANumber,
    Fatal,
    End,
    NoInstance,
    RefusedParameter,
}

type Libraries = HashMap<(u8, Fault), Vec<u8>>;

/// Returns the library of `tests/data/fmu/tissue.c`, compiled once for each version and fault.
pub fn library(fmi: u8, fault: Fault) -> Vec<u8> {
    static COMPILED: Mutex<Option<Libraries>> = Mutex::new(None);
    let mut compiled = COMPILED.lock().unwrap_or_else(PoisonError::into_inner);
    let compile = || {
        let folder = TestFolder::new();
        let out = folder.path("tissue.so");
        // Disable fused multiplication and addition, so that the bits equal Rust's.
        let output = Command::new("cc")
            .args(["-Wall", "-Wextra", "-Werror", "-O1", "-ffp-contract=off", "-shared", "-fPIC", "-o"])
            .arg(&out)
            .args([format!("-DFMI={fmi}"), format!("-DFAULT={}", fault as u8)])
            .arg(file("tests/data/fmu/tissue.c"))
            .arg("-lm")
            .output()
            .expect("a C compiler");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        std::fs::read(out).expect("compiled")
    };
    compiled.get_or_insert_default().entry((fmi, fault)).or_insert_with(compile).clone()
}

/// Returns the model description of `tests/data/fmu/tissue.c`.
pub fn description(fmi: u8) -> String {
    let variables = [
        ("x", 1, "input", "Real", "unit=\"m\" start=\"0\""),
        ("v", 2, "input", "Real", "unit=\"m/s\" start=\"0\""),
        ("f", 3, "output", "Real", "declaredType=\"Force\""),
        ("open", 4, "output", "Boolean", ""),
        ("k", 5, "parameter", "Real", "start=\"200\""),
        ("b", 6, "parameter", "Real", "start=\"5\""),
        ("contact", 7, "parameter", "Real", "unit=\"m\" start=\"0\""),
        ("depth", 8, "parameter", "Real", "unit=\"m\" start=\"1\""),
        ("layers", 9, "parameter", "Integer", "start=\"1\""),
        ("reaction.shaft_force_n", 10, "output", "Real", ""),
        ("y", 11, "input", "Real", "unit=\"m\" start=\"0\""),
        ("w", 11, "input", "Real", "unit=\"m/s\" start=\"0\""),
        ("name", 12, "parameter", "String", ""),
    ];
    let units = "<UnitDefinitions><Unit name=\"m\"><BaseUnit m=\"1\"/></Unit><Unit name=\"mm\"><BaseUnit m=\"1\" factor=\"0.001\"/></Unit>\
                 <Unit name=\"m/s\"><BaseUnit m=\"1\" s=\"-1\"/></Unit><Unit name=\"N\"><BaseUnit kg=\"1\" m=\"1\" s=\"-2\"/></Unit></UnitDefinitions>";
    let each = variables.map(|(name, reference, causality, kind, attributes)| {
        let head = format!("name=\"{name}\" valueReference=\"{reference}\" causality=\"{causality}\"");
        let kind_3 = match kind {
            "Real" => "Float64",
            "Integer" => "Int32",
            other => other,
        };
        if fmi == 2 {
            format!("<ScalarVariable {head}><{kind} {attributes}/></ScalarVariable>\n")
        } else {
            format!("<{kind_3} {head} {attributes}/>\n")
        }
    });
    let (token, force) = if fmi == 2 {
        ("guid", "<SimpleType name=\"Force\"><Real unit=\"N\"/></SimpleType>")
    } else {
        ("instantiationToken", "<Float64Type name=\"Force\" unit=\"N\"/>")
    };
    format!(
        "<?xml version=\"1.0\"?>\n<fmiModelDescription fmiVersion=\"{fmi}.0\" modelName=\"t\" {token}=\"{{1}}\">\
         <CoSimulation modelIdentifier=\"tissue\"/>{units}<TypeDefinitions>{force}</TypeDefinitions>\n\
         <ModelVariables>\n{}</ModelVariables></fmiModelDescription>",
        each.concat()
    )
}

pub fn container(files: &[(&str, &[u8])]) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(vec![]));
    for (path, content) in files {
        zip.start_file(*path, SimpleFileOptions::default()).expect("begun");
        zip.write_all(content).expect("written");
    }
    zip.finish().expect("finished").into_inner()
}

/// Returns the path of the library in an FMU, on this machine.
pub fn place(fmi: u8) -> String {
    let version = if fmi == 2 { trocar_studies::fmu::Version::Two } else { trocar_studies::fmu::Version::Three };
    format!("binaries/{}/tissue.{}", version.platform(), std::env::consts::DLL_EXTENSION)
}

pub fn unit_with(description: &str, fmi: u8, library: &[u8]) -> Vec<u8> {
    container(&[("modelDescription.xml", description.as_bytes()), (&place(fmi), library)])
}

pub fn unit(fmi: u8, fault: Fault) -> Vec<u8> {
    unit_with(&description(fmi), fmi, &library(fmi, fault))
}
