//! The linear problem behind each step: assembled block by block, factorised front by front.

pub(crate) mod analyses;
pub(crate) mod cholesky;
mod dissection;
pub(crate) mod evaluate;
pub(crate) mod kernels;
mod ordering;
pub(crate) mod pattern;
mod plan;
mod selected_inverse;
pub(crate) mod structure;
mod symbolic;
pub(crate) mod vector;

#[cfg(test)]
pub(crate) mod oracle;
#[cfg(test)]
mod tests;
