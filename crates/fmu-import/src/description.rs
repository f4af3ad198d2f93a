//! The description of a unit, `modelDescription.xml`.

use std::collections::HashMap;

use crate::markup::Markup;
use roxmltree::{Document, Node, ParsingOptions};
use trocar_base::names::{shortened, with_short_words};

use crate::error::FmuError;
use crate::version::Version;

/// The role of a variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Causality {
    /// Set before the first step.
    Parameter,
    /// Set before each step.
    Input,
    /// Read after each step.
    Output,
    /// Any other role.
    Other,
}

impl Causality {
    fn word(self) -> &'static str {
        match self {
            Self::Parameter => "parameter",
            Self::Input => "input",
            Self::Output => "output",
            Self::Other => "variable",
        }
    }
}

/// The supported types of variables.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Type {
    /// A number: `Real` in FMI 2.0, `Float64` in 3.0.
    Real,
    /// A whole number of 32 bits: `Integer` and `Enumeration` in FMI 2.0, `Int32` in 3.0.
    Int32,
    /// A whole number of 64 bits: `Int64` and `Enumeration` in FMI 3.0.
    Int64,
    /// True or false.
    Boolean,
}

/// A variable of a unit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Variable {
    /// The name.
    pub name: String,
    /// The value reference: its number in calls.
    pub reference: u32,
    /// The role.
    pub causality: Causality,
    /// The type; `None` for an unsupported type such as a text or an array.
    pub kind: Option<Type>,
    /// True if the variable can be set before the first step.
    pub is_settable: bool,
    /// The unit as written.
    pub unit: Option<String>,
}

/// The exponents of kg, m, s, A, K, mol, cd and rad of an SI unit without a factor; `None` for another unit.
type Exponents = Option<[i32; 8]>;

/// The description of a unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Description {
    /// The version of the standard.
    pub version: Version,
    /// The name of the library.
    pub identifier: String,
    /// The token that identifies the unit to its library.
    pub token: String,
    /// True if the unit needs the program that exported it.
    pub needs_tool: bool,
    /// True if a process can have only one instance.
    pub is_single: bool,
    /// The internal step in s, if it is fixed and stated.
    pub internal_step_s: Option<f64>,
    /// The variables.
    pub variables: Vec<Variable>,
    units: Vec<(String, Exponents)>,
}

/// Limits of a description, whose standard has elements of up to 15 attributes and a few namespaces. Large units have
/// some hundred thousand variables.
const MAX_ATTRIBUTES: usize = 48;
const MAX_ALL_ATTRIBUTES: usize = 4_000_000;
const MAX_NAMESPACES: usize = 64;
const MAX_NODES: u32 = 3_000_000;

/// Checks the number of attributes and namespaces, on which time and memory of the library depend.
fn check(text: &str) -> Result<(), FmuError> {
    let mut markup = Markup::new(MAX_ATTRIBUTES);
    let checked = markup.push(text.as_bytes());
    checked.ok_or_else(|| wrong(format!("an element has more than {MAX_ATTRIBUTES} attributes")))?;
    if markup.namespaces() > MAX_NAMESPACES {
        return Err(wrong(format!("it declares more than {MAX_NAMESPACES} namespaces")));
    }
    if markup.attributes() > MAX_ALL_ATTRIBUTES {
        return Err(wrong(format!("it has more than {MAX_ALL_ATTRIBUTES} attributes")));
    }
    Ok(())
}

fn wrong(message: impl Into<String>) -> FmuError {
    FmuError::Description(with_short_words(&message.into()).into_owned())
}

fn child<'a, 'input>(node: Node<'a, 'input>, name: &str) -> Option<Node<'a, 'input>> {
    node.children().find(|child| child.has_tag_name(name))
}

fn is_true(node: Node<'_, '_>, attribute: &str) -> bool {
    matches!(node.attribute(attribute).map(str::trim), Some("true" | "1"))
}

