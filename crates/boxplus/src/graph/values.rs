//! Values of variables: one contiguous array per kind, typed keys.

use core::any::{Any, TypeId};
use core::fmt;
use core::marker::PhantomData;

use super::GraphError;
use super::names::VariableName;
use super::variable::Variable;

/// Names one variable of type `V` in the [`Values`] that made it.
pub struct Key<V> {
    pub(crate) slot: u32,
    kind: PhantomData<fn() -> V>,
}

impl<V> Key<V> {
    pub(crate) fn new(slot: u32) -> Self {
        Self { slot, kind: PhantomData }
    }
}

// Written out: a derive would ask the same of V.
impl<V> Clone for Key<V> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<V> Copy for Key<V> {}
impl<V> PartialEq for Key<V> {
    fn eq(&self, other: &Self) -> bool {
        self.slot == other.slot
    }
}
impl<V> Eq for Key<V> {}
impl<V: Variable> fmt::Debug for Key<V> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} key {}", V::NAME, self.slot)
    }
}

/// A key without its type: what reports and errors hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct VariableId {
    pub(crate) kind: TypeId,
    pub(crate) slot: u32,
}

impl<V: Variable> From<Key<V>> for VariableId {
    fn from(key: Key<V>) -> Self {
        Self { kind: TypeId::of::<V>(), slot: key.slot }
    }
}

/// The estimate: every variable's value, and which of them are held.
///
/// ```
/// use boxplus::{graph::Values, lie::{LieGroup, SE2}};
/// let mut values = Values::new();
/// let start = values.insert(SE2::identity());
/// values.hold(start); // exactly fixed: it leaves the problem, no prior stands in for it
/// assert_eq!(values.get(start), Some(&SE2::identity()));
/// ```
#[derive(Default)]
pub struct Values {
    stores: Vec<Box<dyn AnyStore>>,
}

impl Clone for Values {
    fn clone(&self) -> Self {
        Self { stores: self.stores.iter().map(|store| store.boxed_clone()).collect() }
    }
}

impl fmt::Debug for Values {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_map().entries(self.stores.iter().map(|s| (s.name(), s.len()))).finish()
    }
}

impl Values {
    /// No variables.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a variable with its initial value; its label is the number of its key.
    pub fn insert<V: Variable>(&mut self, value: V) -> Key<V> {
        let label = self.len::<V>() as u64;
        self.push(Some(value), label)
    }

    /// Adds a variable under the id that its file gives it, for messages.
    pub fn insert_labelled<V: Variable>(&mut self, value: V, label: u64) -> Key<V> {
        self.push(Some(value), label)
    }

    /// Adds a variable that has no value yet. Initialisation gives it one; solving without is an error.
    pub fn declare<V: Variable>(&mut self, label: u64) -> Key<V> {
        self.push(None, label)
    }

    /// The key of a variable by its number among those of its kind, in the order of insertion; `None` where there are not so many.
    pub fn key<V: Variable>(&self, number: usize) -> Option<Key<V>> {
        (number < self.len::<V>()).then(|| Key::new(number as u32))
    }

    /// The value, or `None` where the variable is only declared or the key is foreign.
    pub fn get<V: Variable>(&self, key: Key<V>) -> Option<&V> {
        self.store::<V>()?.values.get(key.slot as usize)?.as_ref()
    }

    /// Sets the value of a variable.
    ///
    /// # Errors
    /// [`GraphError::ForeignKey`] where these values do not have the variable.
    pub fn set<V: Variable>(&mut self, key: Key<V>, value: V) -> Result<(), GraphError> {
        let cell = self.store_mut::<V>().values.get_mut(key.slot as usize);
        *cell.ok_or(GraphError::ForeignKey { kind: V::NAME, number: key.slot })? = Some(value);
        Ok(())
    }

    /// Holds a variable exactly at its value: it is a constant of the problem. Does nothing for a foreign key.
    pub fn hold<V: Variable>(&mut self, key: Key<V>) {
        self.set_held(key.into(), true);
    }

    /// Lets a held variable move again.
    pub fn release<V: Variable>(&mut self, key: Key<V>) {
        self.set_held(key.into(), false);
    }

    /// Whether the variable is held.
    pub fn is_held(&self, id: impl Into<VariableId>) -> bool {
        let id = id.into();
        self.any_store(id.kind).is_some_and(|store| store.held(id.slot))
    }

