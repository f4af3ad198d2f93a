//! An insertion by hand: its sound, vibration and text.

use std::time::Duration;

use fantoccini::key::Key;
use serde_json::json;
use tokio::time::sleep;

use crate::page::BrowserPage;

/// Records vibrations in `vibrated` instead of on a device.
const DEVICE: &str = "window.vibrated = []; Object.defineProperty(navigator, 'vibrate', { value: (ms) => vibrated.push(ms), configurable: true });
    const pad = { vibrationActuator: { playEffect: (kind, how) => { vibrated.push([kind, how]); return Promise.resolve(); } } };
    Object.defineProperty(navigator, 'getGamepads', { value: () => [null, pad], configurable: true }); return null";

const RUPTURES: &str = "trocarPush.state().events.filter(([, kind]) => kind === 'rupture').length";

pub async fn push(page: BrowserPage) -> BrowserPage {
    page.resize(390, 844).await;
    page.open("scenario=builtin:layers/skin-augmented.toml").await;
    page.evaluate(DEVICE).await;
    page.tab_to("#push-open").await;
    page.press(&[Key::Enter]).await;
    page.wait("return !!trocarPush.state()?.range && document.activeElement.id === 'field'").await;
    // A mode can be shorter than the time between two queries, so the page records the modes.
    let watch = "const text = document.querySelector('#field .state'); window.modes = [text.textContent];
        new MutationObserver(() => modes.push(text.textContent)).observe(text, { childList: true }); return null";
    page.evaluate(watch).await;
    // On a telephone, the whole field is in the window and uncovered.
    let [_, top, _, height] = page.place("#field").await;
    assert!(top > 0.0 && top + height < 844.0, "{top}, {height}");
    let free = "const box = document.getElementById('field').getBoundingClientRect();
        return [0.1, 0.5, 0.9].every((share) => document.elementFromPoint(box.left + box.width / 2, box.top + share * box.height).closest('#field'))";
    assert_eq!(page.evaluate(free).await, json!(true));
    // Move at about 10 mm/s, as in an insertion: jumps of the hand would restart the detector's settling time. The
    // tone follows the load before the rupture; a felt force of 0 after it is silent.
    let mut loudness = 0.0_f64;
    for _ in 0..320 {
        page.press(&[Key::Down]).await;
        sleep(Duration::from_millis(20)).await;
        let heard = page.evaluate(&format!("return [trocarListen.state().loudness, {RUPTURES}]")).await;
        loudness = loudness.max(heard[0].as_f64().expect("a loudness"));
        if heard[1] != json!(0) {
            break;
        }
    }
    page.wait(&format!("return {RUPTURES} > 0 && modes[0] === 'teleoperation' && modes.includes('frozen')")).await;
    // The rupture gives a tone, a click and one vibration on each device.
    let sound = page.evaluate("return trocarListen.state()").await;
    assert_eq!(sound["state"], json!("running"));
    assert!(loudness > 0.0, "{sound}");
    page.wait(&format!("return trocarListen.state().clicks === {RUPTURES} && vibrated.length === 2 * {RUPTURES}"))
        .await;
    assert_eq!(page.evaluate("return [typeof vibrated[0], vibrated[1][0]]").await, json!(["number", "dual-rumble"]));
    // Wait for the time of the metric of the needle's advance.
    sleep(Duration::from_millis(900)).await;
    // With the sound off, the next rupture gives no click and no vibration.
    page.element("push-sound").await.click().await.expect("clicked");
    let before = page.evaluate("return [trocarListen.state().clicks, vibrated.length]").await;
    page.evaluate("document.getElementById('field').focus(); return null").await;
    page.press(&[Key::End]).await;
    sleep(Duration::from_millis(1500)).await;
    let ruptures = page.evaluate(&format!("return {RUPTURES}")).await.as_u64().expect("a number");
    assert!(ruptures > before[0].as_u64().expect("a number"), "{ruptures}, {before}");
    assert_eq!(page.evaluate("return [trocarListen.state().clicks, vibrated.length]").await, before);
    page.element("push").await.click().await.expect("ended");
    page.wait("return !document.getElementById('push-result').hidden").await;
    // The result shows the same motion of the hand with both schemes. The augmented run is the one that the user
    // felt.
    let text = page.text("push-text").await;
    assert!(text.contains("both schemes") && text.contains("without augmentation"), "{text}");
    let compared = "const { rows, events } = trocarPush.state();
        const { lines } = trocarPush.result().figure.rows.flatMap((row) => row.panels).find(({ id }) => id === 'position');
        const line = (name) => lines.find((line) => line.name === name).points;
        const [xs, ys] = line('slave, augmented');
        const at = (time) => { const k = xs.findIndex((x) => x >= time) || 1; return ys[k - 1] + (ys[k] - ys[k - 1]) * (time - xs[k - 1]) / (xs[k] - xs[k - 1]); };
        const apart = rows.filter((_, k) => k % 50 === 0).map((row) => Math.abs(row[3] - at(row[0])));
        return [apart.length, Math.max(...apart), trocarPush.result().overshoot_mm]";
    let compared = page.evaluate(compared).await;
    assert!(compared[0].as_u64().is_some_and(|count| count > 10), "{compared}");
    assert!(compared[1].as_f64().is_some_and(|mm| mm < 0.2), "{compared}");
    let overshoot = |run: usize| compared[2][run][0].as_f64().expect("an overshoot");
    assert!(overshoot(0) > 3.0 * overshoot(1), "{compared}");
    assert_eq!(
        page.evaluate("return document.querySelectorAll('#push-animation .needle-panel').length").await,
        json!(2)
    );
    // On a wide screen, a drag selects no text.
    page.resize(1280, 800).await;
    page.element("push").await.click().await.expect("again");
    page.wait("return !!trocarPush.state()?.range && !trocarPush.state().ended").await;
    let [left, top, width, height] = page.place("#field svg").await;
    page.mouse("mousePressed", (left + 0.5 * width, top + 0.1 * height)).await;
    for step in 0..30 {
        page.mouse(
            "mouseMoved",
            (left + (0.5 + 0.04 * f64::from(step)) * width, top + (0.1 + 0.01 * f64::from(step)) * height),
        )
        .await;
    }
    assert_eq!(page.evaluate("return getSelection().toString()").await, json!(""));
    assert!(
        page.evaluate("return trocarPush.state().aim - trocarPush.state().range[0]")
            .await
            .as_f64()
            .is_some_and(|mm| mm > 1.0)
    );
    page.mouse("mouseReleased", (left, top)).await;
    // The axes do not magnify the signals before contact.
    let axes = "return [...document.querySelectorAll('#pushed canvas')].length";
    assert_eq!(page.evaluate(axes).await, json!(2));
    page.element("push-close").await.click().await.expect("closed");
    let shown = "return [document.getElementById('push-section').hidden, document.querySelector('.stage').checkVisibility() || getComputedStyle(document.querySelector('.stage')).display, document.activeElement.id]";
    let shown = page.evaluate(shown).await;
    assert_eq!((&shown[0], &shown[2]), (&json!(true), &json!("push-open")));
    page
}

/// A force bar has the same length in every run and shows its scale.
pub async fn scale(page: BrowserPage) -> BrowserPage {
    for state in ["", "scaling.force=0.002", "scenario=builtin:layers/skin-augmented.toml"] {
        page.open(state).await;
        let drawn = "const a = trocar.animation(); a.pause(); a.show(0);
            const panel = document.querySelector('#animation .needle-panel'), box = (role) => panel.querySelector(role).getBBox();
            const texts = [...panel.querySelectorAll('text')].map((text) => text.textContent);
            return [box('.force').height / box('.track').height, parseFloat(panel.querySelector('.newtons').textContent), texts.filter((text) => /^\\d+ N$/.test(text))]";
        let drawn = page.evaluate(drawn).await;
        let (share, newtons) = (drawn[0].as_f64().expect("a share"), drawn[1].as_f64().expect("a force"));
        let full: f64 =
            drawn[2][0].as_str().and_then(|text| text.trim_end_matches(" N").parse().ok()).expect("a scale");
        assert!(full >= 5.0 && (share - newtons / full).abs() < 0.01, "{state}: {drawn}");
    }
    page
}
