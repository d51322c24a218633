//! The hot loops, and the few machine instructions that core has no stable name for.

mod convert;
mod lattice;
#[cfg(not(target_arch = "arm"))]
mod lookups;
mod sqrt;
mod uniform;

pub(crate) use convert::{to_angle, to_index};
pub(crate) use lattice::{miss_lattice, place_on_row, project_lattice};
#[cfg(not(target_arch = "arm"))]
pub(crate) use lookups::Lookups;
pub(crate) use sqrt::sqrt;
pub(crate) use uniform::project_uniform;
