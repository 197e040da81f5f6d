//! Recorded sensors: what was measured and when, filters that go through it, and how right they were.

mod course;
mod log;
mod score;
mod sensors;
mod timeline;

pub use course::{Course, Fates, Track, part_of};
pub use log::{Log, Oddity, Stamped, seconds};
pub use score::{Judged, Score};
pub use sensors::{ImuReading, Landmark, NavigationState, Sighted, Twist2};
pub use timeline::{Event, timeline};