    /// Number of variables of one kind.
    pub fn len<V: Variable>(&self) -> usize {
        self.store::<V>().map_or(0, |store| store.values.len())
    }

    /// Number of variables of all kinds.
    pub fn total(&self) -> usize {
        self.stores.iter().map(|store| store.len()).sum()
    }

    /// Whether there is no variable at all.
    pub fn is_empty(&self) -> bool {
        self.total() == 0
    }

    /// Keys and values of one kind, in the order of insertion; `None` where only declared.
    pub fn iter<V: Variable>(&self) -> impl Iterator<Item = (Key<V>, Option<&V>)> {
        let values = self.store::<V>().map_or(&[][..], |store| &store.values);
        values.iter().enumerate().map(|(slot, value)| (Key::new(slot as u32), value.as_ref()))
    }

    /// Every variable of every kind.
    pub fn ids(&self) -> impl Iterator<Item = VariableId> {
        self.stores
            .iter()
            .flat_map(|store| (0..store.len() as u32).map(|slot| VariableId { kind: store.kind(), slot }))
    }

    /// What messages call a variable.
    pub fn name(&self, id: impl Into<VariableId>) -> VariableName {
        let id = id.into();
        match self.any_store(id.kind) {
            Some(store) => VariableName { kind: store.name(), label: store.label(id.slot) },
            None => VariableName { kind: "unknown kind", label: id.slot.into() },
        }
    }

    /// Dimension of a variable's tangent; 0 for a foreign one.
    pub(crate) fn dim(&self, id: VariableId) -> usize {
        self.any_store(id.kind).map_or(0, AnyStore::dim)
    }

    /// Whether holding the variable keeps a world in place.
    pub(crate) fn is_pose(&self, id: VariableId) -> bool {
        self.any_store(id.kind).is_some_and(AnyStore::is_pose)
    }

    /// Names of the coordinates of a variable's tangent.
    pub(crate) fn coordinates(&self, id: VariableId) -> &'static [&'static str] {
        self.any_store(id.kind).map_or(&[], |store| store.coordinates())
    }

    /// Whether the variable exists and has a finite value.
    pub(crate) fn state(&self, id: VariableId) -> Option<State> {
        self.states(id.kind)(id.slot)
    }

    /// As [`Self::state`], for many variables of one kind.
    pub(crate) fn states(&self, kind: TypeId) -> impl Fn(u32) -> Option<State> {
        let store = self.any_store(kind);
        move |slot| store.filter(|store| (slot as usize) < store.len()).map(|store| store.state(slot))
    }

    pub(crate) fn set_held(&mut self, id: VariableId, held: bool) {
        if let Some(store) = self.stores.iter_mut().find(|store| store.kind() == id.kind) {
            store.set_held(id.slot, held);
        }
    }

    /// All values of one kind, to be indexed by slot.
    pub(crate) fn slice<V: Variable>(&self) -> &[Option<V>] {
        self.store::<V>().map_or(&[], |store| &store.values)
    }

    /// Overwrites `target`, a clone of `self`, with `self ⊞ step`.
    pub(crate) fn retract_into(&self, target: &mut Values, step: &[f64], offsets: &Offsets) {
        for (from, to) in self.stores.iter().zip(&mut target.stores) {
            from.retract_into(to.as_mut(), step, offsets.of(from.kind()));
        }
    }

    fn push<V: Variable>(&mut self, value: Option<V>, label: u64) -> Key<V> {
        const { assert!(V::DIM > 0, "a variable without dimensions is a constant") };
        let store = self.store_mut::<V>();
        let slot = store.values.len() as u32;
        store.values.push(value);
        store.held.push(false);
        store.labels.push(label);
        Key::new(slot)
    }

    fn any_store(&self, kind: TypeId) -> Option<&dyn AnyStore> {
        self.stores.iter().find(|store| store.kind() == kind).map(AsRef::as_ref)
    }

    fn store<V: Variable>(&self) -> Option<&Store<V>> {
        self.any_store(TypeId::of::<V>())?.as_any().downcast_ref()
    }

    fn store_mut<V: Variable>(&mut self) -> &mut Store<V> {
        let position = self.stores.iter().position(|store| store.kind() == TypeId::of::<V>());
        let position = position.unwrap_or_else(|| {
            self.stores.push(Box::new(Store::<V> { values: vec![], held: vec![], labels: vec![] }));
            self.stores.len() - 1
        });
        match self.stores[position].as_any_mut().downcast_mut() {
            Some(store) => store,
            None => unreachable!("a store is found by the type it holds"),
        }
    }
}

