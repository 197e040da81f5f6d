//! The drawings of the boxplus command line, for its examples.
#![allow(unreachable_pub, reason = "inside, `pub` is what other modules use")]

pub mod draw;
pub mod text;
