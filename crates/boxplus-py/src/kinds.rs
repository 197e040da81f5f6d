//! Which groups there are, with their numbers, for the tables that hold something for each.

use boxplus::lie::Rn;

pub(crate) type R1 = Rn<1>;
pub(crate) type R2 = Rn<2>;
pub(crate) type R3 = Rn<3>;
pub(crate) type R4 = Rn<4>;
pub(crate) type R5 = Rn<5>;
pub(crate) type R6 = Rn<6>;

/// Hands the groups that beliefs are of to the macro `$give`: type, D, N, P as in [`Group`](crate::groups::Group).
macro_rules! each_group {
    ($give:ident, $module:ident) => {
        $give! { $module;
            SO2 1 2 2
            SO3 3 4 3
            SE2 3 4 2
            SE3 6 7 3
            SE23 9 10 3
            SGal3 10 11 4
            Sim2 4 5 2
            Sim3 7 8 3
            R1 1 1 1
            R2 2 2 2
            R3 3 3 3
            R4 4 4 4
        }
    };
}

pub(crate) use each_group;

/// Calls a function with the group of a name: its type, dimension, and count of stored numbers.
macro_rules! of_group {
    ($kind:expr, $function:ident($($argument:expr),*)) => {
        of_group!(@ $kind, $function($($argument),*);
            SO2 1 2, SO3 3 4, SE2 3 4, SE3 6 7, SE23 9 10, SGal3 10 11, Sim2 4 5, Sim3 7 8,
            R1 1 1, R2 2 2, R3 3 3, R4 4 4, R5 5 5, R6 6 6)
    };
    (@ $kind:expr, $function:ident $arguments:tt; $($group:ident $d:literal $n:literal),*) => {
        match $kind {
            $(stringify!($group) => of_group!(@ $function $group $d $n $arguments),)*
            kind => Err(PyTypeError::new_err(format!("a graph has no variables of the kind {kind}"))),
        }
    };
    (@ $function:ident $group:ident $d:literal $n:literal ($($argument:expr),*)) => {
        $function::<$group, $d, $n>($($argument),*)
    };
}

pub(crate) use of_group;
