//! Serialisation of every group and bundle (feature `serde`).
//!
//! In formats for people (JSON, TOML) an element is a map of the names of [`Plain::FIELDS`], so that no reader
//! has to guess the order of a quaternion: `{"translation":[1.0,2.0,3.0],"xyzw":[0.0,0.0,0.6,0.8]}`; an element of ℝⁿ is
//! its list of numbers. In binary formats it is the tuple of [`Plain::to_array`], without names or
//! lengths. A bundle is a struct of its fields in both. Reading checks as
//! [`Plain::from_array`] does: what is not finite, or no rotation, is an error of the format with
//! the reason of [`LieError`](super::LieError).

use super::groups::every_plain;
use super::{Plain, Real, Rn, RxSO2, RxSO3, S3, SE2, SE3, SE23, SGal3, SO2, SO3, Sim2, Sim3};
use core::fmt::Formatter;
use core::marker::PhantomData;
use serde_core::de::{Deserialize, DeserializeSeed, Deserializer, Error, MapAccess, SeqAccess, Visitor};
use serde_core::ser::{Serialize, SerializeStruct, SerializeTuple, Serializer};

/// A run of numbers as a tuple; one number as itself.
struct Numbers<'a, S>(&'a [S]);

impl<S: Serialize> Serialize for Numbers<'_, S> {
    fn serialize<T: Serializer>(&self, serializer: T) -> Result<T::Ok, T::Error> {
        if let [number] = self.0 {
            return number.serialize(serializer);
        }
        let mut tuple = serializer.serialize_tuple(self.0.len())?;
        self.0.iter().try_for_each(|x| tuple.serialize_element(x))?;
        tuple.end()
    }
}

fn serialize<G: Plain<N>, T: Serializer, const N: usize>(x: &G, serializer: T) -> Result<T::Ok, T::Error>
where
    G::Number: Serialize,
{
    let numbers = x.to_array();
    if !serializer.is_human_readable() || is_bare::<G, N>() {
        return Numbers(&numbers).serialize(serializer);
    }
    let mut map = serializer.serialize_struct(G::NAME, G::FIELDS.len())?;
    let mut rest = numbers.as_slice();
    for (name, length) in G::FIELDS {
        let (part, after) = rest.split_at_checked(*length).unwrap_or((rest, &[]));
        map.serialize_field(name, &Numbers(part))?;
        rest = after;
    }
    map.end()
}

/// Whether the numbers need no name.
fn is_bare<G: Plain<N>, const N: usize>() -> bool {
    matches!(G::FIELDS, [("", _)])
}

/// Reads numbers into a slice, exactly as many.
struct NumbersInto<'a, S>(&'a mut [S]);

impl<'de, S: Deserialize<'de>> DeserializeSeed<'de> for NumbersInto<'_, S> {
    type Value = ();
    fn deserialize<T: Deserializer<'de>>(self, deserializer: T) -> Result<(), T::Error> {
        if let [number] = self.0 {
            *number = S::deserialize(deserializer)?;
            return Ok(());
        }
        deserializer.deserialize_tuple(self.0.len(), self)
    }
}

impl<'de, S: Deserialize<'de>> Visitor<'de> for NumbersInto<'_, S> {
    type Value = ();
    fn expecting(&self, f: &mut Formatter<'_>) -> core::fmt::Result {
        write!(f, "a list of {} numbers", self.0.len())
    }
    fn visit_seq<A: SeqAccess<'de>>(self, mut sequence: A) -> Result<(), A::Error> {
        let length = self.0.len();
        for (i, place) in self.0.iter_mut().enumerate() {
            *place = sequence.next_element()?.ok_or_else(|| wrong_length(i, length))?;
        }
        match sequence.next_element::<S>()? {
            Some(_) => Err(wrong_length(length + 1, length)),
            None => Ok(()),
        }
    }
}

fn wrong_length<E: Error>(found: usize, expected: usize) -> E {
    let order = if found > expected { "at least " } else { "only " };
    E::custom(format_args!("{order}{found} numbers where {expected} are expected"))
}

/// The place of a field name among those of a type.
#[doc(hidden)]
pub struct FieldName<F>(pub &'static str, pub F);

impl<'de, F: Fn(&str) -> Option<usize>> DeserializeSeed<'de> for FieldName<F> {
    type Value = usize;
    fn deserialize<T: Deserializer<'de>>(self, deserializer: T) -> Result<usize, T::Error> {
        deserializer.deserialize_identifier(self)
    }
}

impl<F: Fn(&str) -> Option<usize>> Visitor<'_> for FieldName<F> {
    type Value = usize;
    fn expecting(&self, f: &mut Formatter<'_>) -> core::fmt::Result {
        write!(f, "the name of a field of {}", self.0)
    }
    fn visit_str<E: Error>(self, name: &str) -> Result<usize, E> {
        (self.1)(name).ok_or_else(|| E::custom(format_args!("{} has no field `{name}`", self.0)))
    }
}

/// The parts of an element, by name and in any order, or all its numbers.
struct Parts<G, const N: usize>(PhantomData<G>);

