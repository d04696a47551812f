//! The services of `matpoint_msgs`: describe, get, set, save, restore.

use crate::interfaces::matpoint::*;
use crate::interfaces::{Bytes, Empty};
use crate::node::{NodeError, Ros};
use crate::session::Session;
use std::sync::Arc;

const PACKAGE: &str = "matpoint_msgs";

/// Serves them.
///
/// # Errors
/// DDS refuses.
pub fn serve(ros: &mut Ros) -> Result<(), NodeError> {
    ros.serve("~/describe", PACKAGE, "Describe", |session, _: Empty, reply| {
        let scene = SceneDescription::new(&session.description, env!("CARGO_PKG_VERSION"), &session.parameters.settings.frame_id);
        reply.send(DescribeResponse { scene });
    })?;
    ros.serve("~/get", PACKAGE, "GetVariable", |session, request: GetVariableRequest, reply| reply.send(get(session, &request.name)))?;
    ros.serve("~/set", PACKAGE, "SetVariable", |session, request: SetVariableRequest, reply| {
        let outcome = session.sim.set(&request.name, &request.values);
        if outcome.is_ok() {
            session.loads.forget(&request.name);
        }
        let message = outcome.as_ref().err().map(ToString::to_string).unwrap_or_default();
        reply.send(SetVariableResponse { success: outcome.is_ok(), message });
    })?;
    ros.serve("~/save", PACKAGE, "SaveState", |session, request: SaveStateRequest, reply| {
        let time = session.sim.time();
        let bytes = session.sim.save();
        reply.send(if request.path.is_empty() {
            SaveStateResponse { success: true, message: String::new(), time, snapshot: Bytes(Arc::new(bytes)) }
        } else {
            let outcome = std::fs::write(&request.path, bytes);
            let message = outcome.as_ref().err().map(|error| format!("cannot write `{}`: {error}", request.path)).unwrap_or_default();
            SaveStateResponse { success: outcome.is_ok(), message, time, ..Default::default() }
        });
    })?;
    ros.serve("~/restore", PACKAGE, "RestoreState", |session, request: RestoreStateRequest, reply| {
        let outcome = restore(session, &request);
        let message = outcome.as_ref().err().cloned().unwrap_or_default();
        reply.send(RestoreStateResponse { success: outcome.is_ok(), message, time: session.sim.time() });
    })
}

fn get(session: &mut Session, name: &str) -> GetVariableResponse {
    let time = session.sim.time();
    match session.sim.get(name) {
        Err(error) => GetVariableResponse { success: false, message: error.to_string(), time, ..Default::default() },
        Ok(values) => {
            let values = values.to_vec();
            let variable = session.description.variables.iter().find(|v| v.name == name).map(Into::into).unwrap_or_default();
            GetVariableResponse { success: true, message: String::new(), time, variable, values }
        }
    }
}

fn restore(session: &mut Session, request: &RestoreStateRequest) -> Result<(), String> {
    let read = if request.path.is_empty() { Ok(request.snapshot.0.to_vec()) } else { std::fs::read(&request.path) };
    let bytes = read.map_err(|error| format!("cannot read `{}`: {error}", request.path))?;
    session.sim.restore(&bytes).map_err(|error| error.to_string())?;
    session.finish_stepping(Err("a snapshot was restored".into()));
    session.jumped();
    Ok(())
}
