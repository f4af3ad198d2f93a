//! What a person does at the page, and what they see.

use std::path::Path;
use std::time::Duration;

use assert_cmd::Command;
use fantoccini::Locator;
use fantoccini::actions::{InputSource, MouseActions, PointerAction};
use fantoccini::key::Key;
use serde_json::Value as Json;
use tokio::time::sleep;

use crate::desk::{Body, Desk};

/// Every trial.
pub const ALL: [(&str, Body); 7] = [
    ("a_slider_moves_the_metrics_to_what_compare_prints", |desk| Box::pin(slider(desk))),
    ("from_input_to_picture", |desk| Box::pin(timing(desk))),
    ("a_click_on_the_map_moves_the_controls_and_the_address_holds_it", |desk| Box::pin(map(desk))),
    ("the_pointer_pushes_through_a_rupture_and_the_slave_freezes", |desk| Box::pin(push(desk))),
    ("what_is_exported_runs_to_the_same_bytes", |desk| Box::pin(export(desk))),
    ("it_is_used_by_keys_alone_and_fits_narrow_windows", |desk| Box::pin(access(desk))),
    ("screenshots", |desk| Box::pin(screenshots(desk))),
];

/// The lines that `compare` prints of the shipped pair with settings.
fn compared(settings: &[&str]) -> Vec<String> {
    let folder = tempfile::tempdir().expect("a folder");
    let mut command = Command::cargo_bin("trocar").expect("built");
    command.current_dir(folder.path()).args(["compare", "builtin:classical.toml", "builtin:augmented.toml"]);
    for setting in settings {
        command.args(["--set", setting]);
    }
    let output = command.assert().success();
    let text = String::from_utf8(output.get_output().stdout.clone()).expect("text");
    text.lines().skip(2).take_while(|line| !line.is_empty()).map(squeezed).collect()
}

/// A line with single blanks.
fn squeezed(line: &str) -> String {
    line.split_whitespace().collect::<Vec<_>>().join(" ")
}

async fn lines(desk: &Desk) -> Vec<String> {
    desk.table().await.into_iter().map(|cells| squeezed(&cells.join(" "))).collect()
}

async fn slider(desk: Desk) -> Desk {
    desk.open("").await;
    let printed = compared(&[]);
    assert!(printed.len() > 30);
    assert_eq!(lines(&desk).await, printed);
    let slider = desk.element("key-scaling-force").await;
    for _ in 0..10 {
        slider.send_keys(&String::from(char::from(Key::Right))).await.expect("moved");
    }
    desk.wait("return !trocar.busy() && trocar.state.set['scaling.force'] > 1.2").await;
    let force = desk.ask("return trocar.state.set['scaling.force']").await;
    let moved = compared(&[&format!("scaling.force={force}")]);
    assert_ne!(moved, printed);
    assert_eq!(lines(&desk).await, moved);
    desk
}

async fn timing(desk: Desk) -> Desk {
    // 7 s of insertion through the skin, in ticks of 1 ms, classical and augmented.
    desk.open("scenario=builtin:01_augmented.toml&simulation.duration_s=7").await;
    let slider = desk.element("key-scaling-force").await;
    for count in 0..40 {
        slider.send_keys(&String::from(char::from(Key::Right))).await.expect("moved");
        desk.wait(&format!(
            "return !trocar.busy() && trocar.timings.filter(t => t.total_ms !== null).length > {count}"
        ))
        .await;
    }
    let timings = desk.ask("return trocar.timings.filter(t => t.total_ms !== null)").await;
    let of = |name: &str| {
        let mut values: Vec<f64> =
            timings.as_array().into_iter().flatten().filter_map(|one| one[name].as_f64()).collect();
        values.sort_by(f64::total_cmp);
        values
    };
    let (server, total) = (of("server_ms"), of("total_ms"));
    assert_eq!((server.len(), total.len()), (40, 40));
    let told =
        |values: &[f64]| format!("best {:.1} ms, median {:.1} ms, worst {:.1} ms", values[0], values[20], values[39]);
    let build = std::env::var("TROCAR_BIN").unwrap_or_else(|_| "as tests are built".into());
    eprintln!("two 7 s insertions on the server ({build}): {}", told(&server));
    eprintln!("from the input event to the drawn frame: {}", told(&total));
    desk
}

