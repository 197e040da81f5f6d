//! What is a covariance, what is not, and what a degenerate one knows about itself.

use boxplus::lie::{LieGroup, SE3};
use boxplus::uncertainty::{Covariance, Direction, Gaussian, Pair, UncertaintyError};
use nalgebra::{Matrix2, Matrix3, SMatrix, SVector, Vector6, matrix, vector};

#[test]
fn faulty_matrices_are_refused_with_their_reason() {
    let nan = Covariance::new(matrix![1.0, f64::NAN; 0.0, 1.0]);
    assert_eq!(nan, Err(UncertaintyError::NotFinite { row: 0, column: 1 }));
    let skew = Covariance::new(matrix![4.0, 0.5; 0.25, 1.0]);
    assert_eq!(skew, Err(UncertaintyError::Asymmetric { row: 0, column: 1, difference: 0.25 }));
    let Err(UncertaintyError::Indefinite { eigenvalue, variance, direction }) =
        Covariance::new(matrix![4.0, 4.0; 4.0, 1.0])
    else {
        panic!("correlation 2 is no correlation")
    };
    assert!((eigenvalue + 1.0).abs() < 1e-15, "1 − 2");
    // (1, −2) in units of the standard deviations 2 and 1.
    let [(i, x), (j, y), _] = direction.coordinates;
    assert!(
        i == 1 && j == 0 && (x - 2.0 / 5_f64.sqrt()).abs() < 1e-15 && (y + 1.0 / 5_f64.sqrt()).abs() < 1e-15
    );
    assert!((variance - (x * x + 4.0 * y * y + 8.0 * x * y)).abs() < 1e-14);
    let negative = Covariance::new(matrix![1.0, 0.0; 0.0, -1e-6]);
    assert!(matches!(negative, Err(UncertaintyError::Indefinite { variance, .. }) if variance == -1e-6));
    let certain_but_correlated = Covariance::new(matrix![1.0, 0.1; 0.1, 0.0]);
    assert!(matches!(certain_but_correlated, Err(UncertaintyError::Indefinite { .. })));
    for sigma in [-0.1, f64::NAN, f64::INFINITY] {
        let refused = Covariance::from_sigmas(&vector![1.0, sigma]);
        assert!(matches!(refused, Err(UncertaintyError::InvalidSigma { index: 1, .. })));
    }
    // Finite, but their squares are not.
    assert_eq!(
        Covariance::from_sigmas(&vector![1e200]),
        Err(UncertaintyError::InvalidSigma { index: 0, sigma: 1e200 })
    );
    assert!(Covariance::from_sigmas(&vector![1.0_f32, 1e20]).is_err());
}

#[test]
fn definiteness_and_rank_do_not_depend_on_units() {
    let correlation: SMatrix<f64, 3, 3> = matrix![1.0, 0.5, 0.2; 0.5, 1.0, 0.3; 0.2, 0.3, 1.0];
    for exponent in [0, 8, 40, 100] {
        let units = Matrix3::from_diagonal(&vector![1.0, 10_f64.powi(-exponent), 10_f64.powi(exponent)]);
        let covariance = Covariance::new(units * correlation * units).unwrap();
        assert_eq!(covariance.rank(), 3);
        let product = covariance.information().unwrap() * covariance.matrix();
        let scaled = units * product * units.try_inverse().unwrap();
        assert!((scaled - Matrix3::identity()).amax() < 1e-15);
        let turned = Matrix3::new(1.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, -0.1);
        assert!(Covariance::new(units * turned * units).is_err());
    }
}

#[test]
fn rounding_is_forgiven_and_made_symmetric() {
    let j = Matrix2::new(0.6, -0.8, 0.8, 0.6);
    let flat = Matrix2::new(1.0, 0.0, 0.0, 0.0);
    let turned = j * (j * flat * j.transpose()) * j.transpose();
    assert_eq!(Covariance::new(turned).unwrap().rank(), 1);
    let mut printed = matrix![1.0, 0.333333; 0.333333, 0.5];
    printed[(0, 1)] += 1e-9;
    let kept = *Covariance::new(printed).unwrap().matrix();
    assert_eq!(kept, kept.transpose());
    assert!(Covariance::new(matrix![1.0_f32, 0.5; 0.50001, 1.0]).is_ok());
    assert!(Covariance::new(matrix![1.0_f32, 0.5; 0.502, 1.0]).is_err());
}

