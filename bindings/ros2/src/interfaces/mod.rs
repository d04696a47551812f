//! The Rust types of all messages and services, in the order of the fields of their `.msg` and `.srv` files. Those that recordings hold too are
//! in `matpoint::messages`.

pub mod matpoint;
pub mod parameters;
pub mod simulation;
pub mod standard;

pub use ::matpoint::messages::{Bytes, Definition, Interface};

/// Messages as structs with public fields, and `definitions()`, the list of them.
macro_rules! interfaces {
    ($($(#[$doc:meta])* $ros:literal $name:ident $fields:tt)*) => {
        ::matpoint::interfaces! { $($(#[$doc])* $ros $name $fields)* }
        $(impl ros2_client::Message for $name {})*
    };
}
use interfaces;

/// A request or answer without fields: one byte on the wire.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Empty {
    structure_needs_at_least_one_member: u8,
}
impl ros2_client::Message for Empty {}

/// A request that is answered without being read.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Ignored {}
impl ros2_client::Message for Ignored {}

#[cfg(test)]
mod tests;
