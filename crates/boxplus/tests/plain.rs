//! Elements as numbers: arrays, slices of arrays, text, and serialised forms.
#![allow(missing_docs, clippy::unwrap_used)]

use boxplus::lie::{LieError, LieGroup, Plain, R3xSO3, Rn, SE2, SE3, SE23, SGal3, SO2, SO3, Sim2, Sim3};
use nalgebra::{SVector, Vector2, Vector3};
use proptest::prelude::*;

/// A generic element of each group.
fn some<G: LieGroup<D, Scalar = f64>, const D: usize>() -> G {
    G::exp(&SVector::from_fn(|i, _| 0.3 + 0.1 * i as f64))
}

macro_rules! every_group {
    ($check:ident) => {
        $check!(Rn<3>, 3, 3);
        $check!(SO2, 1, 2);
        $check!(SO3, 3, 4);
        $check!(SE2, 3, 4);
        $check!(SE3, 6, 7);
        $check!(SE23, 9, 10);
        $check!(SGal3, 10, 11);
        $check!(Sim2, 4, 5);
        $check!(Sim3, 7, 8);
        $check!(R3xSO3, 6, 7);
    };
}

fn bits<const N: usize>(numbers: [f64; N]) -> [u64; N] {
    numbers.map(f64::to_bits)
}

fn numbers<const N: usize>() -> impl Strategy<Value = SVector<f64, N>> {
    prop::collection::vec(-1.5..1.5_f64, N).prop_map(|x| SVector::from_column_slice(&x))
}

proptest! {
    #[test]
    fn an_array_comes_back_to_the_last_bit(tau in numbers::<10>()) {
        macro_rules! check {
            ($group:ty, $d:literal, $n:literal) => {{
                let x = <$group>::exp(&tau.fixed_rows::<$d>(0).into_owned());
                let array: [f64; $n] = x.to_array();
                prop_assert_eq!(bits(<$group>::from_array(array).unwrap().to_array()), bits(array));
                prop_assert_eq!(<$group>::from_array(array).unwrap(), x);
                let lengths: usize = <$group as Plain<$n>>::FIELDS.iter().map(|(_, n)| n).sum();
                prop_assert_eq!(lengths, $n);
            }};
        }
        every_group!(check);
    }

    #[test]
    fn products_without_end_stay_plain(tau in numbers::<6>()) {
        // Composition keeps unit norm within the bound that arrays are held to.
        let (step, mut x) = (SE3::exp(&tau), SE3::identity());
        for _ in 0..1000 {
            x *= step;
            prop_assert_eq!(SE3::check_array(&x.to_array()), Ok(()));
        }
    }
}

#[test]
fn the_order_of_the_numbers_is_the_documented_one() {
    let q = SO3::from_wxyz([0.5, -0.5, 0.5, 0.5]).unwrap();
    assert_eq!(q.to_array(), [-0.5, 0.5, 0.5, 0.5]);
    let (p, v) = (Vector3::new(1.0, 2.0, 3.0), Vector3::new(4.0, 5.0, 6.0));
    assert_eq!(SE3::new(q, p).to_array(), [1.0, 2.0, 3.0, -0.5, 0.5, 0.5, 0.5]);
    assert_eq!(SE23::new(q, p, v).to_array(), [1.0, 2.0, 3.0, -0.5, 0.5, 0.5, 0.5, 4.0, 5.0, 6.0]);
    assert_eq!(SGal3::new(q, p, v, 7.0).to_array(), [1.0, 2.0, 3.0, -0.5, 0.5, 0.5, 0.5, 4.0, 5.0, 6.0, 7.0]);
    assert_eq!(Sim3::new(q, p, 0.7).to_array(), [1.0, 2.0, 3.0, -0.5, 0.5, 0.5, 0.5, 0.7]);
    assert_eq!(R3xSO3::new(q, p).to_array(), [1.0, 2.0, 3.0, -0.5, 0.5, 0.5, 0.5]);
    let turn = SO2::from_cos_sin(0.6, 0.8).unwrap();
    assert_eq!(turn.to_array(), [0.6, 0.8]);
    assert_eq!(SE2::from_parts(Vector2::new(1.0, 2.0), turn).to_array(), [1.0, 2.0, 0.6, 0.8]);
    assert_eq!(Sim2::new(turn, Vector2::new(1.0, 2.0), 0.7).to_array(), [1.0, 2.0, 0.6, 0.8, 0.7]);
    assert_eq!(Rn::new(p).to_array(), [1.0, 2.0, 3.0]);
}

