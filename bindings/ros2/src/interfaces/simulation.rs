//! Messages and services of `simulation_interfaces` 2.1, the part that the node reads and answers.

use super::interfaces;
use super::standard::{Accel, Header, Pose, Twist, Vector3};

interfaces! {
    /// Outcome of a call.
    "simulation_interfaces/Result" Outcome { result: u8, error_message: String }
    /// Stopped, playing, paused, quitting.
    "simulation_interfaces/SimulationState" SimulationState { state: u8 }
    /// What this simulator can do.
    "simulation_interfaces/SimulatorFeatures" SimulatorFeatures { features: Vec<u16>, spawn_formats: Vec<String>, custom_info: String }
    /// A region.
    "simulation_interfaces/Bounds" Bounds { r#type: u8, points: Vec<Vector3> }
    /// Kind of an entity.
    "simulation_interfaces/EntityCategory" EntityCategory { category: u8 }
    /// Tags to look for.
    "simulation_interfaces/TagsFilter" TagsFilter { tags: Vec<String>, filter_mode: u8 }
    /// Entities to look for.
    "simulation_interfaces/EntityFilters" EntityFilters {
        filter: String, categories: Vec<EntityCategory>, tags: TagsFilter, bounds: Bounds,
    }
    /// What an entity is.
    "simulation_interfaces/EntityInfo" EntityInfo { category: EntityCategory, description: String, tags: Vec<String> }
    /// Where an entity is.
    "simulation_interfaces/EntityState" EntityState { header: Header, pose: Pose, twist: Twist, acceleration: Accel }
    /// Features.
    "simulation_interfaces/GetSimulatorFeatures.response" GetSimulatorFeaturesResponse { features: SimulatorFeatures }
    /// State.
    "simulation_interfaces/GetSimulationState.response" GetSimulationStateResponse { state: SimulationState, result: Outcome }
    /// State to go to.
    "simulation_interfaces/SetSimulationState.request" SetSimulationStateRequest { state: SimulationState }
    /// Outcome.
    "simulation_interfaces/SetSimulationState.response" SetSimulationStateResponse { result: Outcome }
    /// Number of steps.
    "simulation_interfaces/StepSimulation.request" StepSimulationRequest { steps: u64 }
    /// Outcome.
    "simulation_interfaces/StepSimulation.response" StepSimulationResponse { result: Outcome }
    /// What to reset.
    "simulation_interfaces/ResetSimulation.request" ResetSimulationRequest { scope: u8 }
    /// Outcome.
    "simulation_interfaces/ResetSimulation.response" ResetSimulationResponse { result: Outcome }
    /// Entities to look for.
    "simulation_interfaces/GetEntities.request" GetEntitiesRequest { filters: EntityFilters }
    /// Entities found.
    "simulation_interfaces/GetEntities.response" GetEntitiesResponse { result: Outcome, entities: Vec<String> }
    /// Entities found, with their states.
    "simulation_interfaces/GetEntitiesStates.response" GetEntitiesStatesResponse {
        result: Outcome, entities: Vec<String>, states: Vec<EntityState>,
    }
    /// An entity.
    "simulation_interfaces/GetEntityInfo.request" EntityRequest { entity: String }
    /// What it is.
    "simulation_interfaces/GetEntityInfo.response" GetEntityInfoResponse { result: Outcome, info: EntityInfo }
    /// Where it is.
    "simulation_interfaces/GetEntityState.response" GetEntityStateResponse { result: Outcome, state: EntityState }
    /// Its extent.
    "simulation_interfaces/GetEntityBounds.response" GetEntityBoundsResponse { result: Outcome, bounds: Bounds }
}
