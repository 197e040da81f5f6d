//! `boxplus pose`: the calculator of uncertain poses.

pub mod args;
mod space;
mod told;
mod written;

use boxplus::lie::{Rn, SE2, SE3};
use boxplus::uncertainty::{Covariance, Criterion, Fused, Gaussian, Order, Pair, UncertaintyError};
use nalgebra::SMatrix;

use args::{Meaning, Operation, OrderName, Pose, SideName};
use space::Space;
use told::{Answer, Fit, Told};
use written::{Library, Named};

use crate::error::Error;
use crate::output::{Console, document};

/// Computes and prints.
pub fn run(options: &Pose, console: Console) -> Result<(), Error> {
    let operation = &options.operation;
    let library = Library::read(operation.options())?;
    let operands =
        operation.operands().into_iter().map(|word| library.find(word)).collect::<Result<Vec<_>, _>>()?;
    let dimension = same_dimension(&operands)?;
    operands.iter().for_each(|named| warn_of_degrees(named, console));
    let told = match dimension {
        2 => Calculator::<SE2, 3, 2>::new(operation, &library, &operands).told()?,
        3 => Calculator::<SE3, 6, 3>::new(operation, &library, &operands).told()?,
        other => {
            let message = format!("{}: a position has 2 numbers or 3, not {other}", operands[0].label());
            return Err(Error::Unreadable { message, help: None });
        }
    };
    if console.is_json() { document(&told.document()) } else { console.say(told.text().trim_end()) }
}

/// The number of coordinates of all positions.
fn same_dimension(operands: &[Named]) -> Result<usize, Error> {
    let size = |named: &Named| named.written.position.len();
    let first = operands.first().map_or(0, size);
    match operands.iter().find(|named| size(named) != first) {
        None => Ok(first),
        Some(other) => Err(Error::Usage {
            message: format!(
                "{} has a position of {first} numbers, {} one of {}",
                operands[0].label(),
                other.label(),
                size(other)
            ),
            help: Some("poses in the plane and in space do not mix".to_owned()),
        }),
    }
}

/// Angles beyond two turns are degrees in most cases.
fn warn_of_degrees(named: &Named, console: Console) {
    let written = &named.written;
    let angles = [written.yaw].into_iter().flatten().chain(written.yaw_pitch_roll.into_iter().flatten());
    let vector = written.rotation_vector.into_iter().flatten();
    if let Some(angle) = angles.chain(vector).find(|angle| angle.abs() > 2.0 * std::f64::consts::TAU) {
        console.warn(&format!(
            "{}: an angle of {angle} rad is more than two turns; degrees end in _deg",
            named.label()
        ));
    }
}

/// One operation on poses of one space.
struct Calculator<'a, G, const D: usize, const N: usize> {
    operation: &'a Operation,
    library: &'a Library,
    operands: &'a [Named],
    space: std::marker::PhantomData<G>,
}

impl<'a, G: Space<D, N>, const D: usize, const N: usize> Calculator<'a, G, D, N> {
    fn new(operation: &'a Operation, library: &'a Library, operands: &'a [Named]) -> Self {
        Self { operation, library, operands, space: std::marker::PhantomData }
    }

    /// The answer, ready for print.
    fn told(&self) -> Result<Told, Error> {
        let (answer, fit) = self.answer()?;
        let names: Vec<_> = self.operands.iter().map(|named| named.name.clone()).collect();
        Told::new(self.operation, &names, &answer, fit)
    }

    fn answer(&self) -> Result<(Answer<G, D, N>, Option<Fit>), Error> {
        let order = match self.operation.order() {
            Some(OrderName::First) => Order::First,
            Some(OrderName::Second) => Order::Second,
            Some(OrderName::Fourth) | None => Order::Fourth,
        };
        let pose = match self.operation {
            Operation::Compose { .. } => self.product(order)?,
            Operation::Invert { .. } => self.pose(0)?.inverse(),
            Operation::Relate { .. } => self.pair()?.between(order),
            Operation::Show { .. } => self.pose(0)?,
            Operation::Move { meaning, .. } => self.moved(*meaning)?,
            Operation::Fuse { unknown_correlation, .. } => {
                let (pose, fit) = if *unknown_correlation { self.intersection()? } else { self.fusion()? };
                return Ok((Answer::Pose(pose), Some(fit)));
            }
            Operation::Act { .. } => return Ok((self.seen(order)?, None)),
        };
        Ok((Answer::Pose(pose), None))
    }

    fn pose(&self, k: usize) -> Result<Gaussian<G, D>, Error> {
        Ok(self.pose_and_chart(k)?.0)
    }

    fn pose_and_chart(&self, k: usize) -> Result<(Gaussian<G, D>, SMatrix<f64, D, D>), Error> {
        space::pose(&self.operands[k], self.operation.options().from)
    }

