//! The action `simulate_steps` of `simulation_interfaces`: steps while paused, with feedback, and can be cancelled.

use crate::control::stepped;
use crate::interfaces::simulation::StepSimulationResponse;
use crate::node::{NodeError, Ros};
use crate::session::{Session, Stepping};
use futures::channel::{mpsc, oneshot};
use futures::{FutureExt, StreamExt};
use ros2_client::action::{ActionServerQosPolicies, AsyncActionServer, GoalEndStatus};
use ros2_client::qos::{Durability, History};
use ros2_client::{ActionTypeName, Message, QosProfile};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::Duration;

/// Number of steps.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct Goal {
    steps: u64,
}
impl Message for Goal {}

/// Steps done and left.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct Feedback {
    completed_steps: u64,
    remaining_steps: u64,
}
impl Message for Feedback {}

type Server = AsyncActionServer<Goal, StepSimulationResponse, Feedback>;

/// A client that wants the result asks for it within this time.
const PATIENCE: Duration = Duration::from_secs(10);

/// Serves the action.
///
/// # Errors
/// DDS refuses.
pub fn serve(ros: &mut Ros) -> Result<(), NodeError> {
    let quality = QosProfile::publisher_default().history(History::KeepLast { depth: 10 });
    let policies = ActionServerQosPolicies {
        goal_service: quality.clone(),
        result_service: quality.clone(),
        cancel_service: quality.clone(),
        feedback_publisher: quality.clone(),
        status_publisher: quality.durability(Durability::TransientLocal),
    };
    let server: Server = ros.action_server("~/simulate_steps", &ActionTypeName::new("simulation_interfaces", "SimulateSteps"), policies)?;
    let inbox = ros.inbox();
    ros.spawn(async move {
        loop {
            // One goal at a time: the loop refuses steps beside steps anyway.
            if goal(&server, &inbox).await.is_none() {
                smol::Timer::after(Duration::from_millis(10)).await;
            }
        }
    });
    Ok(())
}

/// One goal from its arrival to its result; `None` where the client went away.
async fn goal(server: &Server, inbox: &crate::inbox::Inbox) -> Option<()> {
    let new = server.receive_new_goal().await.ok()?;
    let total = server.get_new_goal(new)?.steps;
    let accepted = server.accept_goal(new).await.ok()?;
    let executing = server.start_executing_goal(accepted).await.ok()?;

    let (feedback, mut done) = mpsc::unbounded::<(u64, u64)>();
    let (finish, finished) = oneshot::channel();
    let go_on = Arc::new(AtomicBool::new(true));
    let theirs = go_on.clone();
    let start = move |session: &mut Session| {
        session.start_stepping(Stepping {
            done: 0,
            total,
            progress: Box::new(move |done, total| {
                let _ = feedback.unbounded_send((done, total));
                theirs.load(Relaxed)
            }),
            finish: Box::new(move |how| drop(finish.send(how))),
        });
    };
    inbox.send(Box::new(start)).await;

    let mut finished = finished.fuse();
    let mut cancelled = false;
    let how = loop {
        futures::select_biased! {
            cancel = FutureExt::fuse(server.receive_cancel_request()) => {
                let Ok(cancel) = cancel else { continue };
                let id = executing.goal_id();
                if cancel.contains_goal(&id) {
                    let _ = server.respond_to_cancel_requests(&cancel, std::iter::once(id)).await;
                    cancelled = true;
                    go_on.store(false, Relaxed);
                }
            }
            step = done.select_next_some() => {
                // Only the newest: a client need not hear of each of a million steps.
                let (done, total) = std::iter::from_fn(|| done.next().now_or_never().flatten()).last().unwrap_or(step);
                let _ = server.publish_feedback(executing, Feedback { completed_steps: done, remaining_steps: total - done }).await;
            }
            how = finished => break how.unwrap_or_else(|_| Err("the simulator is quitting".into())),
        }
    };
    let status = match &how {
        Ok(()) => GoalEndStatus::Succeeded,
        Err(_) if cancelled => GoalEndStatus::Canceled,
        Err(_) => GoalEndStatus::Aborted,
    };
    let answer = server.send_result_response(executing, status, StepSimulationResponse { result: stepped(how) });
    futures::select! {
        sent = FutureExt::fuse(Box::pin(answer)) => sent.ok(),
        _ = FutureExt::fuse(smol::Timer::after(PATIENCE)) => None,
    }
}
