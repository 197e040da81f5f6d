//! boxplus: the graph built by its public interface, with its own first estimate (`auto`) or from the file's poses (`file`).

use std::{error::Error, fs, ops::ControlFlow};

use boxplus::{
    graph::{Between, Chart, Graph, GraphError, GroupVariable, Initial, Log, Noise, SolveOptions, Values},
    io::read,
    lie::{SE2, SE3},
    pose_graph::{Edge, Vertex},
};
use boxplus_peers::{Arguments, Recorder, threads};

/// Solves, and records the state after the last step: the clocks stop there, if the limit allows no other.
fn solve<P: GroupVariable<D>, const D: usize>(
    (vertices, edges): (&[Vertex<P>], &[Edge<P, D>]),
    arguments: &Arguments,
    coordinates: impl Fn(&P) -> Vec<f64>,
) -> Result<(Recorder, String), GraphError>
where
    Log: Chart<P, D>,
{
    let (mut graph, mut values) = (Graph::new(), Values::new());
    let keys: Vec<_> = vertices.iter().map(|vertex| values.insert(vertex.value)).collect();
    let key = |id: u64| keys[usize::try_from(id).unwrap_or(usize::MAX)];
    for edge in edges {
        let noise = Noise::from_information(&edge.information)?;
        graph.add((key(edge.from), key(edge.to)), Between::<P, Log>::new(edge.measured), noise);
    }
    let initial = if arguments.method == "file" { Initial::AsGiven } else { Initial::Auto };
    let mut options = SolveOptions { threads: threads(), ..SolveOptions::default() };
    options.max_iterations = arguments.max_iterations.unwrap_or(options.max_iterations);

    let (mut recorder, mut steps) = (Recorder::default(), 0);
    recorder.start();
    let start = graph.initialise(&values, initial)?;
    if options.max_iterations == 0 {
        recorder.stop();
    }
    let solution = graph.optimize_observed(&start.values, &options, &mut |_| {
        steps += 1;
        if arguments.max_iterations == Some(steps) {
            recorder.stop();
        }
        ControlFlow::Continue(())
    })?;
    recorder.stop();
    recorder.keep(steps, solution.values.iter::<P>().filter_map(|(_, pose)| pose).flat_map(coordinates));
    Ok((recorder, format!("{:?}", solution.report.termination)))
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse()?;
    let graph = read(&fs::read(&arguments.graph)?, "graph.g2o", None)?.graph;
    let (recorder, status) = if graph.poses3.is_empty() {
        solve((&graph.poses2, &graph.edges2), &arguments, |pose: &SE2| {
            vec![pose.translation().x, pose.translation().y, pose.angle()]
        })?
    } else {
        solve((&graph.poses3, &graph.edges3), &arguments, |pose: &SE3| {
            let (t, [x, y, z, w]) = (pose.translation(), pose.rotation().quaternion_xyzw());
            vec![t.x, t.y, t.z, x, y, z, w]
        })?
    };
    recorder.report(&status, &arguments.poses)?;
    Ok(())
}
