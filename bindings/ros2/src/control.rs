//! `simulation_interfaces`: play, pause, step, reset, and the bodies as entities. What has no meaning here is answered as unsupported.

use crate::inbox::Reply;
use crate::interfaces::simulation::*;
use crate::interfaces::standard::{Point, Pose, Quaternion, Twist, Vector3};
use crate::interfaces::{Empty, Ignored, standard};
use crate::node::{NodeError, Ros};
use crate::session::{Running, Session, Stepping};

const UNSUPPORTED: u8 = 0;
const OK: u8 = 1;
const NOT_FOUND: u8 = 2;
const FAILED: u8 = 4;
const ALREADY_THERE: u8 = 101;
const INCORRECT_TRANSITION: u8 = 103;
const DYNAMIC_OBJECT: u8 = 4;

/// Features by the numbers of the standard: entity categories, bounds, state and info getting; reset; simulation state getting, setting and
/// pause; stepping one, many, by action; current world.
const FEATURES: [u16; 12] = [5, 8, 10, 12, 20, 24, 25, 26, 31, 32, 33, 44];

const PACKAGE: &str = "simulation_interfaces";

/// Outcome with a code of the standard.
pub fn outcome(result: u8, text: impl Into<String>) -> Outcome {
    Outcome { result, error_message: text.into() }
}

fn ok() -> Outcome {
    outcome(OK, "")
}

/// Serves all services of the standard.
///
/// # Errors
/// DDS refuses.
pub fn serve(ros: &mut Ros) -> Result<(), NodeError> {
    ros.serve("~/get_simulator_features", PACKAGE, "GetSimulatorFeatures", |_, _: Empty, reply| {
        let custom_info = "elastic solids by the material point method; time and state are reset together; an entity is a body".into();
        reply.send(GetSimulatorFeaturesResponse {
            features: SimulatorFeatures { features: FEATURES.into(), spawn_formats: Vec::new(), custom_info },
        });
    })?;
    ros.serve("~/get_simulation_state", PACKAGE, "GetSimulationState", |session, _: Empty, reply| {
        reply.send(GetSimulationStateResponse { state: SimulationState { state: session.running as u8 }, result: ok() });
    })?;
    ros.serve("~/set_simulation_state", PACKAGE, "SetSimulationState", |session, request: SetSimulationStateRequest, reply| {
        reply.send(SetSimulationStateResponse { result: set_state(session, request.state.state) });
    })?;
    ros.serve(
        "~/step_simulation",
        PACKAGE,
        "StepSimulation",
        |session, request: StepSimulationRequest, reply: Reply<StepSimulationResponse>| {
            session.start_stepping(Stepping {
                done: 0,
                total: request.steps,
                progress: Box::new(|_, _| true),
                finish: Box::new(move |how| reply.send(StepSimulationResponse { result: stepped(how) })),
            });
        },
    )?;
    ros.serve("~/reset_simulation", PACKAGE, "ResetSimulation", |session, request: ResetSimulationRequest, reply| {
        reply.send(ResetSimulationResponse { result: reset(session, request.scope) });
    })?;
    serve_entities(ros)?;
    serve_unsupported(ros)
}

/// Outcome of steps.
pub fn stepped(how: Result<(), String>) -> Outcome {
    how.map_or_else(|why| outcome(FAILED, why), |()| ok())
}

fn set_state(session: &mut Session, target: u8) -> Outcome {
    let target = match target {
        0 => Running::Stopped,
        1 => Running::Playing,
        2 => Running::Paused,
        3 => Running::Quitting,
        4 | 5 => return outcome(INCORRECT_TRANSITION, "there is always one world here"),
        other => {
            return outcome(INCORRECT_TRANSITION, format!("{other} is no state; states are 0 stopped, 1 playing, 2 paused, 3 quitting"));
        }
    };
    if session.running == target {
        return outcome(ALREADY_THERE, "already in that state");
    }
    if target == Running::Playing
        && let Some(fault) = &session.fault
    {
        return outcome(102, format!("{fault}; reset or restore first"));
    }
    session.finish_stepping(Err("the state of the simulation was set".into()));
    session.running = target;
    match target {
        // Stopped is paused and reset.
        Running::Stopped => session.reset(),
        Running::Playing | Running::Paused => session.resume(),
        Running::Quitting => {}
    }
    ok()
}

