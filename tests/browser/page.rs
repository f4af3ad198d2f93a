//! A server, a browser and a simulated user.

use std::future::Future;
use std::net::SocketAddr;
use std::pin::Pin;
use std::process::Command;
use std::time::{Duration, Instant};

use fantoccini::elements::Element;
use fantoccini::key::Key;
use fantoccini::wd::WebDriverCompatibleCommand;
use fantoccini::{Client, ClientBuilder, Locator};
use serde_json::{Value as Json, json};

use crate::server::{Running, explore};

pub type Body = fn(BrowserPage) -> Pin<Box<dyn Future<Output = BrowserPage>>>;

/// Time limit of a page. A machine that runs all tests at once is slow.
const TIMEOUT: Duration = Duration::from_secs(20);

/// Maximum number of presses of Tab to reach an element.
const MAX_TABS: usize = 150;

/// A JavaScript function that returns the element that covers another one, or why the element is out of view; `null`
/// if it can be used.
pub const COVERED: &str = r"const covered = (one) => {
    const box = one.getBoundingClientRect();
    const [x, y] = [box.left + box.width / 2, box.top + Math.min(box.height, innerHeight) / 2];
    if (x < 0 || y < 0 || x > innerWidth || y > innerHeight) return `${one.id || one.outerHTML} is at ${x}, ${y}`;
    const top = document.elementFromPoint(x, y);
    return one.contains(top) || top.contains(one) || top.closest('label')?.control === one ? null : `${one.id || one.outerHTML} lies under ${top.outerHTML.slice(0, 200)}`;
};";

fn found(program: &str) -> bool {
    Command::new(program).arg("--version").output().is_ok_and(|output| output.status.success())
}

/// Returns true if a browser and its driver are installed.
pub fn is_there() -> bool {
    found("chromium") && found("chromedriver")
}

pub struct BrowserPage {
    pub client: Client,
    pub address: SocketAddr,
    /// The process id of the server.
    pub server: u32,
}

/// Starts chromedriver for all trials. Returns it with its port.
///
/// It chooses a free port of IPv4 and exits if another process has the same port of IPv6, so it is started again.
pub fn driver() -> (Running, u16) {
    let port = |line: &str| line.split("successfully on port ").nth(1)?.trim_end_matches('.').parse::<u16>().ok();
    let start = |_| Running::start(Command::new("chromedriver").arg("--port=0"), port);
    (0..5).find_map(start).expect("chromedriver starts")
}

/// Runs a trial with its own server, in its own session of the driver at this port.
pub fn run(body: Body, port: u16) -> Result<(), String> {
    let (server, address) = explore(&[]);
    let server_id = server.id();
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(|e| e.to_string())?;
    tokio::task::LocalSet::new().block_on(&runtime, async {
        let options = json!({
            "binary": "/usr/bin/chromium",
            "args": ["--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--window-size=1400,1000"],
        });
        let mut builder = ClientBuilder::new(hyper_util::client::legacy::connect::HttpConnector::new());
        builder.capabilities([("goog:chromeOptions".to_owned(), options)].into_iter().collect());
        let client = builder.connect(&format!("http://127.0.0.1:{port}")).await.map_err(|error| error.to_string())?;
        // Run the trial in its own task, so that a failing trial also closes its browser.
        let trial = tokio::task::spawn_local(body(BrowserPage { client: client.clone(), address, server: server_id }));
        let outcome = trial.await;
        client.close().await.map_err(|error| error.to_string())?;
        outcome.map(drop).or_else(|failed| std::panic::resume_unwind(failed.into_panic()))
    })
}

impl BrowserPage {
    /// Opens the page of a state and waits for its charts.
    pub async fn open(&self, state: &str) {
        // Changing only the hash of an address does not load a new page.
        self.client.goto("about:blank").await.expect("goes");
        self.client.goto(&format!("http://{}/#{state}", self.address)).await.expect("goes");
        self.wait("return typeof trocar !== 'undefined' && trocar.timings.length > 0 && !trocar.busy()").await;
    }

