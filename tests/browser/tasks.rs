//! Tasks of a new user, with the keyboard alone and at four sizes.

use std::time::Duration;

use fantoccini::key::Key;
use serde_json::json;
use tokio::time::sleep;

use crate::page::{BrowserPage, COVERED};

/// A small telephone, a telephone in portrait and in landscape, and a laptop.
const SIZES: [(u32, u32); 4] = [(320, 640), (390, 844), (844, 390), (1280, 800)];

pub async fn sizes(page: BrowserPage) -> BrowserPage {
    for (width, height) in SIZES.into_iter().chain([(640, 400)]) {
        page.resize(width, height).await;
        page.open("").await;
        page.element("all")
            .await
            .find(fantoccini::Locator::Css("summary"))
            .await
            .expect("a summary")
            .click()
            .await
            .expect("opened");
        let script = format!(
            "{COVERED}
            document.querySelectorAll('details').forEach((one) => {{ one.open = true; }});
            const all = [...document.querySelectorAll('input, select, button, canvas, summary')].filter((one) => one.checkVisibility() && !one.disabled
                && getComputedStyle(one).visibility === 'visible');
            const found = [];
            for (const one of all) {{
                one.focus();
                const trouble = covered(one);
                if (trouble) found.push(trouble);
            }}
            return [all.length, found.slice(0, 5), document.documentElement.scrollWidth - innerWidth]"
        );
        let seen = page.evaluate(&script).await;
        assert!(seen[0].as_u64().is_some_and(|count| count > 100), "{seen}");
        assert_eq!((&seen[1], seen[2].as_f64() <= Some(0.0)), (&json!([]), true), "at {width} × {height}: {seen}");
    }
    page
}

