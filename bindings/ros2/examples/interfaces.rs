//! Prints every message type that the node has, field by field, for comparison with ROS itself.

use matpoint::messages;
use matpoint_ros2::interfaces::{matpoint as own, parameters, simulation, standard};

fn main() {
    for definitions in
        [messages::definitions(), own::definitions(), parameters::definitions(), simulation::definitions(), standard::definitions()]
    {
        for definition in definitions {
            for (name, kind) in definition.fields {
                println!("{} {name} {kind}", definition.name);
            }
        }
    }
}
