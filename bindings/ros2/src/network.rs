//! Which machines may find the node: the usual ROS variables. Unlike in ROS, it stays on this machine unless asked otherwise.

use std::net::{IpAddr, Ipv4Addr};

/// Variables that make no sense.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NetworkError {
    /// The domain is no number, or too large.
    #[error("ROS_DOMAIN_ID is `{0}`; a domain is a whole number from 0 to 232")]
    Domain(String),
    /// The range is none.
    #[error("ROS_AUTOMATIC_DISCOVERY_RANGE is `{0}`; it may be LOCALHOST (default here), SUBNET or SYSTEM_DEFAULT; OFF cannot be had")]
    Range(String),
}

/// Domain and reach.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Network {
    /// ROS domain.
    pub domain: u16,
    /// Only processes on this machine may find the node.
    pub local: bool,
    /// What is set and has no effect.
    pub ignored: Vec<String>,
}

impl Network {
    /// Reads `ROS_DOMAIN_ID`, `ROS_AUTOMATIC_DISCOVERY_RANGE` and `ROS_LOCALHOST_ONLY` with `variable`.
    ///
    /// # Errors
    /// A value that is not allowed.
    pub fn read(variable: impl Fn(&str) -> Option<String>) -> Result<Self, NetworkError> {
        let get = |name: &str| variable(name).map(|v| v.trim().to_owned()).filter(|v| !v.is_empty());
        let domain = match get("ROS_DOMAIN_ID") {
            None => 0,
            Some(text) => text.parse().ok().filter(|id| *id <= 232).ok_or(NetworkError::Domain(text))?,
        };
        let by_range = match get("ROS_AUTOMATIC_DISCOVERY_RANGE").as_deref() {
            None | Some("LOCALHOST") => true,
            Some("SUBNET" | "SYSTEM_DEFAULT") => false,
            Some(other) => return Err(NetworkError::Range(other.to_owned())),
        };
        let local = match get("ROS_LOCALHOST_ONLY").as_deref() {
            Some("1") => true,
            // The older variable asks for the network where the newer one is silent.
            Some("0") if get("ROS_AUTOMATIC_DISCOVERY_RANGE").is_none() => false,
            _ => by_range,
        };
        let ignored =
            ["ROS_STATIC_PEERS", "ROS_SECURITY_ENABLE"].into_iter().filter(|name| get(name).is_some()).map(str::to_owned).collect();
        Ok(Self { domain, local, ignored })
    }

    /// What is said of variables that are set and have no effect.
    pub fn warnings(&self) -> impl Iterator<Item = String> {
        self.ignored.iter().map(|name| format!("{name} has no effect on this node"))
    }

    /// The networks to use: this machine's own, or all.
    pub fn addresses(&self) -> Option<[IpAddr; 1]> {
        self.local.then_some([IpAddr::V4(Ipv4Addr::LOCALHOST)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(variables: &[(&str, &str)]) -> Result<Network, NetworkError> {
        Network::read(|name| variables.iter().find(|v| v.0 == name).map(|v| v.1.to_owned()))
    }

    #[test]
    fn the_usual_variables() {
        let plain = |domain, local| Ok(Network { domain, local, ignored: Vec::new() });
        assert_eq!(read(&[]), plain(0, true));
        assert_eq!(read(&[("ROS_DOMAIN_ID", "42"), ("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET")]), plain(42, false));
        assert_eq!(read(&[("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET"), ("ROS_LOCALHOST_ONLY", "1")]), plain(0, true));
        assert_eq!(read(&[("ROS_LOCALHOST_ONLY", "0")]), plain(0, false));
        assert_eq!(read(&[("ROS_DOMAIN_ID", "-1")]), Err(NetworkError::Domain("-1".into())));
        assert_eq!(read(&[("ROS_DOMAIN_ID", "233")]), Err(NetworkError::Domain("233".into())));
        assert_eq!(read(&[("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF")]), Err(NetworkError::Range("OFF".into())));
        assert_eq!(read(&[("ROS_STATIC_PEERS", "10.0.0.1")]).unwrap().ignored, ["ROS_STATIC_PEERS"]);
    }
}
