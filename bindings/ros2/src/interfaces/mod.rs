//! The Rust types of all messages and services, in the order of the fields of their `.msg` and `.srv` files.

pub mod matpoint;
pub mod parameters;
pub mod simulation;
pub mod standard;

/// A type that has a name in ROS interface files.
pub trait Interface {
    /// That name: `float64[]`, `std_msgs/Header`.
    fn ros() -> String;
}

/// Name and fields of a message or of one half of a service.
#[derive(Debug, Clone, PartialEq)]
pub struct Definition {
    /// `package/Name`, `package/Name.request` or `package/Name.response`.
    pub name: &'static str,
    /// Names and types, in order.
    pub fields: Vec<(&'static str, String)>,
}

macro_rules! primitives {
    ($($rust:ty = $ros:literal),*) => { $(impl Interface for $rust { fn ros() -> String { $ros.into() } })* };
}
primitives!(
    bool = "bool",
    u8 = "uint8",
    u16 = "uint16",
    i32 = "int32",
    u32 = "uint32",
    i64 = "int64",
    u64 = "uint64",
    f64 = "float64",
    String = "string"
);

impl<T: Interface> Interface for Vec<T> {
    fn ros() -> String {
        format!("{}[]", T::ros())
    }
}

impl Interface for [f64; 9] {
    fn ros() -> String {
        "float64[9]".into()
    }
}

/// Messages as structs with public fields, and `definitions()`, the list of them.
macro_rules! interfaces {
    ($($(#[$doc:meta])* $ros:literal $name:ident { $($field:ident: $type:ty),* $(,)? })*) => {
        $(
            $(#[$doc])*
            #[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize)]
            #[allow(missing_docs, reason = "the interface files document the fields")]
            pub struct $name { $(pub $field: $type),* }
            impl ros2_client::Message for $name {}
            impl $crate::interfaces::Interface for $name {
                fn ros() -> String { $ros.into() }
            }
        )*
        /// Every definition of this file.
        pub fn definitions() -> Vec<$crate::interfaces::Definition> {
            use $crate::interfaces::Interface;
            vec![$($crate::interfaces::Definition {
                name: $ros,
                fields: vec![$((stringify!($field).trim_start_matches("r#"), <$type>::ros())),*],
            }),*]
        }
    };
}
use interfaces;

/// `uint8[]` that is written in one piece and cloned for free.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Bytes(pub std::sync::Arc<Vec<u8>>);

impl Interface for Bytes {
    fn ros() -> String {
        "uint8[]".into()
    }
}

impl serde::Serialize for Bytes {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_bytes(&self.0)
    }
}

impl<'de> serde::Deserialize<'de> for Bytes {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl serde::de::Visitor<'_> for Visitor {
            type Value = Vec<u8>;
            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("bytes")
            }
            fn visit_bytes<E>(self, bytes: &[u8]) -> Result<Vec<u8>, E> {
                Ok(bytes.to_vec())
            }
            fn visit_byte_buf<E>(self, bytes: Vec<u8>) -> Result<Vec<u8>, E> {
                Ok(bytes)
            }
        }
        deserializer.deserialize_byte_buf(Visitor).map(|bytes| Self(std::sync::Arc::new(bytes)))
    }
}

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