#[test]
fn an_array_that_is_no_element_is_refused_with_the_reason() {
    macro_rules! check {
        ($group:ty, $d:literal, $n:literal) => {{
            let good: [f64; $n] = some::<$group, $d>().to_array();
            for i in 0..$n {
                for bad in [f64::NAN, f64::INFINITY] {
                    let mut array = good;
                    array[i] = bad;
                    assert_eq!(<$group>::from_array(array), Err(LieError::NotFinite));
                    assert_eq!(<$group>::check_array(&array), Err(LieError::NotFinite));
                }
            }
        }};
    }
    every_group!(check);
    let long = SE3::from_array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.1]).unwrap_err();
    assert!(matches!(long, LieError::NotUnit { deviation } if (deviation - 0.21).abs() < 1e-12));
    assert!(long.to_string().contains("2.1e-1"), "{long}");
    assert!(matches!(SO2::from_array([0.0, 0.0]), Err(LieError::NotUnit { .. })));
    assert!(matches!(SO3::from_array([f64::MAX; 4]), Err(LieError::NotUnit { .. })));
}

#[test]
fn six_printed_digits_are_normalised() {
    let x = some::<SE3, 6>();
    let printed = x.to_array().map(|n| (n * 1e6).round() / 1e6);
    assert!(matches!(SE3::check_array(&printed), Err(LieError::NotUnit { .. })));
    let read = SE3::from_array(printed).unwrap();
    assert_eq!(SE3::check_array(&read.to_array()), Ok(()));
    assert!(read.is_near(&x, 2e-6));
    assert!(!read.is_near(&x, 1e-9));
}

#[test]
fn near_means_near_in_the_group() {
    let x = some::<SE3, 6>();
    let [a, b, c, i, j, k, w] = x.to_array();
    let negated = SE3::from_array([a, b, c, -i, -j, -k, -w]).unwrap();
    assert!(x.is_near(&negated, 1e-15));
    assert!(!SO2::from_angle(0.1).is_near(&SO2::from_angle(f64::NAN), f64::INFINITY));
}

#[test]
fn a_person_can_read_it() {
    let pose = SE3::from_array([1.0, 2.0, 3.25, 0.0, 0.0, 0.6, 0.8]).unwrap();
    assert_eq!(pose.to_string(), "SE3(translation [1.0, 2.0, 3.25], xyzw [0.0, 0.0, 0.6, 0.8])");
    assert_eq!(format!("{pose:.1}"), "SE3(translation [1.0, 2.0, 3.2], xyzw [0.0, 0.0, 0.6, 0.8])");
    assert_eq!(format!("{pose:?}"), "SE3 { translation: [1.0, 2.0, 3.25], xyzw: [0.0, 0.0, 0.6, 0.8] }");
    let scaled = Sim2::new(SO2::identity(), Vector2::new(1.0, 2.0), 0.5);
    assert_eq!(
        format!("{scaled:.2}"),
        "Sim2(translation [1.00, 2.00], cos_sin [1.00, 0.00], log_scale 0.50)"
    );
    assert_eq!(Rn::new(Vector2::new(1.0_f32, 0.1)).to_string(), "Rn([1.0, 0.1])");
    let pair = R3xSO3::from_pose(&SE3::<f64>::default());
    assert_eq!(format!("{pair:.0}"), "R3xSO3(translation Rn([0, 0, 0]), rotation SO3(xyzw [0, 0, 0, 1]))");
}

