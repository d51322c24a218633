//! Written by `examples/train_priors.rs`.
pub(super) static SMALL: &[u8; 359] = &[128; 359];
pub(super) static DENSE: &[i8; 1728] = &[0; 1728];
