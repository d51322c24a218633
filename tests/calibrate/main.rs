//! `calibrate` finds a sensor's grid from point clouds alone, or says why there is none.
#![cfg(feature = "std")]

mod made_up;
mod recover;
mod refuse;
