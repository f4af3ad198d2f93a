//! Standard input and signals, whichever comes first.

use std::io::{self, ErrorKind, Read};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread;

use crate::cli::error::DetectError;
use crate::cli::interrupt;

/// Bytes read at once at most. A live rig's lines come one by one, each as soon as it was written.
const CHUNK_BYTES: usize = 64 << 10;

/// Chunks on their way.
const CHUNKS: usize = 2;

/// What comes next.
pub(super) enum Event<'a> {
    /// Bytes of the input.
    Bytes(&'a [u8]),
    /// The input's end.
    End,
    /// Ctrl-C, or a request to end.
    Stop,
    /// The input broke.
    Failed(io::Error),
}

enum Message {
    Bytes(Vec<u8>, usize),
    End,
    Stop,
    Failed(io::Error),
}

/// Standard input, read by a thread of its own so that a signal can end the wait for it. A fixed number of buffers go to and
/// fro.
pub(super) struct Source {
    messages: Receiver<Message>,
    spare: SyncSender<Vec<u8>>,
    current: Vec<u8>,
}

impl Source {
    /// Begins to read, and takes over SIGINT, SIGTERM and SIGHUP. A second signal ends the process at once.
    pub(super) fn open() -> Result<Self, DetectError> {
        let (sender, messages) = sync_channel(CHUNKS);
        let (spare, empty) = sync_channel(CHUNKS + 2);
        let stop = sender.clone();
        interrupt::on_first(move || {
            let stop = stop.clone();
            // Not here: the queue may be full, and a second signal must come through.
            thread::spawn(move || stop.send(Message::Stop));
        })?;
        thread::spawn(move || read(&sender, &empty));
        Ok(Self { messages, spare, current: vec![] })
    }

    /// Waits for what comes next.
    pub(super) fn next(&mut self) -> Event<'_> {
        let used = std::mem::take(&mut self.current);
        if !used.is_empty() {
            // Without room the buffer is dropped, and the reader makes another.
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
        // Nobody listens once the command has ended.
        if sender.send(message).is_err() || is_last {
            return;
        }
    }
}
