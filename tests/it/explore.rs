//! The server of the page, with regular and hostile clients.

use std::io::{Read, Write};
use std::net::{Shutdown, SocketAddr, TcpStream};
use std::time::{Duration, Instant};

use serde_json::{Value as Json, json};
use tungstenite::Message;

use crate::support::server::{RESPONSIVE, Running, Socket, connect, explore, link, open};
use crate::support::test_folder::TestFolder;

/// Returns the answer to a request: all bytes until the server closes the connection.
fn answer(address: SocketAddr, request: &str) -> String {
    let mut stream = connect(address);
    stream.write_all(request.as_bytes()).expect("sent");
    let mut text = String::new();
    let _ = stream.read_to_string(&mut text);
    text
}

fn get(address: SocketAddr, path: &str, host: &str) -> String {
    answer(address, &format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n"))
}

pub(crate) struct ServedPage {
    socket: Socket,
    last_id: u32,
}

impl ServedPage {
    pub(crate) fn open(address: SocketAddr) -> Self {
        let mut page = Self { socket: open(&address.to_string()), last_id: 0 };
        assert_eq!(page.receive("hello")["type"], "hello");
        page
    }

    fn send(&mut self, request: &Json) {
        self.socket.send(Message::text(request.to_string())).expect("sent");
    }

    /// Returns the next message of a kind; for a frame, its header.
    fn receive(&mut self, kind: &str) -> Json {
        loop {
            let message: Json = match self.socket.read().expect("received") {
                Message::Text(text) => serde_json::from_str(&text).expect("JSON"),
                Message::Binary(bytes) => {
                    let length = u32::from_le_bytes(bytes[..4].try_into().expect("four")) as usize;
                    serde_json::from_slice(&bytes[4..4 + length]).expect("JSON")
                }
                _ => continue,
            };
            assert!(kind == "refused" || message["type"] != "refused", "{message}");
            if message["type"] == kind {
                return message;
            }
        }
    }

    pub(crate) fn request(&mut self, mut request: Json, kind: &str) -> Json {
        self.last_id += 1;
        request["id"] = self.last_id.into();
        self.send(&request);
        loop {
            let message = self.receive(kind);
            if message["id"] == self.last_id {
                return message;
            }
        }
    }

    fn show(&mut self, set: Json) -> Json {
        let state = json!({ "scenario": "builtin:layers/skin-augmented.toml", "set": set });
        self.request(json!({ "type": "show", "state": state, "points": 400 }), "shown")
    }

    /// Requests a new run. Returns the time until its answer.
    fn moves_a_slider(&mut self, force: f64) -> Duration {
        let began = Instant::now();
        let shown = self.show(json!({ "scaling.force": force }));
        assert!(shown["table"]["rows"].as_array().is_some_and(|rows| rows.len() > 10), "{shown}");
        began.elapsed()
    }
}

#[test]
fn the_page_is_complete_and_its_policy_admits_no_other_source() {
    let (_server, address) = explore(&[]);
    let host = address.to_string();
    let page = get(address, "/", &host);
    assert!(page.starts_with("HTTP/1.1 200"), "{page}");
    assert!(page.contains("default-src 'none'") && page.contains("frame-ancestors 'none'"), "{page}");
    let parts: Vec<&str> = page.split(['"']).filter(|part| part.starts_with('/') && part.len() > 1).collect();
    assert!(parts.len() > 10, "{parts:?}");
    for part in parts {
        assert!(get(address, part, &host).starts_with("HTTP/1.1 200"), "{part}");
    }
    assert!(get(address, "/../Cargo.toml", &host).starts_with("HTTP/1.1 404"));
    assert!(answer(address, &format!("POST / HTTP/1.1\r\nHost: {host}\r\n\r\n")).starts_with("HTTP/1.1 405"));
}

#[test]
fn a_page_of_another_site_is_refused() {
    let (_server, address) = explore(&[]);
    let origin = format!("http://{address}");
    let port = address.port();
    for origin in ["http://evil.example", "null", &format!("http://localhost:{port}"), &format!("https://{address}")] {
        let refused = link(address, Some(origin), &address.to_string()).expect_err(origin);
        assert!(refused.to_string().contains("403"), "{origin}: {refused}");
    }
    assert!(link(address, None, &address.to_string()).expect_err("no origin").to_string().contains("403"));
    // DNS rebinding.
    let rebound = format!("evil.example:{port}");
    let refused = link(address, Some(&format!("http://{rebound}")), &rebound).expect_err("rebound");
    assert!(refused.to_string().contains("421"), "{refused}");
    assert!(get(address, "/", &rebound).starts_with("HTTP/1.1 421"));
    let two = format!("GET / HTTP/1.1\r\nHost: {address}\r\nHost: evil.example\r\n\r\n");
    let absolute = format!("GET http://evil.example/ HTTP/1.1\r\nHost: {address}\r\n\r\n");
    for unclear in [two, absolute] {
        assert!(answer(address, &unclear).starts_with("HTTP/1.1 400"), "{unclear}");
    }
    let same = format!("GET http://{address}/ HTTP/1.1\r\nHost: {address}\r\n\r\n");
    assert!(answer(address, &same).starts_with("HTTP/1.1 200"));
    assert!(link(address, Some(&origin), &address.to_string()).is_ok());
}

#[test]
fn other_machines_need_the_token_of_the_printed_address() {
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_trocar"));
    command.args(["explore", "--no-open", "--port", "0", "--bind", "0.0.0.0"]);
    let printed = |line: &str| line.split("http://").nth(1).map(str::to_owned);
    let (_server, printed) = Running::start(&mut command, printed).expect("the page is served");
    let (address, query) = printed.split_once('/').expect("an address and a query");
    let address: SocketAddr = address.parse().expect("an address");
    let host = address.to_string();
    assert!(query.starts_with("?token=") && query.len() == 39, "{query}");
    assert!(get(address, &format!("/{query}"), &host).starts_with("HTTP/1.1 200"));
    for path in ["/", "/?token=", "/link", &format!("/{}", query.replace("token=", "token=0"))] {
        let refused = get(address, path, &host);
        assert!(refused.starts_with("HTTP/1.1 403") && refused.contains("token"), "{path}: {refused}");
    }
    assert!(link(address, Some(&format!("http://{host}")), &host).expect_err("no token").to_string().contains("403"));
}

#[test]
fn all_invalid_values_are_named_at_once() {
    let (_server, address) = explore(&[]);
    let mut page = ServedPage::open(address);
    let set = json!({ "scaling.force": -1, "detector.threshold": "high", "simulation.seed": 1 });
    let state = json!({ "scenario": "builtin:paper/augmented.toml", "set": set });
    let refused = page.request(json!({ "type": "show", "state": state, "points": 400 }), "refused");
    let all = refused["all"].as_array().expect("a list");
    assert_eq!(all.len(), 2, "{refused}");
    for (error, key) in all.iter().zip(["detector.threshold", "scaling.force"]) {
        assert!(error.as_str().is_some_and(|error| error.starts_with(key)), "{refused}");
    }
}

#[test]
fn invalid_requests_of_a_page_are_rejected_with_a_reason() {
    let (_server, address) = explore(&[]);
    let mut page = ServedPage::open(address);
    let refusals = [
        ("builtin:layers/skin-augmented.toml", json!({ "recording.file": "/etc/passwd" }), "cannot name files"),
        ("/etc/passwd", json!({}), "no scenario"),
        ("builtin:layers/skin-augmented.toml", json!({ "scaling.force": -1 }), "scaling.force must be"),
        ("builtin:layers/skin-augmented.toml", json!({ "scaling.forse": 1 }), "did you mean scaling.force"),
        (
            "builtin:layers/skin-augmented.toml",
            json!({ "simulation.duration_s": 1e3 }),
            "maximum on this page is 120000",
        ),
        ("builtin:layers/skin-augmented.toml", json!({ "simulation.tick_s": 1e-9 }), "ticks"),
    ];
    for (scenario, set, reason) in refusals {
        let request = json!({ "type": "show", "state": { "scenario": scenario, "set": set }, "points": 400 });
        let refused = page.request(request, "refused");
        assert!(refused["message"].as_str().is_some_and(|text| text.contains(reason)), "{refused}");
    }
    page.moves_a_slider(1.5);
}

#[test]
fn hostile_clients_do_not_stall_an_honest_page() {
    let (_server, address) = explore(&[]);
    let origin = format!("http://{address}");
    let host = address.to_string();
    let mut honest = ServedPage::open(address);
    let mut slowest = honest.moves_a_slider(1.0);
    let mut watch = |what: &str, force: f64| {
        let took = honest.moves_a_slider(force);
        slowest = slowest.max(took);
        assert!(took < RESPONSIVE, "{what}: the honest page waited {took:?}");
    };

    // The beginning of a frame whose header announces a gigabyte.
    let mut liar = link(address, Some(&origin), &host).expect("opens");
    let stream = liar.get_mut();
    let mut frame = vec![0x82, 0xff];
    frame.extend_from_slice(&(1_u64 << 30).to_be_bytes());
    frame.extend_from_slice(&[1, 2, 3, 4]);
    stream.write_all(&frame).expect("sent");
    let block = vec![0_u8; 1 << 16];
    // The server closes the connection early, so sending fails.
    let sent = (0..1 << 14).take_while(|_| stream.write_all(&block).is_ok()).count();
    assert!(sent < 1 << 10, "{sent} blocks of a frame that is too large were taken");
    watch("a frame of a gigabyte", 1.1);

    // Invalid bytes, as requests and as messages.
    for garbage in ["\0\0\0\0\0\0\0\0\r\n\r\n", "GET / HTTP/9.9\r\n\r\n", "\u{16}\u{3}\u{1}\u{2}", &"A".repeat(1 << 20)]
    {
        let mut stream = connect(address);
        let _ = stream.write_all(garbage.as_bytes());
        let _ = stream.shutdown(Shutdown::Write);
        let mut rest = vec![];
        let _ = stream.read_to_end(&mut rest);
    }
    for garbage in ["{", "[]", "{\"type\":\"show\"}", "{\"type\":\"aim\",\"m\":1e999}", &"[".repeat(10_000)] {
        let mut socket = link(address, Some(&origin), &host).expect("opens");
        let _ = socket.send(Message::text(garbage));
        while socket.read().is_ok() {}
    }
    watch("garbage", 1.2);

    // Clients that send half a request and then nothing.
    let half_open: Vec<TcpStream> = (0..300)
        .map(|_| {
            let mut stream = connect(address);
            let _ = stream.write_all(b"GET / HTTP/1.1\r\nHost: ");
            stream
        })
        .collect();
    watch("half-open sockets", 1.3);
    assert!(get(address, "/", &host).starts_with("HTTP/1.1 200"), "a newcomer is served all the same");
    drop(half_open);

    // A page that sends many requests and reads no answer.
    let mut deaf: Vec<Socket> = (0..4).map(|_| link(address, Some(&origin), &host).expect("opens")).collect();
    for socket in &mut deaf {
        socket.get_ref().set_write_timeout(Some(Duration::from_millis(200))).expect("set");
        for id in 0..200 {
            let state =
                json!({ "scenario": "builtin:paper/augmented.toml", "set": { "scaling.force": 1.0 + f64::from(id) } });
            let request = json!({ "type": "show", "id": id, "state": state, "points": 4000 });
            if socket.send(Message::text(request.to_string())).is_err() {
                break;
            }
        }
    }
    watch("pages that do not read", 1.6);
    drop(deaf);

    eprintln!("the honest page waited {slowest:?} at most");
}

#[test]
fn a_hand_pushes_through_the_skin_in_real_time() {
    let (_server, address) = explore(&[]);
    let mut page = ServedPage::open(address);
    let state = json!({ "scenario": "builtin:layers/skin-augmented.toml", "set": {} });
    page.last_id += 1;
    let began = Instant::now();
    page.send(&json!({ "type": "push", "id": page.last_id, "state": state, "augmented": true }));
    let message = page.receive("pushing");
    let deepest_m = message["range_mm"][1].as_f64().expect("a number") / 1e3;
    let mut events = vec![];
    let mut frozen = vec![];
    let mut last_s = 0.0;
    for step in 0..1200 {
        // A page aims at each frame of its screen.
        std::thread::sleep(Duration::from_millis(16));
        let share = (f64::from(step) / 600.0).min(1.0);
        page.send(&json!({ "type": "aim", "id": page.last_id, "m": share * deepest_m }));
        let moved = page.receive("moved");
        events.extend(moved["events"].as_array().expect("a list").iter().map(|event| event[1].clone()));
        for row in moved["rows"].as_array().expect("a list") {
            last_s = row[0].as_f64().expect("a number");
            if row[6] == 1.0 {
                frozen.push(row[3].as_f64().expect("a number"));
            }
        }
        if frozen.len() > 300 {
            break;
        }
    }
    let passed_s = began.elapsed().as_secs_f64();
    assert!(events.contains(&json!("rupture")) && events.contains(&json!("alarm")), "{events:?}");
    assert!(frozen.len() > 300, "the slave freezes");
    let moved_mm = frozen.iter().map(|position| (position - frozen[0]).abs()).fold(0.0, f64::max);
    assert!(moved_mm < 0.5, "frozen, and moved by {moved_mm} mm");
    assert!(last_s <= passed_s, "{last_s} s in {passed_s} s: not faster than time");
    page.send(&json!({ "type": "stop", "id": page.last_id }));
    // The same motion runs with both schemes: the augmented run equals the one above, and the classical needle moves
    // on.
    let result = page.receive("pushed");
    let overshoot_mm = |run: usize| result["overshoot_mm"][run][0].as_f64().expect("an overshoot");
    assert!(overshoot_mm(0) > 3.0 && overshoot_mm(1) < 1.0, "{result}");
    let panels = result["figure"]["rows"]
        .as_array()
        .expect("rows")
        .iter()
        .flat_map(|row| row["panels"].as_array().expect("panels"));
    let lines: Vec<_> = panels
        .filter(|panel| panel["id"] == "position")
        .flat_map(|panel| panel["lines"].as_array().expect("lines"))
        .collect();
    let slave = lines.iter().find(|line| line["name"] == "slave, augmented").expect("a line");
    let points =
        slave["points"][0].as_array().expect("times").iter().zip(slave["points"][1].as_array().expect("positions"));
    let near = |time_s: &Json| (time_s.as_f64().expect("a time") - last_s).abs() < 0.02;
    let again: Vec<f64> =
        points.filter(|(time_s, _)| near(time_s)).map(|(_, mm)| mm.as_f64().expect("a position")).collect();
    let felt = frozen[frozen.len() - 1];
    assert!(!again.is_empty() && again.iter().all(|mm| (mm - felt).abs() < 0.02), "{again:?}, {felt}");
}

#[test]
#[cfg(unix)]
fn ctrl_c_ends_the_server_cleanly_with_an_open_page() {
    let (mut server, address) = explore(&[]);
    let mut page = ServedPage::open(address);
    page.moves_a_slider(1.0);
    let killed = std::process::Command::new("kill").args(["-INT", &server.id().to_string()]).status().expect("runs");
    assert!(killed.success());
    assert_eq!(server.wait(), Some(0));
}

#[test]
fn an_occupied_port_is_named_with_the_remedy() {
    let (_server, address) = explore(&[]);
    let port = address.port().to_string();
    let folder = TestFolder::new();
    folder.refused(&["explore", "--no-open", "--port", &port], &[&address.to_string(), "--port"]);
    folder.refused(&["explore", "no-such.toml"], &["no-such.toml"]);
}
