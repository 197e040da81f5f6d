//! Every group passes the public law suite in `f64` and `f32`: one line each.
#![allow(missing_docs, clippy::unwrap_used)]

use boxplus::lie::{LieGroup, Rn, SE2, SE3, SO2, SO3, laws};

macro_rules! laws {
    ($($name:ident: $group:ty, $d:literal, $n:literal;)*) => { $(
        mod $name {
            use super::*;
            type Single = <$group as LieGroup<$d>>::Over<f32>;

            #[test]
            fn is_a_lie_group_in_f64() {
                laws::check_group::<$group, $d>().unwrap();
            }
            #[test]
            fn is_a_lie_group_in_f32() {
                laws::check_group::<Single, $d>().unwrap();
            }
            #[test]
            fn acts_on_points_in_f64_and_f32() {
                laws::check_action::<$group, $d, $n>().unwrap();
                laws::check_action::<Single, $d, $n>().unwrap();
            }
        }
    )* };
}

laws! {
    rn: Rn<3>, 3, 3;
    so2: SO2, 1, 2;
    se2: SE2, 3, 2;
    so3: SO3, 3, 3;
    se3: SE3, 6, 3;
}
