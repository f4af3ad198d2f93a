//! Actions of a user on the page, and their results.

use std::path::Path;
use std::time::Duration;

use fantoccini::actions::{InputSource, MouseActions, PointerAction};
use fantoccini::key::Key;
use serde_json::{Value as Json, json};
use tokio::time::sleep;

use crate::page::{Body, BrowserPage};
use crate::test_folder::TestFolder;

pub const ALL: [(&str, Body); 24] = [
    // The longest trial comes first, so that it does not run alone at the end.
    ("thirteen_tasks_are_done_by_keys_alone_at_four_sizes", |page| Box::pin(crate::tasks::tasks(page))),
    ("every_control_can_be_reached_at_every_size", |page| Box::pin(crate::tasks::sizes(page))),
    ("the_keys_of_charts_move_zoom_and_tell_what_the_trace_has", |page| Box::pin(crate::charts::keys(page))),
    ("the_number_under_the_pointer_is_the_drawn_boundary", |page| Box::pin(crate::charts::boundary(page))),
    ("only_a_frozen_needle_is_called_frozen", |page| Box::pin(crate::charts::events(page))),
    ("forced_colours_hide_no_curve", |page| Box::pin(crate::charts::forced_colours(page))),
    ("a_push_is_heard_felt_and_compared_with_both_schemes", |page| Box::pin(crate::pushing::push(page))),
    ("a_force_bar_is_full_at_the_same_force", |page| Box::pin(crate::pushing::scale(page))),
    ("undo_back_and_the_address_hold_settings_zoom_and_time", |page| Box::pin(crate::steps::undo(page))),
    ("the_page_reports_an_ended_server_and_continues_with_a_new_one", |page| Box::pin(crate::steps::ended(page))),
    ("a_decimal_comma_is_understood_and_nothing_moves", |page| Box::pin(crate::steps::comma(page))),
    ("axe_finds_no_violation_on_page_and_report", |page| Box::pin(crate::picture::axe(page))),
    ("the_animation_draws_the_trace_and_the_bracket_is_the_metric", |page| Box::pin(crate::picture::animation(page))),
    ("the_result_and_the_controls_in_front_fit_the_window", |page| Box::pin(crate::picture::layout(page))),
    ("the_page_looks_as_it_did", |page| Box::pin(crate::picture::look(page))),
    ("the_animation_plays_beside_a_moving_slider", |page| Box::pin(crate::picture::playing(page))),
    ("the_warnings_of_both_runs_are_listed", |page| Box::pin(warnings(page))),
    ("a_slider_moves_the_metrics_to_what_compare_prints", |page| Box::pin(slider(page))),
    ("what_is_no_number_is_wrong_and_a_refused_value_dims_the_curves", |page| Box::pin(refused(page))),
    ("from_input_to_picture", |page| Box::pin(timing(page))),
    ("a_click_on_the_map_moves_the_controls_and_the_address_holds_it", |page| Box::pin(map(page))),
    ("what_is_exported_runs_to_the_same_bytes", |page| Box::pin(export(page))),
    ("a_finger_zooms_a_chart_and_scrolls_the_page", |page| Box::pin(touch(page))),
    ("screenshots", |page| Box::pin(screenshots(page))),
];

/// Returns the lines that `compare` prints for the shipped pair with these settings.
fn compared(settings: &[&str]) -> Vec<String> {
    let settings = settings.iter().flat_map(|setting| ["--set", setting]);
    let arguments = ["compare", "--all", "paper/classical", "paper/augmented"].into_iter().chain(settings);
    let text = TestFolder::new().good(&arguments.collect::<Vec<_>>());
    // The terminal wraps the longest labels, those of the noise checks.
    let is_row = |line: &&str| !line.is_empty() && !line.starts_with("in noise");
    text.split("\n\n").nth(2).expect("all metrics").lines().skip(2).take_while(is_row).map(squeezed).collect()
}

fn squeezed(line: &str) -> String {
    line.split_whitespace().collect::<Vec<_>>().join(" ")
}

async fn lines(page: &BrowserPage) -> Vec<String> {
    let rows = page.table().await.into_iter().map(|cells| squeezed(&cells.join(" ")));
    rows.filter(|line| !line.starts_with("in noise")).collect()
}

async fn slider(page: BrowserPage) -> BrowserPage {
    page.open("").await;
    let printed = compared(&[]);
    assert!(printed.len() > 30);
    assert_eq!(lines(&page).await, printed);
    let slider = page.element("key-scaling-force").await;
    for _ in 0..10 {
        slider.send_keys(&String::from(char::from(Key::Right))).await.expect("moved");
    }
    page.wait("return !trocar.busy() && trocar.state.set['scaling.force'] > 1.2").await;
    let force = page.evaluate("return trocar.state.set['scaling.force']").await;
    let moved = compared(&[&format!("scaling.force={force}")]);
    assert_ne!(moved, printed);
    assert_eq!(lines(&page).await, moved);
    page
}

