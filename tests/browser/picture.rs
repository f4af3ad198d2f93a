//! The animation, the layout and the appearance of the page.

use std::time::Duration;

use serde_json::{Value as Json, json};
use tokio::time::sleep;

use crate::page::BrowserPage;
use crate::similar::{assert_similar, changed_share};
use crate::test_folder::TestFolder;

pub fn column(csv: &str, name: &str) -> Vec<f64> {
    let mut lines = csv.lines();
    let at = lines.next().and_then(|head| head.split(',').position(|one| one == name)).expect("a column");
    lines.map(|line| line.split(',').nth(at).and_then(|cell| cell.parse().ok()).expect("a number")).collect()
}

/// For both runs: the lower end of the needle, the ends of the bracket and its text, and the length of the scale in
/// pixels and mm.
const DRAWN: &str = r"return [...document.querySelectorAll('#animation .needle-panel')].map(panel => {
    const box = (kind) => panel.querySelector(kind).getBoundingClientRect();
    const { top } = panel.querySelector('svg').getBoundingClientRect();
    const scale = [...panel.querySelectorAll('text')].find(text => /^[\d.]+ mm$/.test(text.textContent) && !text.classList.contains('overshoot'));
    return { tip: box('.needle').bottom - top, bracket: box('.bracket').height, text: panel.querySelector('.overshoot').textContent,
        scale_px: box('.ruler').height, scale_mm: parseFloat(scale.textContent), state: panel.dataset.state };
})";

pub async fn animation(page: BrowserPage) -> BrowserPage {
    for scenario in ["paper/augmented", "layers/skin-augmented"] {
        page.open(&format!("scenario=builtin:{scenario}.toml")).await;
        let table = page.table().await;
        let folder = TestFolder::new();
        let times: Vec<f64> = serde_json::from_value(page.evaluate("return trocar.animation().data.time_s").await)
            .expect("the times of the frames");
        let still = page.evaluate("return trocar.animation().data.still").await.as_u64().expect("a frame") as usize;
        assert!(still > 100 && (times[still] - times[0] - 0.6).abs() < 0.002, "{still} of {}", times.len());
        // The animation continues until the needle has caught up.
        let states = page.evaluate("return trocar.animation().data.panels[1].states").await;
        let states: Vec<String> = serde_json::from_value(states).expect("states");
        assert!(states[still] != "teleoperation" && states[states.len() - 1] == "teleoperation", "{states:?}");
        let mut tips_m = vec![];
        let mut ticks_s = vec![];
        for enabled in [false, true] {
            let setting = format!("augmentation.enabled={enabled}");
            folder.good(&["run", scenario, "--set", &setting, "--quiet", "--out", "o"]);
            let name = scenario.rsplit('/').next().expect("a name");
            let csv = folder.text(&format!("o/{name}/trace.csv"));
            ticks_s = column(&csv, "time_s");
            tips_m.push(column(&csv, "slave_position_m"));
        }
        let tick_at = |time_s: f64| ticks_s.iter().position(|tick_s| (tick_s - time_s).abs() < 1e-6).expect("a tick");
        page.evaluate("trocar.animation().pause(); return null").await;
        let mut first: Option<(Json, usize)> = None;
        let mut states = vec![];
        for frame in (0..times.len()).step_by(10) {
            let drawn = page.evaluate(&format!("trocar.animation().show({frame}); {DRAWN}")).await;
            let tick = tick_at(times[frame]);
            let (from, from_tick) = first.get_or_insert_with(|| (drawn.clone(), tick));
            for (run, tip_m) in tips_m.iter().enumerate() {
                let number = |name: &str| drawn[run][name].as_f64().expect("a number");
                let pixels_per_mm = number("scale_px") / number("scale_mm");
                let moved_px = number("tip") - from[run]["tip"].as_f64().expect("a number");
                let expected_px = 1e3 * (tip_m[tick] - tip_m[*from_tick]) * pixels_per_mm;
                assert!((moved_px - expected_px).abs() < 1.0, "{scenario}, frame {frame}: {moved_px}, {expected_px}");
                states.push(drawn[run]["state"].as_str().unwrap_or_default().to_owned());
            }
        }
        assert!(states.iter().any(|state| state == "frozen"), "{states:?}");
        // The frame at rest is at the end of the metric's time.
        let drawn = page.evaluate(&format!("trocar.animation().rest(); {DRAWN}")).await;
        let row = table.iter().find(|row| row[0] == "rupture 1: overshoot in 0.5 s").expect("the metric");
        for run in 0..2 {
            assert_eq!(drawn[run]["text"].as_str(), Some(row[run + 1].as_str()));
            let number = |name: &str| drawn[run][name].as_f64().expect("a number");
            let metric_mm: f64 = row[run + 1].split(' ').next().and_then(|text| text.parse().ok()).expect("a number");
            let expected_px = metric_mm * number("scale_px") / number("scale_mm");
            assert!((number("bracket") - expected_px).abs() < 1.0, "{scenario}: {drawn}");
        }
    }
    // Without a rupture there is no bracket, and the title says so.
    page.open("scenario=builtin:passivity/late-wall.toml").await;
    let drawn = page.evaluate(&format!("trocar.animation().rest(); {DRAWN}")).await;
    assert_eq!(drawn[0]["text"], json!(""));
    let title = page.evaluate("return document.querySelector('.animation-title').textContent").await;
    assert!(title.as_str().is_some_and(|title| title.starts_with("No layer ruptures: ")), "{title}");
    // With reduced motion it is a still frame, which the keyboard can step.
    page.devtools(
        "Emulation.setEmulatedMedia",
        json!({ "features": [{ "name": "prefers-reduced-motion", "value": "reduce" }] }),
    )
    .await;
    page.open("").await;
    let at = "return [trocar.animation().isPlaying, trocar.animation().at]";
    let before = page.evaluate(at).await;
    sleep(Duration::from_millis(200)).await;
    assert_eq!((&before[0], page.evaluate(at).await), (&Json::Bool(false), before.clone()));
    let slider = page.client.find(fantoccini::Locator::Css(".player input")).await.expect("a slider");
    slider.send_keys(&String::from(char::from(fantoccini::key::Key::Left))).await.expect("sent");
    assert_eq!(page.evaluate(at).await[1].as_u64(), before[1].as_u64().map(|at| at - 1));
    let spoken = slider.attr("aria-valuetext").await.expect("an attribute").unwrap_or_default();
    assert!(spoken.ends_with("ms after the rupture"), "{spoken}");
    page
}

