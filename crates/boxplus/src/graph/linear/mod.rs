//! The linear problem behind each step: assembled block by block, factorised sparse.

pub(crate) mod cholesky;
pub(crate) mod evaluate;
pub(crate) mod structure;
pub(crate) mod vector;