#[test]
fn a_degenerate_covariance_knows_its_directions() {
    let l = SMatrix::<f64, 4, 2>::from_fn(|i, j| ((2 * i + 3 * j + 1) as f64).sin());
    let covariance = Covariance::new(l * l.transpose()).unwrap();
    assert_eq!(covariance.rank(), 2);
    let null: Vec<_> = covariance.null_directions().collect();
    assert_eq!(null.len(), 2);
    for direction in &null {
        assert!((direction.norm() - 1.0).abs() < 1e-15);
        assert!((covariance.matrix() * direction).amax() < 1e-15);
    }
    let factor = covariance.factor();
    assert!((factor * factor.transpose() - covariance.matrix()).amax() < 1e-15);
    let Err(UncertaintyError::Singular { direction }) = covariance.information() else {
        panic!("inverted a singular matrix")
    };
    let named = SVector::<f64, 4>::from_fn(|i, _| {
        direction.coordinates.iter().filter(|(index, x)| *index == i && *x != 0.0).map(|(_, x)| x).sum()
    });
    assert!((1.0 - named.norm()).abs() < 0.3, "the three largest of four coordinates");
    assert!(matches!(covariance.log_determinant(), Err(UncertaintyError::Singular { .. })));
    let no_heading = Covariance::from_information(&Matrix3::from_diagonal(&vector![1.0, 1.0, 0.0]));
    let named = Direction { coordinates: [(2, 1.0), (0, 0.0), (0, 0.0)] };
    assert_eq!(no_heading, Err(UncertaintyError::NoInformation { direction: named }));
}

#[test]
fn principal_axes_are_eigenvectors_in_descending_order() {
    let l = SMatrix::<f64, 6, 6>::from_fn(|i, j| ((5 * i * j + 3 * j + i + 1) as f64).sin());
    let covariance = Covariance::new(l * l.transpose()).unwrap();
    let (values, axes) = covariance.principal_axes();
    assert!(values.as_slice().windows(2).all(|pair| pair[0] >= pair[1]));
    let rebuilt = axes * SMatrix::from_diagonal(&values) * axes.transpose();
    assert!((rebuilt - covariance.matrix()).amax() < 1e-14);
    assert!((axes.transpose() * axes - SMatrix::identity()).amax() < 1e-14);
    let log_determinant: f64 = values.iter().map(|x| x.ln()).sum();
    assert!((log_determinant - covariance.log_determinant().unwrap()).abs() < 1e-10);
}

#[test]
fn orders_of_other_libraries_are_permutations() {
    let ours = Covariance::<6>::from_sigmas(&Vector6::from_fn(|i, _| (i + 1) as f64)).unwrap();
    let gtsam = ours.permuted(&[3, 4, 5, 0, 1, 2]).unwrap();
    assert_eq!(gtsam.sigmas(), vector![4.0, 5.0, 6.0, 1.0, 2.0, 3.0]);
    assert_eq!(gtsam.permuted(&[3, 4, 5, 0, 1, 2]).unwrap(), ours);
    let twice = ours.permuted(&[3, 4, 5, 0, 1, 1]);
    assert_eq!(twice, Err(UncertaintyError::NotAPermutation { missing: 2 }));
}

#[test]
fn a_pair_cannot_be_correlated_beyond_its_marginals() {
    let x = Gaussian::<SE3, 6>::from_sigmas(SE3::identity(), &Vector6::repeat(0.1)).unwrap();
    assert!(Pair::new(x, x, *x.covariance().matrix()).is_ok());
    let refused = Pair::new(x, x, x.covariance().matrix() * 1.01).unwrap_err();
    let UncertaintyError::Indefinite { eigenvalue, direction, .. } = refused else { panic!("{refused}") };
    assert!((eigenvalue + 0.01).abs() < 1e-12);
    let [(i, a), (j, b), _] = direction.coordinates;
    assert!(i.abs_diff(j) == 6 && (a + b).abs() < 1e-12, "one coordinate of X against its twin of Y");
}
