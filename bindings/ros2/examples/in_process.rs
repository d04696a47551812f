//! Applies load commands in process and writes the final snapshot: what a controller over ROS must reach bit by bit.
//!
//!     in_process SCENE STEP LOAD COMMANDS SNAPSHOT
//!
//! STEP in seconds; COMMANDS is a text file with one command a line, components apart by spaces.

use matpoint::Simulation;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [scene, step, load, commands, snapshot] = args.as_slice() else {
        return Err("in_process SCENE STEP LOAD COMMANDS SNAPSHOT".into());
    };
    let step: f64 = step.parse()?;
    let mut sim = Simulation::load(scene, &[])?;
    for line in std::fs::read_to_string(commands)?.lines() {
        let value = line.split_whitespace().map(str::parse).collect::<Result<Vec<f64>, _>>()?;
        sim.set(load, &value)?;
        sim.step(step)?;
    }
    std::fs::write(snapshot, sim.save())?;
    Ok(())
}
