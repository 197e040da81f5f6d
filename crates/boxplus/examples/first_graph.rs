//! How do I build and solve a graph of my own?
//!
//! A robot drives a square and comes back to where it started, a little off. Closing the loop spreads the error.
#![expect(clippy::print_stdout, reason = "an example talks")]

use boxplus::graph::{Between, Graph, Initial, Noise, SolveOptions, Values};
use boxplus::lie::SE2;
use nalgebra::vector;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (mut graph, mut values) = (Graph::new(), Values::new());
    let corners: Vec<_> = (0..5).map(|label| values.declare::<SE2>(label)).collect();
    values.set(corners[0], SE2::new(vector![0.0, 0.0], 0.0))?;
    values.hold(corners[0]); // where we start is what "the map" means

    // Odometry: two metres ahead, a quarter turn left. It turns one degree too far each time.
    let odometry = Noise::from_sigmas(&vector![0.1, 0.1, 0.03])?;
    let side = SE2::new(vector![2.0, 0.0], 91f64.to_radians());
    for pair in corners.windows(2) {
        graph.add((pair[0], pair[1]), Between::new(side), odometry);
    }
    // The camera recognises the start.
    let seen = Noise::from_sigmas(&vector![0.02, 0.02, 0.005])?;
    graph.add((corners[4], corners[0]), Between::new(SE2::new(vector![0.0, 0.0], 0.0)), seen);

    let start = graph.initialise(&values, Initial::SpanningTree)?;
    let solution = graph.optimize(&start.values, &SolveOptions::default())?;
    let mut marginals = graph.marginals(&solution.values)?;

    println!(
        "cost {:.3} → {:.3}, {}",
        solution.report.initial_cost, solution.report.cost, solution.report.termination
    );
    for (label, &corner) in corners.iter().enumerate() {
        let Some(pose) = solution.values.get(corner) else { continue };
        let sigma = marginals.covariance(corner)?.diagonal().map(f64::sqrt);
        let (t, yaw) = (pose.translation(), pose.angle().to_degrees());
        println!(
            "corner {label}: {:6.3} ± {:.3} m, {:6.3} ± {:.3} m, {yaw:7.2} ± {:.2}°",
            t.x,
            sigma[0],
            t.y,
            sigma[1],
            sigma[2].to_degrees()
        );
    }
    Ok(())
}
