//! The charts: their keys, the pointer, and the marks of events.

use std::time::Duration;

use fantoccini::key::Key;
use fantoccini::{Client, Locator};
use serde_json::{Value as Json, json};
use tokio::time::sleep;

use crate::page::BrowserPage;
use crate::picture::column;
use crate::test_folder::TestFolder;

/// Collects script errors in `failed`.
const WATCH: &str =
    "window.failed = []; window.addEventListener('error', ({ message }) => failed.push(message)); return null";

/// Returns the screen reader's text of the first canvas of a group of charts.
async fn text_of(client: &Client, selector: &str) -> String {
    let canvas = client.find(Locator::Css(selector)).await.expect("a chart");
    canvas.attr("aria-valuetext").await.expect("an attribute").unwrap_or_default()
}

/// Returns the number after a word in a text such as "Time 5.520 s, slave, classical 19.04 mm".
fn number_after(text: &str, word: &str) -> f64 {
    let rest = text.split(word).nth(1).unwrap_or_else(|| panic!("{word} in {text}")).trim_start();
    rest.split(' ')
        .next()
        .and_then(|number| number.parse().ok())
        .unwrap_or_else(|| panic!("a number after {word}: {text}"))
}

pub async fn keys(page: BrowserPage) -> BrowserPage {
    const CHART: &str = "#chart-1 canvas";
    page.open("").await;
    page.evaluate(WATCH).await;
    let chart = page.client.find(Locator::Css(CHART)).await.expect("a chart");
    let press = async |keys: &str| chart.send_keys(keys).await.expect("pressed");
    let shown = "const { x } = trocarPictures.panel('position'); return [x.low, x.high]";
    let range = async || -> (f64, f64) { serde_json::from_value(page.evaluate(shown).await).expect("times") };
    // Go to the next rupture; the values there equal those of the trace.
    press("e").await;
    let text = text_of(&page.client, CHART).await;
    let folder = TestFolder::new();
    folder.good(&["run", "paper/augmented", "--set", "augmentation.enabled=false", "--quiet", "--out", "o"]);
    let csv = folder.text("o/augmented/trace.csv");
    let rupture_s =
        page.evaluate("return trocarPictures.panel('position').ruptures[0]").await.as_f64().expect("a time");
    let tick = column(&csv, "time_s").iter().position(|time_s| (time_s - rupture_s).abs() < 1e-6).expect("a tick");
    let expected_mm = 1e3 * column(&csv, "slave_position_m")[tick];
    assert_eq!(number_after(&text, "Time"), rupture_s);
    assert!((number_after(&text, "slave, classical") - expected_mm).abs() < 0.01, "{text}, {expected_mm}");
    // The animation rests at the same time.
    let animated = "const a = trocar.animation(); return [a.data.time_s[a.at], a.isPlaying]";
    let now = page.evaluate(animated).await;
    assert!((now[0].as_f64().expect("a time") - rupture_s).abs() < 0.003 && now[1] == json!(false), "{now}");
    // Another chart with the same time axis also shows the cursor.
    let other = page.evaluate("return document.querySelector('#chart-2 figcaption').textContent").await;
    assert_eq!(number_after(other.as_str().unwrap_or_default(), "Time"), rupture_s);
    press(&String::from(char::from(Key::Right))).await;
    let moved_s = number_after(&text_of(&page.client, CHART).await, "Time");
    assert!(moved_s > rupture_s && moved_s < rupture_s + 0.1, "{moved_s}");
    let before = range().await;
    press("+").await;
    page.wait(&format!("return (() => {{ {shown} }})()[0] > {}", before.0 + 0.05)).await;
    page.wait("return !trocar.busy()").await;
    let zoomed = range().await;
    assert!((zoomed.1 - zoomed.0) / (before.1 - before.0) < 0.65, "{before:?}, {zoomed:?}");
    press("-").await;
    page.wait(&format!("return (() => {{ {shown} }})()[0] < {}", zoomed.0 - 0.01)).await;
    press("0").await;
    page.wait(&format!("return (() => {{ {shown} }})()[0] === 0")).await;
    // Enter on the name of a line hides the line.
    let name = page.client.find(Locator::Css("#chart-1 .legend button")).await.expect("a name");
    name.send_keys(&String::from(char::from(Key::Enter))).await.expect("pressed");
    assert_eq!(name.attr("aria-checked").await.expect("an attribute").as_deref(), Some("false"));
    assert_eq!(page.evaluate("return failed").await, json!([]));
    // Moving the animation's slider moves the charts' cursor and updates the values.
    let slider = page.client.find(Locator::Css("#animation .player input")).await.expect("a slider");
    slider.send_keys(&String::from(char::from(Key::Right))).await.expect("pressed");
    let reading = page.evaluate("return document.querySelector('#chart-2 figcaption').textContent").await;
    let at = page.evaluate(animated).await[0].as_f64().expect("a time");
    assert!((number_after(reading.as_str().unwrap_or_default(), "Time") - at).abs() < 0.001, "{reading}, {at}");
    // Every chart of every report accepts the keys.
    let folder = TestFolder::new();
    folder.good(&["compare", "--report", "--quiet", "--out", "compared"]);
    folder.good(&["stability", "paper/augmented", "--report", "--quiet", "--out", "loop"]);
    let walls = ["--z-width", "0:50:6", "--absolute", "channel.delay_s=0:0.1:5"];
    folder.good(&[&["stability", "--report", "--quiet", "--out", "walls"], &walls[..]].concat());
    let all_drawn = "const { figures } = JSON.parse(document.getElementById('data').textContent);
        const panels = Object.values(figures).flat().flatMap(({ rows }) => rows).flatMap(({ panels }) => panels);
        return panels.length > 3 && document.querySelectorAll('canvas').length === panels.length";
    let walls = folder.path("walls/depth-classical/report.html");
    page.client.goto(&format!("file://{}", walls.display())).await.expect("goes");
    page.wait(all_drawn).await;
    for file in ["compared/compare/report.html", "loop/augmented/report.html"] {
        page.client.goto(&format!("file://{}", folder.path(file).display())).await.expect("goes");
        page.evaluate(WATCH).await;
        page.wait(all_drawn).await;
        let charts = page.client.find_all(Locator::Css(".chart canvas")).await.expect("charts");
        for chart in charts {
            chart.send_keys(&String::from(char::from(Key::Right))).await.expect("pressed");
            let first = chart.attr("aria-valuetext").await.expect("an attribute");
            chart.send_keys(&String::from(char::from(Key::Right)).repeat(10)).await.expect("pressed");
            let second = chart.attr("aria-valuetext").await.expect("an attribute");
            assert!(first != second && first.as_deref() != Some("no cursor"), "{file}: {first:?}, {second:?}");
            chart.send_keys("+0").await.expect("pressed");
        }
        assert_eq!(page.evaluate("return failed").await, json!([]), "{file}");
    }
    page
}

