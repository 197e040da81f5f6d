//! Simulators: reproducible, connected, and noisy exactly as promised.
#![cfg(feature = "io")]
#![allow(clippy::unwrap_used)] // a failing test may panic

use boxplus::io::{self, Format};
use boxplus::lie::{Action, LieGroup};
use boxplus::pose_graph::simulate::{Options, OptionsError, Simulated, Simulator};
use boxplus::pose_graph::{Edge, PoseGraph, Severity, Vertex};
use nalgebra::{SVector, Vector3};

const SMALL: Options = Options {
    size: Some(600),
    seed: 3,
    sigma_translation: 0.05,
    sigma_rotation: 0.02,
    closures: 1.0,
    outliers: 0.0,
};

fn all(options: &Options) -> impl Iterator<Item = (Simulator, Simulated)> + '_ {
    Simulator::ALL.into_iter().map(|s| (s, s.simulate(options).unwrap()))
}

/// Log(Z⁻¹·X₁⁻¹·X₂) of every edge at the given poses, whose ids are their places in the list.
fn residuals<'a, G: LieGroup<D, Scalar = f64>, const D: usize>(
    poses: &'a [Vertex<G>],
    edges: &'a [Edge<G, D>],
) -> impl Iterator<Item = SVector<f64, D>> + 'a {
    let pose = |id: u64| poses[usize::try_from(id).unwrap()].value;
    edges.iter().map(move |e| e.measured.between(&pose(e.from).between(&pose(e.to))).log())
}

fn residuals2(graph: &PoseGraph, at: &PoseGraph) -> Vec<Vector3<f64>> {
    residuals(&at.poses2, &graph.edges2).collect()
}

#[test]
fn one_seed_gives_the_same_bytes_and_another_seed_others() {
    for ((world, a), (_, b)) in all(&SMALL).zip(all(&SMALL)) {
        let text = |s: &Simulated| {
            io::write(&s.graph, Format::G2o).unwrap() + &io::write(&s.truth, Format::G2o).unwrap()
        };
        assert!(text(&a) == text(&b), "{world}");
        let other = world.simulate(&Options { seed: 4, ..SMALL }).unwrap();
        assert!(text(&a) != text(&other), "{world}");
    }
}

#[test]
fn without_noise_the_truth_satisfies_every_measurement() {
    let exact = Options { sigma_translation: 0.0, sigma_rotation: 0.0, ..SMALL };
    for (world, s) in all(&exact) {
        let flat = residuals2(&s.graph, &s.truth).into_iter().map(|r| r.norm());
        let spatial = residuals(&s.truth.poses3, &s.graph.edges3).map(|r| r.norm());
        let points = s.graph.sightings2.iter().map(|e| {
            let point = s.truth.points2.iter().find(|v| v.id == e.to).unwrap().value;
            let pose = &s.truth.poses2[usize::try_from(e.from).unwrap()].value;
            (pose.act_inverse(&point) - e.measured).norm()
        });
        let worst = flat.chain(spatial).chain(points).fold(0.0, f64::max);
        assert!(worst < 1e-13, "{world}: {worst}"); // ~ ε × 100 m
    }
}

#[test]
fn without_noise_the_initial_values_are_the_truth() {
    let exact = Options { sigma_translation: 0.0, sigma_rotation: 0.0, ..SMALL };
    for (world, s) in all(&exact) {
        let flat = s.graph.poses2.iter().zip(&s.truth.poses2).map(|(a, b)| a.value.rminus(&b.value).norm());
        let spatial =
            s.graph.poses3.iter().zip(&s.truth.poses3).map(|(a, b)| a.value.rminus(&b.value).norm());
        let points = s.graph.points2.iter().zip(&s.truth.points2).map(|(a, b)| (a.value - b.value).norm());
        let worst = flat.chain(spatial).chain(points).fold(0.0, f64::max);
        assert!(worst < 1e-10, "{world}: {worst}"); // 600 steps of rounding, each turned into ε × 100 m
    }
}

#[test]
fn graphs_are_connected_without_faults_and_survive_a_file() {
    for size in [1, 2, 3, 5, 17, 100, 600] {
        for (world, s) in all(&Options { size: Some(size), ..SMALL }) {
            let statistics = s.graph.statistics();
            assert_eq!((statistics.poses, statistics.components), (size, 1), "{world} {size}");
            let faults: Vec<_> =
                s.graph.faults().into_iter().filter(|f| f.severity() > Severity::Note).collect();
            assert_eq!(faults, [], "{world} {size}");
            let text = io::write(&s.graph, Format::G2o).unwrap();
            let back = io::read(text.as_bytes(), world.name(), None).unwrap().graph;
            assert!(text == io::write(&back, Format::G2o).unwrap(), "{world} {size}");
        }
    }
}

#[test]
fn neighbours_are_about_a_metre_apart_and_loops_close() {
    for (world, s) in all(&Options { size: None, ..SMALL }) {
        let flat = s.truth.poses2.windows(2).map(|w| w[0].value.between(&w[1].value).translation().norm());
        let spatial = s.truth.poses3.windows(2).map(|w| w[0].value.between(&w[1].value).translation().norm());
        let steps: Vec<f64> = flat.chain(spatial).collect();
        let mean = steps.iter().sum::<f64>() / steps.len() as f64;
        assert!((0.5..1.5).contains(&mean), "{world}: {mean} m a step");
        let statistics = s.graph.statistics();
        assert_eq!(statistics.poses, world.default_size());
        assert!(statistics.loop_closures > 100 || statistics.points > 20, "{world}: {statistics:?}");
        for e in &s.graph.edges3 {
            let distance = e.measured.translation().norm();
            assert!(distance < 6.0, "{world}: an edge {} → {} over {distance} m", e.from, e.to);
        }
    }
}

