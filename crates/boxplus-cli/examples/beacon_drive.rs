//! A drive among beacons whose places nobody knows, by odometry whose bias nobody knows: dead reckoning, and what smoothing, mapping and
//! self-calibration make of it; Solà et al. (2018) §V-C, §V-D. The numbers are printed by the library's example `smoothing_and_mapping`.
//!
//! Arguments: `plane` or `space`, the picture to draw, .svg or .png; without them it says in a line what the picture of the plane would.
#![expect(clippy::print_stdout, reason = "an example talks")]

use std::error::Error;
use std::path::Path;

use boxplus::graph::{BeaconDrive, Driven, Marginals, Sees, SolveOptions, Values};
use boxplus_cli::draw::{Ellipse, Figure, Panel, Scene, png};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let figure = match arguments.first().map_or("plane", String::as_str) {
        "plane" => drawn("Smoothing and mapping in the plane", &BeaconDrive::in_plane())?,
        "space" => drawn("Smoothing and mapping in space", &BeaconDrive::in_space())?,
        _ => return Err("there are plane and space".into()),
    };
    println!("{}: {}", figure.title, figure.facts);
    let Some(name) = arguments.get(1) else { return Ok(()) };
    let svg = figure.svg();
    let is_png = Path::new(name).extension().is_some_and(|ending| ending == "png");
    let bytes = if is_png { png(&svg).ok_or("nothing to draw")? } else { svg.into_bytes() };
    Ok(std::fs::write(name, bytes)?)
}

/// Dead reckoning beside the estimate.
fn drawn<G: Sees<D, N>, const D: usize, const N: usize>(
    title: &str,
    drive: &BeaconDrive<G, D, N>,
) -> Result<Figure, Box<dyn Error>> {
    let driven = drive.simulate(&mut ChaCha8Rng::seed_from_u64(3))?;
    let solved = driven.graph.optimize(&driven.start, &SolveOptions::default())?.values;
    let mut marginals = driven.graph.marginals(&solved)?;
    let sigmas = marginals.covariance(driven.bias)?.diagonal().map(f64::sqrt);
    let bias = solved.get(driven.bias).ok_or("no bias")?.vector();
    let told = |i: usize, factor: f64| {
        format!("{:.1} ± {:.1} for {:.1}", factor * bias[i], factor * 3.0 * sigmas[i], factor * drive.bias[i])
    };
    let facts = format!(
        "bias of a step: {} mm ahead, {} mrad of turn (estimate ± 3σ for truth)",
        told(0, 1e3),
        told(1, 1e3)
    );
    let before = scene(&driven, &driven.start, None)?;
    let after = scene(&driven, &solved, Some(&mut marginals))?;
    let note = |values: &Values| format!("position {:.2} m rms", rms(&driven, values));
    let panels = vec![
        Panel { heading: "Dead reckoning".to_owned(), note: note(&driven.start), scene: before },
        Panel { heading: "Estimate".to_owned(), note: note(&solved), scene: after },
    ];
    Ok(Figure { title: title.to_owned(), facts, panels })
}

/// Where everything is, and, as far as it is known, how surely.
fn scene<G: Sees<D, N>, const D: usize, const N: usize>(
    driven: &Driven<G, D, N>,
    values: &Values,
    mut marginals: Option<&mut Marginals>,
) -> Result<Scene, Box<dyn Error>> {
    let path = |values: &Values| {
        driven.poses.iter().filter_map(|&x| Some(place(values.get(x)?))).collect::<Vec<_>>()
    };
    let mut scene =
        Scene { spatial: N == 3, tracks: vec![path(values)], truth: path(&driven.truth), ..Scene::default() };
    for &key in &driven.poses {
        if let (Some(marginals), Some(x)) = (&mut marginals, values.get(key)) {
            let covariance = SMatrix::<f64, D, D>::from_column_slice(marginals.covariance(key)?.as_slice());
            let (_, d_place, _) = x.act_jac(&SVector::zeros());
            scene.band.push(ellipse(place(x), &(d_place * covariance * d_place.transpose())));
        }
    }
    for &key in &driven.beacons {
        let at = in_space(&values.get(key).ok_or("no beacon")?.vector());
        scene.landmarks.push(at);
        if let Some(marginals) = &mut marginals {
            let covariance = SMatrix::<f64, N, N>::from_column_slice(marginals.covariance(key)?.as_slice());
            scene.ellipses.push(ellipse(at, &covariance));
        }
    }
    Ok(scene)
}

/// √ of the mean square of the distance of the poses from their true places.
fn rms<G: Sees<D, N>, const D: usize, const N: usize>(driven: &Driven<G, D, N>, values: &Values) -> f64 {
    let off = |&x| Some((place(values.get(x)?) - place(driven.truth.get(x)?)).norm_squared());
    (driven.poses.iter().filter_map(off).sum::<f64>() / driven.poses.len() as f64).sqrt()
}

fn place<G: Sees<D, N>, const D: usize, const N: usize>(x: &G) -> Vector3<f64> {
    in_space(&x.act(&SVector::zeros()))
}

fn in_space<const N: usize>(p: &SVector<f64, N>) -> Vector3<f64> {
    Vector3::from_fn(|i, _| p.get(i).copied().unwrap_or(0.0))
}

fn ellipse<const N: usize>(centre: Vector3<f64>, covariance: &SMatrix<f64, N, N>) -> Ellipse {
    let covariance = Matrix3::from_fn(|i, j| covariance.get((i, j)).copied().unwrap_or(0.0));
    Ellipse { centre, covariance }
}
