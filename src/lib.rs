//! flicr: a LiDAR codec for the device the sensor hangs on.
#![cfg_attr(not(feature = "std"), no_std)]
#![deny(unsafe_code)]
