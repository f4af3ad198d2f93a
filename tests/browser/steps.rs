//! Steps of a session: undo, Back, the address, and typed values.

use std::process::Command;
use std::time::Duration;

use fantoccini::key::Key;
use serde_json::json;
use tokio::time::sleep;

use crate::page::BrowserPage;
use crate::server::Running;

/// The state that a step can change.
const STATE: &str = "const { x } = trocarPictures.panel('position');
    return [trocar.state.set, [x.low, x.high].map((at) => Number(at.toFixed(2))), document.getElementById('key-scaling-force-number').value]";

pub async fn undo(page: BrowserPage) -> BrowserPage {
    page.open("").await;
    assert!(page.client.title().await.expect("a title").starts_with("The insertion of the paper"));
    assert_eq!(page.evaluate("return document.getElementById('undo').disabled").await, json!(true));
    let mut states = vec![page.evaluate(STATE).await];
    let settled = async || {
        page.wait("return !trocar.busy()").await;
        // Wait, so that the next change is another step.
        sleep(Duration::from_millis(900)).await;
    };
    // Two settings and a zoom are one step each.
    for (control, keys) in [("key-scaling-force", 3), ("key-scaling-position", 2)] {
        let slider = page.element(control).await;
        slider.send_keys(&String::from(char::from(Key::Right)).repeat(keys)).await.expect("moved");
        settled().await;
        states.push(page.evaluate(STATE).await);
    }
    let chart = page.client.find(fantoccini::Locator::Css("#chart-1 canvas")).await.expect("a chart");
    chart.send_keys("e+").await.expect("pressed");
    settled().await;
    states.push(page.evaluate(STATE).await);
    assert!((1..states.len()).all(|index| states[index] != states[index - 1]), "{states:?}");
    // The address contains the whole state: another page shows the same, with its animation at the time of the
    // cursor.
    let address = page.client.current_url().await.expect("there");
    let fragment = address.fragment().expect("the state").to_owned();
    assert!(fragment.contains("time=") && fragment.contains("at=5.52"), "{fragment}");
    // Undo by the button, by Ctrl+Z and by Back each go back by one step.
    page.element("undo").await.click().await.expect("clicked");
    settled().await;
    assert_eq!(page.evaluate(STATE).await, states[2]);
    let body = page.client.find(fantoccini::Locator::Css("body")).await.expect("a body");
    body.send_keys(&format!("{}z{}", char::from(Key::Control), char::from(Key::Null))).await.expect("pressed");
    settled().await;
    assert_eq!(page.evaluate(STATE).await, states[1]);
    page.client.back().await.expect("back");
    settled().await;
    assert_eq!(page.evaluate(STATE).await, states[0]);
    assert_eq!(page.evaluate("return document.getElementById('undo').disabled").await, json!(true));
    page.client.forward().await.expect("forward");
    settled().await;
    assert_eq!(page.evaluate(STATE).await, states[1]);
    page.open(&fragment).await;
    page.wait("return trocar.animation()?.isPlaying === false").await;
    assert_eq!(page.evaluate(STATE).await, states[3]);
    let at = page.evaluate("const a = trocar.animation(); return a.data.time_s[a.at]").await;
    assert!(at.as_f64().is_some_and(|at| (at - 5.52).abs() < 0.003), "{at}");
    // Another scenario has another title, and Back returns to the first one.
    page.evaluate("const menu = document.getElementById('scenario'); menu.value = 'builtin:strategies/cue.toml'; menu.dispatchEvent(new Event('change')); return null").await;
    page.wait("return document.title.startsWith('A vibration') && !trocar.busy()").await;
    settled().await;
    page.client.back().await.expect("back");
    page.wait("return document.title.startsWith('The insertion of the paper')").await;
    settled().await;
    assert_eq!(page.evaluate(STATE).await, states[3]);
    page
}

