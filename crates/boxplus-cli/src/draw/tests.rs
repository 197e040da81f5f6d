use super::*;
use nalgebra::{Matrix3, Vector3};
use scene::Link;

fn helix(loops: usize) -> Scene {
    let at = |i: usize| {
        let angle = i as f64 * 0.1;
        Vector3::new(5.0 * angle.cos(), 5.0 * angle.sin(), 0.01 * i as f64)
    };
    let link = |i: usize| Link { ends: [at(i), at(i + 63)], residual: 0.1 + (i % 40) as f64 };
    Scene {
        spatial: true,
        tracks: vec![(0..loops + 64).map(at).collect()],
        loops: (0..loops).map(link).collect(),
        landmarks: vec![Vector3::new(1.0, 2.0, 0.0)],
        sightings: vec![[at(3), Vector3::new(1.0, 2.0, 0.0)]],
        clouds: [vec![at(3)], vec![at(5)]],
        ellipses: vec![Ellipse { centre: at(9), covariance: Matrix3::identity() }],
        ..Scene::default()
    }
}

fn figure(scene: Scene) -> Figure {
    let panel = Panel { heading: "Result".to_owned(), note: "cost 1.5".to_owned(), scene };
    Figure {
        title: "a < b & \"c\"".to_owned(),
        facts: "½Σ‖r‖²".to_owned(),
        panels: vec![panel.clone(), panel],
    }
}

fn tree(svg: &str) -> resvg::usvg::Tree {
    resvg::usvg::Tree::from_str(svg, &resvg::usvg::Options::default()).unwrap()
}

#[test]
fn the_drawing_is_an_svg_whatever_the_title() {
    for spatial in [false, true] {
        let svg = figure(Scene { spatial, ..helix(100) }).svg();
        assert!(tree(&svg).root().has_children());
        assert!(svg.contains("a &lt; b &amp; \"c\""), "{svg}");
    }
}

#[test]
fn an_empty_graph_and_one_of_nonsense_numbers_are_drawn_too() {
    let mut broken = helix(20);
    broken.tracks[0][5].x = f64::NAN;
    broken.loops[3].residual = f64::INFINITY;
    broken.ellipses[0].covariance[(0, 0)] = f64::NAN;
    broken.landmarks.push(Vector3::repeat(f64::INFINITY));
    for scene in [Scene::default(), broken] {
        let svg = figure(scene).svg();
        let nonsense: Vec<_> = svg.lines().filter(|l| l.contains("NaN") || l.contains("inf")).collect();
        assert!(nonsense.is_empty(), "{nonsense:?}");
        assert!(png(&svg).is_some());
    }
}

#[test]
fn a_hundred_thousand_edges_are_a_small_file() {
    let svg = figure(helix(100_000)).svg();
    assert!(svg.len() < 12_000_000, "{} bytes", svg.len());
    assert!(svg.matches("<path").count() < 1200);
}

#[test]
fn the_png_carries_its_text_on_a_machine_without_fonts() {
    let svg = |title: &str| Figure { title: title.to_owned(), ..figure(Scene::default()) }.svg();
    let (named, nameless) = (png(&svg("sphere")).unwrap(), png(&svg("")).unwrap());
    assert!(named.starts_with(b"\x89PNG"));
    assert!(named != nameless);
}

#[test]
fn the_same_graph_gives_the_same_bytes() {
    assert_eq!(figure(helix(300)).svg(), figure(helix(300)).svg());
}
