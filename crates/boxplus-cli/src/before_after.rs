//! The picture of `solve`: before, after, and how badly each loop closure fits.

use boxplus::pose_graph::solve::PositionCovariance;
use boxplus::pose_graph::{PoseGraph, SolveSettings, Solved};

use crate::choices::Gauge;
use crate::draw::{Ellipse, Figure, Panel, Places, Scene};
use crate::error::Error;
use crate::input::Loaded;
use crate::output::Console;
use crate::plot::{facts, sigmas};
use crate::progress::Progress;
use crate::text::{count, duration, significant};

/// Positions whose covariance is drawn: each costs two triangular solves, and more would hide each other.
const ELLIPSES: usize = 150;

/// Two panels: the graph as it was given (or first estimated), and its optimum.
pub fn figure(
    loaded: &Loaded,
    settings: &SolveSettings,
    solved: &Solved,
    covariance: Option<Gauge>,
    console: Console,
) -> Result<Figure, Error> {
    let _progress = Progress::start(console, "drawing");
    let refused = |error| loaded.refusal(error);
    let (heading, before, cost) = match solved.given_cost {
        Some(cost) => ("Before", &loaded.graph, cost),
        None => ("First estimate", &solved.initial, solved.initial_cost),
    };
    let chi2 = before.chi2(settings).map_err(refused)?;
    let mut after = Scene::of(&solved.graph, &sigmas(&solved.graph, &solved.chi2));
    if let Some(gauge) = covariance {
        let (ids, kept) = (spread(&solved.graph), solved.agreeing());
        let covariances = match gauge {
            Gauge::Held => kept.position_covariances(&ids, settings),
            Gauge::Free => kept.position_covariances_of_minimum_norm(&ids, settings),
        };
        let covariances = covariances.map_err(refused)?;
        after.ellipses = ellipses(&solved.graph, &covariances);
    }
    let panel = |heading: &str, cost, scene| Panel {
        heading: heading.to_owned(),
        note: format!("cost {}", significant(cost, 6)),
        scene,
    };
    let change = format!("cost {} → {}", significant(cost, 4), significant(solved.cost, 6));
    let before = panel(heading, cost, Scene::of(before, &sigmas(before, &chi2)));
    let steps = count(solved.report.iterations.len(), "step", "steps");
    let effort = format!("{steps}, {}", duration(solved.seconds.initialise + solved.seconds.optimise));
    Ok(Figure {
        title: loaded.title(),
        facts: format!("{} · {change} · {effort}", facts(&solved.graph)),
        panels: vec![before, panel("After", solved.cost, after)],
    })
}

/// Some of the poses, evenly over the travel, and some of the landmarks.
fn spread(graph: &PoseGraph) -> Vec<u64> {
    let ids: Vec<u64> = graph.vertices().map(|(id, ..)| id).collect();
    let every = ids.len().div_ceil(ELLIPSES).max(1);
    ids.into_iter().step_by(every).collect()
}

fn ellipses(graph: &PoseGraph, covariances: &[PositionCovariance]) -> Vec<Ellipse> {
    let places = Places::of(graph);
    let ellipse =
        |c: &PositionCovariance| Some(Ellipse { centre: places.at(c.id)?, covariance: c.covariance });
    covariances.iter().filter_map(ellipse).collect()
}