async fn map(desk: Desk) -> Desk {
    desk.open("").await;
    desk.wait("return trocarMap.told() !== null").await;
    let map = desk.element("map").await;
    desk.client
        .execute("arguments[0].scrollIntoView({block: 'center'})", vec![serde_json::to_value(&map).expect("JSON")])
        .await
        .expect("scrolled");
    let spot = desk.ask("const c = document.getElementById('map'), b = c.getBoundingClientRect(), s = trocarMap.spot(c, 8, 1500); return [s[0] - b.width / 2, s[1] - b.height / 2]").await;
    let at = |index: usize| spot[index].as_f64().expect("a number").round();
    let mouse = MouseActions::new("mouse".into())
        .then(PointerAction::MoveToElement { element: map, duration: None, x: at(0), y: at(1) })
        .then(PointerAction::Down { button: 0 })
        .then(PointerAction::Up { button: 0 });
    desk.client.perform_actions(mouse).await.expect("clicked");
    desk.wait("return trocar.state.set['scaling.force'] > 6").await;
    let set = desk.ask("return trocar.state.set").await;
    let near = |key: &str, value: f64| (set[key].as_f64().expect("a number") / value - 1.0).abs() < 0.05;
    assert!(near("scaling.force", 8.0) && near("tissue.stiffness_n_per_m", 1500.0), "{set}");
    // Beyond the boundary of this corner of the map, as `trocar stability` draws it.
    desk.wait("return document.getElementById('map-told').textContent.includes('unstable')").await;
    let address = desk.client.current_url().await.expect("there");
    let state = address.fragment().expect("the state").to_owned();
    desk.open(&state).await;
    assert_eq!(desk.ask("return trocar.state.set").await, set);
    let shown = desk.ask("return document.getElementById('key-scaling-force-number').value").await;
    assert_eq!(shown.as_str().and_then(|text| text.parse().ok()), set["scaling.force"].as_f64());
    desk
}

async fn push(desk: Desk) -> Desk {
    desk.open("scenario=builtin:01_augmented.toml").await;
    let field = desk.element("field").await;
    desk.element("push").await.click().await.expect("clicked");
    desk.wait("return !!trocarPush.state()?.range").await;
    desk.client
        .execute("arguments[0].scrollIntoView({block: 'center'})", vec![serde_json::to_value(&field).expect("JSON")])
        .await
        .expect("scrolled");
    let height = desk.ask("return document.getElementById('field').getBoundingClientRect().height").await;
    let top = -height.as_f64().expect("a number") / 2.0 + 16.0;
    let mouse = MouseActions::new("mouse".into())
        .then(PointerAction::MoveToElement { element: field, duration: None, x: 0.0, y: top })
        .then(PointerAction::Down { button: 0 });
    desk.client.perform_actions(mouse).await.expect("pressed");
    // What the page tells for a third of a second may be over when it is asked: it is written down there.
    let watch = "const told = document.getElementById('push-mode'); window.modes = [told.textContent];
        new MutationObserver(() => modes.push(told.textContent)).observe(told, { childList: true }); return null";
    desk.ask(watch).await;
    for _ in 0..15 {
        // Ten at once: the driver moves as fast as it is told, however slowly it answers.
        let step = PointerAction::MoveBy { duration: Some(Duration::from_millis(15)), x: 0.0, y: 3.0 };
        let down = (0..10).fold(MouseActions::new("mouse".into()), |down, _| down.then(step.clone()));
        desk.client.perform_actions(down).await.expect("pulled");
        if desk.ask("return trocarPush.state().rows.some(row => row[6] === 1)").await == Json::Bool(true) {
            break;
        }
    }
    let modes: Vec<String> = serde_json::from_value(desk.ask("return modes").await).expect("texts");
    assert_eq!(modes.first().map(String::as_str), Some("teleoperation"));
    assert!(modes.iter().any(|mode| mode.contains("the slave is frozen")), "{modes:?}");
    // What was told of the first frozen stretch: the hand goes on, the slave does not.
    sleep(Duration::from_millis(300)).await;
    let first = "const rows = trocarPush.state().rows, from = rows.slice(rows.findIndex(row => row[6] === 1));
        const end = from.findIndex(row => row[6] !== 1); return end < 0 ? from : from.slice(0, end)";
    let rows = desk.ask(first).await;
    let span = |column: usize| {
        let values: Vec<f64> = rows.as_array().expect("rows").iter().filter_map(|row| row[column].as_f64()).collect();
        values.iter().copied().fold(f64::NEG_INFINITY, f64::max) - values.iter().copied().fold(f64::INFINITY, f64::min)
    };
    assert!(span(3) < 0.5, "the slave moved by {} mm while frozen", span(3));
    assert!(span(2) > span(3), "the master moved by {} mm", span(2));
    let events = desk.ask("return trocarPush.state().events.map(event => event[1])").await;
    assert!(events.as_array().is_some_and(|all| all.iter().any(|event| event == "rupture")), "{events}");
    desk.element("push").await.click().await.expect("ended");
    desk
}

