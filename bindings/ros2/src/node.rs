//! The node on the graph: publishers, subscriptions, services, and leaving without a trace.

use crate::args::ArgsError;
use crate::graph::{self, Watch};
use crate::inbox::{Inbox, Reply};
use crate::names::Names;
use crate::network::Network;
use crate::reply::Replies;
use crate::session::Session;
use futures::StreamExt;
use futures::channel::oneshot;
use ros2_client::action::{ActionServerQosPolicies, AsyncActionServer};
use ros2_client::dds::rustdds::policy::{Durability, History, ResourceLimits};
use ros2_client::dds::rustdds::{DomainParticipantBuilder, Duration as DdsDuration, QosPolicyBuilder, SequenceNumber, Topic, TopicKind};
use ros2_client::{
    ActionTypeName, Context, Message, MessageTypeName, Name, Node, NodeName, NodeOptions, Publisher, RmwRequestId, ServiceMapping,
};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// The node cannot join the graph.
#[derive(Debug, thiserror::Error)]
pub enum NodeError {
    /// A ROS argument.
    #[error(transparent)]
    Args(#[from] ArgsError),
    /// DDS refuses.
    #[error("{what}: {reason}")]
    Dds {
        /// What was to be made.
        what: String,
        /// What DDS says.
        reason: String,
    },
    /// No thread.
    #[error("cannot start a thread: {0}")]
    Thread(#[from] std::io::Error),
}

impl NodeError {
    /// For `map_err` on calls of DDS.
    pub(crate) fn dds<E: std::fmt::Debug>(what: &str) -> impl FnOnce(E) -> Self + '_ {
        move |error| Self::Dds { what: what.into(), reason: format!("{error:?}") }
    }
}

/// Quality of service of a topic.
#[derive(Debug, Clone, Copy)]
pub struct Quality {
    /// Lost messages are sent again.
    pub reliable: bool,
    /// Messages kept for late (if `latched`) or slow subscribers.
    pub depth: usize,
    /// Late subscribers get the last ones.
    pub latched: bool,
    /// Messages that a subscriber may leave unanswered before there is no room for more: bounds the memory that a dead one costs.
    pub unanswered: usize,
    /// How long a message waits for room, where it is reliable; without room after that it is not published.
    pub patience: Duration,
}

impl Quality {
    /// Reliable, the default of ROS.
    pub const RELIABLE: Self = Self { reliable: true, depth: 10, latched: false, unanswered: 256, patience: Duration::ZERO };
}

/// The node. Parts are dropped in the order in which other nodes must hear of it.
pub struct Ros {
    names: Names,
    executor: Arc<smol::Executor<'static>>,
    node: Node,
    context: Context,
    inbox: Inbox,
    /// Calls that are not answered yet.
    open: Arc<AtomicUsize>,
    /// Who listens.
    pub watch: Arc<Watch>,
}

impl Ros {
    /// Joins the graph.
    ///
    /// # Errors
    /// DDS refuses.
    pub fn open(names: Names, network: &Network, inbox: Inbox) -> Result<Self, NodeError> {
        let mut builder = DomainParticipantBuilder::new(network.domain);
        if let Some(addresses) = network.addresses() {
            builder = builder.with_only_networks(addresses);
        }
        let participant = builder.build().map_err(NodeError::dds("cannot join the DDS domain"))?;
        let context = Context::from_domain_participant(participant).map_err(NodeError::dds("cannot join the ROS graph"))?;
        let name = NodeName::new(names.namespace(), names.node()).map_err(NodeError::dds("name of the node"))?;
        // The parameter services of ros2-client have no descriptions, and need a spinner that puts a second type on /clock.
        let options = NodeOptions::new().enable_rosout(true).start_parameter_services(false);
        let node = context.new_node(name, options).map_err(NodeError::dds("cannot make the node"))?;
        Ok(Self { names, executor: Arc::default(), node, context, inbox, open: Arc::default(), watch: Arc::default() })
    }

    /// Makes a publisher of messages of type `package/Name`.
    ///
    /// # Errors
    /// A remap to what is no name; DDS refuses.
    pub fn publisher<M: Serialize>(
        &mut self,
        name: &str,
        package: &str,
        message: &str,
        quality: Quality,
    ) -> Result<Publisher<M>, NodeError> {
        let topic = self.topic(name, package, message, quality)?;
        self.node.create_publisher(&topic, None).map_err(NodeError::dds(name))
    }