/// The pointer on the stability map shows the boundary in the table of verdicts.
pub async fn boundary(page: BrowserPage) -> BrowserPage {
    let folder = TestFolder::new();
    folder.good(&["stability", "paper/classical", "--report", "--quiet", "--out", "o"]);
    let csv = folder.text("o/classical/stability_map.csv");
    let [x, y, stable] = ["scaling.force", "tissue.stiffness_n_per_m", "stable"].map(|name| column(&csv, name));
    let points = || x.iter().zip(&y).zip(&stable).map(|((x, y), stable)| (*x, *y, *stable == 1.0));
    page.client.goto(&format!("file://{}", folder.path("o/classical/report.html").display())).await.expect("goes");
    page.resize(1280, 900).await;
    const MAP: &str = ".charts[data-name=stability] canvas";
    page.evaluate(&format!("document.querySelector('{MAP}').scrollIntoView({{ block: 'center' }}); return null")).await;
    sleep(Duration::from_millis(300)).await;
    let [left, top, width, height] = page.place(MAP).await;
    let mut boundaries = 0;
    for share in [0.4, 0.6, 0.75, 0.9] {
        page.mouse("mouseMoved", (left + share * width, top + 0.3 * height)).await;
        let read = "const chart = document.querySelector('.charts[data-name=stability] figure');
            return [chart.querySelector('figcaption').textContent, chart.querySelector('.legend').textContent]";
        let read = page.evaluate(read).await;
        let [place, legend] = [0, 1].map(|index| read[index].as_str().unwrap_or_default().to_owned());
        let at = number_after(&place, "Force scale");
        // The pointer is between the last stable and the first unstable stiffness of the columns on both sides.
        let near = || points().filter(|(x, ..)| (x / at).ln().abs() < 0.025);
        let limit = |is_stable: bool| near().filter(move |(.., stable)| *stable == is_stable).map(|(_, y, _)| y);
        if limit(false).next().is_none() {
            continue;
        }
        boundaries += 1;
        let (most, least) = (limit(true).fold(0.0, f64::max), limit(false).fold(f64::MAX, f64::min));
        let shown = number_after(&legend, "boundary (analysis)");
        assert!(shown > 0.95 * least && shown < 1.05 * most, "{place}: {shown}, from {least} to {most}");
    }
    assert!(boundaries >= 2, "{boundaries} places with a boundary");
    page
}

