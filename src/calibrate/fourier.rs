//! Finding a period: the fast Fourier transform and what reads its peaks.

use std::vec;
use std::vec::Vec;

use core::f64::consts::TAU;

/// A complex number: real, imaginary.
pub(super) type Complex = [f64; 2];

/// Transforms in place with the kernel `exp(+2 pi i j k / n)`; `n` a power of two.
///
/// Radix 2, as the three spectra that a calibration takes need no faster one.
pub(super) fn transform(values: &mut [Complex]) {
    let len = values.len();
    debug_assert!(len.is_power_of_two());
    reorder(values);
    let roots: Vec<Complex> = (0..len / 2).map(|k| unit(TAU * k as f64 / len as f64)).collect();
    let mut half = 1;
    while half < len {
        let stride = len / (2 * half);
        for block in values.chunks_exact_mut(2 * half) {
            let (low, high) = block.split_at_mut(half);
            for (k, (a, b)) in low.iter_mut().zip(high).enumerate() {
                let turned = product(*b, roots[k * stride]);
                *b = [a[0] - turned[0], a[1] - turned[1]];
                *a = [a[0] + turned[0], a[1] + turned[1]];
            }
        }
        half *= 2;
    }
}

fn reorder(values: &mut [Complex]) {
    let len = values.len();
    let bits = len.trailing_zeros();
    for index in 1..len {
        let mirror = index.reverse_bits() >> (usize::BITS - bits);
        if index < mirror {
            values.swap(index, mirror);
        }
    }
}

/// `exp(i angle)`.
pub(super) fn unit(angle: f64) -> Complex {
    let (sin, cos) = angle.sin_cos();
    [cos, sin]
}

fn product(a: Complex, b: Complex) -> Complex {
    [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]]
}

/// Weighted values on a circle of one turn, from which every whole frequency's coherence follows.
pub(super) struct Circle {
    bins: Vec<Complex>,
    weight: f64,
}

impl Circle {
    /// An empty circle of `bins` bins, a power of two at least eight times the
    /// highest frequency that will be asked for.
    pub(super) fn new(bins: usize) -> Self {
        Self { bins: vec![[0.0; 2]; bins], weight: 0.0 }
    }

    /// Adds a value; `turn` is taken modulo 1 and shared between the two nearest bins.
    pub(super) fn add(&mut self, turn: f64, weight: f64) {
        let len = self.bins.len();
        let place = turn.rem_euclid(1.0) * len as f64;
        let (bin, share) = (place as usize, place.fract());
        self.bins[bin % len][0] += weight * (1.0 - share);
        self.bins[(bin + 1) % len][0] += weight * share;
        self.weight += weight;
    }

    /// Mean of `cos(2 pi k turn)` for each k below `len`: 1 where all values are multiples of 1/k.
    pub(super) fn coherence(mut self, len: usize) -> Vec<f64> {
        transform(&mut self.bins);
        let scale = if self.weight > 0.0 { 1.0 / self.weight } else { 0.0 };
        // Sharing between two bins lowers high frequencies a little. That stays, as it
        // helps to tell the fundamental from harmonics that are as good.
        self.bins.iter().take(len).map(|value| value[0] * scale).collect()
    }
}

/// The fundamental in a coherence spectrum: the lowest peak that is about as high as the highest.
///
/// Noise lowers harmonics and never raises them; without noise all are equal.
/// `tolerance` is the share by which a peak may be lower than the highest.
/// `None` if nothing stands out from `from` on.
pub(super) fn fundamental(coherence: &[f64], from: usize, tolerance: f64) -> Option<usize> {
    let highest = coherence.get(from..)?.iter().copied().fold(0.0, f64::max);
    let mut at =
        (from..coherence.len()).find(|&k| coherence[k] > 0.0 && coherence[k] >= highest - tolerance * highest)?;
    // Values that lie close together make broad peaks: climb.
    while at + 1 < coherence.len() && coherence[at + 1] > coherence[at] {
        at += 1;
    }
    Some(at)
}
