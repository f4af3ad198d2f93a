//! `--report`: one self-contained page with the results of a command, in which all texts are escaped.

use std::collections::BTreeMap;

use crate::support;
use crate::support::test_folder::TestFolder;
use serde_json::Value as Json;

/// Maximum size of a page, in bytes.
const MAX_BYTES: usize = 2_000_000;

const SHORT: &str =
    "name = \"short\"\noperator.kind = \"ramp\"\ntissue.kind = \"kelvin-voigt\"\nsimulation.duration_s = 0.5\n";

/// A text that would be executed if it were not escaped.
const EVIL: &str = "</script><script>alert(1)</script><img src=x onerror=alert(2)>";

fn unescaped(html: &str) -> String {
    let pairs = [
        ("&lt;", "<"),
        ("&gt;", ">"),
        ("&quot;", "\""),
        ("&#34;", "\""),
        ("&#x27;", "'"),
        ("&#39;", "'"),
        ("&#x2f;", "/"),
    ];
    pairs.iter().fold(html.to_owned(), |text, (code, plain)| text.replace(code, plain)).replace("&amp;", "&")
}

fn between<'a>(text: &'a str, from: &str, to: &str) -> &'a str {
    let rest = text.split_once(from).unwrap_or_else(|| panic!("no {from}")).1;
    rest.split_once(to).unwrap_or_else(|| panic!("no {to} after {from}")).0
}

fn data(html: &str) -> Json {
    serde_json::from_str(between(html, "<script id=\"data\" type=\"application/json\">", "</script>")).expect("JSON")
}

/// Returns the rows of all tables. The first cell has no meaning text.
fn rows(html: &str) -> Vec<Vec<String>> {
    let cell = |cell: &str| {
        let content = cell.split_once('>').map_or("", |(_, content)| content);
        unescaped(content.split('<').next().unwrap_or_default())
    };
    let row = |row: &str| {
        let row = row.split("</tr>").next().unwrap_or_default().replace("<th", "<td");
        row.split("<td").skip(1).map(cell).collect()
    };
    html.split("<tr>").skip(1).map(row).collect()
}

fn is_sound(html: &str) {
    assert!(html.len() < MAX_BYTES, "{} bytes", html.len());
    assert!(html.starts_with("<!doctype html>\n<html lang=\"en\">"));
    assert!(!between(html, "<title>", "</title>").is_empty());
    assert!(html.contains("http-equiv=\"Content-Security-Policy\" content=\"default-src &#x27;none&#x27;; script-src"));
    assert!(html.contains("<noscript>"));
    // There is one heading of level 1, followed by headings of level 2, and no level is skipped.
    let headings: Vec<&str> =
        html.split("<h").skip(1).map(|rest| &rest[..1]).filter(|level| "123456".contains(level)).collect();
    assert!(
        headings[0] == "1" && headings.len() > 3 && headings[1..].iter().all(|level| *level == "2"),
        "{headings:?}"
    );
    // There are two script elements, the data and the program, and the page loads no file.
    assert_eq!((html.matches("<script").count(), html.matches("</script").count()), (2, 2));
    for tag in html.split('<').skip(1).map(|rest| rest.split('>').next().unwrap_or_default()) {
        let is_tag = tag.starts_with(|c: char| c.is_ascii_lowercase());
        assert!(!is_tag || !tag.contains(" src="), "{tag}");
    }
    for loading in ["<link", "<img", "<iframe", "<object", "@import", "url("] {
        assert!(!html.contains(loading), "{loading}");
    }
    assert!(html.split("href=\"").skip(1).all(|rest| rest.starts_with('#')), "only places on the page");
    assert!(!html.contains("http://") && !html.contains("https://"), "no address");
    // Every figure has a place, every panel has a named line, and every line has points.
    for (name, figures) in data(html)["figures"].as_object().expect("figures") {
        let is_empty = figures.as_array() == Some(&vec![]);
        assert!(html.contains(&format!("<div class=\"charts\" data-name=\"{name}\">")) || is_empty);
        for (title, panel) in titled_panels(figures) {
            // Bars have the title of their row on the left.
            let is_bars = panel["y"]["caption"] == "";
            let caption = if is_bars { &title } else { &panel["y"]["caption"] };
            assert!(caption.as_str().is_some_and(|caption| caption.len() > 2), "{name}");
            let lines = panel["lines"].as_array().expect("lines");
            assert!(is_bars || lines.is_empty() || lines.iter().any(|line| line["name"] != ""), "{name}");
            for line in lines {
                let [x, y] = [0, 1].map(|k| line["points"][k].as_array().expect("a column").len());
                assert_eq!(x, y, "{name}");
            }
        }
    }
}

