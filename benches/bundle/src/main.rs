//! boxplus on a problem of Bundle Adjustment in the Large, by default but on one thread.
//!
//! Usage: `bundle PROBLEM.txt`. Prints one line an iteration, `cost cpu_seconds wall_seconds`, from the call of the solver, which builds
//! its graph in that time, then `end` and the same.

use std::error::Error;
use std::ops::ControlFlow;
use std::time::Instant;
use std::{env, fs};

use boxplus::bundle_adjustment::{Settings, solve::solve_observed};
use boxplus::graph::SolveOptions;
use boxplus::io::bal;
use cpu_time::ProcessTime;

fn main() -> Result<(), Box<dyn Error>> {
    let path = env::args().nth(1).ok_or("name a problem")?;
    let bundle = bal::read(&fs::read(&path)?, &path)?;
    let settings = Settings { options: SolveOptions { threads: 1, ..Settings::options() }, ..Settings::default() };
    let (cpu, wall) = (ProcessTime::now(), Instant::now());
    let print = |cost: f64| println!("{cost:.10e} {:.6} {:.6}", cpu.elapsed().as_secs_f64(), wall.elapsed().as_secs_f64());
    let solved = solve_observed(&bundle, &settings, &mut |iteration| {
        print(iteration.cost);
        ControlFlow::Continue(())
    })?;
    print!("end ");
    print(solved.bundle.cost()); // from the points in space, not from what the solver says
    Ok(())
}