/// Where the tangent of each variable stands in a vector of all free tangents.
#[derive(Clone, Debug, Default)]
pub(crate) struct Offsets {
    kinds: Vec<(TypeId, Vec<u32>)>,
}

impl Offsets {
    /// The mark of a variable that has no place: it is held, or nothing reads it.
    pub(crate) const NONE: u32 = u32::MAX;

    /// No variable of `values` has a place yet.
    pub(crate) fn none(values: &Values) -> Self {
        Self { kinds: values.stores.iter().map(|s| (s.kind(), vec![Self::NONE; s.len()])).collect() }
    }

    /// By slot, the offsets of one kind.
    pub(crate) fn of(&self, kind: TypeId) -> &[u32] {
        self.kinds.iter().find(|(of, _)| *of == kind).map_or(&[], |(_, offsets)| offsets)
    }

    pub(crate) fn get(&self, id: VariableId) -> Option<usize> {
        self.of(id.kind).get(id.slot as usize).filter(|&&offset| offset != Self::NONE).map(|&o| o as usize)
    }

    pub(crate) fn set(&mut self, id: VariableId, offset: usize) {
        if let Some((_, offsets)) = self.kinds.iter_mut().find(|(of, _)| *of == id.kind) {
            offsets[id.slot as usize] = offset as u32;
        }
    }
}

/// What is known of a variable's value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum State {
    Declared,
    NotFinite,
    Finite,
}

#[derive(Clone)]
struct Store<V> {
    values: Vec<Option<V>>,
    held: Vec<bool>,
    labels: Vec<u64>,
}

trait AnyStore: Any + Send + Sync {
    fn kind(&self) -> TypeId;
    fn name(&self) -> &'static str;
    fn dim(&self) -> usize;
    fn coordinates(&self) -> &'static [&'static str];
    fn is_pose(&self) -> bool;
    fn len(&self) -> usize;
    fn label(&self, slot: u32) -> u64;
    fn state(&self, slot: u32) -> State;
    fn held(&self, slot: u32) -> bool;
    fn set_held(&mut self, slot: u32, held: bool);
    fn retract_into(&self, target: &mut dyn AnyStore, step: &[f64], offsets: &[u32]);
    fn boxed_clone(&self) -> Box<dyn AnyStore>;
    fn as_any(&self) -> &dyn Any;
    fn as_any_mut(&mut self) -> &mut dyn Any;
}

impl<V: Variable> AnyStore for Store<V> {
    fn kind(&self) -> TypeId {
        TypeId::of::<V>()
    }
    fn name(&self) -> &'static str {
        V::NAME
    }
    fn dim(&self) -> usize {
        V::DIM
    }
    fn coordinates(&self) -> &'static [&'static str] {
        V::COORDINATES
    }
    fn is_pose(&self) -> bool {
        V::POSE
    }
    fn len(&self) -> usize {
        self.values.len()
    }
    fn label(&self, slot: u32) -> u64 {
        self.labels.get(slot as usize).copied().unwrap_or(slot.into())
    }
    fn state(&self, slot: u32) -> State {
        match self.values[slot as usize] {
            None => State::Declared,
            Some(value) if value.is_finite() => State::Finite,
            Some(_) => State::NotFinite,
        }
    }
    fn held(&self, slot: u32) -> bool {
        self.held.get(slot as usize).copied().unwrap_or(false)
    }
    fn set_held(&mut self, slot: u32, held: bool) {
        if let Some(flag) = self.held.get_mut(slot as usize) {
            *flag = held;
        }
    }
    fn retract_into(&self, target: &mut dyn AnyStore, step: &[f64], offsets: &[u32]) {
        let Some(target) = target.as_any_mut().downcast_mut::<Self>() else {
            unreachable!("the target is a clone of the source");
        };
        for ((from, to), &offset) in self.values.iter().zip(&mut target.values).zip(offsets) {
            *to = match from {
                Some(value) if offset != Offsets::NONE => {
                    Some(value.retract(&step[offset as usize..offset as usize + V::DIM]))
                }
                _ => *from,
            };
        }
    }
    fn boxed_clone(&self) -> Box<dyn AnyStore> {
        Box::new(self.clone())
    }
    fn as_any(&self) -> &dyn Any {
        self
    }
    fn as_any_mut(&mut self) -> &mut dyn Any {
        self
    }
}
