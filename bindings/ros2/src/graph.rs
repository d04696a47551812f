//! Who is there: subscribers of our topics, so that nothing is built for nobody, and nodes of the same name.

use futures::{FutureExt, StreamExt};
use ros2_client::Subscription;
use ros2_client::dds::rustdds::{DomainParticipant, StatusEvented};
use ros2_client::entities_info::ParticipantEntitiesInfo;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};
use std::time::Duration;

/// Subscribers of each topic, and whether the name of the node is taken.
#[derive(Debug, Default)]
pub struct Watch {
    /// Of `/clock`.
    pub clock: AtomicUsize,
    /// Of `~/state`.
    pub state: AtomicUsize,
    /// Of `~/particles`.
    pub particles: AtomicUsize,
    /// Of `/diagnostics`.
    pub diagnostics: AtomicUsize,
    /// Another node has the same name.
    pub same_name: AtomicBool,
}

impl Watch {
    /// Whether anybody subscribes to a topic of this node.
    pub fn listened(count: &AtomicUsize) -> bool {
        count.load(Relaxed) > 0
    }

    /// What is said when another node has the same `name`.
    pub fn taken(name: &str) -> String {
        format!(
            "another node is named {name} (one that was killed is remembered for up to 50 s); give one of them --ros-args -r __node:=NAME"
        )
    }

    /// Counts again. `topics` are the DDS names of clock, state, particles and diagnostics.
    fn count(&self, participant: &DomainParticipant, topics: &[String; 4]) {
        let mut counts = [0; 4];
        for reader in participant.discovered_readers() {
            if let Some(i) = topics.iter().position(|t| t == reader.subscription_topic_data.topic_name()) {
                counts[i] += 1;
            }
        }
        for (count, place) in counts.into_iter().zip([&self.clock, &self.state, &self.particles, &self.diagnostics]) {
            place.store(count, Relaxed);
        }
    }
}

/// Keeps the counts up to date, for ever. An event may get lost, so they are counted anew each second too.
pub async fn follow(participant: DomainParticipant, topics: [String; 4], watch: std::sync::Arc<Watch>) {
    let listener = participant.status_listener();
    let mut events = listener.as_async_status_stream();
    loop {
        watch.count(&participant, &topics);
        futures::select! {
            _ = events.select_next_some() => {}
            _ = FutureExt::fuse(smol::Timer::after(Duration::from_secs(1))) => {}
        }
        // Events come in crowds.
        smol::Timer::after(Duration::from_millis(10)).await;
        while events.next().now_or_never().flatten().is_some() {}
    }
}

/// Watches what nodes other participants have, for ever.
pub async fn names(info: Subscription<ParticipantEntitiesInfo>, own: ros2_client::Gid, full_name: String, watch: std::sync::Arc<Watch>) {
    let mut holders = std::collections::BTreeSet::new();
    let mut stream = Box::pin(info.async_stream());
    while let Some(message) = stream.next().await {
        let Ok((participant, _)) = message else { continue };
        if participant.gid() == own {
            continue;
        }
        let gid = format!("{:?}", participant.gid());
        if participant.nodes().iter().any(|node| node.fully_qualified_name() == full_name) {
            holders.insert(gid);
        } else {
            holders.remove(&gid);
        }
        watch.same_name.store(!holders.is_empty(), Relaxed);
    }
}
