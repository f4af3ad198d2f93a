use std::collections::BTreeSet;
use std::fmt::Write as _;

use super::variables::{Causality, Model, Scalar, Type, Variable};
use super::version::Version;
use trocar_scenario::Scenario;

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Exponents of kg, m and s of a unit such as `N·s/m`.
fn base_units(unit: &str) -> String {
    let (mut kg, mut m, mut s) = (0, 0, 0);
    let mut sign = 1;
    for part in unit.replace('/', " / ").replace('·', " ").split_whitespace() {
        let squared = if part.ends_with('²') { 2 } else { 1 };
        let (of_kg, of_m, of_s) = match part.trim_end_matches('²') {
            "/" => {
                sign = -1;
                continue;
            }
            "N" => (1, 1, -2),
            "J" => (1, 2, -2),
            "kg" => (1, 0, 0),
            "m" => (0, 1, 0),
            "s" => (0, 0, 1),
            "Hz" => (0, 0, -1),
            _ => continue,
        };
        kg += sign * squared * of_kg;
        m += sign * squared * of_m;
        s += sign * squared * of_s;
    }
    let exponents = [("kg", kg), ("m", m), ("s", s)];
    exponents
        .iter()
        .filter(|(_, exponent)| *exponent != 0)
        .map(|(name, exponent)| format!(" {name}=\"{exponent}\""))
        .collect()
}

fn type_name(variable: &Variable) -> String {
    format!("{}.words", variable.name)
}

impl Scalar {
    fn to_xml(self) -> String {
        match self {
            Self::Real(value) => format!("{value:?}"),
            Self::Integer(value) => value.to_string(),
            Self::Boolean(value) => value.to_string(),
        }
    }
}

fn type_attributes(variable: &Variable) -> String {
    let mut text = String::new();
    if let Some(unit) = &variable.unit
        && matches!(variable.kind, Type::Real(_))
    {
        let _ = write!(text, " unit=\"{}\"", escaped(unit));
    }
    match variable.kind {
        Type::Real(Some((min, max))) => {
            let _ = write!(text, " min=\"{min:?}\" max=\"{max:?}\"");
        }
        Type::Integer(min) => {
            let _ = write!(text, " min=\"{min}\"");
        }
        Type::Choice(_) => {
            let _ = write!(text, " declaredType=\"{}\"", type_name(variable));
        }
        Type::Real(None) | Type::Boolean => {}
    }
    if variable.causality != Causality::Output {
        let _ = write!(text, " start=\"{}\"", variable.start.to_xml());
    }
    text
}

fn role(variable: &Variable) -> &'static str {
    match (variable.causality, variable.kind) {
        (Causality::Parameter, _) => "causality=\"parameter\" variability=\"fixed\"",
        (Causality::Input, Type::Real(_)) => "causality=\"input\" variability=\"continuous\"",
        (Causality::Input, _) => "causality=\"input\" variability=\"discrete\"",
        (Causality::Output, _) => "causality=\"output\" variability=\"discrete\" initial=\"calculated\"",
    }
}

fn variable_2(variable: &Variable) -> String {
    let element = match variable.kind {
        Type::Real(_) => "Real",
        Type::Integer(_) => "Integer",
        Type::Boolean => "Boolean",
        Type::Choice(_) => "Enumeration",
    };
    let Variable { name, reference, meaning, .. } = variable;
    format!(
        "<ScalarVariable name=\"{name}\" valueReference=\"{reference}\" {} description=\"{}\"><{element}{}/></ScalarVariable>\n",
        role(variable),
        escaped(meaning),
        type_attributes(variable)
    )
}

fn variable_3(variable: &Variable) -> String {
    let element = match variable.kind {
        Type::Real(_) => "Float64",
        Type::Integer(_) => "Int64",
        Type::Boolean => "Boolean",
        Type::Choice(_) => "Enumeration",
    };
    let Variable { name, reference, meaning, .. } = variable;
    format!(
        "<{element} name=\"{name}\" valueReference=\"{reference}\" {} description=\"{}\"{}/>\n",
        role(variable),
        escaped(meaning),
        type_attributes(variable)
    )
}

