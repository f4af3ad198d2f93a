//! The page's server, as the tests run it.

use std::io::{BufRead, BufReader};
use std::net::SocketAddr;
use std::process::{Child, Command, Stdio};

/// A program that ends with the test.
pub struct Running(Child);

impl Running {
    /// Starts a program whose standard output is read up to a line that tells something; the rest is read and dropped.
    pub fn start<T>(command: &mut Command, tells: impl Fn(&str) -> Option<T>) -> Option<(Self, T)> {
        let mut child = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().ok()?;
        let mut lines = BufReader::new(child.stdout.take()?).lines();
        let told = lines.by_ref().map_while(Result::ok).find_map(|line| tells(&line));
        let running = Self(child);
        // Whoever writes to a pipe that nobody reads waits for ever.
        std::thread::spawn(move || lines.for_each(drop));
        Some((running, told?))
    }

    /// Its process.
    pub fn id(&self) -> u32 {
        self.0.id()
    }

    /// Waits for its end; gives the exit code.
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

/// Serves a scenario's page on a free port, by the program of this build or by the one that `TROCAR_BIN` names.
pub fn explore(arguments: &[&str]) -> (Running, SocketAddr) {
    let program = std::env::var_os("TROCAR_BIN").unwrap_or_else(|| env!("CARGO_BIN_EXE_trocar").into());
    let mut command = Command::new(program);
    command.args(["explore", "--no-open", "--port", "0"]).args(arguments);
    let address = |line: &str| line.split("http://").nth(1)?.trim_end_matches('/').parse().ok();
    Running::start(&mut command, address).expect("the page is served")
}