    /// Calls `handle` for each message on a topic, on the thread of the executor; `None` stands for bytes that are no such message.
    ///
    /// # Errors
    /// A remap to what is no name; DDS refuses.
    pub fn subscribe<M, F>(&mut self, name: &str, package: &str, message: &str, handle: F) -> Result<(), NodeError>
    where
        M: DeserializeOwned + Send + Sync + 'static,
        F: Fn(Option<M>) -> Option<crate::inbox::Request> + Send + 'static,
    {
        let topic = self.topic(name, package, message, Quality::RELIABLE)?;
        let subscription = self.node.create_subscription::<M>(&topic, None).map_err(NodeError::dds(name))?;
        let inbox = self.inbox.clone();
        self.spawn(async move {
            let mut stream = Box::pin(subscription.async_stream());
            while let Some(received) = stream.next().await {
                if let Some(request) = handle(received.ok().map(|(message, _)| message)) {
                    inbox.send(request).await;
                }
            }
        });
        Ok(())
    }

    /// Serves calls of type `package/Name`: `handle` runs in the loop and may answer later.
    ///
    /// # Errors
    /// A remap to what is no name; DDS refuses.
    pub fn serve<Req, Resp>(
        &mut self,
        name: &str,
        package: &str,
        service: &str,
        handle: impl Fn(&mut Session, Req, Reply<Resp>) + Copy + Send + 'static,
    ) -> Result<(), NodeError>
    where
        Req: Message + Clone + Send + Sync + 'static,
        Resp: Message + Send + Sync + 'static,
    {
        let quality = QosPolicyBuilder::new()
            .durability(Durability::Volatile)
            .reliable(DdsDuration::ZERO)
            .history(History::KeepLast { depth: 10 })
            .build();
        let full = self.names.resolve(name)?;
        let participant = self.context.domain_participant();
        let topic = |prefix: &str, suffix: &str, kind: &str| {
            let kind = format!("{package}::srv::dds_::{service}_{kind}_");
            participant.create_topic(format!("{prefix}{full}{suffix}"), kind, &quality, TopicKind::NoKey).map_err(NodeError::dds(name))
        };
        let (requests, replies) = (topic("rq", "Request", "Request")?, topic("rr", "Reply", "Response")?);
        let requests = self.node.create_subscription::<Req>(&requests, None).map_err(NodeError::dds(name))?;
        let replies = Replies::new(participant.clone(), &replies, format!("rr{full}Reply"), &quality)?;
        let (inbox, open) = (self.inbox.clone(), self.open.clone());
        self.spawn(async move {
            let mut stream = Box::pin(requests.async_stream());
            while let Some(received) = stream.next().await {
                let Ok((request, info)) = received else { continue };
                // Fast DDS names the call by the client's own identity, and may leave its number open.
                let own = RmwRequestId { writer_gid: info.publisher_gid(), sequence_number: info.sequence_number() };
                let mut id = info.related_request_id().unwrap_or(own);
                if id.sequence_number == i64::from(SequenceNumber::UNKNOWN) {
                    id.sequence_number = own.sequence_number;
                }
                open.fetch_add(1, Ordering::SeqCst);
                let (reply, answer) = oneshot::channel();
                inbox.send(Box::new(move |session| handle(session, request, Reply(reply)))).await;
                if let Ok(response) = answer.await {
                    replies.send(id, &response);
                }
                open.fetch_sub(1, Ordering::SeqCst);
            }
        });
        Ok(())
    }

    /// Makes a server of an action.
    ///
    /// # Errors
    /// A remap to what is no name; DDS refuses.
    pub fn action_server<G, R, F>(
        &mut self,
        name: &str,
        kind: &ActionTypeName,
        policies: ActionServerQosPolicies,
    ) -> Result<AsyncActionServer<G, R, F>, NodeError>
    where
        G: Message + Clone + 'static,
        R: Message + Clone + 'static,
        F: Message + 'static,
    {
        let place = self.place(name)?;
        let server = self.node.create_action_server(ServiceMapping::Enhanced, &place, kind, policies).map_err(NodeError::dds(name))?;
        Ok(AsyncActionServer::new(server))
    }

    /// The way to bring requests.
    pub fn inbox(&self) -> Inbox {
        self.inbox.clone()
    }

