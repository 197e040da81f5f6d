//! The gauge: relative measurements leave a whole connected part free to move; one of its variables is then held.

use super::VariableName;
use super::factor::AnySet;
use super::values::{Offsets, State, Values, VariableId};

/// Holds one variable in every connected part that has no held variable and whose factors are all relative.
///
/// The one held is the first of the largest kind (a pose rather than a landmark). Returns what was held.
pub(crate) fn fix(sets: &[Box<dyn AnySet>], values: &mut Values) -> Vec<VariableId> {
    let parts = Parts::new(sets, values);
    let mut best: Vec<Option<VariableId>> = vec![None; parts.ids.len()];
    for (i, &id) in parts.ids.iter().enumerate().filter(|&(i, _)| parts.read[i]) {
        let best = &mut best[parts.root(i)];
        if best.is_none_or(|held| values.dim(id) > values.dim(held)) {
            *best = Some(id);
        }
    }
    let held: Vec<_> = best
        .iter()
        .enumerate()
        .filter(|&(root, _)| !parts.anchored[root])
        .filter_map(|(_, &id)| id)
        .collect();
    held.iter().for_each(|&id| values.set_held(id, true));
    held
}

/// The connected parts of a graph.
pub(crate) struct Parts {
    /// Every variable.
    pub(crate) ids: Vec<VariableId>,
    parent: Vec<usize>,
    /// By root: whether something ties the part to the world.
    pub(crate) anchored: Vec<bool>,
    /// By variable: whether a factor reads it.
    pub(crate) read: Vec<bool>,
}

impl Parts {
    pub(crate) fn new(sets: &[Box<dyn AnySet>], values: &Values) -> Self {
        let ids: Vec<VariableId> = values.ids().collect();
        let mut index = Offsets::none(values);
        ids.iter().enumerate().for_each(|(i, &id)| index.set(id, i));
        let count = ids.len();
        let mut parts = Self {
            ids,
            parent: (0..count).collect(),
            anchored: vec![false; count],
            read: vec![false; count],
        };
        let mut ties = vec![];
        for set in sets {
            for factor in 0..set.len() {
                let members: Vec<usize> = set.ids(factor).iter().filter_map(|&id| index.get(id)).collect();
                members.iter().for_each(|&i| parts.read[i] = true);
                members.windows(2).for_each(|pair| parts.join(pair[0], pair[1]));
                if !set.is_relative() {
                    ties.extend(members.first());
                }
            }
        }
        ties.extend((0..count).filter(|&i| values.is_held(parts.ids[i])));
        for i in ties {
            let root = parts.root(i);
            parts.anchored[root] = true;
        }
        parts
    }

    /// The names of the variables that are read, part by part.
    pub(crate) fn named(&self, values: &Values) -> Vec<Vec<VariableName>> {
        let mut parts: Vec<Vec<VariableName>> = vec![vec![]; self.ids.len()];
        for i in (0..self.ids.len()).filter(|&i| self.read[i]) {
            parts[self.root(i)].push(values.name(self.ids[i]));
        }
        parts.retain(|part| !part.is_empty());
        parts
    }

    pub(crate) fn root(&self, mut i: usize) -> usize {
        while self.parent[i] != i {
            i = self.parent[i];
        }
        i
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root_halving(a), self.root_halving(b));
        // The earlier variable stays the root, so that parts are numbered as the file numbers them.
        self.parent[a.max(b)] = a.min(b);
    }

    fn root_halving(&mut self, mut i: usize) -> usize {
        while self.parent[i] != i {
            self.parent[i] = self.parent[self.parent[i]];
            i = self.parent[i];
        }
        i
    }
}

/// Variables that some factor reads and whose value is not finite or missing.
pub(crate) fn faulty(sets: &[Box<dyn AnySet>], values: &Values) -> Vec<(VariableId, State)> {
    let parts = Parts::new(sets, values);
    let read = parts.ids.iter().zip(&parts.read).filter(|(_, read)| **read);
    read.filter_map(|(&id, _)| values.state(id).filter(|&s| s != State::Finite).map(|s| (id, s))).collect()
}
