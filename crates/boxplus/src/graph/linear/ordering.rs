//! Elimination orders that keep the factor sparse: approximate minimum degree.
//!
//! Eliminating a variable joins all its neighbours into a clique. The cliques are kept as *elements*, lists of the
//! variables they join, so that the graph never grows: a neighbour is reached directly or through an element. The next
//! variable to go is the one with the fewest scalars around it, counted through the elements without taking their overlaps
//! apart. Amestoy, Davis & Duff (1996), with degrees weighted by dimension: a landmark of two or three coordinates goes
//! before a pose of six, which leaves landmarks as the leaves of the elimination tree.

/// A list in the common store: elements first, then variables.
#[derive(Clone, Copy, Default)]
struct List {
    start: usize,
    elements: usize,
    len: usize,
}

/// No variable.
const NONE: u32 = u32::MAX;

/// Quotient graph of a partial elimination. A variable stands for itself and for those found to have the same neighbours.
struct Quotient {
    store: Vec<u32>,
    lists: Vec<List>,
    /// Scalars of each variable with its likes; 0 once it is eliminated or found like another.
    weight: Vec<usize>,
    /// Scalars joined by each element, 0 for a dead one or a variable.
    joined: Vec<usize>,
    /// The next of the variables that go together.
    next: Vec<u32>,
    last: Vec<u32>,
    degrees: Degrees,
    /// Marks of the variables of the element being made.
    inside: Vec<u32>,
    round: u32,
    /// Scalars of an element outside the one being made, and the round in which that was found.
    outside: Vec<(u32, usize)>,
    /// The members of the element being made that stay: hash, variable, degree outside.
    kept: Vec<(u64, u32, usize)>,
    /// Variables that count as neighbours but are not to be eliminated.
    held: Vec<bool>,
}

/// An order of elimination of variables with these dimensions, joined by `pairs` (each once in either direction, loops
/// ignored), that leaves little fill. Those of `last` go last, in this order.
pub(crate) fn minimum_degree(dims: &[usize], pairs: &[(u32, u32)], last: &[u32]) -> Vec<u32> {
    let mut graph = Quotient::new(dims, pairs);
    let mut order = Vec::with_capacity(dims.len());
    last.iter().for_each(|&variable| graph.hold(variable));
    let dense = graph.set_dense_aside(pairs);
    while let Some(pivot) = graph.degrees.pop_least() {
        graph.eliminate(pivot as usize);
        graph.emit(pivot, &mut order);
    }
    for variable in dense {
        graph.emit(variable, &mut order);
    }
    order.extend(last);
    order
}

impl Quotient {
    fn new(dims: &[usize], pairs: &[(u32, u32)]) -> Self {
        let count = dims.len();
        let mut lists = vec![List::default(); count];
        let joining = || pairs.iter().filter(|(a, b)| a != b);
        for &(a, b) in joining() {
            lists[a as usize].len += 1;
            lists[b as usize].len += 1;
        }
        let mut start = 0;
        for list in &mut lists {
            list.start = start;
            start += core::mem::take(&mut list.len);
        }
        let mut store = vec![0; start];
        store.reserve(start); // for the elements
        for &(a, b) in joining() {
            for (one, other) in [(a, b), (b, a)] {
                let list = &mut lists[one as usize];
                store[list.start + list.len] = other;
                list.len += 1;
            }
        }
        let mut degrees = Degrees::new(count, dims.iter().sum());
        for (variable, list) in lists.iter().enumerate() {
            let neighbours = &store[list.start..list.start + list.len];
            degrees.insert(variable as u32, neighbours.iter().map(|&j| dims[j as usize]).sum());
        }
        Self {
            store,
            lists,
            weight: dims.to_vec(),
            joined: vec![0; count],
            next: vec![NONE; count],
            last: (0..count as u32).collect(),
            degrees,
            inside: vec![0; count],
            round: 0,
            outside: vec![(0, 0); count],
            kept: vec![],
            held: vec![false; count],
        }
    }

    fn hold(&mut self, variable: u32) {
        self.degrees.remove(variable);
        self.held[variable as usize] = true;
    }