#[test]
fn generators_are_a_basis() {
    let tau = SVector::<f64, 6>::new(1.0, -2.0, 3.0, -4.0, 5.0, -6.0);
    let sum = SE3::<f64>::generators().iter().zip(tau.iter()).map(|(e, t)| e * *t).sum();
    assert_eq!(SE3::hat(&tau), sum);
}

#[cfg(feature = "bytemuck")]
mod slices {
    use super::*;
    use boxplus::lie::{PlainSlices, SliceError};

    #[test]
    fn a_slice_of_arrays_is_a_slice_of_elements_in_the_same_place() {
        macro_rules! check {
            (R3xSO3, $d:literal, $n:literal) => {}; // a bundle keeps its fields, not one array
            ($group:ty, $d:literal, $n:literal) => {{
                let arrays: Vec<[f64; $n]> = vec![some::<$group, $d>().to_array(); 3];
                let elements: &[$group] = <$group>::slice_from_arrays(&arrays).unwrap();
                assert_eq!(elements, [some::<$group, $d>(); 3]);
                assert_eq!(elements.as_ptr().cast::<f64>(), arrays.as_ptr().cast::<f64>());
                assert_eq!(<$group>::as_arrays(elements), arrays);
            }};
        }
        every_group!(check);
        let single = [[0.0_f32, 0.0, 0.0, 1.0]];
        assert_eq!(SO3::<f32>::slice_from_arrays(&single), Ok(&[SO3::identity()][..]));
    }

    #[test]
    fn the_first_array_that_is_no_element_is_named() {
        let mut arrays = vec![SE3::<f64>::identity().to_array(); 5];
        arrays[3][6] = 1.0 + 1e-6;
        arrays[4][0] = f64::NAN;
        let error: SliceError = SE3::slice_from_arrays(&arrays).unwrap_err();
        assert_eq!(error.index, 3);
        assert!(
            error.to_string().starts_with("element 3 (counted from 0): the rotation is not of unit norm")
        );
        assert_eq!(SE3::slice_from_arrays_mut(&mut arrays).unwrap_err(), error);
    }

    #[test]
    fn what_is_written_through_the_slice_is_in_the_arrays() {
        let mut arrays = [SE2::<f64>::identity().to_array(); 2];
        let step = SE2::new(Vector2::new(1.0, 0.0), 0.5);
        for pose in SE2::slice_from_arrays_mut(&mut arrays).unwrap() {
            *pose *= step;
        }
        assert_eq!(arrays, [step.to_array(); 2]);
    }

    #[test]
    fn an_empty_slice_is_a_slice() {
        assert_eq!(SE3::<f64>::slice_from_arrays(&[]), Ok(&[][..]));
    }
}

#[cfg(feature = "serde")]
mod serialised {
    use super::*;

    boxplus::bundle! {
        struct Rover { pose: SE3 [6], bias: Rn<3> [3], clock: Rn<1> [1] }
    }

    fn rover() -> Rover {
        let pose = SE3::from_array([1.0, 2.0, 3.0, 0.0, 0.0, 0.6, 0.8]).unwrap();
        Rover { pose, bias: Rn::new(Vector3::new(0.1, 0.2, 0.3)), clock: Rn::new([7.0].into()) }
    }

    const ROVER: &str =
        r#"{"pose":{"translation":[1.0,2.0,3.0],"xyzw":[0.0,0.0,0.6,0.8]},"bias":[0.1,0.2,0.3],"clock":7.0}"#;