    fn poses(&self) -> Result<Vec<Gaussian<G, D>>, Error> {
        (0..self.operands.len()).map(|k| self.pose(k)).collect()
    }

    /// The first two operands and what their errors share.
    fn pair(&self) -> Result<Pair<G, D, G, D>, Error> {
        let [named, other] = [&self.operands[0], &self.operands[1]];
        let ((first, from_first), (second, from_second)) = (self.pose_and_chart(0)?, self.pose_and_chart(1)?);
        let Some(rows) = self.library.correlation(&named.name, &other.name) else {
            return Ok(Pair::independent(first, second));
        };
        let given = space::square::<D>(named, "covariance of the correlation", &rows)?;
        let cross = from_first * given * from_second.transpose();
        Pair::new(first, second, cross).map_err(|error| Error::Unreadable {
            message: format!("the correlation of {} and {}: {error}", named.label(), other.label()),
            help: Some("a correlation cannot exceed what both covariances allow".to_owned()),
        })
    }

    fn product(&self, order: Order) -> Result<Gaussian<G, D>, Error> {
        if self.operands.len() == 2 {
            return Ok(self.pair()?.compose(order));
        }
        self.refuse_correlations("a product of more than two poses")?;
        Ok(Gaussian::chain(&self.poses()?, order))
    }

    /// Correlations that would be forgotten in silence.
    fn refuse_correlations(&self, what: &str) -> Result<(), Error> {
        for (k, first) in self.operands.iter().enumerate() {
            for second in &self.operands[k + 1..] {
                if self.library.correlation(&first.name, &second.name).is_some() {
                    return Err(Error::Usage {
                        message: format!(
                            "{} and {} are correlated, which {what} does not take",
                            first.label(),
                            second.label()
                        ),
                        help: Some(
                            "compose and relate take it, of two poses; fuse has --unknown-correlation"
                                .to_owned(),
                        ),
                    });
                }
            }
        }
        Ok(())
    }

    fn fusion(&self) -> Result<(Gaussian<G, D>, Fit), Error> {
        self.refuse_correlations("fusion")?;
        let poses = self.poses()?;
        let Fused { estimate, cost, iterations, converged, step } =
            Gaussian::fuse(&poses).map_err(|error| unfusable(&error))?;
        if !converged {
            return Err(unfusable(&UncertaintyError::NotConverged { iterations, step }));
        }
        Ok((
            estimate,
            Fit::Independent { chi_squared: 2.0 * cost, freedom: D * (poses.len() - 1), iterations },
        ))
    }

    fn intersection(&self) -> Result<(Gaussian<G, D>, Fit), Error> {
        let [first, second] = self.poses()?[..] else {
            return Err(Error::Usage {
                message: "covariance intersection takes two estimates".to_owned(),
                help: Some("fuse the result with the next one".to_owned()),
            });
        };
        let found = first.intersect(&second, Criterion::Determinant).map_err(|error| unfusable(&error))?;
        Ok((found.estimate, Fit::Intersection { weight: found.weight }))
    }

    fn seen(&self, order: Order) -> Result<Answer<G, D, N>, Error> {
        let (p, covariance) = space::point::<N>(&self.operands[1])?;
        let y = self.pose(0)?.act_on(&Gaussian::new(Rn::new(p), covariance), order);
        Ok(Answer::Point(y.mean().vector(), *y.covariance()))
    }

    fn moved(&self, meaning: Meaning) -> Result<Gaussian<G, D>, Error> {
        let (pose, by) = (self.pose(0)?, *self.pose(1)?.mean());
        let theta = by.log();
        let global = self.operation.options().side == Some(SideName::Global);
        Ok(match (meaning, global) {
            (Meaning::Body, _) => pose.change_body(&by),
            (Meaning::Parent, _) => pose.change_parent(&by),
            (Meaning::Correction, false) => pose.reset(&theta),
            (Meaning::Correction, true) => pose.to_global().reset(&theta).to_local(),
            (Meaning::Transport, false) => pose.transport(&theta),
            (Meaning::Transport, true) => pose.to_global().transport(&theta).to_local(),
        })
    }
}

fn unfusable(error: &UncertaintyError) -> Error {
    let help = match error {
        UncertaintyError::Singular { .. } => {
            "a pose that is certain somewhere cannot be fused; give it a variance there"
        }
        _ => "are they estimates of one pose, in one frame?",
    };
    Error::Undetermined { message: format!("not fused: {error}"), help: Some(help.to_owned()) }
}

/// The covariance of an answer in the convention asked for.
fn in_convention<G: Space<D, N>, const D: usize, const N: usize>(
    pose: &Gaussian<G, D>,
    options: &args::Options,
) -> Result<(Covariance<D>, SideName), Error> {
    let side = space::side(options.to, options.side)?;
    let chart = G::chart(pose.mean(), options.to, side)?;
    Ok((pose.covariance().transformed(&chart), side))
}
