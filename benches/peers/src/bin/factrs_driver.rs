//! fact.rs, with its own reader (which anchors a first pose by a prior) and its observers.

use std::{cell::RefCell, error::Error, rc::Rc};

use boxplus_peers::{Arguments, Recorder, guarded};
use factrs::{
    assign_symbols,
    containers::Values,
    core::{GaussNewton, LevenMarquardt, SE2, SE3},
    optimizers::{BaseOptParams, LevenParams, OptError, OptObserver},
    traits::Optimizer,
    utils::load_g20,
};

assign_symbols!(X: SE2, SE3);

struct Observer(Rc<RefCell<Recorder>>);

impl OptObserver for Observer {
    fn on_step(&self, values: &Values, iteration: i64) {
        self.0.borrow_mut().observe(usize::try_from(iteration).unwrap_or(0), coordinates(values));
    }
}

/// x y θ or x y z qx qy qz qw of each pose.
fn coordinates(values: &Values) -> Vec<f64> {
    let ids = (0..).map(X).take(values.len());
    ids.flat_map(|id| match (values.get::<_, SE2>(id), values.get::<_, SE3>(id)) {
        (Some(pose), _) => vec![pose.x(), pose.y(), pose.theta()],
        (_, Some(pose)) => {
            let (t, q) = (pose.xyz(), pose.rot());
            vec![t[0], t[1], t[2], q.x(), q.y(), q.z(), q.w()]
        }
        (None, None) => Vec::new(),
    })
    .collect()
}

fn optimize(mut optimizer: impl Optimizer, values: Values, recorder: &Rc<RefCell<Recorder>>) -> String {
    recorder.borrow_mut().keep(0, coordinates(&values));
    optimizer.add_observer(Observer(Rc::clone(recorder)));
    recorder.borrow_mut().start();
    let outcome = guarded(|| optimizer.optimize(values));
    recorder.borrow_mut().stop();
    match outcome {
        Ok(Ok(_)) => "converged".into(),
        Ok(Err(OptError::MaxIterations(_))) => "max_iterations".into(),
        Ok(Err(OptError::InvalidSystem)) => "error: invalid system".into(),
        Ok(Err(OptError::FailedToStep)) => "error: failed to step".into(),
        Err(panic) => panic,
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse()?;
    let (graph, values) = load_g20(arguments.graph.to_str().ok_or("the path is not UTF-8")?);
    let mut base = BaseOptParams::default();
    base.max_iterations = arguments.max_iterations.unwrap_or(base.max_iterations);
    let recorder = Rc::default();
    let status = match arguments.method.as_str() {
        "lm" => {
            let params = LevenParams { base, ..LevenParams::default() };
            optimize(LevenMarquardt::new(params, graph), values, &recorder)
        }
        "gn" => optimize(GaussNewton::new(base, graph), values, &recorder),
        other => return Err(format!("unknown method {other}").into()),
    };
    recorder.borrow().report(&status, &arguments.poses)?;
    Ok(())
}
