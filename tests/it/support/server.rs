//! The server of the page for tests.

use std::io::{BufRead, BufReader};
use std::net::{SocketAddr, TcpStream};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use tungstenite::WebSocket;
use tungstenite::client::IntoClientRequest;

/// Maximum time of an answer during an attack.
pub const RESPONSIVE: Duration = Duration::from_secs(5);

pub type Socket = WebSocket<TcpStream>;

/// A program that ends with the test.
pub struct Running(Child);

impl Running {
    /// Starts a program and reads its standard output up to a line for which `parse` returns a value. Reads and drops
    /// the rest.
    pub fn start<T>(command: &mut Command, parse: impl Fn(&str) -> Option<T>) -> Option<(Self, T)> {
        let mut child = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().ok()?;
        let mut lines = BufReader::new(child.stdout.take()?).lines();
        let value = lines.by_ref().map_while(Result::ok).find_map(|line| parse(&line));
        let running = Self(child);
        // Keep reading, because a process that writes to a full pipe blocks.
        std::thread::spawn(move || lines.for_each(drop));
        Some((running, value?))
    }

    pub fn id(&self) -> u32 {
        self.0.id()
    }

    pub fn wait(&mut self) -> Option<i32> {
        self.0.wait().ok()?.code()
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Serves the page of a scenario on a free port, with the program of this build or the program in `TROCAR_BIN`.
pub fn explore(arguments: &[&str]) -> (Running, SocketAddr) {
    let program = std::env::var_os("TROCAR_BIN").unwrap_or_else(|| env!("CARGO_BIN_EXE_trocar").into());
    let mut command = Command::new(program);
    command.args(["explore", "--no-open", "--port", "0"]).args(arguments);
    let address = |line: &str| line.split("http://").nth(1)?.split('/').next()?.parse().ok();
    Running::start(&mut command, address).expect("the page is served")
}

pub fn connect(address: SocketAddr) -> TcpStream {
    let stream = TcpStream::connect_timeout(&address, RESPONSIVE).expect("connects");
    stream.set_read_timeout(Some(Duration::from_secs(30))).expect("set");
    stream.set_write_timeout(Some(Duration::from_secs(30))).expect("set");
    stream
}

pub fn link(address: SocketAddr, origin: Option<&str>, host: &str) -> Result<Socket, Box<tungstenite::Error>> {
    let mut request = format!("ws://{address}/link").into_client_request().map_err(Box::new)?;
    let headers = request.headers_mut();
    headers.insert("host", host.parse().expect("a header"));
    if let Some(origin) = origin {
        headers.insert("origin", origin.parse().expect("a header"));
    }
    match tungstenite::client(request, connect(address)) {
        Ok((socket, _)) => Ok(socket),
        Err(tungstenite::HandshakeError::Failure(error)) => Err(Box::new(error)),
        Err(tungstenite::HandshakeError::Interrupted(_)) => panic!("the stream blocks"),
    }
}

/// Opens the WebSocket of a server from its own page.
pub fn open(address: &str) -> Socket {
    let to = address.parse().expect("an address");
    link(to, Some(&format!("http://{address}")), address).expect("opens")
}
