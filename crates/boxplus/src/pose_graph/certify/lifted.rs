//! The relaxation of a pose graph one or two dimensions up, as a factor graph of its own.
//!
//! In ℝᴾ with P > D there is room around the obstacles of ℝᴰ: where an estimate is no optimum although every step makes it
//! worse, the eigenvector of S with a negative eigenvalue is a way down through the new dimension. A Riemannian
//! staircase, Boumal (2015); Rosen et al. (2019), §4.2.
//!
//! A frame is stored as Q ∈ O(P), of which the first D columns count; it moves by Q·Cay(A) with A skew and zero where
//! both coordinates are beyond D, so that T = D(D−1)/2 + D(P−D) numbers turn it and P move it.

use nalgebra::{SMatrix, SVector, SymmetricEigen};

use super::quadratic::{Frame, Link};
use crate::graph::{self, Factor, Graph, GraphError, Noise, SolveOptions, TangentResidual, Values, Variable};
use crate::lie::Real;

/// A frame of the relaxation, with a T-dimensional tangent.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Lifted<const P: usize, const D: usize, const T: usize, S = f64> {
    q: SMatrix<S, P, P>,
    t: SVector<S, P>,
}

/// The pairs (a, b) of axes that a turn may mix, a < D, in the order of the tangent.
fn planes<const P: usize, const D: usize>() -> impl Iterator<Item = (usize, usize)> {
    (0..D).flat_map(|a| (a + 1..P).map(move |b| (a, b)))
}

impl<const P: usize, const D: usize, const T: usize, S: Real> Lifted<P, D, T, S> {
    /// A: turns of the tangent as a skew matrix.
    fn skew(delta: &[S]) -> SMatrix<S, P, P> {
        let mut skew = SMatrix::<S, P, P>::zeros();
        for ((a, b), x) in planes::<P, D>().zip(delta) {
            skew[(b, a)] += *x;
            skew[(a, b)] -= *x;
        }
        skew
    }

    fn moved(&self, delta: &[S]) -> SVector<S, P> {
        let turns = planes::<P, D>().count();
        self.t + SVector::<S, P>::from_fn(|i, _| delta[turns + i])
    }

    /// The D columns that count.
    fn y(&self) -> SMatrix<S, P, D> {
        self.q.fixed_columns::<D>(0).into_owned()
    }
}

impl<const P: usize, const D: usize, const T: usize> Variable for Lifted<P, D, T> {
    const DIM: usize = T;
    const NAME: &'static str = "frame";
    const COORDINATES: &'static [&'static str] = &["a coordinate"; 16];
    const POSE: bool = true;
    type Jacobian<const R: usize> = SMatrix<f64, R, T>;
    type Over<S: Real> = Lifted<P, D, T, S>;

    fn retract(&self, delta: &[f64]) -> Self {
        // Cay(A) = (I − A/2)⁻¹(I + A/2) is orthogonal, and I − A/2 always invertible.
        let half = Self::skew(delta) * 0.5;
        let one = SMatrix::<f64, P, P>::identity();
        let turn = (one - half).try_inverse().map_or(one, |inverse| inverse * (one + half));
        Self { q: orthonormal(&(self.q * turn)), t: self.moved(delta) }
    }
    fn constant<S: Real>(&self) -> Lifted<P, D, T, S> {
        Lifted { q: self.q.map(S::lit), t: self.t.map(S::lit) }
    }
    fn perturb<S: Real>(&self, delta: &[S]) -> Lifted<P, D, T, S> {
        let (x, a) = (self.constant::<S>(), Lifted::<P, D, T, S>::skew(delta));
        Lifted { q: x.q + x.q * a, t: x.moved(delta) } // right to first order
    }
    fn derivative<const R: usize>(residual: &impl TangentResidual<R>) -> SMatrix<f64, R, T> {
        graph::derivative::<R, T>(residual)
    }
    fn is_finite(&self) -> bool {
        self.q.iter().chain(&self.t).all(|x| x.is_finite())
    }
}

/// One Newton step towards the nearest orthogonal matrix: Q(3I − QᵀQ)/2.
fn orthonormal<const P: usize>(q: &SMatrix<f64, P, P>) -> SMatrix<f64, P, P> {
    q * (SMatrix::<f64, P, P>::identity() * 1.5 - q.transpose() * q * 0.5)
}

/// A link between two frames: √κ(Y_j − Y_i·R̃) by columns, then √τ(t_j − t_i − Y_i·t̃); R = P·D + P numbers.
struct Joint<const P: usize, const D: usize, const T: usize, const R: usize>(Link<D>);

impl<const P: usize, const D: usize, const T: usize, const R: usize> Factor<R> for Joint<P, D, T, R> {
    const NAME: &'static str = "displacement of frames";
    const RELATIVE: bool = true;
    type Variables = (Lifted<P, D, T>, Lifted<P, D, T>);

    fn residual<S: Real>(&self, (a, b): &(Lifted<P, D, T, S>, Lifted<P, D, T, S>)) -> SVector<S, R> {
        let Self(link) = self;
        let y = b.y() - a.y() * link.rotation.map(S::lit);
        let t = b.t - a.t - a.y() * link.translation.map(S::lit);
        let (root_kappa, root_tau) = (S::lit(link.kappa.sqrt()), S::lit(link.tau.sqrt()));
        SVector::from_fn(|i, _| if i < P * D { y[i] * root_kappa } else { t[i - P * D] * root_tau })
    }

