//! How do I write a measurement that the library does not have?
//!
//! A drone measures its height above a table of unknown height, and its distance to a beacon. One residual each; the
//! derivatives come from dual numbers, exact to rounding.
#![expect(clippy::print_stdout, reason = "an example talks")]

use boxplus::graph::{Factor, Graph, Noise, Prior, Range, SolveOptions, Values};
use boxplus::lie::{LieGroup, Real, Rn, SE3};
use nalgebra::{SVector, vector};

/// The downward distance from the drone to a horizontal table, along the drone's own z axis, in metres.
#[derive(Clone)]
struct Altimeter {
    measured: f64,
}

impl Factor<1> for Altimeter {
    const NAME: &'static str = "altimeter";
    type Variables = (SE3, Rn<1>);

    fn residual<S: Real>(&self, (drone, table): &(SE3<S>, Rn<1, S>)) -> SVector<S, 1> {
        let down = drone.rotation().to_matrix()[(2, 2)]; // cosine of the tilt
        vector![(drone.translation().z - table.vector()[0]) / down - S::lit(self.measured)]
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (mut graph, mut values) = (Graph::new(), Values::new());
    let drone = values.insert(SE3::exp(&vector![0.0, 0.0, 2.0, 0.1, 0.0, 0.0])); // tilted by 0.1 rad
    let table = values.insert(Rn::new(vector![0.0]));
    let beacon = values.insert(Rn::new(vector![3.0, 0.0, 2.0]));
    values.hold(beacon);

    let mean = SE3::exp(&vector![0.2, 0.0, 2.0, 0.1, 0.0, 0.0]);
    let sigmas = vector![0.5, 0.05, 0.05, 0.02, 0.02, 0.02];
    graph.add((drone,), Prior { mean }, Noise::from_sigmas(&sigmas)?);
    graph.add((drone, table), Altimeter { measured: 1.2 }, Noise::from_sigmas(&vector![0.01])?);
    graph.add((drone, beacon), Range::new(2.9), Noise::from_sigmas(&vector![0.02])?);

    let solution = graph.optimize(&values, &SolveOptions::default())?;
    let mut marginals = graph.marginals(&solution.values)?;
    let sigma = marginals.covariance(table)?[(0, 0)].sqrt();
    let height = solution.values.get(table).map_or(f64::NAN, |table| table.vector()[0]);
    println!("the table stands {height:.3} ± {sigma:.3} m high");
    let x = solution.values.get(drone).map_or(f64::NAN, |drone| drone.translation().x);
    println!("the drone hovers at x = {x:.3} ± {:.3} m", marginals.covariance(drone)?[(0, 0)].sqrt());
    Ok(())
}
