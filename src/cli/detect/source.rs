//! Waits for input and signals at the same time.

use std::io::{self, ErrorKind, Read};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread;

use crate::cli::interrupt;

/// Maximum number of bytes per read. The lines of a live rig arrive one by one.
const CHUNK_BYTES: usize = 64 << 10;

const CHUNKS: usize = 2;

pub(super) enum Event<'a> {
    Bytes(&'a [u8]),
    End,
    /// Ctrl-C or another termination signal.
    Stop,
    /// The input cannot be read.
    Failed(io::Error),
}

enum Message {
    Bytes(Vec<u8>, usize),
    End,
    Stop,
    Failed(io::Error),
}

/// A separate thread reads into a fixed number of buffers, so that a signal can end the wait.
pub(super) struct StandardInput {
    messages: Receiver<Message>,
    spare: SyncSender<Vec<u8>>,
    current: Vec<u8>,
}

impl StandardInput {
    /// Stops at SIGINT, SIGTERM or SIGHUP. A second signal ends the process at once.
    pub(super) fn open() -> Self {
        let (sender, messages) = sync_channel(CHUNKS);
        let (spare, empty) = sync_channel(CHUNKS + 2);
        let stop = sender.clone();
        interrupt::on_first(move || {
            let stop = stop.clone();
            // Send from a new thread: the queue may be full, and the handler must stay free for a second signal.
            thread::spawn(move || stop.send(Message::Stop));
        });
        thread::spawn(move || read(&sender, &empty));
        Self { messages, spare, current: vec![] }
    }

    pub(super) fn next(&mut self) -> Event<'_> {
        let used = std::mem::take(&mut self.current);
        if !used.is_empty() {
            // If the queue is full, drop the buffer; the reader allocates a new one.
            let _ = self.spare.try_send(used);
        }
        match self.messages.recv() {
            Ok(Message::Bytes(bytes, count)) => {
                self.current = bytes;
                Event::Bytes(&self.current[..count])
            }
            Ok(Message::Stop) => Event::Stop,
            Ok(Message::Failed(error)) => Event::Failed(error),
            Ok(Message::End) | Err(_) => Event::End,
        }
    }
}

fn read(sender: &SyncSender<Message>, empty: &Receiver<Vec<u8>>) {
    let mut input = io::stdin().lock();
    loop {
        let mut bytes = empty.try_recv().unwrap_or_else(|_| vec![0; CHUNK_BYTES]);
        let message = match input.read(&mut bytes) {
            Ok(0) => Message::End,
            Ok(count) => Message::Bytes(bytes, count),
            Err(error) if error.kind() == ErrorKind::Interrupted => continue,
            Err(error) => Message::Failed(error),
        };
        let is_last = !matches!(message, Message::Bytes(..));
        // The receiver closes when the command ends.
        if sender.send(message).is_err() || is_last {
            return;
        }
    }
}