/// Returns the panels of figures in order, each with the title of its row.
fn titled_panels(figures: &Json) -> Vec<(Json, Json)> {
    let list = |of: &Json| of.as_array().cloned().unwrap_or_default();
    let rows = list(figures).into_iter().flat_map(|figure| list(&figure["rows"]));
    rows.flat_map(|row| list(&row["panels"]).into_iter().map(move |panel| (row["title"].clone(), panel))).collect()
}

fn panels(figures: &Json) -> Vec<Json> {
    titled_panels(figures).into_iter().map(|(_, panel)| panel).collect()
}

#[test]
fn the_shipped_pair_fits_on_a_page_with_every_number_that_is_printed() {
    let folder = TestFolder::new();
    let printed = folder.good(&["compare", "--all", "--report", "--out", "o"]);
    assert!(printed.ends_with("report: o/compare/report.html\n"), "{printed}");
    let html = folder.text("o/compare/report.html");
    is_sound(&html);
    let rows = rows(&html);
    let mut lines = 0;
    for line in printed.split("\n\n").nth(2).expect("all metrics").lines().skip(2) {
        let cells: Vec<&str> = line.split("  ").map(str::trim).filter(|cell| !cell.is_empty()).collect();
        let found = rows.iter().find(|row| row[0] == cells[0]).unwrap_or_else(|| panic!("no row {}", cells[0]));
        assert_eq!(found.iter().map(String::as_str).filter(|cell| !cell.is_empty()).collect::<Vec<_>>(), cells);
        assert!(html.contains(&format!("{}<small>", cells[0])), "{} says what it means", cells[0]);
        lines += 1;
    }
    assert!(lines > 30, "{lines} metrics");
    for fact in ["classical: slave travel in 300 ms", "the derivative in that noise"] {
        assert!(rows.iter().any(|row| row[0] == fact), "{fact}");
    }
    // The scenarios equal those in the folder of the page.
    for name in ["classical", "augmented"] {
        let shown = unescaped(
            html.split(&format!("aria-label=\"{name}.toml\">"))
                .nth(1)
                .expect("shown")
                .split("</pre>")
                .next()
                .expect("ended"),
        );
        assert_eq!(shown, folder.text(&format!("o/compare/{name}/scenario.toml")));
    }
    assert!(html.contains("trocar compare --report</pre>"));
    assert!(!folder.path("o/classical/report.html").exists());
}

#[test]
fn the_page_is_reproducible_anywhere_and_with_the_command_that_it_states() {
    let (here, there) = (TestFolder::new(), TestFolder::new());
    let given =
        ["run", "builtin:paper/augmented.toml", "--set", "sensor.force_noise_std_n=0.02", "--report", "--quiet"];
    here.good(&given);
    there.good(&[&given[..], &["--out", "far/away"]].concat());
    let html = here.text("out/augmented/report.html");
    assert!(html == there.text("far/away/augmented/report.html"));
    is_sound(&html);
    // Follow the page's instructions: save the scenario under its name and run the command.
    let toml = unescaped(between(&html, "aria-label=\"augmented.toml\">", "</pre>"));
    let command = unescaped(between(&html, "aria-label=\"Command\">", "</pre>"));
    let again = TestFolder::new();
    again.file("augmented.toml", toml);
    again.good(&command.split(' ').skip(1).collect::<Vec<_>>());
    assert!(html == again.text("out/augmented/report.html"));
    // The report changes no other file.
    let plain = TestFolder::new();
    plain.good(&given[..4]);
    let others = |mut files: BTreeMap<std::path::PathBuf, Vec<u8>>| {
        files.retain(|path, _| !path.ends_with("report.html") && !path.ends_with("manifest.json"));
        files
    };
    assert!(others(here.files("out")) == others(plain.files("out")));
}

