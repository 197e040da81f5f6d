use crate::support::*;
use boxplus::lie::{LieGroup, SE2, SE3, SGal3, SO3, Tangent};
use boxplus::trajectory::{TrajectoryError, discretise, velocity_noise, velocity_noise_first_order};
use nalgebra::{Matrix2, Matrix3, SMatrix, SVector, matrix, vector};

#[test]
fn it_is_van_loans_at_two_hundred_digits() {
    let table = Table::parse(include_str!("../reference/discretise.csv"));
    for row in 0..table.rows() {
        let (a, w) = (table.matrix(row, "a"), table.matrix(row, "w"));
        let dt = table.get::<1>(row, "dt")[0];
        let (phi, q_d) = discretise(&a, &Matrix3::identity(), &w, dt).unwrap();
        let (truth, q_truth) = (table.matrix(row, "phi"), table.matrix(row, "q"));
        // Each doubling rounds, and squares what was rounded before; exp itself is conditioned by ‖A‖Δ.
        let bound = 8.0 * EPS * (1.0 + 4.0 * a.norm() * dt);
        assert!((phi - truth).norm() <= bound * truth.norm().max(1.0), "row {row}: Φ {phi}{truth}");
        let error = (q_d - q_truth).norm() / (1e-300 + q_truth.norm());
        assert!(error <= bound * (1.0 + phi.norm()), "row {row}: Q_d off by {error:.1e}\n{q_d}{q_truth}");
        assert_eq!(q_d, q_d.transpose());
    }
}

#[test]
fn two_steps_are_one_of_twice_the_length() {
    let (a, l, q) = (
        SMatrix::<f64, 4, 4>::from_fn(|i, j| draw::<4>(i as u64)[j]),
        SMatrix::<f64, 4, 2>::from_fn(|i, j| draw::<2>(9 + i as u64)[j]),
        Matrix2::new(2.0, 0.3, 0.3, 1.0),
    );
    let (phi, q_d) = discretise(&a, &l, &q, 0.7).unwrap();
    let (phi2, q2) = discretise(&a, &l, &q, 1.4).unwrap();
    close("Φ", &phi2, &(phi * phi), 64.0 * EPS);
    close("Q_d", &q2, &(q_d + phi * q_d * phi.transpose()), 64.0 * EPS);
}

#[test]
fn a_strongly_damped_system_reaches_its_stationary_covariance() {
    // ẋ = −1000x + w: variance q/2000. Van Loan's matrix would hold e¹⁰⁰⁰ here.
    let (phi, q_d) = discretise(&matrix![-1000.0_f64], &vector![1.0], &matrix![3.0], 1.0).unwrap();
    assert_eq!(phi[0], 0.0);
    assert!((q_d[0] / 0.0015 - 1.0).abs() < 8.0 * EPS);
}

#[test]
fn what_is_not_finite_or_no_duration_is_refused() {
    let one = Matrix2::<f64>::identity();
    for duration in [0.0, -1.0, f64::INFINITY] {
        assert_eq!(discretise(&one, &one, &one, duration), Err(TrajectoryError::NotADuration { duration }));
    }
    let mut bad = one;
    bad[(1, 0)] = f64::NAN;
    assert_eq!(discretise(&bad, &one, &one, 1.0), Err(TrajectoryError::NotFinite { index: 0 }));
    assert_eq!(discretise(&one, &bad, &one, 1.0), Err(TrajectoryError::NotFinite { index: 1 }));
    assert_eq!(discretise(&one, &one, &bad, 1.0), Err(TrajectoryError::NotFinite { index: 2 }));
}

#[test]
fn isotropic_noise_of_a_rotation_is_not_turned() {
    let (phi, q_d) = velocity_noise::<SO3, 3>(&vector![1.0, -2.0, 0.5], &Matrix3::identity(), 1.5).unwrap();
    close("Q_d", &q_d, &(Matrix3::identity() * 1.5), 16.0 * EPS);
    close("Φ", &phi, &SO3::exp(&vector![-1.5, 3.0, -0.75]).adjoint(), 16.0 * EPS);
}

fn transition_is_the_adjoint<G: LieGroup<D, Scalar = f64>, const D: usize>() {
    let omega: Tangent<f64, D> = draw(1);
    let (phi, _) = velocity_noise::<G, D>(&omega, &SMatrix::identity(), 1.3).unwrap();
    close("Φ = Ad(Exp(−ωΔ))", &phi, &G::exp(&(omega * -1.3)).adjoint(), 64.0 * EPS);
    // The exact noise and that of a noise held over the step differ by a third-order term.
    let gap = |dt: f64| {
        let q = SMatrix::from_diagonal(&draw::<D>(2).map(|x| 1.0 + x));
        let (_, exact) = velocity_noise::<G, D>(&omega, &q, dt).unwrap();
        (exact - velocity_noise_first_order::<G, D>(&omega, &q, dt)).norm()
    };
    let order = (gap(0.02) / gap(0.01)).log2();
    assert!((order - 3.0).abs() < 0.05, "{order:.3}");
}

#[test]
fn the_transition_is_the_adjoint_and_first_order_noise_is_off_by_the_cube_of_the_step() {
    transition_is_the_adjoint::<SO3, 3>();
    transition_is_the_adjoint::<SE2, 3>();
    transition_is_the_adjoint::<SE3, 6>();
    transition_is_the_adjoint::<SGal3, 10>();
}

fn monte_carlo<G: LieGroup<D, Scalar = f64>, const D: usize>(
    omega: &Tangent<f64, D>,
    sigmas: &Tangent<f64, D>,
) {
    let (runs, substeps, duration) = (4000_u32, 64_u32, 1.2);
    let dt = duration / f64::from(substeps);
    let q = SMatrix::from_diagonal(&sigmas.map(|s| s * s));
    let (_, q_d) = velocity_noise::<G, D>(omega, &q, duration).unwrap();
    let end = G::exp(&(omega * duration));
    let samples: Vec<SVector<f64, D>> = (0..runs)
        .map(|run| {
            let x = (0..substeps).fold(G::identity(), |x, k| {
                let w = normal::<D>(u64::from(run * substeps + k)).component_mul(sigmas) / dt.sqrt();
                x.rplus(&((omega + w) * dt))
            });
            x.rminus(&end)
        })
        .collect();
    agrees_with_samples(&q_d, &samples);
    // The test can tell: the noise that forgets the motion is out.
    let naive = q * duration;
    assert!((naive - q_d).norm() > 0.2 * q_d.norm());
}

#[test]
fn discretised_noise_is_what_simulated_noise_accumulates_to() {
    // Noise of 2 % and less: the second order in it, 4e-4, hides below the standard error of 4000 runs, 2 %.
    monte_carlo::<SE2, 3>(&vector![1.0, 0.2, 0.9], &vector![0.01, 0.003, 0.02]);
    monte_carlo::<SE3, 6>(
        &vector![1.0, 0.2, 0.0, 0.3, 0.1, 0.9],
        &vector![0.01, 0.003, 0.003, 0.02, 0.005, 0.02],
    );
}