async fn warnings(page: BrowserPage) -> BrowserPage {
    page.open("").await;
    assert_eq!(page.evaluate("return document.getElementById('warnings').hidden").await, Json::Bool(true));
    page.open("detector.threshold=100").await;
    let text = page.text("warnings").await;
    assert!(page.text("answer").await.contains("missed in both runs (below the threshold"));
    assert!(text.contains("classical and augmented: rupture 1 at 5.520 s missed: below the threshold"), "{text}");
    assert!(text.contains("missed-rupture") && text.contains("detector.threshold"), "{text}");
    page
}

/// Texts that are not numbers and refused values change nothing and are marked as wrong.
async fn refused(page: BrowserPage) -> BrowserPage {
    page.open("").await;
    let number = page.element("key-scaling-force-number").await;
    let wrong =
        "return document.getElementById('key-scaling-force-number').closest('.control').classList.contains('wrong')";
    let all = format!("{}a{}", char::from(Key::Control), char::from(Key::Null));
    for text in ["1e999", "--"] {
        number.send_keys(&format!("{all}{text}{}", char::from(Key::Tab))).await.expect("typed");
        page.wait(wrong).await;
        let outdated = page.evaluate("return trocar.state.set['scaling.force'] === undefined").await;
        assert_eq!(outdated, Json::Bool(true), "{text}");
    }
    // The browser accepts it as a number, but the scenario does not.
    number.send_keys(&format!("{all}-3{}", char::from(Key::Tab))).await.expect("typed");
    page.wait("return document.getElementById('main').classList.contains('outdated')").await;
    assert!(page.text("status").await.contains("last valid values"));
    number.send_keys(&format!("{all}2{}", char::from(Key::Tab))).await.expect("typed");
    page.wait("return !trocar.busy() && !document.getElementById('main').classList.contains('outdated')").await;
    // Several refused values are marked at once, each at its control.
    page.client.goto("about:blank").await.expect("goes");
    let state = "scaling.force=-1&detector.threshold=-2&tissue.contact_m=%22deep%22";
    page.client.goto(&format!("http://{}/#{state}", page.address)).await.expect("goes");
    let marked = "return [...document.querySelectorAll('.control.wrong')].map(box => box.dataset.key).sort().join()";
    page.wait(&format!("{} === 'detector.threshold,scaling.force,tissue.contact_m'", marked)).await;
    // A control without effect is disabled and says why.
    let script = "const box = document.querySelector('[data-key=\"operator.speed_m_per_s\"]');
        return [box.querySelector('.reason').textContent, box.querySelector('input').disabled]";
    let inactive = page.evaluate(script).await;
    assert!(inactive[0].as_str().is_some_and(|reason| reason.contains("operator.kind")), "{inactive}");
    assert_eq!(inactive[1], Json::Bool(true));
    page
}

/// Prints the time from the input to the drawn frame. A browser delivers pointer moves with a frame of the screen,
/// but a key at any time between two frames.
async fn timing(page: BrowserPage) -> BrowserPage {
    page.resize(1280, 800).await;
    // 7 s of insertion through the skin in ticks of 1 ms, classical and augmented.
    page.open("scenario=builtin:layers/skin-augmented.toml&simulation.duration_s=7").await;
    let slider = page.element("key-scaling-force").await;
    let (mut by_key, mut by_drag) = (vec![], vec![]);
    for _ in 0..40 {
        let key = async || slider.send_keys(&String::from(char::from(Key::Right))).await.expect("moved");
        by_key.push(timing_of(&page, key).await);
    }
    let spot = "const box = document.getElementById('key-scaling-force').getBoundingClientRect();
        return [box.left + box.width / 2, box.top + box.height / 2]";
    let spot = page.evaluate(spot).await;
    let mouse = async |event: &str, x: i32| {
        let x = spot[0].as_f64().expect("a place").round() + f64::from(x);
        let at = json!({ "type": event, "x": x, "y": spot[1], "button": "left", "buttons": 1, "clickCount": 1 });
        page.devtools("Input.dispatchMouseEvent", at).await;
    };
    timing_of(&page, async || mouse("mousePressed", -30).await).await;
    // To the right and back, by 3 pixels each.
    for x in (-9..=10).chain((-10..=9).rev()) {
        by_drag.push(timing_of(&page, async || mouse("mouseMoved", 3 * x).await).await);
    }
    mouse("mouseReleased", -30).await;
    let build = std::env::var("TROCAR_BIN").unwrap_or_else(|_| "as tests are built".into());
    for (how, times) in [("a key", by_key), ("a drag", by_drag)] {
        for (index, what) in
            ["two 7 s insertions on the server", "from the input to the drawn frame"].iter().enumerate()
        {
            let mut ms: Vec<f64> = times.iter().map(|time| time[index]).collect();
            ms.sort_by(f64::total_cmp);
            eprintln!("{how} ({build}): {what}: best {:.1} ms, median {:.1} ms, worst {:.1} ms", ms[0], ms[20], ms[39]);
        }
    }
    page
}