#[test]
fn the_drawn_lines_agree_with_the_trace_to_five_digits() {
    let folder = TestFolder::new();
    folder.good(&["run", "builtin:paper/augmented.toml", "--report", "--quiet"]);
    let trace = support::table(folder.path("out/augmented/trace.csv").to_str().expect("a path"));
    let ticks: BTreeMap<String, usize> =
        trace["time_s"].iter().enumerate().map(|(tick, time)| (format!("{time:.6}"), tick)).collect();
    let data = data(&folder.text("out/augmented/report.html"));
    let panels = panels(&data["figures"]["teleoperation"]);
    let line = |caption: &str, name: &str| -> Json {
        let panel = panels.iter().find(|panel| panel["y"]["caption"] == caption).expect(caption);
        let lines = panel["lines"].as_array().expect("lines");
        lines.iter().find(|line| line["name"] == name).expect(name)["points"].clone()
    };
    let mut seen = 0;
    for (caption, name, column, factor) in [
        ("Position (mm)", "slave", "slave_position_m", 1e3),
        ("Position (mm)", "master", "master_position_m", 1e3),
        ("Force (N)", "feedback", "feedback_force_n", 1.0),
        ("Force (N)", "felt", "operator_force_n", 1.0),
        ("Force (N)", "tissue", "tissue_force_n", 1.0),
        ("Stiffness (N/m)", "Stiffness", "stiffness_n_per_m", 1.0),
        ("Damping (N·s/m)", "Damping", "damping_n_s_per_m", 1.0),
        ("Decision function g (N²)", "Decision function g", "decision", 1.0),
    ] {
        let points = line(caption, name);
        let (times, values) = (points[0].as_array().expect("times"), points[1].as_array().expect("values"));
        assert!((500..9_000).contains(&times.len()) && times.len() == values.len(), "{}", times.len());
        let whole = &trace[column];
        let mut extremes = (f64::INFINITY, f64::NEG_INFINITY);
        for (time, value) in times.iter().zip(values) {
            let tick = ticks[&format!("{:.6}", time.as_f64().expect("a time"))];
            let (value, true_value) = (value.as_f64().expect("a value"), factor * whole[tick]);
            assert!(
                (value - true_value).abs() <= 0.6e-4 * true_value.abs(),
                "{column} at {time}: {value}, {true_value}"
            );
            extremes = (extremes.0.min(value), extremes.1.max(value));
            seen += 1;
        }
        // The points include the minimum and the maximum of the whole run.
        let (least, most) = whole.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), v| (l.min(*v), m.max(*v)));
        assert!((extremes.0 - factor * least).abs() <= 0.6e-4 * (factor * least).abs(), "{column}");
        assert!((extremes.1 - factor * most).abs() <= 0.6e-4 * (factor * most).abs(), "{column}");
    }
    assert!(seen > 9 * 500);
    // In the 0.1 s after a rupture, every tick of the force drop is drawn.
    let points = line("Force (N)", "tissue");
    let times: Vec<f64> = points[0].as_array().expect("times").iter().filter_map(Json::as_f64).collect();
    assert!(times.iter().filter(|time| (5.52..5.62).contains(*time)).count() >= 95);
}