/// Returns the ends of elements, in pixels from the top left of the window.
async fn ends(page: &BrowserPage, elements: &str) -> Vec<(String, f64, f64)> {
    let script = format!(
        "return [...document.querySelectorAll('{elements}')].map(one => {{
            const box = one.getBoundingClientRect(); return [one.id || one.getAttribute('class') || one.tagName, box.right, box.bottom]; }})"
    );
    serde_json::from_value(page.evaluate(&script).await).expect("places")
}

pub async fn layout(page: BrowserPage) -> BrowserPage {
    for (width, height, elements, count) in [
        (
            1280,
            800,
            "#answer, #animation svg, #animation .force, #chart-1 canvas, #chart-2 canvas, #front .control",
            15,
        ),
        (390, 844, "#answer, #animation svg, #chart-1 canvas, #front .control:first-child input", 6),
    ] {
        page.resize(width, height).await;
        page.open("").await;
        sleep(Duration::from_millis(300)).await;
        let ends = ends(&page, elements).await;
        assert!(ends.len() >= count, "{ends:?}");
        for (name, right, bottom) in ends {
            let is_inside = right <= f64::from(width) && bottom <= f64::from(height) && bottom > 0.0;
            assert!(is_inside, "{name} ends at {right}, {bottom} of {width}, {height}");
        }
    }
    // On a telephone the animation and a chart stay in view above the controls.
    page.evaluate("document.getElementById('all').scrollIntoView({ block: 'end' }); return null").await;
    sleep(Duration::from_millis(300)).await;
    assert!(page.evaluate("return scrollY").await.as_f64().is_some_and(|y| y > 100.0));
    for (name, _, bottom) in ends(&page, "#animation svg, #chart-1 canvas").await {
        assert!(bottom > 0.0 && bottom < 844.0, "{name} ends at {bottom}");
    }
    // The page opens with a zoom to the rupture at 5.52 s.
    let shown = page.evaluate("const { x } = trocarPictures.panel('position'); return [x.low, x.high]").await;
    let shown: (f64, f64) = serde_json::from_value(shown).expect("times");
    assert!(shown.0 > 5.0 && shown.0 < 5.52 && shown.1 > 5.52 && shown.1 < 8.0, "{shown:?}");
    page
}

pub async fn look(page: BrowserPage) -> BrowserPage {
    let mut light = vec![];
    for (name, width, height) in [("desktop", 1280, 800), ("telephone", 390, 844)] {
        page.resize(width, height).await;
        for theme in ["light", "dark"] {
            page.open("").await;
            page.still("trocar.animation()", theme).await;
            page.evaluate("document.getElementById('timing').textContent = ''; return null").await;
            let screenshot = page.client.screenshot().await.expect("a picture");
            assert_similar(&format!("{name}-{theme}"), &screenshot);
            if theme == "light" {
                light = screenshot;
            } else {
                assert!(changed_share(&light, &screenshot) > 0.5, "the themes differ");
            }
        }
    }
    page
}