pub async fn comma(page: BrowserPage) -> BrowserPage {
    page.open("").await;
    let id = "key-sensor-force_noise_std_n-number";
    let number = page.element(id).await;
    let place = async || {
        page.place("#key-channel-forward_delay_s, [data-key='channel.forward_delay_s'] input[type=range]").await
    };
    let before = place().await;
    let typed = async |text: &str| {
        let all = format!("{}a{}", char::from(Key::Control), char::from(Key::Null));
        number.send_keys(&format!("{all}{text}{}", char::from(Key::Tab))).await.expect("typed");
        sleep(Duration::from_millis(200)).await;
        page.evaluate("return trocar.state.set['sensor.force_noise_std_n'] ?? null").await
    };
    for text in ["0,05", "0.05", " 0,050 "] {
        assert_eq!(typed(text).await, json!(5e-5), "{text} mN");
    }
    let is_wrong =
        format!("return document.getElementById('{id}').closest('.control').querySelector('.error').textContent");
    // The number is ambiguous: a thousand or one.
    assert_eq!(typed("1,000").await, json!(5e-5));
    assert!(page.evaluate(&is_wrong).await.as_str().is_some_and(|text| text.contains("1,000 is not a number")));
    assert_eq!(typed("1,5").await, json!(1.5e-3));
    assert_eq!(page.evaluate(&is_wrong).await, json!(""));
    // The additional button of a changed control moves nothing, not even the slider with the longest name.
    assert_eq!(place().await, before);
    let slider =
        page.client.find(fantoccini::Locator::Css("#front [id^='key-both'][type=range]")).await.expect("a slider");
    let top = async || slider.rectangle().await.expect("a place").1;
    let first = top().await;
    slider.send_keys(&String::from(char::from(Key::Right)).repeat(3)).await.expect("moved");
    page.wait("return !trocar.busy() && trocar.state.set['channel.forward_delay_s'] > 0").await;
    assert_eq!(top().await, first);
    // The map has the unit of the slider.
    page.wait("return document.getElementById('map-text').textContent.includes('(ms)')").await;
    let map = page.text("map-text").await;
    let shown = page.evaluate("return document.querySelector('#front [id^=\"key-both\"][inputmode]').value").await;
    let shown = shown.as_str().unwrap_or_default();
    page.wait(&format!("return document.getElementById('map-text').textContent.includes('(ms) {shown}')")).await;
    assert!(!map.contains("(s)"), "{map}");
    page
}

pub async fn ended(page: BrowserPage) -> BrowserPage {
    page.open("scaling.force=1.3").await;
    assert_eq!(page.evaluate("return document.getElementById('offline').checkVisibility()").await, json!(false));
    page.evaluate("trocar.timings.length = 0; return null").await;
    let killed = Command::new("kill").args(["-KILL", &page.server.to_string()]).status().expect("runs");
    assert!(killed.success());
    page.wait("return document.getElementById('offline').textContent.includes('server has ended')").await;
    let seen = "const { top, bottom, width } = document.getElementById('offline').getBoundingClientRect();
        return [top >= 0 && bottom > top && width > 0.9 * innerWidth, document.getElementById('controls').inert, trocar.animation().isPlaying,
            Number(getComputedStyle(document.querySelector('#chart-1 canvas')).opacity) < 0.5]";
    assert_eq!(page.evaluate(seen).await, json!([true, true, false, true]));
    // The page continues with the same state on another server at the same port.
    let mut again = Command::new(env!("CARGO_BIN_EXE_trocar"));
    again.args(["explore", "--no-open", "--port", &page.address.port().to_string()]);
    let _again = Running::start(&mut again, |line| line.contains("http://").then_some(())).expect("served again");
    page.wait(
        "return !document.getElementById('offline').checkVisibility() && !document.getElementById('controls').inert",
    )
    .await;
    // The first picture of the new server comes after its controls.
    page.wait("return trocar.timings.length > 0 && !trocar.busy()").await;
    assert_eq!(page.evaluate("return trocar.state.set").await, json!({ "scaling.force": 1.3 }));
    let slider = page.element("key-scaling-force").await;
    slider.send_keys(&String::from(char::from(Key::Right))).await.expect("moved");
    page.wait("return trocar.state.set['scaling.force'] > 1.3 && !trocar.busy()").await;
    page
}