    /// Takes variables with very many neighbours out of the graph, to be eliminated last: they would be looked at in every
    /// step, and end up last anyway.
    fn set_dense_aside(&mut self, pairs: &[(u32, u32)]) -> Vec<u32> {
        let count = self.lists.len();
        let many = (10 * count.isqrt()).max(16);
        let is_dense = |&i: &u32| self.lists[i as usize].len > many && !self.held[i as usize];
        let dense: Vec<u32> = (0..count as u32).filter(is_dense).collect();
        for &variable in &dense {
            self.degrees.remove(variable);
            self.weight[variable as usize] = 0;
        }
        if !dense.is_empty() {
            let weight = |i: u32| self.weight[i as usize];
            let mut lighter = vec![0; count];
            for &(a, b) in pairs.iter().filter(|(a, b)| a != b) {
                lighter[a as usize] += weight(b);
                lighter[b as usize] += weight(a);
            }
            let listed = |&i: &u32| weight(i) > 0 && !self.held[i as usize];
            for variable in (0..count as u32).filter(listed) {
                self.degrees.remove(variable);
                self.degrees.insert(variable, lighter[variable as usize]);
            }
        }
        dense
    }

    /// Appends a variable and those that go with it.
    fn emit(&self, variable: u32, order: &mut Vec<u32>) {
        let mut at = variable;
        while at != NONE {
            order.push(at);
            at = self.next[at as usize];
        }
    }

    /// Lets `other` go together with `variable`.
    fn join(&mut self, variable: usize, other: usize) {
        self.weight[variable] += core::mem::take(&mut self.weight[other]);
        self.next[self.last[variable] as usize] = other as u32;
        self.last[variable] = self.last[other];
    }

    /// Makes the pivot an element and updates the variables that it joins.
    fn eliminate(&mut self, pivot: usize) {
        self.round += 1;
        let element = self.gather(pivot);
        let members = element.start..element.start + element.len;
        self.measure_overlaps(members.clone());
        let mut kept = core::mem::take(&mut self.kept);
        let mut size = self.joined[pivot];
        for k in members {
            let variable = self.store[k] as usize;
            let (hash, degree) = self.prune(variable, pivot as u32);
            if degree == 0 && !self.held[variable] {
                // It has no other neighbours: it goes in the same front, without fill.
                size -= self.weight[variable];
                self.join(pivot, variable);
                self.weight[pivot] = 0;
            } else {
                kept.push((hash, variable as u32, degree));
            }
        }
        self.joined[pivot] = size;
        self.join_alike(&mut kept);
        let mut end = element.start;
        for &(_, variable, degree) in &kept {
            let weight = self.weight[variable as usize];
            if weight == 0 {
                continue;
            }
            let old = self.degrees.of(variable);
            if !self.held[variable as usize] {
                self.degrees.insert(variable, old.min(degree) + size - weight);
            }
            self.store[end] = variable;
            end += 1;
        }
        self.lists[pivot] = List { start: element.start, elements: 0, len: end - element.start };
        self.store.truncate(end); // the element is the last list in the store
        kept.clear();
        self.kept = kept;
    }

    /// The variables around a pivot, in a list at the end of the store; the pivot's own elements are absorbed.
    fn gather(&mut self, pivot: usize) -> List {
        let List { start, elements, len } = self.lists[pivot];
        self.weight[pivot] = 0;
        let begin = self.store.len();
        let mut size = 0;
        let round = self.round;
        for k in (start..start + len).rev() {
            let neighbour = self.store[k] as usize;
            let List { start: from, len, .. } = self.lists[neighbour];
            let range = if k < start + elements {
                if core::mem::take(&mut self.joined[neighbour]) == 0 {
                    continue;
                }
                from..from + len
            } else {
                k..k + 1
            };
            for at in range {
                let variable = self.store[at];
                let weight = self.weight[variable as usize];
                if weight > 0 && self.inside[variable as usize] != round {
                    self.inside[variable as usize] = round;
                    size += weight;
                    self.store.push(variable);
                    if !self.held[variable as usize] {
                        self.degrees.remove(variable);
                    }
                }
            }
        }
        self.joined[pivot] = size;
        List { start: begin, elements: 0, len: self.store.len() - begin }
    }

    /// Finds for each element around the members how much of it lies outside.
    fn measure_overlaps(&mut self, members: core::ops::Range<usize>) {
        for k in members {
            let variable = self.store[k] as usize;
            let List { start, elements, .. } = self.lists[variable];
            for &element in &self.store[start..start + elements] {
                let joined = self.joined[element as usize];
                let (round, outside) = &mut self.outside[element as usize];
                if *round != self.round {
                    (*round, *outside) = (self.round, joined);
                }
                *outside = outside.saturating_sub(self.weight[variable]);
            }
        }
    }