/// Checks the accessibility of every page with axe-core, if `TROCAR_AXE` names its `axe.min.js`, and the length of a
/// printed report.
pub async fn axe(page: BrowserPage) -> BrowserPage {
    let folder = TestFolder::new();
    let sweep =
        "base = \"builtin:paper/augmented.toml\"\n[axes]\nscaling.force = [0.5, 1.0]\nscaling.position = [0.5, 1.0]\n";
    folder.file("sweep.toml", sweep);
    let made: [(&[&str], &str); 6] = [
        (&["compare", "--report"], "compare/report.html"),
        (&["run", "layers/skin-augmented", "--report"], "skin-augmented/report.html"),
        (&["stability", "paper/augmented", "--report"], "augmented/report.html"),
        (&["sweep", "sweep.toml", "--report"], "sweep/report.html"),
        (&["detect", "builtin:in_vivo_like.csv", "--contact-m", "0.012", "--report"], "in_vivo_like/report.html"),
        (&["paper"], "paper/paper.html"),
    ];
    let reports = made.map(|(words, file)| {
        folder.good(&[words, &["--quiet", "--out", words[0]]].concat());
        format!("file://{}", folder.path(words[0]).join(file).display())
    });
    page.client.goto(&reports[0]).await.expect("goes");
    sleep(Duration::from_millis(500)).await;
    let printed = page.devtools("Page.printToPDF", json!({})).await;
    let count = "return atob(arguments[0]).match(/\\/Type\\s*\\/Page[^s]/g).length";
    let pages = page.client.execute(count, vec![printed["data"].clone()]).await.expect("a count");
    assert!(pages.as_u64().is_some_and(|pages| (1..=6).contains(&pages)), "{pages} printed pages");
    let Some(axe) = std::env::var_os("TROCAR_AXE") else {
        eprintln!("left out: axe-core, as TROCAR_AXE does not name its axe.min.js");
        return page;
    };
    let axe = std::fs::read_to_string(axe).expect("axe.min.js");
    let mut found = vec![];
    let address = format!("http://{}/", page.address);
    // Also check the page at the size of a telephone, with the result of an insertion by hand.
    let pages = [(&address, 1400, false), (&address, 390, true)].into_iter();
    for (address, width, is_pushed) in pages.chain(reports.iter().map(|report| (report, 1400, false))) {
        page.resize(width, 900).await;
        page.client.goto("about:blank").await.expect("goes");
        page.client.goto(address).await.expect("goes");
        sleep(Duration::from_millis(if address.starts_with("http") { 1500 } else { 300 })).await;
        if is_pushed {
            page.element("push-open").await.click().await.expect("opened");
            page.wait("return !!trocarPush.state()?.range").await;
            page.element("push").await.click().await.expect("ended");
            page.wait("return !document.getElementById('push-result').hidden").await;
        }
        for theme in ["light", "dark"] {
            page.evaluate(&format!(
                "document.documentElement.dataset.theme = '{theme}'; window.dispatchEvent(new Event('themechange'));
                 document.querySelectorAll('details').forEach(one => {{ one.open = true; }}); return null"
            ))
            .await;
            let run = format!(
                "{axe}; const done = arguments[arguments.length - 1]; axe.run({{ resultTypes: ['violations'], rules: {{ 'target-size': {{ enabled: true }} }} }})
                 .then(found => done(found.violations.map(one => [one.id, one.nodes.map(node => node.html)])))"
            );
            let violations = page.client.execute_async(&run, vec![]).await.expect("a result");
            if violations != json!([]) {
                found.push(format!("{address}, {width} pixels wide, in the {theme} theme: {violations}"));
            }
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
    page
}

/// Moves a slider while the animation plays, and prints the times between frames.
pub async fn playing(page: BrowserPage) -> BrowserPage {
    page.open("").await;
    let script = "window.frames_ms = []; window.shown = new Set(); let last = null;
        const slider = document.getElementById('key-scaling-force');
        const step = (now) => {
            if (last !== null) frames_ms.push(now - last);
            last = now;
            shown.add(trocar.animation().at);
            slider.value = 100 + 60 * Math.sin(now / 300);
            slider.dispatchEvent(new Event('input', { bubbles: true }));
            if (frames_ms.length < 240) requestAnimationFrame(step);
        };
        requestAnimationFrame(step); return null";
    page.evaluate(script).await;
    page.wait("return frames_ms.length === 240").await;
    let mut frames_ms: Vec<f64> = serde_json::from_value(page.evaluate("return frames_ms").await).expect("times");
    frames_ms.sort_by(f64::total_cmp);
    let late = frames_ms.iter().filter(|ms| **ms > 20.0).count();
    eprintln!(
        "240 frames beside a moving slider: median {:.1} ms, {late} over 20 ms, longest {:.1} ms",
        frames_ms[120], frames_ms[239]
    );
    let shown = page.evaluate("return shown.size").await;
    assert!(shown.as_u64().is_some_and(|shown| shown > 50), "{shown} frames of the animation");
    page
}
