//! What the node adds to a step while nobody subscribes: turns of its loop and bare steps of the same simulation, taken in turns.
//!
//!     overhead SCENE [STEP [ROUNDS]]

use matpoint::Simulation;
use matpoint_ros2::args::RosArgs;
use matpoint_ros2::start::start;
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let scene = args.next().ok_or("overhead SCENE [STEP [ROUNDS]]")?;
    let step = args.next().unwrap_or_else(|| "0.01".into());
    let rounds: usize = args.next().map_or(Ok(400), |text| text.parse())?;
    let ros = RosArgs {
        parameters: [("step", step.as_str()), ("real_time_factor", "0.0")].map(|(n, v)| (None, n.into(), v.into())).into(),
        ..Default::default()
    };
    let step: f64 = step.parse()?;
    let mut node = start(Simulation::load(&scene, &[])?, &ros)?;
    let (mut ratios, mut times) = (Vec::new(), [Vec::new(), Vec::new()]);
    for round in 0..rounds {
        let mut seconds = [0.0; 2];
        // Each goes first every other time.
        for which in [round % 2, 1 - round % 2] {
            let begin = Instant::now();
            if which == 0 {
                // Of the node's own simulation: another would lie elsewhere in memory, which shows.
                node.session.sim.step(step)?;
            } else {
                node.session.turn(&node.requests);
            }
            seconds[which] = begin.elapsed().as_secs_f64();
        }
        ratios.push(seconds[1] / seconds[0]);
        (0..2).for_each(|which| times[which].push(seconds[which]));
    }
    assert_eq!(node.session.steps, rounds as u64, "each turn was a step");
    let median = |values: &mut Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values[rounds / 2]
    };
    let [bare, with] = times.each_mut().map(median);
    println!("medians: bare {:.4} ms, node {:.4} ms a step, ratio {:.4}", 1e3 * bare, 1e3 * with, median(&mut ratios));
    node.close();
    Ok(())
}