pub async fn tasks(page: BrowserPage) -> BrowserPage {
    let settled = async || page.wait("return !trocar.busy()").await;
    for (width, height) in SIZES {
        page.resize(width, height).await;
        page.open("").await;
        let from_top = async || page.evaluate("document.activeElement.blur(); scrollTo(0, 0); return null").await;
        for id in ["#theme", "#map-x", "#listen"].iter().filter(|_| width == 1280) {
            page.tab_to(id).await;
            from_top().await;
        }
        // 1. Choose another scenario.
        page.tab_to("#scenario").await;
        page.type_text("Insertion through the skin, classical").await;
        settled().await;
        assert_ne!(
            page.evaluate("return trocar.state.scenario").await,
            json!("builtin:paper/augmented.toml"),
            "{width}"
        );
        // 2. Undo it.
        sleep(Duration::from_millis(300)).await;
        page.tab_to("#undo").await;
        page.press(&[Key::Enter]).await;
        page.wait("return trocar.state.scenario === 'builtin:paper/augmented.toml' && !trocar.busy()").await;
        // 3. Reduce the felt force with a slider, and see the table change.
        let before = page.evaluate("return document.querySelector('#metrics tbody').textContent").await;
        page.tab_to("#key-scaling-force").await;
        page.press(&[Key::Left, Key::Left, Key::Left]).await;
        page.wait("return trocar.state.set['scaling.force'] < 1 && !trocar.busy()").await;
        assert_ne!(page.evaluate("return document.querySelector('#metrics tbody').textContent").await, before);
        // 4. Type a delay with a decimal comma.
        page.tab_to("#front [id^='key-both'][inputmode]").await;
        page.type_text("2,5").await;
        page.press(&[Key::Tab]).await;
        page.wait("return trocar.state.set['channel.forward_delay_s'] === 0.0025 && trocar.state.set['channel.backward_delay_s'] === 0.0025").await;
        // 5. Reset that control.
        from_top().await;
        page.tab_to("[aria-label='Reset Delay of the link, each way']").await;
        page.press(&[Key::Enter]).await;
        page.wait("return !('channel.forward_delay_s' in trocar.state.set) && !trocar.busy()").await;
        // 6. Find a setting, and change it.
        page.tab_to("#all > summary").await;
        page.press(&[Key::Enter]).await;
        page.tab_to("#find").await;
        page.type_text("blend").await;
        page.tab_to("#sections input[id*='blend'][inputmode]").await;
        page.type_text("0.3").await;
        page.press(&[Key::Tab]).await;
        page.wait("return trocar.state.set['augmentation.blend_s'] === 0.3 && !trocar.busy()").await;
        // 7. Stop the animation at a time, and step it.
        from_top().await;
        page.tab_to("#animation .player button").await;
        page.press(&[Key::Enter]).await;
        page.tab_to("#animation .player input").await;
        let at = page.evaluate("return trocar.animation().at").await.as_u64().expect("a frame");
        page.press(&[if at > 0 { Key::Left } else { Key::Right }]).await;
        assert!(page.evaluate("return trocar.animation().at").await.as_u64() != Some(at), "{width}: {at}");
        assert_eq!(page.evaluate("return trocar.animation().isPlaying").await, json!(false));
        // 8. Read the position of the needle at the rupture.
        page.tab_to("#chart-1 canvas").await;
        page.type_text("e").await;
        let shown = page.evaluate("return document.activeElement.getAttribute('aria-valuetext')").await;
        assert!(
            shown.as_str().is_some_and(|shown| shown.contains("Time 5.520 s") && shown.contains("slave, augmented")),
            "{shown}"
        );
        // 9. Zoom in, and show everything.
        page.type_text("+").await;
        page.wait("return location.hash.includes('time=5')").await;
        page.type_text("0").await;
        page.wait("return location.hash.includes('time=all') && trocarPictures.panel('position').x.low === 0").await;
        // 10. Hide a line.
        page.tab_to("#chart-1 .legend button").await;
        page.press(&[Key::Enter]).await;
        assert_eq!(page.evaluate("return document.activeElement.getAttribute('aria-checked')").await, json!("false"));
        // 11. Move the point of the stability map.
        page.tab_to("#map").await;
        page.wait("return trocarMap.current() !== null").await;
        let force = page.evaluate("return trocar.state.set['scaling.force']").await.as_f64().expect("a number");
        page.press(&[Key::Right, Key::Right]).await;
        page.wait(&format!("return trocar.state.set['scaling.force'] > {force} && !trocar.busy()")).await;
        // 12. Save the scenario.
        page.tab_to("#export-toml").await;
        page.press(&[Key::Enter]).await;
        page.wait("return trocar.file()?.name === 'augmented.toml' && trocar.file().content.includes('blend_s = 0.3')")
            .await;
        // 13. Push through a layer, and read the results of both schemes.
        from_top().await;
        page.tab_to("#push-open").await;
        page.press(&[Key::Enter]).await;
        page.wait("return !!trocarPush.state()?.range && document.activeElement.id === 'field'").await;
        let ruptured = "return trocarPush.state().events.some(([, kind]) => kind === 'rupture')";
        // The insertion ends with its recording, after 7 s. On a slow machine every key takes a tenth of a second.
        page.press(&[Key::PageDown, Key::PageDown, Key::End]).await;
        page.wait(ruptured).await;
        sleep(Duration::from_millis(400)).await;
        from_top().await;
        page.tab_to("#push").await;
        // On a slow machine the insertion has ended by itself; the button would begin another one.
        if page.evaluate("return trocarPush.state().ended").await == json!(false) {
            page.press(&[Key::Enter]).await;
        }
        page.wait("return !document.getElementById('push-result').hidden").await;
        let shown = page.text("push-text").await;
        assert!(shown.contains("both schemes: In the 0.3 s after"), "{width}: {shown}");
        page.tab_to("#push-close").await;
        page.press(&[Key::Enter]).await;
        assert_eq!(page.evaluate("return document.getElementById('push-section').hidden").await, json!(true));
    }
    page
}