    /// Sets the size of the page in pixels.
    pub async fn resize(&self, width: u32, height: u32) {
        let size = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false });
        self.devtools("Emulation.setDeviceMetricsOverride", size).await;
    }

    pub async fn devtools(&self, command: &str, parameters: Json) -> Json {
        self.client.issue_cmd(DevTools(json!({ "cmd": command, "params": parameters }))).await.expect("a command")
    }

    /// Stops an animation at its still frame, in a theme.
    pub async fn still(&self, animation: &str, theme: &str) {
        self.evaluate(&format!(
            "{animation}.rest(); document.documentElement.dataset.theme = '{theme}'; \
             window.dispatchEvent(new Event('themechange')); return null"
        ))
        .await;
        tokio::time::sleep(Duration::from_millis(700)).await;
    }

    pub async fn evaluate(&self, script: &str) -> Json {
        self.client.execute(script, vec![]).await.expect("a script of this test")
    }

    pub async fn wait(&self, script: &str) {
        let until = Instant::now() + TIMEOUT;
        while self.evaluate(script).await != Json::Bool(true) {
            if Instant::now() > until {
                let trouble = self.evaluate("return document.getElementById('trouble')?.textContent").await;
                panic!("timeout: {script}; message of the page: {trouble}");
            }
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
    }

    /// Presses keys, one after the other, at the present focus.
    pub async fn press(&self, keys: &[Key]) {
        for key in keys {
            let (name, code, text) = match key {
                Key::Tab => ("Tab", 9, ""),
                Key::Enter => ("Enter", 13, "\r"),
                Key::Backspace => ("Backspace", 8, ""),
                Key::Down => ("ArrowDown", 40, ""),
                Key::PageDown => ("PageDown", 34, ""),
                Key::End => ("End", 35, ""),
                Key::Left => ("ArrowLeft", 37, ""),
                Key::Right => ("ArrowRight", 39, ""),
                key => panic!("no code of {key:?}"),
            };
            self.key(name, code, text).await;
        }
    }

    pub async fn type_text(&self, text: &str) {
        for letter in text.chars() {
            let text = letter.to_string();
            // Other characters have no code, because their codes would be those of keys such as Delete.
            let code = if letter.is_ascii_alphanumeric() { letter.to_ascii_uppercase() as u32 } else { 0 };
            self.key(&text, code, &text).await;
        }
    }

    async fn key(&self, name: &str, code: u32, text: &str) {
        for event in ["keyDown", "keyUp"] {
            let text = if event == "keyDown" { text } else { "" };
            let key = json!({ "type": event, "key": name, "windowsVirtualKeyCode": code, "text": text });
            self.devtools("Input.dispatchKeyEvent", key).await;
        }
    }

    /// Presses Tab until an element that matches a selector has the focus. Checks that each focused element is in
    /// view and uncovered.
    pub async fn tab_to(&self, selector: &str) {
        let is_there = format!("return document.activeElement.matches({selector:?})");
        for _ in 0..MAX_TABS {
            if self.evaluate(&is_there).await == Json::Bool(true) {
                let covered = self.evaluate(&format!("{COVERED} return covered(document.activeElement)")).await;
                assert_eq!(covered, Json::Null, "{selector} has the focus");
                return;
            }
            self.press(&[Key::Tab]).await;
        }
        panic!("{selector} is not reached by Tab");
    }

    pub async fn mouse(&self, event: &str, (x, y): (f64, f64)) {
        let buttons = i32::from(event != "mouseReleased");
        let at = json!({ "type": event, "x": x, "y": y, "button": "left", "buttons": buttons, "clickCount": 1 });
        self.devtools("Input.dispatchMouseEvent", at).await;
    }

    pub async fn place(&self, selector: &str) -> [f64; 4] {
        let script = format!(
            "const box = document.querySelector({selector:?}).getBoundingClientRect(); return [box.left, box.top, box.width, box.height]"
        );
        serde_json::from_value(self.evaluate(&script).await).expect("a place")
    }

    pub async fn element(&self, id: &str) -> Element {
        self.client.find(Locator::Id(id)).await.expect("an element of the page")
    }

    pub async fn text(&self, id: &str) -> String {
        self.element(id).await.text().await.expect("text")
    }

    /// Waits for the whole table, including the detection in noise, and returns its lines.
    pub async fn table(&self) -> Vec<Vec<String>> {
        self.wait("return !trocar.busy() && document.querySelector('#metrics tbody').textContent.includes('in noise')")
            .await;
        let script = "return [...document.querySelectorAll('#metrics tbody tr')].map(r => [...r.children].map(c => c.textContent))";
        serde_json::from_value(self.evaluate(script).await).expect("a table")
    }

    /// Returns the file that a button saves.
    pub async fn file(&self, button: &str) -> (String, String) {
        self.evaluate("trocar.file.before = trocar.file(); return null").await;
        self.element(button).await.click().await.expect("clicked");
        self.wait("return trocar.file() !== null && trocar.file() !== trocar.file.before").await;
        let file = self.evaluate("return trocar.file()").await;
        (file["name"].as_str().unwrap_or_default().to_owned(), file["content"].as_str().unwrap_or_default().to_owned())
    }
}

/// A command of the DevTools protocol, which chromedriver forwards.
#[derive(Debug)]
struct DevTools(Json);

impl WebDriverCompatibleCommand for DevTools {
    fn endpoint(&self, base: &url::Url, session: Option<&str>) -> Result<url::Url, url::ParseError> {
        base.join(&format!("session/{}/goog/cdp/execute", session.unwrap_or_default()))
    }

    fn method_and_body(&self, _: &url::Url) -> (axum::http::Method, Option<String>) {
        (axum::http::Method::POST, Some(self.0.to_string()))
    }
}
