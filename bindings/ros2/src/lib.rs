//! The ROS 2 node of matpoint.
//!
//! | file | what |
//! |---|---|
//! | `args`, `names`, `network` | what a ROS user says: arguments, names and remaps, variables |
//! | `parameters`, `parameter_services` | the table of parameters, and `ros2 param` |
//! | `interfaces` | the types of all messages, checked against their files |
//! | `reply` | answers to calls, of any size |
//! | `node`, `graph` | publishers, subscriptions and services on DDS; who listens |
//! | `inbox`, `session`, `pace` | the loop that owns the simulation; requests run between its steps |
//! | `loads`, `cloud`, `state`, `diagnostics` | loads in; particles, state and diagnostics out |
//! | `recording` | recordings while it runs |
//! | `publish` | the thread that publishes: the newest wins, no subscriber holds up a step |
//! | `replay` | a recording instead of a simulation, by the same publishers |
//! | `services`, `control`, `action` | services of `matpoint_msgs` and of `simulation_interfaces` |

pub mod action;
pub mod args;
pub mod cloud;
pub mod control;
pub mod diagnostics;
pub mod graph;
pub mod inbox;
pub mod interfaces;
pub mod loads;
pub mod names;
pub mod network;
pub mod node;
pub mod pace;
pub mod parameter_services;
pub mod parameters;
pub mod publish;
pub mod recording;
pub mod replay;
pub mod reply;
pub mod services;
pub mod session;
pub mod start;
pub mod state;
