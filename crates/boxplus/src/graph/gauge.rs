//! The gauge: relative measurements leave a whole connected part free to move; one of its variables is then held.

use super::set::{AnySet, Places};
use super::values::{Offsets, Values, VariableId};
use crate::partition::Partition;

/// Holds one variable in every connected part that has no held variable and whose factors are all relative.
///
/// The one held is the first pose of the largest kind, or the first of anything where there is no pose. Returns what was
/// held.
pub(crate) fn fix(sets: &[Box<dyn AnySet>], values: &mut Values) -> Vec<VariableId> {
    let mut held = vec![];
    for part in parts(sets, values).iter().filter(|part| !part.anchored) {
        let rank = |id: VariableId| (values.is_pose(id), values.dim(id));
        let highest = part.variables.iter().map(|&id| rank(id)).max();
        held.extend(part.variables.iter().find(|&&id| Some(rank(id)) == highest));
    }
    held.iter().for_each(|&id| values.set_held(id, true));
    held
}

/// Variables that hang together through factors.
pub(crate) struct Part {
    /// In the order of the values.
    pub(crate) variables: Vec<VariableId>,
    /// Whether something ties them to the world: a held variable, or a factor that is not relative.
    pub(crate) anchored: bool,
}

/// The connected parts of a graph, ordered by their first variables; those that no factor reads are left out.
pub(crate) fn parts(sets: &[Box<dyn AnySet>], values: &Values) -> Vec<Part> {
    let ids: Vec<VariableId> = values.ids().collect();
    let mut index = Offsets::none(values);
    ids.iter().enumerate().for_each(|(i, &id)| index.set(id, i));
    let mut partition = Partition::new(ids.len());
    let mut read = vec![false; ids.len()];
    let mut tied: Vec<bool> = ids.iter().map(|&id| values.is_held(id)).collect();
    for set in sets {
        let places = Places::new(set.as_ref(), &index);
        for factor in 0..set.len() {
            let mut first = None;
            for i in places.of(factor).flatten() {
                read[i] = true;
                tied[i] |= !set.is_relative();
                partition.join(*first.get_or_insert(i), i);
            }
        }
    }
    let mut parts: Vec<Part> = vec![];
    let mut part_of = vec![None; ids.len()];
    for i in (0..ids.len()).filter(|&i| read[i]) {
        let number = *part_of[partition.find(i)].get_or_insert_with(|| {
            parts.push(Part { variables: vec![], anchored: false });
            parts.len() - 1
        });
        parts[number].variables.push(ids[i]);
        parts[number].anchored |= tied[i];
    }
    parts
}
