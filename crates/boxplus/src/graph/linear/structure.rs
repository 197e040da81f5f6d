//! The normal equations JᵀJ δ = −Jᵀr as a block-sparse lower triangle, laid out once and refilled every iteration.
//!
//! No Jacobian matrix is formed. Each pair of variables that a factor joins has one block in the triangle; a factor's
//! part of JᵀJ is added there, at an offset found beforehand. Variables stand in elimination order, worked out on the graph
//! of variables, not of scalars, so that the factorisation permutes nothing.

use super::analyses::Analyses;
use super::pattern::Pattern;
use crate::graph::GraphError;
use crate::graph::set::{AnySet, Places};
use crate::graph::values::{Offsets, Values, VariableId};

/// The matrix JᵀJ (its lower triangle, by the blocks of [`Structure::pattern`]) and the vector Jᵀr.
#[derive(Clone, Debug)]
pub(crate) struct Normal {
    pub(crate) matrix: Vec<f64>,
    pub(crate) gradient: Vec<f64>,
}

/// Where everything stands in the normal equations.
#[derive(Clone, Debug)]
pub(crate) struct Structure {
    /// The free variables in elimination order.
    pub(crate) variables: Vec<VariableId>,
    /// First scalar of each, by variable.
    pub(crate) offsets: Offsets,
    pub(crate) pattern: Pattern,
    /// Position of each diagonal entry in the matrix.
    pub(crate) diagonal: Vec<usize>,
    /// Free variables that no factor reads.
    pub(crate) unread: Vec<VariableId>,
    pub(crate) plans: Vec<SetPlan>,
}

/// Where each factor of a set adds its part.
#[derive(Clone, Debug)]
pub(crate) struct SetPlan {
    /// Offset of each variable of each factor in the gradient.
    gradients: Vec<u32>,
    blocks: Vec<Place>,
}

/// Where one block stands: its first number, and how a factor's block becomes it.
#[derive(Clone, Copy, Debug)]
struct Place {
    at: u32,
    kind: PlaceKind,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum PlaceKind {
    /// A held variable: nothing is added.
    Nowhere,
    /// Rows of the later variable of the factor, columns of the earlier one; or a diagonal block.
    AsIs,
    Transposed,
    /// Both variables of the pair are one and the same: B + Bᵀ goes to its diagonal block.
    Twice,
}

impl Structure {
    /// Orders the free variables of the sets and lays out the matrix.
    ///
    /// # Errors
    /// [`GraphError::OutOfMemory`] beyond 2³² numbers in the triangle.
    pub(crate) fn new(
        sets: &[Box<dyn AnySet>],
        values: &Values,
        analyses: &Analyses,
    ) -> Result<Self, GraphError> {
        let free: Vec<VariableId> = values.ids().filter(|&id| !values.is_held(id)).collect();
        let mut index = Offsets::none(values);
        free.iter().enumerate().for_each(|(i, &id)| index.set(id, i));
        let mut read = vec![false; free.len()];
        let mut pairs = pairs_of_variables(sets, &index, &mut read);

        // What nothing reads takes no part; the others move up.
        let (mut known, mut unread, mut moved) = (vec![], vec![], vec![0; free.len()]);
        for (i, &id) in free.iter().enumerate() {
            moved[i] = known.len() as u32;
            if read[i] { known.push(id) } else { unread.push(id) }
        }
        for (a, b) in &mut pairs {
            (*a, *b) = (moved[*a as usize], moved[*b as usize]);
        }
        let pairs = sorted(pairs, known.len());
        let dims: Vec<usize> = known.iter().map(|&id| values.dim(id)).collect();
        let pattern = Pattern::lay_out(analyses.of(&dims, &pairs), &dims, &pairs)?;

        let variables: Vec<VariableId> = pattern.symbolic.order.iter().map(|&i| known[i as usize]).collect();
        let (mut position, mut offsets) = (Offsets::none(values), Offsets::none(values));
        for (i, &id) in variables.iter().enumerate() {
            position.set(id, i);
            offsets.set(id, pattern.starts[i]);
        }
        let plans = sets.iter().map(|set| SetPlan::new(set.as_ref(), &pattern, &position)).collect();
        Ok(Self { variables, offsets, diagonal: pattern.diagonal(), pattern, unread, plans })
    }

    /// Number of unknown scalars.
    pub(crate) fn size(&self) -> usize {
        self.diagonal.len()
    }

    /// The free variable to which a scalar belongs, with the number of its coordinate.
    pub(crate) fn coordinate(&self, scalar: usize) -> (VariableId, usize) {
        let place = self.pattern.place_of(scalar);
        (self.variables[place], scalar - self.pattern.starts[place])
    }