/// Moves the slider. Returns the time of the server, and the time from the input to the drawn frame, in ms.
async fn timing_of(page: &BrowserPage, moved: impl AsyncFnOnce()) -> [f64; 2] {
    page.evaluate("trocar.timings.length = 0").await;
    moved().await;
    page.wait("return !trocar.busy() && trocar.timings.some(t => t.total_ms !== null)").await;
    let times = page
        .evaluate("const t = trocar.timings.find(t => t.total_ms !== null); return [t.server_ms, t.total_ms]")
        .await;
    [0, 1].map(|index| times[index].as_f64().expect("a time"))
}

async fn map(page: BrowserPage) -> BrowserPage {
    page.open("y=tissue.stiffness_n_per_m").await;
    page.wait("return trocarMap.current() !== null").await;
    // The last rows of the table move what is below them: the pointer would miss the map.
    page.table().await;
    let ends = "const { x, y } = trocarMap.current(); return [x.low, x.high, y.low, y.high]";
    let before = page.evaluate(ends).await;
    let map = page.element("map").await;
    page.client
        .execute("arguments[0].scrollIntoView({block: 'center'})", vec![serde_json::to_value(&map).expect("JSON")])
        .await
        .expect("scrolled");
    let spot = page.evaluate("const c = document.getElementById('map'), b = c.getBoundingClientRect(), s = trocarMap.spot(c, 8, 1500); return [s[0] - b.width / 2, s[1] - b.height / 2]").await;
    let at = |index: usize| spot[index].as_f64().expect("a number").round();
    let mouse = MouseActions::new("mouse".into())
        .then(PointerAction::MoveToElement { element: map, duration: None, x: at(0), y: at(1) })
        .then(PointerAction::Down { button: 0 })
        .then(PointerAction::Up { button: 0 });
    page.client.perform_actions(mouse).await.expect("clicked");
    page.wait("return trocar.state.set['scaling.force'] > 6").await;
    let set = page.evaluate("return trocar.state.set").await;
    let near = |key: &str, value: f64| (set[key].as_f64().expect("a number") / value - 1.0).abs() < 0.05;
    assert!(near("scaling.force", 8.0) && near("tissue.stiffness_n_per_m", 1500.0), "{set}");
    // This corner of the map is beyond the boundary, according to `trocar stability`.
    page.wait("return document.getElementById('map-text').textContent.includes(': not stable in contact')").await;
    assert_eq!(page.evaluate(ends).await, before, "the map stays where it is");
    let address = page.client.current_url().await.expect("there");
    let state = address.fragment().expect("the state").to_owned();
    page.open(&state).await;
    assert_eq!(page.evaluate("return trocar.state.set").await, set);
    let shown = page.evaluate("return document.getElementById('key-scaling-force-number').value").await;
    assert_eq!(shown.as_str().and_then(|text| text.parse().ok()), set["scaling.force"].as_f64());
    page
}

async fn export(page: BrowserPage) -> BrowserPage {
    page.open(
        "scenario=builtin:paper/augmented.toml&scaling.force=1.5&sensor.force_noise_std_n=0.01&simulation.seed=7",
    )
    .await;
    let folder = TestFolder::new();
    let (name, toml) = page.file("export-toml").await;
    let (_, csv) = page.file("export-csv").await;
    assert!(toml.contains("force = 1.5") && name.ends_with(".toml"), "{name}: {toml}");
    folder.file(&name, &toml).good(&["run", &name, "--quiet"]);
    let scenario = name.trim_end_matches(".toml");
    assert!(folder.text(&format!("out/{scenario}/trace.csv")) == csv, "the same bytes");
    assert_eq!(folder.text(&format!("out/{scenario}/scenario.toml")), toml);
    // The displayed command gives the same file.
    let command = page.text("command").await.replace('\'', "");
    let arguments = command.split_whitespace().skip(1).chain(["--out", "typed"]);
    folder.good(&arguments.collect::<Vec<_>>());
    assert!(folder.text(&format!("typed/{scenario}/trace.csv")) == csv, "the same bytes");
    page.element("export-png").await.click().await.expect("clicked");
    page.wait("return trocar.file().name.endsWith('augmented.png') && trocar.file().size > 10000").await;
    // The picture has the chosen width at 300 dots per inch and shows the chosen run.
    let width = "const { content } = trocar.file(), at = content.byteOffset; return new DataView(content.buffer).getUint32(at + 16)";
    assert_eq!(page.evaluate(width).await, json!(2148));
    page.evaluate("document.getElementById('export-width').value = '3.5in'; document.getElementById('export-scheme').value = '0'; return null").await;
    page.element("export-png").await.click().await.expect("clicked");
    page.wait("return trocar.file().name.endsWith('augmented_classical.png')").await;
    assert_eq!(page.evaluate(width).await, json!(1050));
    page
}

