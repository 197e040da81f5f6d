//! χ² against 50-digit values.

use boxplus::uncertainty::{ChiSquared, UncertaintyError};

const EPS: f64 = f64::EPSILON;

#[test]
fn tails_and_quantiles_are_those_of_arbitrary_precision() {
    let table = include_str!("../reference/chi_squared.csv");
    for row in table.lines().skip(1) {
        let fields: Vec<f64> = row.split(',').map(|field| field.parse().unwrap()).collect();
        let [degrees, probability, quantile, x, cdf, survival] = fields[..] else { panic!("{row}") };
        let chi = ChiSquared::new(row.split(',').next().unwrap().parse().unwrap());
        // An exponent E is rounded by ε·E, which is the relative error of e^E; a tail near 1 is 1 − the other.
        for (name, found, expected) in [("P", chi.cdf(x), cdf), ("Q", chi.survival(x), survival)] {
            let exponent = expected.max(1e-300).ln().abs() + 0.5 * degrees.ln();
            let bound =
                6.0 * EPS * (2.0 + exponent) * expected + 1e-290 + EPS * f64::from(u8::from(expected > 0.1));
            assert!(
                (found - expected).abs() <= bound,
                "{name}: {row}: {found:e}, {:.1} ε",
                (found / expected - 1.0) / EPS
            );
        }
        // P known to ε moves the quantile by ε·P/f.
        let found = chi.quantile(probability).unwrap();
        let h = 1e-4 * quantile;
        let density = (chi.cdf(quantile + h) - chi.cdf(quantile - h)) / (2.0 * h);
        let bound = 8.0 * EPS * (1.0 + degrees.ln()) * (quantile + probability / density);
        assert!((found - quantile).abs() <= bound, "{row}: {found:e}, off by {:e}", found - quantile);
    }
}

#[test]
fn the_edges_are_answered() {
    let chi = ChiSquared::new(3);
    assert_eq!((chi.cdf(0.0), chi.survival(0.0), chi.cdf(-1.0)), (0.0, 1.0, 0.0));
    assert_eq!((chi.cdf(f64::INFINITY), chi.survival(f64::INFINITY)), (1.0, 0.0));
    assert!(chi.cdf(f64::NAN).is_nan());
    assert_eq!((ChiSquared::new(0).cdf(0.0), ChiSquared::new(0).quantile(0.5)), (1.0, Ok(0.0)));
    for given in [0.0, 1.0, -0.5, 1.5] {
        assert_eq!(chi.quantile(given), Err(UncertaintyError::NotAProbability { given }));
        assert_eq!(chi.interval(given), Err(UncertaintyError::NotAProbability { given }));
    }
    assert!(matches!(chi.quantile(f64::NAN), Err(UncertaintyError::NotAProbability { .. })));
    for degrees in [1, 5, 50, 5000, 100_000] {
        for p in [1e-300, 1e-20, 1e-3, 0.3, 0.7, 1.0 - 1e-15] {
            let x = ChiSquared::new(degrees).quantile(p).unwrap();
            if x == 0.0 {
                assert!(degrees == 1 && p == 1e-300, "x² ~ p² is no f64");
                continue;
            }
            let again = ChiSquared::new(degrees).cdf(x);
            assert!((again / p - 1.0).abs() < 1e-11, "{degrees} {p}: {x} {again}");
        }
    }
}

#[test]
fn the_band_of_an_average_nees_is_the_published_one() {
    let published = [
        (3, 50, 2.360, 3.716),
        (6, 50, 5.078, 6.997),
        (6, 1000, 5.787, 6.217),
        (9, 100, 8.188, 9.850),
        (2, 500, 1.829, 2.179),
    ];
    for (n, runs, low, high) in published {
        let band = ChiSquared::new(n * runs).interval(0.95).unwrap().map(|x| x / runs as f64);
        assert!((band[0] - low).abs() < 5e-4 && (band[1] - high).abs() < 5e-4, "{band:?}");
    }
}
