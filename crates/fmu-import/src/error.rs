use thiserror::Error;
use trocar_base::names::shortened;

/// An error of a unit, with a remedy if there is one. It does not contain the unit's file; see
/// [`Fmu::path`](crate::Fmu::path).
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FmuError {
    /// The file cannot be read.
    #[error("cannot be read: {0}")]
    File(String),
    /// The file is not a zip container.
    #[error("is not an FMU: it is not a zip container ({0}); export it again")]
    Container(String),
    /// A file in the container is a link or has a path that leads out of the folder.
    #[error("the container has the path {0:?}, which leads out of it: do not use this file")]
    Path(String),
    /// The container is too large.
    #[error("the container unpacks to more than {max} {unit}")]
    Size {
        /// The limit.
        max: u64,
        /// The counted unit.
        unit: &'static str,
    },
    /// The temporary folder cannot be written.
    #[error("cannot be unpacked to a temporary folder: {0}; make room there, or set TMPDIR")]
    Unpack(String),
    /// The description is missing.
    #[error(
        "has no modelDescription.xml: check that it is an FMU, and that its files are not in a subfolder of the \
        container"
    )]
    NoDescription,
    /// The description violates the standard.
    #[error("modelDescription.xml: {0}")]
    Description(String),
    /// The version of the standard is not supported.
    #[error("is of FMI {0:?}; export it in FMI 2.0 or 3.0")]
    Version(String),
    /// The unit is not for co-simulation.
    #[error("is not for co-simulation; export it for co-simulation, with its own solver")]
    NoCoSimulation,
    /// The unit has no library for this machine.
    #[error("has no library for this machine, {wanted}{}; export it for {}", found(.has), .wanted.rsplit('/').nth(1).unwrap_or("it"))]
    NoPlatform {
        /// The expected path.
        wanted: String,
        /// The platforms of the unit.
        has: Vec<String>,
    },
    /// The library cannot be loaded.
    #[error("its library cannot be loaded: {reason}; it may {}", needed(*.needs_tool))]
    Library {
        /// The reason.
        reason: String,
        /// True if the unit needs the program that exported it.
        needs_tool: bool,
    },
    /// A function is missing in the library.
    #[error("its library has no function {0}; export it again")]
    NoFunction(String),
    /// The variable does not exist.
    #[error("has no variable {:?}{}", shortened(.name), listed(.role, .known))]
    NoVariable {
        /// The name.
        name: String,
        /// The wanted role.
        role: String,
        /// The names of the variables of this role.
        known: Vec<String>,
    },
    /// A variable has the wrong role, type or unit.
    #[error("the variable {name:?} {problem}")]
    Variable {
        /// The name.
        name: String,
        /// The problem.
        problem: String,
    },
    /// The unit does not support the step.
    #[error("its internal step is {internal_s:?} s, and {step_s:?} s is not a whole multiple of it")]
    Step {
        /// The requested step in s.
        step_s: f64,
        /// The internal step in s.
        internal_s: f64,
    },
    /// The unit allows only one instance in a process.
    #[error(
        "supports only one instance per process, which already exists: run one scenario after the other, with one \
        thread"
    )]
    OneInstance,
    /// The unit cannot be instantiated.
    #[error("cannot be instantiated{}{}", reported(.messages), if *.needs_tool { "; it needs the program that exported it" } else { "" })]
    NoInstance {
        /// True if the unit needs the program that exported it.
        needs_tool: bool,
        /// The reported messages.
        messages: Vec<String>,
    },
    /// A call failed.
    #[error("{function} failed with the status {status}{}", reported(.messages))]
    Call {
        /// The function of the standard.
        function: &'static str,
        /// The status in the words of the standard.
        status: &'static str,
        /// The reported messages.
        messages: Vec<String>,
    },
    /// The unit wants to end the simulation.
    #[error("asks to end the simulation{}", reported(.messages))]
    Ended {
        /// The reported messages.
        messages: Vec<String>,
    },
}

fn found(platforms: &[String]) -> String {
    if platforms.is_empty() { ", nor for any other".into() } else { format!(", but for {}", platforms.join(", ")) }
}

fn listed(role: &str, known: &[String]) -> String {
    const SHOWN: usize = 12;
    if known.is_empty() {
        return format!(": it has no {role} at all");
    }
    let more = if known.len() > SHOWN { ", ..." } else { "" };
    let shown: Vec<_> = known.iter().take(SHOWN).map(|name| shortened(name)).collect();
    format!("; each {role}: {}{more}", shown.join(", "))
}

pub(crate) fn reported(messages: &[String]) -> String {
    if messages.is_empty() { String::new() } else { format!(": {}", messages.join("; ")) }
}

fn needed(needs_tool: bool) -> &'static str {
    if needs_tool {
        "need the program that exported it (needsExecutionTool)"
    } else {
        "need other libraries, or be for another machine"
    }
}