    /// Runs a task for as long as the node lives.
    pub fn spawn(&self, task: impl Future<Output = ()> + Send + 'static) {
        self.executor.spawn(task).detach();
    }

    /// Starts to follow who is there.
    ///
    /// # Errors
    /// DDS refuses.
    pub fn follow(&mut self) -> Result<(), NodeError> {
        let mut topics = [const { String::new() }; 4];
        for (topic, name) in topics.iter_mut().zip(["/clock", "~/state", "~/particles", "/diagnostics"]) {
            *topic = format!("rt{}", self.names.resolve(name)?);
        }
        let participant = self.context.domain_participant();
        self.spawn(graph::follow(participant.clone(), topics, self.watch.clone()));

        let quality = QosPolicyBuilder::new()
            .durability(Durability::TransientLocal)
            .reliable(DdsDuration::ZERO)
            .history(History::KeepLast { depth: 100 })
            .build();
        let what = "cannot follow the names of other nodes";
        let (name, kind) = ("ros_discovery_info".to_owned(), "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_".to_owned());
        let topic = participant.create_topic(name, kind, &quality, TopicKind::NoKey).map_err(NodeError::dds(what))?;
        let info = self.node.create_subscription(&topic, None).map_err(NodeError::dds(what))?;
        let own = self.context.participant_entities_info().gid();
        self.spawn(graph::names(info, own, self.names.full(), self.watch.clone()));
        Ok(())
    }

    /// Starts to receive.
    ///
    /// # Errors
    /// No thread can be had.
    pub fn start(&self) -> Result<Receiving, NodeError> {
        let (stop, stopped) = smol::channel::bounded::<()>(1);
        let executor = self.executor.clone();
        let run = move || {
            let _ = smol::block_on(executor.run(stopped.recv()));
        };
        let thread = std::thread::Builder::new().name("receive".into()).spawn(run)?;
        Ok(Receiving { stop, thread: Some(thread) })
    }

    /// A handle that logs to `/rosout`.
    pub fn logger(&self) -> ros2_client::NodeLoggingHandle {
        self.node.logging_handle()
    }

    /// Leaves the graph. All publishers must be gone.
    pub fn close(self, mut receiving: Receiving) {
        let Self { executor, node, context, open, .. } = self;
        // Who made the node quit is told that it does.
        let end = Instant::now() + Duration::from_secs(1);
        while open.load(Ordering::SeqCst) > 0 && Instant::now() < end {
            std::thread::sleep(Duration::from_millis(1));
        }
        // Tasks own subscriptions and servers; they go with the last handle of the executor.
        receiving.join();
        drop(executor);
        drop(node);
        // The news that the node is gone must leave before the participant does.
        std::thread::sleep(Duration::from_millis(100));
        drop(context);
    }

    fn topic(&self, name: &str, package: &str, message: &str, quality: Quality) -> Result<Topic, NodeError> {
        let Quality { reliable, depth, latched, unanswered, patience } = quality;
        let limit = i32::try_from(unanswered).unwrap_or(i32::MAX);
        let builder = QosPolicyBuilder::new()
            .durability(if latched { Durability::TransientLocal } else { Durability::Volatile })
            .history(History::KeepLast { depth: i32::try_from(depth).unwrap_or(i32::MAX) })
            .resource_limits(ResourceLimits { max_samples: limit, max_instances: 1, max_samples_per_instance: limit });
        let policies = if reliable { builder.reliable(DdsDuration::from_std(patience)) } else { builder.best_effort() }.build();
        let kind = MessageTypeName::new(package, message).dds_msg_type();
        let name = format!("rt{}", self.names.resolve(name)?);
        let participant = self.context.domain_participant();
        participant.create_topic(name.clone(), kind, &policies, TopicKind::NoKey).map_err(NodeError::dds(&name))
    }

    fn place(&self, name: &str) -> Result<Name, NodeError> {
        let full = self.names.resolve(name)?;
        let (namespace, base) = full.rsplit_once('/').unwrap_or(("", &full));
        Name::new(if namespace.is_empty() { "/" } else { namespace }, base).map_err(NodeError::dds(name))
    }
}

/// The thread that receives.
pub struct Receiving {
    stop: smol::channel::Sender<()>,
    thread: Option<JoinHandle<()>>,
}

impl Receiving {
    fn join(&mut self) {
        let _ = self.stop.try_send(());
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