impl Description {
    /// Reads a description.
    ///
    /// # Errors
    /// [`FmuError`] for a unit that is not for co-simulation in FMI 2.0 or 3.0, or a description that violates the
    /// standard.
    pub fn parse(text: &str) -> Result<Self, FmuError> {
        check(text)?;
        let options = ParsingOptions { nodes_limit: MAX_NODES, ..ParsingOptions::default() };
        let document = Document::parse_with_options(text, options).map_err(|error| wrong(error.to_string()))?;
        let root = document.root_element();
        if !root.has_tag_name("fmiModelDescription") {
            return Err(wrong("its root is not fmiModelDescription"));
        }
        let written = root.attribute("fmiVersion").unwrap_or_default();
        let version = match written.split('.').next() {
            Some("2") => Version::Two,
            Some("3") => Version::Three,
            _ => return Err(FmuError::Version(written.into())),
        };
        let co_simulation = child(root, "CoSimulation").ok_or(FmuError::NoCoSimulation)?;
        let identifier = co_simulation.attribute("modelIdentifier").unwrap_or_default().to_owned();
        // Check the identifier, because it becomes part of a path.
        if identifier.is_empty() || !identifier.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_') {
            return Err(wrong(format!("the modelIdentifier {identifier:?} is not the name of a function in C")));
        }
        let of_token = if version == Version::Two { "guid" } else { "instantiationToken" };
        let token = root.attribute(of_token).ok_or_else(|| wrong(format!("there is no {of_token}")))?.to_owned();
        let internal_step_s = co_simulation
            .attribute("fixedInternalStepSize")
            .and_then(|text| text.trim().parse().ok())
            .filter(|step_s: &f64| step_s.is_finite() && *step_s > 0.0);
        let list = child(root, "ModelVariables").ok_or_else(|| wrong("there are no ModelVariables"))?;
        let types = units_of_types(root);
        let variables = list.children().filter(Node::is_element).map(|node| variable(&types, version, node));
        Ok(Self {
            version,
            identifier,
            token,
            needs_tool: is_true(co_simulation, "needsExecutionTool"),
            is_single: is_true(co_simulation, "canBeInstantiatedOnlyOncePerProcess"),
            internal_step_s,
            variables: variables.collect::<Result<_, _>>()?,
            units: units(root),
        })
    }

    /// A variable by name.
    ///
    /// # Errors
    /// [`FmuError::NoVariable`], with the names of the variables of `role`.
    pub fn variable(&self, name: &str, role: Causality) -> Result<&Variable, FmuError> {
        self.variables.iter().find(|variable| variable.name == name).ok_or_else(|| {
            let of_role = self.variables.iter().filter(|variable| variable.causality == role);
            let known = of_role.map(|variable| variable.name.clone()).collect();
            FmuError::NoVariable { name: name.into(), role: role.word().into(), known }
        })
    }

    /// The reference of a real input or output, in the SI unit `unit` or without a stated unit.
    ///
    /// # Errors
    /// [`FmuError::NoVariable`]; [`FmuError::Variable`] for another role, type or unit.
    pub fn number(&self, name: &str, role: Causality, (unit, exponents): (&str, [i32; 8])) -> Result<u32, FmuError> {
        let variable = self.variable(name, role)?;
        let refuse = |problem: String| Err(FmuError::Variable { name: name.into(), problem });
        if variable.causality != role {
            return refuse(format!("is not an {}", role.word()));
        }
        if variable.kind != Some(Type::Real) {
            let number = if self.version == Version::Two { "Real" } else { "Float64" };
            return refuse(format!("is not a single number of the type {number}"));
        }
        let stated = variable.unit.as_deref().and_then(|unit| self.units.iter().find(|(name, _)| name == unit));
        if let Some((name, stated)) = stated
            && *stated != Some(exponents)
        {
            return refuse(format!("is in {name}, and must be in {unit}"));
        }
        Ok(variable.reference)
    }
}

