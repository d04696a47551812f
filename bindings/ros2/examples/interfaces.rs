//! Prints every message type that the node has, field by field, for comparison with ROS itself.

use matpoint_ros2::interfaces::{matpoint, parameters, simulation, standard};

fn main() {
    for definitions in [matpoint::definitions(), parameters::definitions(), simulation::definitions(), standard::definitions()] {
        for definition in definitions {
            for (name, kind) in definition.fields {
                println!("{} {name} {kind}", definition.name);
            }
        }
    }
}