    #[test]
    fn a_person_finds_names_and_the_bytes_are_golden() {
        assert_eq!(serde_json::to_string(&rover()).unwrap(), ROVER);
        assert_eq!(serde_json::from_str::<Rover>(ROVER).unwrap(), rover());
        let shuffled =
            r#"{"clock":7,"bias":[0.1,0.2,0.3],"pose":{"xyzw":[0,0,0.6,0.8],"translation":[1,2,3]}}"#;
        assert_eq!(serde_json::from_str::<Rover>(shuffled).unwrap(), rover());
        let text = serde_json::to_string(&SGal3::<f64>::identity()).unwrap();
        assert_eq!(
            text,
            r#"{"position":[0.0,0.0,0.0],"xyzw":[0.0,0.0,0.0,1.0],"velocity":[0.0,0.0,0.0],"time":0.0}"#
        );
        assert_eq!(serde_json::to_string(&SO2::<f32>::identity()).unwrap(), r#"{"cos_sin":[1.0,0.0]}"#);
    }

    #[test]
    fn a_binary_format_holds_the_numbers_and_nothing_else() {
        let bytes = postcard::to_allocvec(&rover()).unwrap();
        let numbers = [1.0, 2.0, 3.0, 0.0, 0.0, 0.6, 0.8, 0.1, 0.2, 0.3, 7.0_f64];
        assert_eq!(bytes, numbers.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<_>>());
        assert_eq!(postcard::from_bytes::<Rover>(&bytes).unwrap(), rover());
    }

    #[test]
    fn every_group_comes_back_from_text_and_from_bytes_to_the_last_bit() {
        macro_rules! check {
            ($group:ty, $d:literal, $n:literal) => {{
                let x = some::<$group, $d>();
                let text = serde_json::to_string(&x).unwrap();
                assert_eq!(
                    bits(serde_json::from_str::<$group>(&text).unwrap().to_array()),
                    bits(x.to_array())
                );
                let bytes = postcard::to_allocvec(&x).unwrap();
                assert_eq!(bytes.len(), 8 * $n);
                assert_eq!(
                    bits(postcard::from_bytes::<$group>(&bytes).unwrap().to_array()),
                    bits(x.to_array())
                );
            }};
        }
        every_group!(check);
    }

    #[test]
    fn what_is_no_element_is_refused_with_the_reason() {
        let refused = |text: &str| serde_json::from_str::<SE3>(text).unwrap_err().to_string();
        let not_unit = refused(r#"{"translation":[1,2,3],"xyzw":[0,0,1,1]}"#);
        assert!(not_unit.starts_with("SE3: the rotation is not of unit norm"), "{not_unit}");
        let missing = refused(r#"{"translation":[1,2,3]}"#);
        assert!(missing.starts_with("missing field `xyzw`"), "{missing}");
        let unknown = refused(r#"{"translation":[1,2,3],"wxyz":[1,0,0,0]}"#);
        assert!(unknown.starts_with("SE3 has no field `wxyz`"), "{unknown}");
        let twice = refused(r#"{"xyzw":[0,0,0,1],"xyzw":[0,0,0,1]}"#);
        assert!(twice.starts_with("duplicate field `xyzw`"), "{twice}");
        let short = refused(r#"{"xyzw":[0,0,1]}"#);
        assert!(short.starts_with("only 3 numbers where 4 are expected"), "{short}");
        let long = refused(r#"{"xyzw":[0,0,0,0,1]}"#);
        assert!(long.starts_with("at least 5 numbers where 4 are expected"), "{long}");
        let list = refused("[1,2,3,0,0,0,1]");
        assert!(list.contains("expected SE3 as a map of `translation` `xyzw`"), "{list}");
        let nan = postcard::to_allocvec(&[f64::NAN, 0.0, 0.0, 1.0]).unwrap();
        assert!(postcard::from_bytes::<SO3>(&nan).is_err());
        let field = serde_json::from_str::<Rover>(r#"{"speed":1}"#).unwrap_err().to_string();
        assert!(field.starts_with("Rover has no field `speed`"), "{field}");
    }
}