    fn residual_jac(
        &self,
        variables: &Self::Variables,
    ) -> (SVector<f64, R>, (SMatrix<f64, R, T>, SMatrix<f64, R, T>)) {
        let (Self(link), (a, b)) = (self, variables);
        let (root_kappa, root_tau) = (link.kappa.sqrt(), link.tau.sqrt());
        let (mut d_a, mut d_b) = (SMatrix::<f64, R, T>::zeros(), SMatrix::<f64, R, T>::zeros());
        for (k, (m, n)) in planes::<P, D>().enumerate() {
            // Turning in the plane (m, n) moves column m along q_n, and column n, if it counts, against q_m.
            let moves = [(m, n, 1.0), (n, m, -1.0)];
            for (column, along, sign) in moves.into_iter().filter(|&(column, ..)| column < D) {
                for p in 0..P {
                    d_b[(column * P + p, k)] += sign * root_kappa * b.q[(p, along)];
                    let x = sign * a.q[(p, along)];
                    (0..D).for_each(|c| d_a[(c * P + p, k)] -= root_kappa * x * link.rotation[(column, c)]);
                    d_a[(P * D + p, k)] -= root_tau * x * link.translation[column];
                }
            }
        }
        for p in 0..P {
            d_a[(P * D + p, T - P + p)] = -root_tau;
            d_b[(P * D + p, T - P + p)] = root_tau;
        }
        (self.residual::<f64>(variables), (d_a, d_b))
    }
}

/// Frames with one row more, moved down along the eigenvector `direction` of S: as far as the cost allows.
pub(super) fn descend<const P: usize, const Q: usize, const D: usize>(
    frames: &[Frame<P, D>],
    direction: impl Fn(usize) -> (SVector<f64, D>, f64),
    cost: impl Fn(&[Frame<Q, D>]) -> f64,
) -> Vec<Frame<Q, D>> {
    let largest = (0..frames.len()).map(|i| direction(i).0.norm()).fold(0.0, f64::max);
    let at = |length: f64| -> Vec<Frame<Q, D>> {
        let moved = |(i, frame): (usize, &Frame<P, D>)| {
            let (turn, shift) = direction(i);
            let mut y = SMatrix::<f64, Q, D>::zeros();
            y.view_mut((0, 0), (P, D)).copy_from(&frame.y);
            y.view_mut((P, 0), (1, D)).copy_from(&(turn.transpose() * length));
            let t = SVector::<f64, Q>::from_fn(|p, _| if p < P { frame.t[p] } else { length * shift });
            Frame { y: polar(&y), t }
        };
        frames.iter().enumerate().map(moved).collect()
    };
    let lengths = core::iter::successors(Some(1.0 / largest), |length| Some(length * 0.5)).take(40);
    let trials = lengths.map(|length| (cost(&at(length)), length));
    // The cost falls as length² for small lengths and rises again: the best of the halvings is near the best there is.
    let best = trials.fold((f64::INFINITY, 0.0), |best, trial| if trial.0 < best.0 { trial } else { best });
    at(best.1)
}

/// The nearest matrix with orthonormal columns: Y(YᵀY)^-½.
pub(super) fn polar<const P: usize, const D: usize>(y: &SMatrix<f64, P, D>) -> SMatrix<f64, P, D> {
    let gram = y.transpose() * y;
    let mut eigen = SymmetricEigen::new(nalgebra::DMatrix::from_column_slice(D, D, gram.as_slice()));
    eigen.eigenvalues.apply(|x| *x = x.max(f64::MIN_POSITIVE).sqrt().recip());
    let root = eigen.recompose();
    y * SMatrix::<f64, D, D>::from_column_slice(root.as_slice())
}

/// The frames of least cost near these.
///
/// # Errors
/// [`GraphError::OutOfMemory`].
pub(super) fn minimise<const P: usize, const D: usize, const T: usize, const R: usize>(
    links: &[Link<D>],
    frames: &[Frame<P, D>],
    options: &SolveOptions,
) -> Result<Vec<Frame<P, D>>, GraphError> {
    let (mut graph, mut values) = (Graph::new(), Values::new());
    let keys: Vec<_> =
        frames.iter().map(|f| values.insert(Lifted::<P, D, T> { q: complete(&f.y), t: f.t })).collect();
    for link in links {
        let factor = Joint::<P, D, T, R>(*link);
        graph.add((keys[link.from], keys[link.to]), factor, Noise::unit());
    }
    let solution = graph.optimize(&values, options)?;
    Ok(solution.values.iter::<Lifted<P, D, T>>().filter_map(|(_, x)| Some(Frame { y: x?.y(), t: x?.t })).collect())
}

/// An orthogonal matrix whose first columns are those of `y`.
fn complete<const P: usize, const D: usize>(y: &SMatrix<f64, P, D>) -> SMatrix<f64, P, P> {
    let mut q = SMatrix::<f64, P, P>::zeros();
    q.view_mut((0, 0), (P, D)).copy_from(y);
    for column in D..P {
        // The axis that the columns so far reach least, made orthogonal to them.
        let reach = |p: usize| q.row(p).columns(0, column).norm_squared();
        let axis = (0..P).min_by(|&a, &b| reach(a).total_cmp(&reach(b))).unwrap_or(0);
        let mut new = SVector::<f64, P>::zeros();
        new[axis] = 1.0;
        for _ in 0..2 {
            for k in 0..column {
                let along = q.column(k).dot(&new);
                new -= q.column(k) * along;
            }
        }
        q.set_column(column, &new.normalize());
    }
    q
}