#[test]
fn names_with_scripts_are_shown_and_not_executed() {
    let folder = TestFolder::new();
    let row = |k: u32| format!("{},{},0.5\n", f64::from(k) * 1e-3, f64::from(k) * 1e-5);
    let content = format!("{EVIL},x_mm,f\n{}", (0..400).map(row).collect::<String>());
    let file = "a '\"&<b>onload=alert(3)<b>.csv";
    folder.file(file, &content).file("b.csv", &content);
    folder.file(
        "labels.csv",
        format!("file,time_s,kind\n{file:?},0.2,{EVIL}\nb.csv,0.3,{EVIL}\n").replace("\\\"", "\"\""),
    );
    let columns = ["--time", EVIL, "--position", "x_mm", "--force", "f"];
    folder.good(
        &[&["detect", file, "b.csv", "--labels", "labels.csv", "--report", "--quiet", "--no-figures"], &columns[..]]
            .concat(),
    );
    let pages: Vec<_> = folder.files("out").into_iter().filter(|(path, _)| path.ends_with("report.html")).collect();
    assert_eq!(pages.len(), 3);
    for (path, page) in pages {
        let html = String::from_utf8(page).expect("text");
        is_sound(&html);
        let shown = unescaped(&html);
        assert!(shown.contains(EVIL), "{} shows the name", path.display());
        for tag in ["<script>alert", "<img", "<b>"] {
            assert!(!html.contains(tag), "{} has {tag}", path.display());
        }
    }
}

#[test]
#[ignore = "more than 5 s of processor time"]
fn a_page_reveals_nothing_about_the_machine() {
    let folder = TestFolder::new();
    let row = |k: u32| format!("{},{},0.5\n", f64::from(k) * 1e-3, f64::from(k) * 1e-5);
    folder.file("r.csv", format!("time_s,position_m,force_n\n{}", (0..400).map(row).collect::<String>()));
    let recording = folder.path("r.csv").display().to_string();
    folder.file("s.toml", format!("recording.file = {recording:?}\nsimulation.duration_s = 0.3\n"));
    let scenario = folder.path("s.toml").display().to_string();
    folder.good(&["detect", &recording, "--report", "--quiet"]);
    folder.good(&["run", &scenario, "--report", "--quiet"]);
    folder.good(&["compare", &scenario, "--report", "--quiet"]);
    let axes = ["--x", "scaling.force=0.5:2:3", "--y", "tissue.stiffness_n_per_m=100:200:3"];
    folder.good(&[&["stability", &scenario, "--report", "--quiet"], &axes[..]].concat());
    let place = recording.strip_suffix("r.csv").expect("a folder");
    for page in ["out/r/report.html", "out/compare/report.html", "out/s/report.html"] {
        let html = folder.text(page);
        is_sound(&html);
        assert!(!unescaped(&html).contains(place), "{page}");
        assert!(unescaped(&html).contains("file = \"r.csv\""), "{page}");
    }
}

#[test]
fn a_large_sweep_fits_and_the_page_states_how_much_is_drawn() {
    let folder = TestFolder::new();
    folder.file("base.toml", SHORT.replace("0.5", "0.02"));
    let axes = "scaling.force = { from = 0.5, to = 2.0, points = 100 }\nscaling.position = { from = 0.1, to = 1.0, points = 70, log = true }\noperator.kind = [\"ramp\", \"sine\"]\n";
    let metrics = "metrics = [\"tracking_rmse_m\", \"max_tissue_force_n\"]\n";
    folder.file("large.toml", format!("base = \"base.toml\"\n{metrics}[axes]\n{axes}"));
    let printed = folder.good(&["sweep", "large.toml", "--report"]);
    let html = folder.text("out/large/report.html");
    is_sound(&html);
    let shown = unescaped(&html);
    assert!(shown.contains("2000 of 14000 cases are drawn, evenly chosen"));
    assert!(shown.contains("A dash") || shown.contains("Intervals in brackets"));
    let lines = || printed.lines().filter(|line| line.starts_with("maximum tissue force "));
    // The columns are printed in two blocks, and the influence of the axes below them.
    assert!(lines().count() >= 2, "{printed}");
    for line in lines().take(2) {
        let cells: Vec<&str> = line.split("  ").map(str::trim).filter(|cell| !cell.is_empty()).collect();
        let row = rows(&html).into_iter().find(|row| row[0] == cells[0]).expect("a row");
        assert!(cells.iter().all(|cell| row.iter().any(|shown| shown == cell)), "{row:?}: {cells:?}");
    }
    let data = data(&html);
    let of = |name: &str| panels(&data["figures"][name]).into_iter().next().unwrap_or_else(|| panic!("no {name}"));
    for metric in ["tracking_rmse_m", "max_tissue_force_n"] {
        for axis in ["scaling.force", "scaling.position", "operator.kind"] {
            of(&format!("cases_{metric}_over_{axis}"));
        }
    }
    let kinds = of("cases_tracking_rmse_m_over_operator.kind");
    assert_eq!(kinds["x"]["caption"], "operator.kind, 1: ramp, 2: sine");
    let values = of("cases_tracking_rmse_m_over_scaling.force")["lines"][0]["points"][1].clone();
    let values = values.as_array().expect("values");
    assert_eq!(values.iter().filter(|value| !value.is_null()).count(), 2_000);
    assert_eq!(of("heat_tracking_rmse_m")["fills"].as_array().map(Vec::len), Some(40 * 40));
}