#[test]
fn noise_has_the_promised_mean_and_deviation() {
    let options = Options { size: Some(3000), ..SMALL };
    let (t, r) = (SMALL.sigma_translation, SMALL.sigma_rotation);
    let check = |name: &str, samples: &[SVector<f64, 6>], sigma: SVector<f64, 6>| {
        let n = samples.len() as f64;
        for i in 0..6 {
            // Mean and variance of n samples have the standard errors σ/√n and σ²·√(2/n); 4 of them are exceeded once in
            // 16 000 draws, and the draw is fixed by the seed.
            let mean = samples.iter().map(|x| x[i]).sum::<f64>() / n;
            let variance = samples.iter().map(|x| x[i] * x[i]).sum::<f64>() / n;
            assert!(mean.abs() < 4.0 * sigma[i] / n.sqrt(), "{name}[{i}]: mean {mean}");
            let excess = variance / (sigma[i] * sigma[i]) - 1.0;
            assert!(excess.abs() < 4.0 * (2.0 / n).sqrt(), "{name}[{i}]: variance off by {excess}");
        }
    };
    let s = Simulator::Sphere.simulate(&options).unwrap();
    let spatial: Vec<_> = residuals(&s.truth.poses3, &s.graph.edges3).collect();
    check("sphere", &spatial, SVector::from([t, t, t, r, r, r]));

    let s = Simulator::Manhattan.simulate(&options).unwrap();
    let pad = |r: Vector3<f64>| SVector::<f64, 6>::from([r.x, r.y, r.x, r.z, r.z, r.z]);
    let flat: Vec<_> = residuals2(&s.graph, &s.truth).into_iter().map(pad).collect();
    check("manhattan", &flat, SVector::from([t, t, t, r, r, r]));
}

#[test]
fn information_is_the_inverse_covariance_and_statistics_give_the_noise_back() {
    for (world, s) in all(&SMALL) {
        let statistics = s.graph.statistics();
        assert!((statistics.sigma_translation.unwrap() - 0.05).abs() < 1e-15, "{world}");
        assert!((statistics.sigma_rotation.unwrap() - 0.02).abs() < 1e-15, "{world}");
    }
}

#[test]
fn outliers_and_closures_come_at_the_asked_rate() {
    let all = Simulator::Sphere.simulate(&Options { size: Some(2500), ..SMALL }).unwrap();
    let some = Options { size: Some(2500), closures: 0.5, outliers: 0.2, ..SMALL };
    let s = Simulator::Sphere.simulate(&some).unwrap();
    let closures = s.graph.edges3.len() - 2499;
    assert_eq!(all.graph.edges3.len() - 2499, 2450);
    assert!((closures as f64 - 1225.0).abs() < 4.0 * (2450.0f64 * 0.25).sqrt(), "{closures} closures");
    let wrong = residuals(&s.truth.poses3, &s.graph.edges3).filter(|r| r.norm() > 1.0).count();
    let expected = 0.2 * closures as f64;
    assert!(
        (wrong as f64 - expected).abs() < 4.0 * (expected * 0.8).sqrt() + 0.02 * expected,
        "{wrong} outliers"
    );
}

#[test]
fn names_are_unique_and_read_back() {
    for world in Simulator::ALL {
        assert_eq!(world.name().parse::<Simulator>(), Ok(world));
        assert!(!world.description().contains('\n'));
    }
    assert!("cube".parse::<Simulator>().unwrap_err().to_string().contains("sphere, torus"));
}

#[test]
fn options_out_of_range_are_refused() {
    let refused = |options: Options| Simulator::Sphere.simulate(&options).unwrap_err();
    assert_eq!(refused(Options { size: Some(0), ..SMALL }), OptionsError::NoPoses);
    let sigma = refused(Options { sigma_rotation: -1.0, ..SMALL });
    assert_eq!(sigma, OptionsError::Sigma { name: "sigma_rotation", value: -1.0 });
    assert!(matches!(refused(Options { sigma_translation: f64::NAN, ..SMALL }), OptionsError::Sigma { .. }));
    let chance = refused(Options { closures: 1.5, ..SMALL });
    assert_eq!(chance, OptionsError::Chance { name: "closures", value: 1.5 });
    assert!(matches!(refused(Options { outliers: f64::NAN, ..SMALL }), OptionsError::Chance { .. }));
}

#[test]
fn bodies_look_where_they_go() {
    for world in [Simulator::Sphere, Simulator::Torus, Simulator::Garage] {
        let s = world.simulate(&Options { size: None, ..SMALL }).unwrap();
        for pair in s.truth.poses3.windows(2) {
            let step = pair[0].value.between(&pair[1].value).translation();
            // On circles of 50 steps and ramps of 3 m on 120 m the chord leaves the tangent by few degrees.
            assert!(step.x > 0.85 * step.norm(), "{world} at {}: {step:?}", pair[0].id);
        }
    }
    let s = Simulator::Landmarks.simulate(&Options { size: None, ..SMALL }).unwrap();
    for pair in s.truth.poses2.windows(2) {
        let step = pair[0].value.between(&pair[1].value).translation();
        assert!(step.x > 0.98 && step.norm() < 1.0 + 1e-12, "at {}: {step:?}", pair[0].id);
    }
}
