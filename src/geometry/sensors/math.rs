//! Angles at compile time, where `core` has no trigonometry.

/// Thousandths of a degree in radians.
pub(super) const fn rad_of_mdeg(mdeg: i32) -> f64 {
    mdeg as f64 * (core::f64::consts::PI / 180_000.0)
}

/// Tangent of an angle in thousandths of a degree.
pub(super) const fn tan_mdeg(mdeg: i32) -> f64 {
    sin_mdeg(mdeg) / cos_mdeg(mdeg)
}

/// Sine of an angle in thousandths of a degree.
pub(super) const fn sin_mdeg(mdeg: i32) -> f64 {
    series(rad_of_mdeg(mdeg), 1)
}

/// Cosine of an angle in thousandths of a degree.
pub(super) const fn cos_mdeg(mdeg: i32) -> f64 {
    series(rad_of_mdeg(mdeg), 0)
}

/// Every second term of the exponential's series from the given power on, signs alternating:
/// exact to an f64's last bit or two below 90 degrees.
const fn series(x: f64, first_power: u32) -> f64 {
    let mut term = if first_power == 0 { 1.0 } else { x };
    let mut sum = term;
    let mut power = first_power;
    while power < 26 {
        power += 2;
        term *= -x * x / (power * (power - 1)) as f64;
        sum += term;
    }
    sum
}

#[cfg(all(test, feature = "std"))]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_std() {
        for mdeg in (-60_000..=60_000).step_by(17) {
            let rad = f64::from(mdeg) * (std::f64::consts::PI / 180_000.0);
            assert!((tan_mdeg(mdeg) - rad.tan()).abs() < 1e-14);
            assert!((sin_mdeg(mdeg) - rad.sin()).abs() < 1e-15);
            assert!((cos_mdeg(mdeg) - rad.cos()).abs() < 1e-15);
        }
    }
}