fn reset(session: &mut Session, scope: u8) -> Outcome {
    const TIME: u8 = 1;
    const STATE: u8 = 2;
    const SPAWNED: u8 = 4;
    match (scope == 0, scope & TIME > 0, scope & STATE > 0) {
        (true, ..) | (_, true, true) => {
            session.reset();
            ok()
        }
        // Nothing is ever spawned.
        (_, false, false) if scope & SPAWNED > 0 => ok(),
        _ => outcome(UNSUPPORTED, "time and state can only be reset together"),
    }
}

fn serve_entities(ros: &mut Ros) -> Result<(), NodeError> {
    ros.serve("~/get_entities", PACKAGE, "GetEntities", |session, request: GetEntitiesRequest, reply| {
        let (result, entities) = unpack(entities(session, &request.filters));
        reply.send(GetEntitiesResponse { result, entities });
    })?;
    ros.serve("~/get_entities_states", PACKAGE, "GetEntitiesStates", |session, request: GetEntitiesRequest, reply| {
        let (result, entities) = unpack(entities(session, &request.filters));
        let states = entities.iter().filter_map(|name| entity_state(session, name).ok()).collect();
        reply.send(GetEntitiesStatesResponse { result, entities, states });
    })?;
    ros.serve("~/get_entity_info", PACKAGE, "GetEntityInfo", |session, request: EntityRequest, reply| {
        let (result, info) = unpack(body(session, &request.entity).map(|b| EntityInfo {
            category: EntityCategory { category: DYNAMIC_OBJECT },
            description: format!("elastic body of {} particles", session.description.bodies[b].1),
            tags: Vec::new(),
        }));
        reply.send(GetEntityInfoResponse { result, info });
    })?;
    ros.serve("~/get_entity_state", PACKAGE, "GetEntityState", |session, request: EntityRequest, reply| {
        let (result, state) = unpack(entity_state(session, &request.entity));
        reply.send(GetEntityStateResponse { result, state });
    })?;
    ros.serve("~/get_entity_bounds", PACKAGE, "GetEntityBounds", |session, request: EntityRequest, reply| {
        let (result, bounds) = unpack(bounds(session, &request.entity));
        reply.send(GetEntityBoundsResponse { result, bounds });
    })
}

/// A result and, if it is good, a value; a default value otherwise.
fn unpack<T: Default>(value: Result<T, Outcome>) -> (Outcome, T) {
    value.map_or_else(|why| (why, T::default()), |value| (ok(), value))
}

fn body(session: &Session, name: &str) -> Result<usize, Outcome> {
    session.description.bodies.iter().position(|b| b.0 == name).ok_or_else(|| {
        let known: Vec<_> = session.description.bodies.iter().map(|b| b.0.as_str()).collect();
        outcome(NOT_FOUND, format!("no entity `{name}`; there are: {}", known.join(", ")))
    })
}

fn entities(session: &Session, filters: &EntityFilters) -> Result<Vec<String>, Outcome> {
    if filters.bounds.r#type != 0 || !filters.tags.tags.is_empty() {
        return Err(outcome(UNSUPPORTED, "filters by bounds or tags"));
    }
    if !filters.categories.is_empty() && !filters.categories.contains(&EntityCategory { category: DYNAMIC_OBJECT }) {
        return Ok(Vec::new());
    }
    // The standard asks for a match of the whole name.
    let pattern = format!("^(?:{})$", filters.filter);
    let pattern = regex_lite::Regex::new(&pattern).map_err(|error| outcome(FAILED, format!("filter `{}`: {error}", filters.filter)))?;
    let names = session.description.bodies.iter().map(|b| b.0.clone());
    Ok(names.filter(|name| filters.filter.is_empty() || pattern.is_match(name)).collect())
}