fn types(version: Version, variables: &[Variable]) -> String {
    let mut text = String::from("<TypeDefinitions>\n");
    for variable in variables {
        let Type::Choice(words) = variable.kind else { continue };
        let name = type_name(variable);
        let items: String = words
            .iter()
            .enumerate()
            .map(|(place, word)| format!("<Item name=\"{}\" value=\"{place}\"/>", escaped(word)))
            .collect();
        text += &match version {
            Version::Two => format!("<SimpleType name=\"{name}\"><Enumeration>{items}</Enumeration></SimpleType>\n"),
            Version::Three => format!("<EnumerationType name=\"{name}\">{items}</EnumerationType>\n"),
        };
    }
    text + "</TypeDefinitions>\n"
}

fn units(variables: &[Variable]) -> String {
    let units: BTreeSet<&str> = variables.iter().filter_map(|variable| variable.unit.as_deref()).chain(["s"]).collect();
    let mut text = String::from("<UnitDefinitions>\n");
    for unit in units {
        let _ = writeln!(text, "<Unit name=\"{}\"><BaseUnit{}/></Unit>", escaped(unit), base_units(unit));
    }
    text + "</UnitDefinitions>\n"
}

pub fn describe(model: Model, version: Version, scenario: &Scenario, variables: &[Variable], token: &str) -> String {
    let identifier = model.identifier();
    let name = escaped(&scenario.name);
    let what = match model {
        Model::Rig => {
            "The controller of a rig for bilateral teleoperation of a needle: samples in, commands and alarm out."
        }
        Model::Simulation => {
            "Bilateral teleoperation of a needle insertion: the person's position in; positions, forces, mode out."
        }
        Model::Tissue => "Tissue that a needle enters: position and velocity of the needle in, force out.",
    };
    let (fmi, identity, version_attributes) = match version {
        Version::Two => (
            "2.0",
            "guid",
            "canHandleVariableCommunicationStepSize=\"true\" canNotUseMemoryManagementFunctions=\"true\" canGetAndSetFMUstate=\"true\"".to_owned(),
        ),
        Version::Three => (
            "3.0",
            "instantiationToken",
            format!(
                "canHandleVariableCommunicationStepSize=\"true\" canGetAndSetFMUState=\"true\" fixedInternalStepSize=\"{:?}\"",
                scenario.grid.tick_s()
            ),
        ),
    };
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <fmiModelDescription fmiVersion=\"{fmi}\" modelName=\"{identifier}\" {identity}=\"{token}\" description=\"{what} Scenario: \
         {name}.\" version=\"{}\" license=\"MIT OR Apache-2.0\" generationTool=\"trocar {}\" \
         variableNamingConvention=\"structured\"{}>\n<CoSimulation modelIdentifier=\"{identifier}\" {version_attributes}/>\n",
        env!("CARGO_PKG_VERSION"),
        env!("CARGO_PKG_VERSION"),
        if version == Version::Two { " numberOfEventIndicators=\"0\"" } else { "" },
    );
    text += &units(variables);
    text += &types(version, variables);
    let tick_s = scenario.grid.tick_s();
    let stop_s = scenario.grid.ticks() as f64 * tick_s;
    let _ = writeln!(text, "<DefaultExperiment startTime=\"0.0\" stopTime=\"{stop_s:?}\" stepSize=\"{tick_s:?}\"/>");
    text += "<ModelVariables>\n";
    if version == Version::Three {
        text += "<Float64 name=\"time\" valueReference=\"0\" causality=\"independent\" variability=\"continuous\" unit=\"s\" \
                 description=\"Simulation time.\"/>\n";
    }
    text.extend(variables.iter().map(|variable| match version {
        Version::Two => variable_2(variable),
        Version::Three => variable_3(variable),
    }));
    text += "</ModelVariables>\n<ModelStructure>\n";
    let outputs: Vec<(usize, &Variable)> =
        variables.iter().enumerate().filter(|(_, variable)| variable.causality == Causality::Output).collect();
    match version {
        Version::Two => {
            let unknowns: String =
                outputs.iter().map(|(place, _)| format!("<Unknown index=\"{}\"/>", place + 1)).collect();
            let _ = writeln!(text, "<Outputs>{unknowns}</Outputs>\n<InitialUnknowns>{unknowns}</InitialUnknowns>");
        }
        Version::Three => {
            for element in ["Output", "InitialUnknown"] {
                for (_, variable) in &outputs {
                    let _ = writeln!(text, "<{element} valueReference=\"{}\"/>", variable.reference);
                }
            }
        }
    }
    text + "</ModelStructure>\n</fmiModelDescription>\n"
}