#[test]
fn a_complete_sweep_still_gets_its_page() {
    let folder = TestFolder::new();
    folder.file("base.toml", SHORT.replace("0.5", "0.02"));
    let sweep = "base = \"base.toml\"\nmetrics = [\"tracking_rmse_m\"]\n[axes]\nscaling.force = [0.5, 1.0, 2.0]\n";
    folder.file("s.toml", sweep);
    folder.good(&["sweep", "s.toml", "--quiet"]);
    let mut before = folder.files("out/s");
    folder.good(&["sweep", "s.toml", "--quiet", "--report"]);
    let mut after = folder.files("out/s");
    let page = after.remove(std::path::Path::new("report.html")).expect("written");
    is_sound(&String::from_utf8(page.clone()).expect("text"));
    // The page comes with the figures of its cases; the existing files do not change.
    after.retain(|path, _| !path.to_string_lossy().starts_with("cases_"));
    // The manifest lists the page as well.
    assert!(
        before.remove(std::path::Path::new("manifest.json")) != after.remove(std::path::Path::new("manifest.json"))
    );
    assert!(before == after);
    // The page of joined shards differs only in the command.
    for shard in ["1/2", "2/2"] {
        folder.good(&["sweep", "s.toml", "--quiet", "--shard", shard, "--out", "parts"]);
    }
    folder.good(&["sweep", "merge", "parts/s", "--out", "joined", "--quiet", "--report"]);
    let joined = folder.text("joined/s/report.html").replace("sweep merge parts&#x2f;s", "sweep s.toml");
    assert!(joined.as_bytes() == page);
    folder.refused(&["sweep", "s.toml", "--shard", "1/2", "--report", "--out", "x"], &["--report", "--shard"]);
}