impl<'de, G: Plain<N>, const N: usize> Visitor<'de> for Parts<G, N>
where
    G::Number: Deserialize<'de>,
{
    type Value = [G::Number; N];
    fn expecting(&self, f: &mut Formatter<'_>) -> core::fmt::Result {
        write!(f, "{} as a map of", G::NAME)?;
        G::FIELDS.iter().try_for_each(|(name, _)| write!(f, " `{name}`"))
    }
    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
        let (mut numbers, mut seen) = ([Real::lit(0.0); N], [false; N]);
        let place = |name: &str| G::FIELDS.iter().position(|(field, _)| *field == name);
        while let Some(i) = map.next_key_seed(FieldName(G::NAME, place))? {
            let (name, length) = G::FIELDS[i];
            if seen[i] {
                return Err(A::Error::duplicate_field(name));
            }
            seen[i] = true;
            let start: usize = G::FIELDS[..i].iter().map(|(_, n)| n).sum();
            map.next_value_seed(NumbersInto(&mut numbers[start..start + length]))?;
        }
        match G::FIELDS.iter().zip(seen).find(|(_, seen)| !seen) {
            Some(((name, _), _)) => Err(A::Error::missing_field(name)),
            None => Ok(numbers),
        }
    }
}

fn deserialize<'de, G: Plain<N>, T: Deserializer<'de>, const N: usize>(deserializer: T) -> Result<G, T::Error>
where
    G::Number: Deserialize<'de>,
{
    let numbers = if !deserializer.is_human_readable() || is_bare::<G, N>() {
        let mut numbers = [Real::lit(0.0); N];
        NumbersInto(&mut numbers).deserialize(deserializer)?;
        numbers
    } else {
        deserializer.deserialize_struct(G::NAME, &[], Parts::<G, N>(PhantomData))?
    };
    G::from_array(numbers).map_err(|reason| T::Error::custom(format_args!("{}: {reason}", G::NAME)))
}

macro_rules! serialize {
    ($($(const $m:ident,)? $group:ty, $n:expr;)*) => { $(
        impl<$(const $m: usize,)? S: Real + Serialize> Serialize for $group {
            fn serialize<T: Serializer>(&self, serializer: T) -> Result<T::Ok, T::Error> {
                serialize::<Self, T, { $n }>(self, serializer)
            }
        }
        impl<'de, $(const $m: usize,)? S: Real + Deserialize<'de>> Deserialize<'de> for $group {
            fn deserialize<T: Deserializer<'de>>(deserializer: T) -> Result<Self, T::Error> {
                deserialize::<Self, T, { $n }>(deserializer)
            }
        }
    )* };
}

every_plain!(serialize);

#[doc(hidden)]
pub use serde_core;

/// Serialisation of a bundle, a struct of its fields.
#[doc(hidden)]
#[macro_export]
macro_rules! __bundle_serialize {
    ($name:ident, $($field:ident: ($group:ty)),+) => {
        const _: () = {
            use $crate::lie::serialize::{FieldName, serde_core};
            use $crate::lie::Real;
            use serde_core::de::{Deserialize, Deserializer, Error, MapAccess, SeqAccess, Visitor};
            use serde_core::ser::{Serialize, SerializeStruct, Serializer};

            const NAME: &str = stringify!($name);
            const FIELDS: &[&str] = &[$(stringify!($field)),+];

            impl<S: Real> Serialize for $name<S>
            where
                $($group: Serialize,)+
            {
                fn serialize<T: Serializer>(&self, serializer: T) -> Result<T::Ok, T::Error> {
                    let mut map = serializer.serialize_struct(NAME, FIELDS.len())?;
                    $(map.serialize_field(stringify!($field), &self.$field)?;)+
                    map.end()
                }
            }

            struct Fields<S>(core::marker::PhantomData<S>);

            impl<'de, S: Real> Visitor<'de> for Fields<S>
            where
                $($group: Deserialize<'de>,)+
            {
                type Value = $name<S>;
                fn expecting(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                    f.write_str(NAME)
                }
                fn visit_seq<A: SeqAccess<'de>>(self, mut sequence: A) -> Result<$name<S>, A::Error> {
                    Ok($name {
                        $($field: sequence.next_element()?
                            .ok_or_else(|| A::Error::missing_field(stringify!($field)))?,)+
                    })
                }
                fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<$name<S>, A::Error> {
                    $(let mut $field = None;)+
                    let place = |name: &str| FIELDS.iter().position(|field| *field == name);
                    while let Some(i) = map.next_key_seed(FieldName(NAME, place))? {
                        $(if FIELDS[i] == stringify!($field) {
                            if $field.is_some() {
                                return Err(A::Error::duplicate_field(stringify!($field)));
                            }
                            $field = Some(map.next_value()?);
                        })+
                    }
                    Ok($name {
                        $($field: $field.ok_or_else(|| A::Error::missing_field(stringify!($field)))?,)+
                    })
                }
            }

            impl<'de, S: Real> Deserialize<'de> for $name<S>
            where
                $($group: Deserialize<'de>,)+
            {
                fn deserialize<T: Deserializer<'de>>(deserializer: T) -> Result<Self, T::Error> {
                    deserializer.deserialize_struct(NAME, FIELDS, Fields(core::marker::PhantomData))
                }
            }
        };
    };
}