fn variable(types: &HashMap<&str, &str>, version: Version, node: Node<'_, '_>) -> Result<Variable, FmuError> {
    let name = node.attribute("name").ok_or_else(|| wrong("a variable has no name"))?.to_owned();
    let reference = node.attribute("valueReference").and_then(|text| text.trim().parse().ok());
    let reference = reference.ok_or_else(|| wrong(format!("{name} has no valueReference")))?;
    let typed = match version {
        Version::Two => {
            const TYPES: [&str; 5] = ["Real", "Integer", "Enumeration", "Boolean", "String"];
            node.children().find(|child| TYPES.contains(&child.tag_name().name()))
        }
        Version::Three => Some(node),
    };
    let typed = typed.ok_or_else(|| wrong(format!("{name} has no type")))?;
    let is_array = node.children().any(|child| child.has_tag_name("Dimension"));
    let kind = match (typed.tag_name().name(), version) {
        _ if is_array => None,
        ("Real", Version::Two) | ("Float64", Version::Three) => Some(Type::Real),
        ("Integer" | "Enumeration", Version::Two) | ("Int32", Version::Three) => Some(Type::Int32),
        ("Int64" | "Enumeration", Version::Three) => Some(Type::Int64),
        ("Boolean", _) => Some(Type::Boolean),
        _ => None,
    };
    let causality = match node.attribute("causality") {
        Some("parameter") => Causality::Parameter,
        Some("input") => Causality::Input,
        Some("output") => Causality::Output,
        _ => Causality::Other,
    };
    let has_start = typed.attribute("start").is_some();
    let is_constant = node.attribute("variability") == Some("constant");
    let of_type = || types.get(typed.attribute("declaredType")?).copied();
    let unit = typed.attribute("unit").or_else(of_type).map(|unit| shortened(unit).into_owned());
    let is_settable = !is_constant && (has_start || matches!(causality, Causality::Parameter | Causality::Input));
    Ok(Variable { name, reference, causality, kind, is_settable, unit })
}

/// The units of the declared types, by their names.
fn units_of_types<'a>(root: Node<'a, '_>) -> HashMap<&'a str, &'a str> {
    let types = root.children().find(|node| node.has_tag_name("TypeDefinitions"));
    let unit = |declared: Node<'a, '_>| {
        // In FMI 2.0 an inner element has the unit.
        Some((declared.attribute("name")?, declared.descendants().find_map(|node| node.attribute("unit"))?))
    };
    // The first type of a name counts.
    types.into_iter().flat_map(|types| types.children().rev()).filter_map(unit).collect()
}

fn units(root: Node<'_, '_>) -> Vec<(String, Exponents)> {
    const BASE: [&str; 8] = ["kg", "m", "s", "A", "K", "mol", "cd", "rad"];
    let definitions = root.children().filter(|node| node.has_tag_name("UnitDefinitions"));
    let units = definitions.flat_map(|node| node.children()).filter(|node| node.has_tag_name("Unit"));
    let unit = |node: Node<'_, '_>| {
        let base = node.children().find(|child| child.has_tag_name("BaseUnit"))?;
        let number = |name: &str, otherwise: f64| match base.attribute(name) {
            Some(text) => text.trim().parse::<f64>().unwrap_or(f64::NAN),
            None => otherwise,
        };
        let is_plain = number("factor", 1.0) == 1.0 && number("offset", 0.0) == 0.0;
        let exponents = BASE.map(|name| number(name, 0.0) as i32);
        Some((node.attribute("name")?.to_owned(), is_plain.then_some(exponents)))
    };
    units.filter_map(unit).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markup_that_costs_a_library_much_time_is_refused() {
        let refusal = |content: &str| {
            let text = format!("<fmiModelDescription fmiVersion=\"2.0\">{content}</fmiModelDescription>");
            Description::parse(&text).expect_err("refused").to_string()
        };
        let attributes: String = (0..100).map(|k| format!("a{k}='' ")).collect();
        assert!(refusal(&format!("<a {attributes}/>")).contains("more than 48 attributes"));
        let (open, close): (String, String) = (0..100).map(|k| (format!("<a xmlns:b{k}='c'>"), "</a>")).collect();
        assert!(refusal(&(open + &close)).contains("more than 64 namespaces"));
        assert!(refusal(&"<a/>".repeat(MAX_NODES as usize)).contains("nodes limit"));
    }
}
