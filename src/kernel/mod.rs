//! The hot loops, and the few machine instructions that core has no stable name for.

mod convert;
mod sqrt;
mod uniform;

pub(crate) use convert::to_index;
pub(crate) use sqrt::sqrt;
pub(crate) use uniform::project_uniform;
