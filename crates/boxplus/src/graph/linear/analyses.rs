//! Analyses shared by problems that join the same variables.

use std::sync::{Arc, Mutex};

use super::symbolic::Symbolic;

/// The last analysis of a graph. The first estimate, every optimisation and the marginals of one graph mostly join the same
/// variables: they are ordered once.
#[derive(Debug, Default)]
pub(crate) struct Analyses(Mutex<Option<Analysis>>);

#[derive(Debug)]
struct Analysis {
    dims: Vec<usize>,
    pairs: Vec<(u32, u32)>,
    symbolic: Arc<Symbolic>,
}

impl Analyses {
    /// The analysis of variables with these dimensions, joined by `pairs`, made now or kept from before: a function of the
    /// arguments alone.
    pub(crate) fn of(&self, dims: &[usize], pairs: &[(u32, u32)]) -> Arc<Symbolic> {
        // A thread that panicked while it held the lock has left nothing half done.
        let mut last = self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if let Some(known) = last.as_ref().filter(|known| known.dims == dims && known.pairs == pairs) {
            return Arc::clone(&known.symbolic);
        }
        let symbolic = Arc::new(Symbolic::new(dims, pairs));
        let (dims, pairs) = (dims.to_vec(), pairs.to_vec());
        *last = Some(Analysis { dims, pairs, symbolic: Arc::clone(&symbolic) });
        symbolic
    }
}
