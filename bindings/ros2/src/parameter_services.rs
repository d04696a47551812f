//! The six services of `ros2 param`.

use crate::args::Level;
use crate::interfaces::parameters::*;
use crate::interfaces::standard::Time;
use crate::node::{NodeError, Ros};
use crate::parameters::{Parameters, Value};
use crate::session::Session;
use std::time::SystemTime;

const PACKAGE: &str = "rcl_interfaces";

/// Serves them.
///
/// # Errors
/// DDS refuses.
pub fn serve(ros: &mut Ros) -> Result<(), NodeError> {
    ros.serve("~/list_parameters", PACKAGE, "ListParameters", |session, request: ListParametersRequest, reply| {
        reply.send(ListParametersResponse { result: list(&session.parameters, &request.prefixes, request.depth) });
    })?;
    ros.serve("~/get_parameters", PACKAGE, "GetParameters", |session, request: NamesRequest, reply| {
        reply.send(GetParametersResponse { values: request.names.iter().map(|name| session.parameters.message(name).value).collect() });
    })?;
    ros.serve("~/get_parameter_types", PACKAGE, "GetParameterTypes", |session, request: NamesRequest, reply| {
        reply
            .send(GetParameterTypesResponse { types: request.names.iter().map(|name| session.parameters.describe(name).r#type).collect() });
    })?;
    ros.serve("~/describe_parameters", PACKAGE, "DescribeParameters", |session, request: NamesRequest, reply| {
        reply
            .send(DescribeParametersResponse { descriptors: request.names.iter().map(|name| session.parameters.describe(name)).collect() });
    })?;
    ros.serve("~/set_parameters", PACKAGE, "SetParameters", |session, request: SetParametersRequest, reply| {
        let results = request.parameters.into_iter().map(|parameter| result(set(session, vec![parameter]))).collect();
        reply.send(SetParametersResponse { results });
    })?;
    ros.serve("~/set_parameters_atomically", PACKAGE, "SetParametersAtomically", |session, request: SetParametersRequest, reply| {
        reply.send(SetParametersAtomicallyResponse { result: result(set(session, request.parameters)) });
    })
}

fn result(outcome: Result<(), String>) -> SetParametersResult {
    SetParametersResult { successful: outcome.is_ok(), reason: outcome.err().unwrap_or_default() }
}

fn set(session: &mut Session, parameters: Vec<Parameter>) -> Result<(), String> {
    let mut changes = Vec::new();
    for Parameter { name, value } in parameters {
        let value = Value::from_wire(value).ok_or_else(|| format!("parameter `{name}`: no parameter of this node is of that type"))?;
        changes.push((name, value));
    }
    let names: Vec<String> = changes.iter().map(|c| c.0.clone()).collect();
    session.parameters.set(changes, false).map_err(|error| error.to_string())?;
    session.resume();
    let recorded = if names.iter().any(|name| name == "record") { session.follow_record_parameter().map(drop) } else { Ok(()) };
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default().as_secs_f64();
    let changed_parameters: Vec<_> = names.iter().map(|name| session.parameters.message(name)).collect();
    session.outlets.log(Level::Debug, format!("set {}", names.join(", ")));
    session.outlets.event(ParameterEvent {
        stamp: Time::from_seconds(now),
        node: session.name.clone(),
        changed_parameters,
        ..Default::default()
    });
    recorded
}

/// Names under `prefixes`, at most `depth` dots deeper; all for depth 0.
fn list(parameters: &Parameters, prefixes: &[String], depth: u64) -> ListParametersResult {
    let fits = |name: &str| {
        let deep = |rest: &str| depth == 0 || (rest.matches('.').count() as u64) < depth;
        if prefixes.is_empty() {
            return deep(name);
        }
        prefixes
            .iter()
            .any(|prefix| name == prefix || name.strip_prefix(prefix.as_str()).and_then(|r| r.strip_prefix('.')).is_some_and(deep))
    };
    let names: Vec<String> = parameters.names().filter(|name| fits(name)).map(str::to_owned).collect();
    let mut prefixes: Vec<String> = names.iter().filter_map(|name| Some(name.rsplit_once('.')?.0.to_owned())).collect();
    prefixes.dedup();
    ListParametersResult { names, prefixes }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_listed_by_prefix_and_depth() {
        let parameters = Parameters::default();
        let all = list(&parameters, &[], 0);
        assert_eq!(all.names.len(), parameters.names().count());
        assert_eq!(all.prefixes, ["command", "particles", "record", "state"]);
        assert!(list(&parameters, &[], 1).names.iter().all(|n| !n.contains('.')));
        assert_eq!(list(&parameters, &["state".into()], 0).names, ["state.rate", "state.reliability"]);
        assert_eq!(list(&parameters, &["step".into()], 1).names, ["step"]);
        assert!(list(&parameters, &["nothing".into()], 0).names.is_empty());
    }
}
