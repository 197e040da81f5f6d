//! A step of a filter, a prediction and an update, beside the crates that do the same model.
//!
//! Without arguments: medians over interleaved rounds, so that what disturbs the machine disturbs all alike. With `NAME STEPS`: so many
//! steps of one contestant and nothing else, for a counter of instructions.
#![allow(missing_docs)]

mod boxplus_side;
mod peers;

use std::hint::black_box;
use std::time::Instant;

/// A filter that runs for some steps and shows a number of its state.
pub type Contestant = (&'static str, &'static str, fn(usize) -> f64);

const CONTESTANTS: [Contestant; 14] = [
    ("cart, 4 states f64", "boxplus extended", boxplus_side::cart),
    ("cart, 4 states f64", "boxplus square root", boxplus_side::cart_root),
    ("cart, 4 states f64", "adskalman 0.18 (Joseph)", peers::cart_adskalman),
    ("cart, 4 states f64", "kfilter 0.5.1", peers::cart_kfilter),
    ("plane, range and bearing, 3 states f64", "boxplus extended", boxplus_side::plane),
    ("plane, range and bearing, 3 states f64", "boxplus iterated", boxplus_side::plane_iterated),
    ("plane, range and bearing, 3 states f64", "boxplus unscented", boxplus_side::plane_unscented),
    ("plane, range and bearing, 3 states f64", "kfilter 0.5.1 (no manifold)", peers::plane_kfilter),
    ("inertial with biases, position", "boxplus extended f64, 15 states", boxplus_side::inertial),
    ("inertial with biases, position", "boxplus invariant f64, 15 states", boxplus_side::inertial_global),
    ("inertial with biases, position", "boxplus extended f32, 15 states", boxplus_side::inertial_single),
    ("inertial with biases, position", "boxplus square root f32, 15 states", boxplus_side::inertial_root),
    ("inertial with biases, position", "boxplus unscented f64, 15 states", boxplus_side::inertial_unscented),
    ("inertial with biases, position", "eskf 0.2 f32 (Joseph), 18 states", peers::inertial_eskf),
];

const ROUNDS: usize = 41;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.as_slice() {
        [index, steps] => {
            let (.., run) = CONTESTANTS[index.parse::<usize>().expect("an index")];
            println!("{}", run(steps.parse().expect("a count of steps")));
        }
        [only] if only == "names" => {
            CONTESTANTS.iter().for_each(|(model, name, _)| println!("{model}\t{name}"));
        }
        _ => timed(),
    }
}

fn timed() {
    let steps = |k: usize| if CONTESTANTS[k].0.starts_with("inertial") { 200 } else { 4000 };
    let mut nanoseconds = vec![Vec::new(); CONTESTANTS.len()];
    for round in 0..=ROUNDS {
        for (k, (.., run)) in CONTESTANTS.iter().enumerate() {
            let start = Instant::now();
            black_box(run(black_box(steps(k))));
            if round > 0 {
                nanoseconds[k].push(start.elapsed().as_secs_f64() * 1e9 / steps(k) as f64);
            }
        }
    }
    for ((model, name, _), mut samples) in CONTESTANTS.iter().zip(nanoseconds) {
        samples.sort_by(f64::total_cmp);
        let at = |quantile: usize| samples[quantile * (samples.len() - 1) / 4];
        println!("{model}\t{name}\t{:.0}\t{:.0}\t{:.0}", at(2), at(1), at(3));
    }
}