    /// Rewrites the list of a member: `pivot` stands for everything inside. Returns a hash of the list and the scalars around
    /// it that lie outside.
    fn prune(&mut self, variable: usize, pivot: u32) -> (u64, usize) {
        let List { start, elements, len } = self.lists[variable];
        let (mut degree, mut hash, mut end) = (0, u64::from(pivot), start);
        for k in start..start + elements {
            let element = self.store[k];
            if self.joined[element as usize] == 0 {
                continue;
            }
            let outside = self.outside[element as usize].1;
            if outside == 0 {
                self.joined[element as usize] = 0; // it lies inside
                continue;
            }
            degree += outside;
            hash += u64::from(element);
            self.store[end] = element;
            end += 1;
        }
        let kept = end - start;
        // Something was dropped, an element or the pivot itself among the variables: there is room for one more. The
        // first variable makes way for it.
        let mut first = None;
        if kept == elements {
            first = Some(self.store[end]);
        }
        let begin = end;
        end += 1;
        let mut keep = |graph: &mut Self, neighbour: u32| {
            let weight = graph.weight[neighbour as usize];
            if weight > 0 && graph.inside[neighbour as usize] != graph.round {
                degree += weight;
                hash += u64::from(neighbour);
                graph.store[end] = neighbour;
                end += 1;
            }
        };
        let variables = start + elements + usize::from(first.is_some())..start + len;
        for k in variables {
            let neighbour = self.store[k];
            keep(self, neighbour);
        }
        if let Some(first) = first {
            keep(self, first);
        }
        self.store[begin] = pivot;
        self.lists[variable] = List { start, elements: kept + 1, len: end - start };
        (hash, degree)
    }

    /// Joins the members that have the same neighbours.
    fn join_alike(&mut self, kept: &mut [(u64, u32, usize)]) {
        kept.sort_unstable();
        for first in 0..kept.len() {
            let (hash, variable, _) = kept[first];
            if self.weight[variable as usize] == 0 {
                continue;
            }
            let mut marked = false;
            for &(_, other, _) in kept[first + 1..].iter().take_while(|(h, ..)| *h == hash) {
                let (a, b) = (self.lists[variable as usize], self.lists[other as usize]);
                let alike = (a.elements, a.len) == (b.elements, b.len)
                    && self.held[variable as usize] == self.held[other as usize];
                if self.weight[other as usize] == 0 || !alike {
                    continue;
                }
                if !marked {
                    self.round += 1;
                    for &entry in &self.store[a.start..a.start + a.len] {
                        self.inside[entry as usize] = self.round;
                    }
                    marked = true;
                }
                let entries = &self.store[b.start..b.start + b.len];
                if entries.iter().all(|&entry| self.inside[entry as usize] == self.round) {
                    self.join(variable as usize, other as usize);
                }
            }
        }
    }
}

/// Variables by degree, in buckets that are chained both ways.
struct Degrees {
    heads: Vec<u32>,
    next: Vec<u32>,
    previous: Vec<u32>,
    degree: Vec<usize>,
    least: usize,
}

impl Degrees {
    fn new(count: usize, largest: usize) -> Self {
        Self {
            heads: vec![NONE; largest + 1],
            next: vec![NONE; count],
            previous: vec![NONE; count],
            degree: vec![0; count],
            least: 0,
        }
    }

    fn of(&self, variable: u32) -> usize {
        self.degree[variable as usize]
    }

    fn insert(&mut self, variable: u32, degree: usize) {
        let degree = degree.min(self.heads.len() - 1);
        let head = core::mem::replace(&mut self.heads[degree], variable);
        self.next[variable as usize] = head;
        self.previous[variable as usize] = NONE;
        if head != NONE {
            self.previous[head as usize] = variable;
        }
        self.degree[variable as usize] = degree;
        self.least = self.least.min(degree);
    }

    fn remove(&mut self, variable: u32) {
        let (next, previous) = (self.next[variable as usize], self.previous[variable as usize]);
        if next != NONE {
            self.previous[next as usize] = previous;
        }
        if previous == NONE {
            self.heads[self.degree[variable as usize]] = next;
        } else {
            self.next[previous as usize] = next;
        }
    }

    /// Takes out a variable of the least degree.
    fn pop_least(&mut self) -> Option<u32> {
        let offset = self.heads[self.least..].iter().position(|&head| head != NONE)?;
        self.least += offset;
        let variable = self.heads[self.least];
        self.remove(variable);
        Some(variable)
    }
}
