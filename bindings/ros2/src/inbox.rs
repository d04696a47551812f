//! The way into the loop: whatever comes from outside becomes a closure that runs between two steps.

use crate::session::Session;
use futures::channel::oneshot;
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::time::Duration;

/// Something to be done by the loop between two steps.
pub type Request = Box<dyn FnOnce(&mut Session) + Send>;

/// Requests that may wait; whoever brings more waits himself.
const ROOM: usize = 256;

/// Sends requests to the loop.
#[derive(Clone)]
pub struct Inbox(SyncSender<Request>);

/// The two ends.
pub fn inbox() -> (Inbox, Receiver<Request>) {
    let (sender, receiver) = sync_channel(ROOM);
    (Inbox(sender), receiver)
}

impl Inbox {
    /// Sends a request, waiting for room.
    pub async fn send(&self, mut request: Request) {
        while let Err(TrySendError::Full(back)) = self.0.try_send(request) {
            request = back;
            smol::Timer::after(Duration::from_millis(1)).await;
        }
    }

    /// Sends a request from outside the executor, waiting for room.
    pub fn send_blocking(&self, request: Request) {
        let _ = self.0.send(request);
    }
}

/// Answers a service call, now or later.
pub struct Reply<Resp>(pub oneshot::Sender<Resp>);

impl<Resp> Reply<Resp> {
    /// Sends the answer; nobody may be left to hear it.
    pub fn send(self, response: Resp) {
        let _ = self.0.send(response);
    }
}