async fn export(desk: Desk) -> Desk {
    desk.open("scenario=builtin:augmented.toml&scaling.force=1.5&sensor.force_noise_std_n=0.01&simulation.seed=7")
        .await;
    let folder = tempfile::tempdir().expect("a folder");
    let (name, toml) = desk.file("export-toml").await;
    let (_, csv) = desk.file("export-csv").await;
    assert!(toml.contains("force = 1.5") && name.ends_with(".toml"), "{name}: {toml}");
    std::fs::write(folder.path().join(&name), &toml).expect("written");
    let run = |folder: &Path, name: &str| {
        Command::cargo_bin("trocar")
            .expect("built")
            .current_dir(folder)
            .args(["run", name, "--quiet"])
            .assert()
            .success();
    };
    run(folder.path(), &name);
    let out = folder.path().join("out").join(name.trim_end_matches(".toml"));
    assert!(std::fs::read_to_string(out.join("trace.csv")).expect("there") == csv, "the same bytes");
    assert_eq!(std::fs::read_to_string(out.join("scenario.toml")).expect("there"), toml);
    // What the page says that one should type gives the same too.
    let command = desk.text("command").await.replace('\'', "");
    let arguments: Vec<&str> = command.split_whitespace().skip(1).collect();
    let typed = Command::cargo_bin("trocar")
        .expect("built")
        .current_dir(folder.path())
        .args(arguments)
        .args(["--out", "typed"])
        .assert();
    typed.success();
    let typed = folder.path().join("typed").join(name.trim_end_matches(".toml"));
    assert!(std::fs::read_to_string(typed.join("trace.csv")).expect("there") == csv, "the same bytes");
    desk.element("export-png").await.click().await.expect("clicked");
    desk.wait("return trocar.file().name.endsWith('.png') && trocar.file().size > 10000").await;
    desk
}

async fn access(desk: Desk) -> Desk {
    desk.open("").await;
    let tab = String::from(char::from(Key::Tab));
    let body = desk.client.find(Locator::Css("body")).await.expect("a body");
    body.send_keys(&tab).await.expect("sent");
    let mut reached: Vec<String> = vec![];
    for _ in 0..90 {
        let active = desk.client.active_element().await.expect("one");
        let id = active.attr("id").await.expect("asked").unwrap_or_default();
        reached.push(id);
        active.send_keys(&tab).await.expect("sent");
    }
    for id in
        ["scenario", "theme", "find", "key-scaling-force", "map-x", "map", "listen", "push", "field", "export-toml"]
    {
        assert!(reached.iter().any(|one| one == id), "{id} is not reached by Tab: {reached:?}");
    }
    // Without names nothing of this is heard.
    let nameless = "return [...document.querySelectorAll('input, select, button, canvas[tabindex], [role]')].filter(e => !(e.labels?.length || e.getAttribute('aria-label') || e.getAttribute('aria-labelledby') || e.textContent.trim() || e.role === 'status' || e.role === 'alert')).map(e => e.outerHTML)";
    assert_eq!(desk.ask(nameless).await, Json::Array(vec![]));
    // 1400 pixels at 125 %, a small window, a telephone.
    for (width, height) in [(1120, 800), (800, 600), (500, 800)] {
        desk.client.set_window_size(width, height).await.expect("set");
        sleep(Duration::from_millis(300)).await;
        let wide = desk.ask("return [document.documentElement.scrollWidth, innerWidth]").await;
        assert!(wide[0].as_u64() <= wide[1].as_u64(), "at {width}: {wide}");
    }
    desk
}

/// The README's pictures, where a folder for them is given.
async fn screenshots(desk: Desk) -> Desk {
    desk.open("scenario=builtin:augmented.toml").await;
    desk.table().await;
    desk.client.set_window_size(1400, 1000).await.expect("set");
    desk.ask(
        "document.documentElement.dataset.theme = 'light'; window.dispatchEvent(new Event('themechange')); return null",
    )
    .await;
    sleep(Duration::from_millis(500)).await;
    let page = desk.client.screenshot().await.expect("a picture");
    assert!(page.len() > 20_000, "a page that shows something");
    let folder = tempfile::tempdir().expect("a folder");
    let pair = ["compare", "builtin:classical.toml", "builtin:augmented.toml", "--report", "--quiet"];
    Command::cargo_bin("trocar").expect("built").current_dir(folder.path()).args(pair).assert().success();
    desk.client.goto(&format!("file://{}", folder.path().join("out/report.html").display())).await.expect("goes");
    desk.ask("document.getElementById('signals').scrollIntoView(); return null").await;
    sleep(Duration::from_millis(1000)).await;
    let report = desk.client.screenshot().await.expect("a picture");
    assert!(report.len() > 20_000, "a report that shows something");
    if let Ok(folder) = std::env::var("TROCAR_SCREENSHOTS") {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
        std::fs::create_dir_all(&folder).expect("made");
        std::fs::write(folder.join("explore.png"), page).expect("written");
        std::fs::write(folder.join("report.png"), report).expect("written");
    }
    desk
}