    /// Zeroed normal equations.
    pub(crate) fn normal(&self) -> Normal {
        Normal { matrix: vec![0.0; self.pattern.len()], gradient: vec![0.0; self.size()] }
    }
}

/// Every pair a < b of free variables that some factor joins, as often as it does; marks those that are read.
fn pairs_of_variables(sets: &[Box<dyn AnySet>], index: &Offsets, read: &mut [bool]) -> Vec<(u32, u32)> {
    let mut pairs = vec![];
    for set in sets {
        let places = Places::new(set.as_ref(), index);
        for factor in 0..set.len() {
            let free = || places.of(factor).flatten().map(|i| i as u32);
            for (q, b) in free().enumerate() {
                read[b as usize] = true;
                pairs.extend(free().take(q).filter(|&a| a != b).map(|a| (a.min(b), a.max(b))));
            }
        }
    }
    pairs
}

/// The pairs (a, b), a < `count`, sorted and each once: by buckets of a, which are small.
pub(crate) fn sorted(pairs: Vec<(u32, u32)>, count: usize) -> Vec<(u32, u32)> {
    let mut starts = vec![0; count + 1];
    pairs.iter().for_each(|&(a, _)| starts[a as usize + 1] += 1);
    (0..count).for_each(|i| starts[i + 1] += starts[i]);
    let mut next = starts.clone();
    let mut sorted = vec![(0, 0); pairs.len()];
    for pair in pairs {
        sorted[next[pair.0 as usize]] = pair;
        next[pair.0 as usize] += 1;
    }
    (0..count).for_each(|i| sorted[starts[i]..starts[i + 1]].sort_unstable());
    sorted.dedup();
    sorted
}

impl SetPlan {
    fn new(set: &dyn AnySet, pattern: &Pattern, position: &Offsets) -> Self {
        let (count, arity) = (set.len(), set.dims().len());
        let mut plan = Self {
            gradients: Vec::with_capacity(count * arity),
            blocks: Vec::with_capacity(count * arity * (arity + 1) / 2),
        };
        let places = Places::new(set, position);
        for factor in 0..count {
            let positions = || places.of(factor).enumerate();
            let offset = |place: Option<usize>| place.map_or(Offsets::NONE, |p| pattern.starts[p] as u32);
            plan.gradients.extend(positions().map(|(_, place)| offset(place)));
            for (q, b) in positions() {
                plan.blocks.extend(positions().take(q + 1).map(|(p, a)| Place::new(pattern, a, b, p == q)));
            }
        }
        plan
    }

    /// Adds the part of one factor: its gradients, then its blocks Jᵀ_q J_p for p ≤ q, column by column.
    #[inline(always)]
    pub(crate) fn scatter(&self, factor: usize, dims: &[usize], part: &[f64], normal: &mut Normal) {
        let mut at = 0;
        for (i, &dim) in dims.iter().enumerate() {
            let offset = self.gradients[factor * dims.len() + i];
            if offset != Offsets::NONE {
                let target = &mut normal.gradient[offset as usize..offset as usize + dim];
                target.iter_mut().zip(&part[at..at + dim]).for_each(|(t, x)| *t += x);
            }
            at += dim;
        }
        let pairs = dims.len() * (dims.len() + 1) / 2;
        let mut places = self.blocks[factor * pairs..(factor + 1) * pairs].iter();
        for q in 0..dims.len() {
            for p in 0..=q {
                let block = &part[at..at + dims[p] * dims[q]];
                if let Some(place) = places.next() {
                    place.add(dims[q], dims[p], block, &mut normal.matrix);
                }
                at += dims[p] * dims[q];
            }
        }
    }
}

impl Place {
    /// The place of the block with the rows of `b` and the columns of `a`, which are `same` if they are one variable of the
    /// factor, not two that happen to be one.
    fn new(pattern: &Pattern, a: Option<usize>, b: Option<usize>, same: bool) -> Self {
        let nowhere = Self { at: 0, kind: PlaceKind::Nowhere };
        let (Some(a), Some(b)) = (a, b) else { return nowhere };
        let kind = match (a == b, same) {
            (true, false) => PlaceKind::Twice,
            _ if a <= b => PlaceKind::AsIs,
            _ => PlaceKind::Transposed,
        };
        pattern.find(a.max(b), a.min(b)).map_or(nowhere, |at| Self { at: at as u32, kind })
    }

    #[inline(always)]
    fn add(self, rows: usize, columns: usize, block: &[f64], matrix: &mut [f64]) {
        if self.kind == PlaceKind::Nowhere {
            return;
        }
        let target = &mut matrix[self.at as usize..][..rows * columns];
        if self.kind != PlaceKind::Transposed {
            target.iter_mut().zip(block).for_each(|(t, x)| *t += x);
        }
        if self.kind != PlaceKind::AsIs {
            for c in 0..rows {
                for r in 0..columns {
                    target[c * columns + r] += block[r * rows + c];
                }
            }
        }
    }
}
