//! What the node adds to a step while nobody subscribes: turns of its loop beside bare steps of the same scene, taken in turns.
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
    let mut bare = Simulation::load(&scene, &[])?;
    let mut node = start(Simulation::load(&scene, &[])?, &ros)?;
    let (mut ratios, mut sums) = (Vec::new(), [0.0; 2]);
    for round in 0..rounds {
        let mut seconds = [0.0; 2];
        // Each goes first every other time.
        for which in [round % 2, 1 - round % 2] {
            let begin = Instant::now();
            if which == 0 {
                bare.step(step)?;
            } else {
                node.session.turn(&node.requests);
            }
            seconds[which] = begin.elapsed().as_secs_f64();
        }
        ratios.push(seconds[1] / seconds[0]);
        sums = [sums[0] + seconds[0], sums[1] + seconds[1]];
    }
    assert_eq!(node.session.sim.time(), bare.time(), "each turn was a step");
    ratios.sort_by(f64::total_cmp);
    let median = ratios[rounds / 2];
    let each = 1e3 / rounds as f64;
    println!("bare {:.4} ms, node {:.4} ms a step; median ratio {median:.4}", each * sums[0], each * sums[1]);
    node.close();
    Ok(())
}