#[test]
#[ignore = "more than 5 s of processor time"]
fn the_page_of_stability_has_the_map_the_limits_and_the_events() {
    let folder = TestFolder::new();
    let axes = ["--x", "scaling.force=0.1:10:12", "--y", "tissue.stiffness_n_per_m=10:2000:11"];
    let stated = ["stability", "paper/augmented", "--report", "--simulate", "--set", "tissue.stiffness_n_per_m=200"];
    let printed = folder.good(&[&stated[..], &axes].concat());
    assert!(printed.ends_with("report: out/augmented/report.html\n"), "{printed}");
    let html = folder.text("out/augmented/report.html");
    is_sound(&html);
    let rows = rows(&html);
    let is_compared =
        |line: &&str| ["spectral radius", "gain margin", "snap"].iter().any(|name| line.starts_with(name));
    for line in printed.lines().filter(is_compared) {
        let cells: Vec<&str> = line.split("  ").map(str::trim).filter(|cell| !cell.is_empty()).collect();
        assert!(
            rows.iter().any(|row| row
                .iter()
                .map(String::as_str)
                .filter(|cell| !cell.is_empty())
                .eq(cells.iter().copied())),
            "{cells:?}"
        );
    }
    let map = &panels(&data(&html)["figures"]["stability"])[0];
    let csv = folder.text("out/augmented/stability_map.csv");
    let stable = csv.lines().skip(1).filter(|line| line.split(',').nth(2) == Some("1")).count();
    // The axes are logarithmic, with 12 by 11 cells; the cells at the ends are half as wide and high.
    let share = |axis: &str, points: &Json| -> f64 {
        let ends: Vec<f64> = points.as_array().expect("an outline").iter().filter_map(Json::as_f64).collect();
        let [low, high] = ["low", "high"].map(|end| map[axis][end].as_f64().expect("a number"));
        (ends.iter().copied().fold(f64::MIN, f64::max) - ends.iter().copied().fold(f64::MAX, f64::min)) / (high - low)
    };
    let fills = map["fills"].as_array().expect("fills");
    let area: f64 = fills.iter().map(|fill| share("x", &fill["points"][0]) * share("y", &fill["points"][1])).sum();
    assert!(fills.iter().all(|fill| fill["text"] == "stable"));
    assert!((area - stable as f64 / (12.0 * 11.0)).abs() < 0.05, "{area} {stable}");
    let boundary = map["lines"][0]["points"][0].as_array().expect("places");
    let pieces = folder.text("out/augmented/stability_boundary.csv").lines().count() - 1;
    assert_eq!(boundary.iter().filter(|place| !place.is_null()).count(), 2 * pieces);
    assert!(unescaped(&html).contains("Springs alone: the motion decays under any sequence of events"));
}

#[test]
#[ignore = "more than 5 s of processor time"]
fn the_page_of_stability_draws_walls_and_absolute_stability_and_repeats_its_command() {
    let folder = TestFolder::new();
    let further =
        ["--tissue", "50:600", "--z-width", "0:50:6", "--absolute", "channel.delay_s=0:0.1:5", "--hand", "10:inf"];
    folder.good(&[&["stability", "paper/augmented", "--report", "--quiet"], &further[..]].concat());
    let html = folder.text("out/augmented/report.html");
    is_sound(&html);
    let figures = &data(&html)["figures"];
    let drawn = |name: &str, panel: usize, line: &str| -> Vec<f64> {
        let panel = &panels(&figures[name])[panel];
        let lines = panel["lines"].as_array().expect("lines");
        let values = &lines.iter().find(|drawn| drawn["name"] == line).expect(line)["points"][1];
        let place = |value: &Json| {
            let value = value.as_f64().expect("a value");
            if panel["y"]["log"] == true { 10_f64.powf(value) } else { value }
        };
        values.as_array().expect("a column").iter().map(place).collect()
    };
    let table = |name: &str, column: usize, of: &str| -> Vec<f64> {
        let text = folder.text(&format!("out/augmented/{name}.csv"));
        let rows = text.lines().skip(1).filter(|line| line.starts_with(of));
        let cell = |line: &str| line.split(',').nth(column).and_then(|cell| cell.parse().ok());
        // An undefined value is not drawn.
        rows.filter_map(cell).filter(|value: &f64| value.is_finite()).collect()
    };
    for (drawn, kept) in [
        (drawn("z_width", 0, "stable walls in the tissue"), table("z_width", 2, "tissue")),
        (drawn("z_width", 0, "passive walls in the tissue"), table("z_width", 3, "tissue")),
        (drawn("absolute", 0, "smallest over the frequencies; absolutely stable from 1 on"), table("absolute", 1, "")),
        (drawn("absolute", 1, "damping that every hand needs"), table("absolute", 3, "")),
    ] {
        assert_eq!(drawn.len(), kept.len());
        for (a, b) in drawn.into_iter().zip(kept) {
            assert!((a - b).abs() <= 1e-3 * b.abs(), "{a} {b}");
        }
    }
    let line = "--hand 10:inf --tissue 50:600 --absolute channel.delay_s=0:0.1:5 --z-width 0:50:6 --report";
    assert!(unescaped(&html).contains(line), "the command is complete");
}
