//! The hot loops, and the few machine instructions that core has no stable name for.

mod sqrt;
mod uniform;

pub(crate) use sqrt::sqrt;
pub(crate) use uniform::project_uniform;