/// Rows of a particle variable that belong to a body.
fn rows(session: &mut Session, variable: &str, body: usize, width: usize) -> Result<Vec<Vec<f64>>, Outcome> {
    let failed = |error: matpoint::component::ComponentError| outcome(FAILED, error.to_string());
    let bodies = session.sim.get("particle/body").map_err(failed)?.to_vec();
    let values = session.sim.get(variable).map_err(failed)?;
    let rows = values.chunks_exact(width).zip(bodies).filter(|(_, b)| *b as usize == body);
    Ok(rows.map(|(row, _)| row.to_vec()).collect())
}

/// Centre and velocity of mass.
fn entity_state(session: &mut Session, name: &str) -> Result<EntityState, Outcome> {
    let (body, dimension) = (body(session, name)?, session.description.dimension);
    let masses = rows(session, "particle/mass", body, 1)?;
    let total: f64 = masses.iter().map(|m| m[0]).sum();
    let mut mean = |variable: &str| -> Result<Vec<f64>, Outcome> {
        let rows = rows(session, variable, body, dimension)?;
        Ok((0..dimension).map(|axis| rows.iter().zip(&masses).map(|(row, m)| m[0] * row[axis]).sum::<f64>() / total).collect())
    };
    let (position, velocity) = (mean("particle/position")?, mean("particle/velocity")?);
    Ok(EntityState {
        header: session.header(),
        pose: Pose { position: Point::from_slice(&position), orientation: Quaternion { w: 1.0, ..Default::default() } },
        twist: Twist { linear: Vector3::from_slice(&velocity), angular: Vector3::default() },
        acceleration: standard::Accel::default(),
    })
}

/// The box around the particles of a body: upper right, then lower left corner.
fn bounds(session: &mut Session, name: &str) -> Result<Bounds, Outcome> {
    let (body, dimension) = (body(session, name)?, session.description.dimension);
    let positions = rows(session, "particle/position", body, dimension)?;
    let corner = |pick: fn(f64, f64) -> f64, start: f64| -> Vector3 {
        let of = |axis| positions.iter().map(|p| p[axis]).fold(start, pick);
        Vector3::from_slice(&(0..dimension).map(of).collect::<Vec<_>>())
    };
    Ok(Bounds { r#type: 1, points: vec![corner(f64::max, f64::NEG_INFINITY), corner(f64::min, f64::INFINITY)] })
}

/// The answer to what there is not. Its fields beside the result are empty: zeros on the wire, whatever they are.
#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
struct Unsupported {
    result: Outcome,
    rest: Vec<u64>,
    more: [u64; 8],
}
impl ros2_client::Message for Unsupported {}

fn serve_unsupported(ros: &mut Ros) -> Result<(), NodeError> {
    const SERVICES: [(&str, &str); 12] = [
        ("~/delete_entity", "DeleteEntity"),
        ("~/get_available_worlds", "GetAvailableWorlds"),
        ("~/get_named_pose_bounds", "GetNamedPoseBounds"),
        ("~/get_named_poses", "GetNamedPoses"),
        ("~/get_spawnables", "GetSpawnables"),
        ("~/load_world", "LoadWorld"),
        ("~/set_entity_info", "SetEntityInfo"),
        ("~/set_entity_state", "SetEntityState"),
        ("~/spawn_entities", "SpawnEntities"),
        ("~/spawn_entity", "SpawnEntity"),
        ("~/unload_world", "UnloadWorld"),
        ("~/get_current_world", "GetCurrentWorld"),
    ];
    for (name, service) in SERVICES {
        ros.serve(name, PACKAGE, service, move |_, _: Ignored, reply| {
            let result = outcome(UNSUPPORTED, format!("{service} has no meaning here"));
            reply.send(Unsupported { result, rest: Vec::new(), more: [0; 8] });
        })?;
    }
    Ok(())
}
