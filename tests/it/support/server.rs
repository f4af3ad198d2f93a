//! The server of the page for tests.

use std::io::{BufRead, BufReader};
use std::net::SocketAddr;
use std::process::{Child, Command, Stdio};

/// A program that ends with the test.
pub struct Running(Child);

impl Running {
    /// Starts a program and reads its standard output up to a line for which `parse` returns a value; the rest is read
    /// and dropped.
    pub fn start<T>(command: &mut Command, parse: impl Fn(&str) -> Option<T>) -> Option<(Self, T)> {
        let mut child = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().ok()?;
        let mut lines = BufReader::new(child.stdout.take()?).lines();
        let value = lines.by_ref().map_while(Result::ok).find_map(|line| parse(&line));
        let running = Self(child);
        // A process that writes to a full pipe blocks.
        std::thread::spawn(move || lines.for_each(drop));
        Some((running, value?))
    }

    /// Returns the process id.
    pub fn id(&self) -> u32 {
        self.0.id()
    }

    /// Waits for the end and returns the exit code.
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

/// Serves the page of a scenario on a free port, with the program of this build or the one in `TROCAR_BIN`.
pub fn explore(arguments: &[&str]) -> (Running, SocketAddr) {
    let program = std::env::var_os("TROCAR_BIN").unwrap_or_else(|| env!("CARGO_BIN_EXE_trocar").into());
    let mut command = Command::new(program);
    command.args(["explore", "--no-open", "--port", "0"]).args(arguments);
    let address = |line: &str| line.split("http://").nth(1)?.split('/').next()?.parse().ok();
    Running::start(&mut command, address).expect("the page is served")
}
