use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use trocar_base::warning::Warning;

use minijinja::value::Serde;
use minijinja::{AutoEscape, Environment};
use serde::Serialize;
use serde_json::Value as Json;
use sha2::{Digest, Sha256};
use thiserror::Error;

use super::assets;
use trocar_document::Animation;

const STYLE: [&str; 2] = [assets::THEME_CSS, assets::REPORT_CSS];
const SCRIPT: [&str; 3] = [assets::CHARTS_JS, assets::ANIMATION_JS, assets::REPORT_JS];

#[derive(Debug, Error)]
#[error("cannot render the report: {0}")]
pub struct HtmlError(String);

#[derive(Clone, Debug)]
pub(super) struct Page {
    pub(super) heading: String,
    pub(super) command: &'static str,
    /// The introduction, one text per paragraph.
    pub(super) lead: Vec<String>,
    pub(super) sections: Vec<Section>,
    pub(super) drawn: Drawn,
}

#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct Drawn {
    pub(super) figures: BTreeMap<Cow<'static, str>, Vec<Json>>,
    pub(super) animation: Option<Animation>,
}

#[derive(Clone, Debug, Serialize)]
pub(super) struct Section {
    pub(super) id: Cow<'static, str>,
    pub(super) title: Cow<'static, str>,
    pub(super) blocks: Vec<Block>,
}

#[derive(Clone, Debug, Serialize)]
pub(super) struct Row {
    pub(super) cells: Vec<String>,
    pub(super) meaning: &'static str,
}

#[derive(Clone, Debug, Serialize)]
pub(super) struct Window {
    pub(super) label: String,
    pub(super) from: f64,
    pub(super) to: f64,
}

#[derive(Clone, Debug, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub(super) enum Block {
    Text { text: String },
    Table { caption: String, head: Vec<String>, rows: Vec<Row>, is_text: bool },
    Figures { name: Cow<'static, str>, windows: Vec<Window> },
    File { name: String, text: String },
    Command { line: String, note: String },
}

pub(super) fn warned(warnings: &[Warning]) -> Vec<String> {
    let sentences = |warning: &Warning| {
        let remedy = warning.remedy.as_ref().map_or(String::new(), |remedy| format!(" Help: {remedy}."));
        format!("Warning ({}): {warning}.{remedy}", warning.code.word())
    };
    warnings.iter().map(sentences).collect()
}

impl Block {
    pub(super) fn text(text: impl Into<String>) -> Self {
        Self::Text { text: text.into() }
    }
}

#[derive(Serialize)]
struct Context<'a> {
    title: String,
    heading: &'a str,
    command: &'static str,
    lead: &'a [String],
    is_animated: bool,
    sections: &'a [Section],
    data: String,
    policy: String,
    style: String,
    script: String,
    version: &'static str,
}

impl Page {
    pub(super) fn render(&self) -> Result<String, HtmlError> {
        let failed = |error: &dyn std::fmt::Display| HtmlError(error.to_string());
        let mut environment = Environment::new();
        environment.set_auto_escape_callback(|_| AutoEscape::Html);
        let data = serde_json::to_string(&self.drawn).map_err(|error| failed(&error))?;
        let (style, script) = (STYLE.join("\n"), SCRIPT.join("\n"));
        let context = Context {
            title: format!("{} · {}", self.heading, self.command),
            heading: &self.heading,
            command: self.command,
            lead: &self.lead,
            is_animated: self.drawn.animation.is_some(),
            sections: &self.sections,
            data: escaped_json(&data),
            policy: policy(&script),
            style,
            script,
            version: env!("CARGO_PKG_VERSION"),
        };
        environment
            .render_named_str("report.html", assets::REPORT_HTML, Serde(&context))
            .map_err(|error| failed(&error))
    }
}

/// Returns JSON that is safe inside a `script` element.
fn escaped_json(json: &str) -> String {
    // In JSON these characters occur only inside strings, where this escape is valid.
    json.replace('<', "\\u003c").replace('>', "\\u003e").replace('&', "\\u0026")
}

/// The content security policy: only the embedded script, by its hash, and inline styles.
fn policy(script: &str) -> String {
    let hash = base64(&Sha256::digest(script.as_bytes()));
    format!(
        "default-src 'none'; script-src 'sha256-{hash}'; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'"
    )
}

fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for three in bytes.chunks(3) {
        let word = three.iter().fold(0_u32, |word, byte| word << 8 | u32::from(*byte)) << (8 * (3 - three.len()));
        for index in 0..4 {
            let letter = LETTERS[(word >> (18 - 6 * index)) as usize & 63];
            let _ = write!(text, "{}", if index > three.len() { '=' } else { char::from(letter) });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn base64_agrees_with_the_standard() {
        // The test vectors of RFC 4648, section 10.
        let vectors =
            [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foob", "Zm9vYg=="), ("fooba", "Zm9vYmE=")];
        for (plain, encoded) in vectors {
            assert_eq!(base64(plain.as_bytes()), encoded);
        }
    }

    #[test]
    fn every_text_is_escaped() {
        let evil = "</script><script>alert(1)</script><!-- & ' \" {{ heading }} {% raw %}";
        let mut drawn = Drawn::default();
        drawn.figures.insert("signals".into(), vec![json!({ "name": evil, "legend": [{ "text": evil }] })]);
        let row = Row { cells: vec![evil.into(), evil.into()], meaning: "" };
        let blocks = vec![
            Block::text(evil),
            Block::Table { caption: evil.into(), head: row.cells.clone(), rows: vec![row], is_text: false },
            Block::File { name: evil.into(), text: evil.into() },
            Block::Command { line: evil.into(), note: evil.into() },
        ];
        let page = Page {
            heading: evil.into(),
            command: "trocar run",
            lead: vec![evil.into()],
            sections: vec![Section { id: "x".into(), title: "X".into(), blocks }],
            drawn,
        };
        let html = page.render().expect("rendered");
        assert_eq!(html.matches("alert(1)").count(), 17, "no text is missing");
        assert!(!html.contains("<script>alert") && !html.contains("<!-- &"));
        // The only script elements are the data and the script.
        assert_eq!(html.matches("<script").count(), 2);
        assert_eq!(html.matches("</script>").count(), 2);
        assert!(html.contains("{{ heading }}"), "texts are not templates");
    }

    #[test]
    fn scripts_and_styles_do_not_close_their_element() {
        for part in SCRIPT.iter().chain(&STYLE) {
            assert!(!part.contains("</script") && !part.contains("</style") && !part.contains("<!--"));
        }
    }
}