/// The name of an event matches the hold, and a cue is drawn where the master vibrates.
pub async fn events(page: BrowserPage) -> BrowserPage {
    let scenarios = [
        ("layers/skin-augmented", "frozen", "clamp"),
        ("strategies/speed-limit", "held", "brake"),
        ("strategies/forbidden-region", "held", "barrier"),
        ("strategies/fixture", "held", "barrier"),
        ("strategies/cue", "event", "vibration"),
        ("strategies/damping", "event", ""),
    ];
    for (scenario, word, mark) in scenarios {
        page.open(&format!("scenario=builtin:{scenario}.toml")).await;
        let script = "const a = trocar.animation(); a.pause();
            const { states } = a.data.panels[1];
            a.show(states.findIndex((state) => ['frozen', 'held', 'event'].includes(state)) + 2);
            const drawn = (role) => [...document.querySelectorAll(`#animation .augmented .${role}`)].some((one) => one.getAttribute('visibility') === 'visible');
            return [[...new Set(states)], document.getElementById('key').textContent,
                ['clamp', 'brake', 'barrier', 'vibration'].filter(drawn), document.querySelector('#animation .augmented .state').textContent]";
        let shown = page.evaluate(script).await;
        let states: Vec<String> = serde_json::from_value(shown[0].clone()).expect("states");
        assert!(states.iter().any(|state| state == word), "{scenario}: {states:?}");
        assert_eq!(states.iter().any(|state| state == "frozen"), word == "frozen", "{scenario}: {states:?}");
        let key = shown[1].as_str().unwrap_or_default();
        assert!(key.starts_with(word) && key.contains("frozen") == (word == "frozen"), "{scenario}: {key}");
        let marks: Vec<&str> = [mark].into_iter().filter(|mark| !mark.is_empty()).collect();
        assert_eq!((&shown[2], &shown[3]), (&json!(marks), &json!(word)), "{scenario}");
    }
    page
}

/// With forced colours, a shade stays pale and differs from a curve.
pub async fn forced_colours(page: BrowserPage) -> BrowserPage {
    for theme in ["light", "dark"] {
        let features =
            json!([{ "name": "forced-colors", "value": "active" }, { "name": "prefers-color-scheme", "value": theme }]);
        page.devtools("Emulation.setEmulatedMedia", json!({ "features": features })).await;
        page.open("").await;
        let colours = "const rgb = (name) => trocarCharts.colour(name).match(/[\\d.]+/g).slice(0, 3).map(Number);
            return ['blue', 'vermilion', 'page', trocarPictures.panel('position').shades[0][2]].map(rgb)";
        let colours: Vec<Vec<f64>> = serde_json::from_value(page.evaluate(colours).await).expect("colours");
        let distance = |a: usize, b: usize| colours[a].iter().zip(&colours[b]).map(|(a, b)| (a - b).abs()).sum::<f64>();
        let scale = if colours.iter().flatten().all(|part| *part <= 1.0) { 1.0 } else { 255.0 };
        for (a, b) in [(0, 1), (0, 2), (0, 3), (1, 3), (2, 3)] {
            assert!(distance(a, b) > 0.1 * scale, "{theme}: {a} and {b} of {colours:?}");
        }
    }
    page.devtools("Emulation.setEmulatedMedia", json!({ "features": Json::Array(vec![]) })).await;
    page
}
