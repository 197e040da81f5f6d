use crate::{args::{Global, Solve}, error::{Error, Outcome}, output::Console};
pub fn run(_o: &Solve, _g: &Global, _c: Console) -> Result<Outcome, Error> { Ok(Outcome::Done) }