/// Sends the steps of a finger: the name of an event, and the touched point if any.
async fn finger(page: &BrowserPage, steps: &[(&str, Option<(f64, f64)>)]) {
    for (event, point) in steps {
        let points: Vec<Json> = point.iter().map(|(x, y)| json!({ "x": x, "y": y })).collect();
        page.devtools("Input.dispatchTouchEvent", json!({ "type": event, "touchPoints": points })).await;
        sleep(Duration::from_millis(30)).await;
    }
}

async fn touch(page: BrowserPage) -> BrowserPage {
    page.devtools("Emulation.setTouchEmulationEnabled", json!({ "enabled": true })).await;
    page.resize(390, 844).await;
    page.open("").await;
    let place = "const box = document.querySelector('#chart-1 canvas').getBoundingClientRect(); return [box.left, box.top, box.width, box.height]";
    let of_chart: [f64; 4] = serde_json::from_value(page.evaluate(place).await).expect("a place");
    let at = |share: f64| Some((of_chart[0] + share * of_chart[2], of_chart[1] + 0.5 * of_chart[3]));
    let shown = "const { x } = trocarPictures.panel('position'); return x.high - x.low";
    let before = page.evaluate(shown).await.as_f64().expect("a time");
    // A finger moved across a chart selects, and two taps show everything.
    let across = [("touchStart", at(0.3)), ("touchMove", at(0.4)), ("touchMove", at(0.6)), ("touchEnd", None)];
    finger(&page, &across).await;
    page.wait(&format!("return (() => {{ {shown} }})() < {}", 0.6 * before)).await;
    let taps = [("touchStart", at(0.5)), ("touchEnd", None), ("touchStart", at(0.5)), ("touchEnd", None)];
    finger(&page, &taps).await;
    page.wait(&format!("return (() => {{ {shown} }})() > {}", 1.5 * before)).await;
    // A finger moved down a chart scrolls the page.
    let down = [0.9, 0.6, 0.3, 0.0, -0.5, -1.0]
        .map(|share| ("touchMove", Some((of_chart[0] + 0.5 * of_chart[2], of_chart[1] + share * of_chart[3]))));
    finger(&page, &[("touchStart", at(0.5))]).await;
    finger(&page, &down).await;
    finger(&page, &[("touchEnd", None)]).await;
    page.wait("return scrollY > 20").await;
    page
}

/// Writes the pictures of the README if a folder for them is given.
async fn screenshots(page: BrowserPage) -> BrowserPage {
    page.resize(1280, 800).await;
    page.open("scenario=builtin:paper/augmented.toml").await;
    page.table().await;
    page.still("trocar.animation()", "light").await;
    let explored = page.client.screenshot().await.expect("a picture");
    assert!(explored.len() > 20_000, "a page that is not empty");
    let folder = TestFolder::new();
    folder.good(&["compare", "builtin:paper/classical.toml", "builtin:paper/augmented.toml", "--report", "--quiet"]);
    // With reduced motion, the picture is the same every time.
    let reduced = json!({ "features": [{ "name": "prefers-reduced-motion", "value": "reduce" }] });
    page.devtools("Emulation.setEmulatedMedia", reduced).await;
    page.client.goto(&format!("file://{}", folder.path("out/compare/report.html").display())).await.expect("goes");
    page.evaluate("document.documentElement.dataset.theme = 'light'; return null").await;
    sleep(Duration::from_millis(1000)).await;
    let report = page.client.screenshot().await.expect("a picture");
    assert!(report.len() > 20_000, "a report that is not empty");
    if let Ok(folder) = std::env::var("TROCAR_SCREENSHOTS") {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
        std::fs::create_dir_all(&folder).expect("created");
        std::fs::write(folder.join("explore.png"), explored).expect("written");
        std::fs::write(folder.join("report.png"), report).expect("written");
    }
    page
}
