//! Coders made for range images: columns in the order in which the sensor fires, each pixel predicted from what its
//! beam saw last, every decision coded with the probability that its neighborhood gave it so far.
//!
//! ```text
//! image ──> column ──> residual ──> model ──────────> range coder ──> bytes
//!           levels,    steps off    small: counts      decisions
//!           sets of    prediction   dense: sums of
//!           returns                 logits
//! ```
//!
//! What they share stands here once: the column ([`column`]), closed-loop quantization ([`step`]), the arithmetic coder
//! of both adaptive tiers ([`range_coder`]).

pub(crate) mod column;
pub(crate) mod range_coder;
pub(crate) mod step;

pub use step::Step;
