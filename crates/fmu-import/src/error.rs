//! What can be wrong with a unit.

use thiserror::Error;

/// The error of a unit, with its remedy where there is one. It does not name the unit's file: [`Fmu::path`](crate::Fmu::path) does.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FmuError {
    /// The file cannot be read.
    #[error("cannot be read: {0}")]
    File(String),
    /// It is not a container of files.
    #[error("is not an FMU: it is no zip container ({0}); export it again")]
    Container(String),
    /// A file in the container has a path that leads out of the folder, or is a link.
    #[error("the container has the path {0:?}, which leads out of it: do not use this file")]
    Path(String),
    /// The container is larger than any unit.
    #[error("the container unpacks to more than {max} {unit}")]
    Size {
        /// The limit.
        max: u64,
        /// What is counted.
        unit: &'static str,
    },
    /// The temporary folder cannot be written.
    #[error("cannot be unpacked to a temporary folder: {0}; make room there, or set TMPDIR")]
    Unpack(String),
    /// There is no description.
    #[error("has no modelDescription.xml: is it an FMU, and its root not in a folder of the container?")]
    NoDescription,
    /// The description is not as the standard says.
    #[error("modelDescription.xml: {0}")]
    Description(String),
    /// Another version of the standard.
    #[error("is of FMI {0:?}; export it in FMI 2.0 or 3.0")]
    Version(String),
    /// Not for co-simulation.
    #[error("is not for co-simulation; export it for co-simulation, with its own solver")]
    NoCoSimulation,
    /// No library for this machine.
    #[error("has no library for this machine, {wanted}{}; export it for {}", found(.has), .wanted.rsplit('/').nth(1).unwrap_or("it"))]
    NoPlatform {
        /// The expected path.
        wanted: String,
        /// The platforms that it has.
        has: Vec<String>,
    },
    /// The library cannot be loaded.
    #[error("its library cannot be loaded: {reason}; it may {}", needed(*.needs_tool))]
    Library {
        /// Why.
        reason: String,
        /// Whether it needs the program that exported it.
        needs_tool: bool,
    },
    /// A function is missing in the library.
    #[error("its library has no function {0}; export it again")]
    NoFunction(String),
    /// There is no such variable.
    #[error("has no variable {name:?}{}", listed(.role, .known))]
    NoVariable {
        /// The name.
        name: String,
        /// What is wanted.
        role: String,
        /// The names of the variables of this role.
        known: Vec<String>,
    },
    /// A variable of another role, type or unit.
    #[error("the variable {name:?} {problem}")]
    Variable {
        /// Its name.
        name: String,
        /// What is wrong.
        problem: String,
    },
    /// A step that the unit cannot make.
    #[error("its internal step is {internal_s:?} s, and {step_s:?} s is no whole multiple of it")]
    Step {
        /// The asked step in s.
        step_s: f64,
        /// The internal step in s.
        internal_s: f64,
    },
    /// It can be instantiated only once in a process.
    #[error("can have one instance in a process, and has one: run one scenario after the other, with one thread")]
    OneInstance,
    /// There is no instance.
    #[error("cannot be instantiated{}{}", reported(.messages), if *.needs_tool { "; it needs the program that exported it" } else { "" })]
    NoInstance {
        /// Whether it needs the program that exported it.
        needs_tool: bool,
        /// What it reported.
        messages: Vec<String>,
    },
    /// A call failed.
    #[error("{function} failed with the status {status}{}", reported(.messages))]
    Call {
        /// The function of the standard.
        function: &'static str,
        /// The status in the words of the standard.
        status: &'static str,
        /// What the unit reported.
        messages: Vec<String>,
    },
    /// It wants to end the simulation.
    #[error("asks to end the simulation{}", reported(.messages))]
    Ended {
        /// What it reported.
        messages: Vec<String>,
    },
}

/// The end of a message about a missing library: the platforms that are there.
fn found(platforms: &[String]) -> String {
    if platforms.is_empty() { ", nor for any other".into() } else { format!(", but for {}", platforms.join(", ")) }
}

/// The end of a message about a missing variable: those that there are, at most this many.
fn listed(role: &str, known: &[String]) -> String {
    const SHOWN: usize = 12;
    if known.is_empty() {
        return format!(": it has no {role} at all");
    }
    let more = if known.len() > SHOWN { ", ..." } else { "" };
    let shown: Vec<&str> = known.iter().take(SHOWN).map(String::as_str).collect();
    format!("; each {role}: {}{more}", shown.join(", "))
}

/// The end of a message: what the unit reported.
pub(crate) fn reported(messages: &[String]) -> String {
    if messages.is_empty() { String::new() } else { format!(": {}", messages.join("; ")) }
}

/// What a library may need.
fn needed(needs_tool: bool) -> &'static str {
    if needs_tool {
        "need the program that exported it (needsExecutionTool)"
    } else {
        "need other libraries, or be for another machine"
    }
}
