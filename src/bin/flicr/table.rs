//! Numbers for people: grouped digits, medians, aligned columns.

use std::fmt::Write;

/// `1234567` as `1,234,567`.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (at, digit) in digits.char_indices() {
        if at > 0 && (digits.len() - at).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// The middle value, or the mean of the two in the middle; NaN of none.
pub fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    match values.get(middle.saturating_sub(1)..=middle) {
        Some(&[low, high]) if values.len().is_multiple_of(2) => f64::midpoint(low, high),
        Some(&[.., high]) => high,
        _ => f64::NAN,
    }
}

/// Lines of cells under their headings; the first column to the left, all others to the right.
pub fn aligned(headings: &[&str], lines: &[Vec<String>]) -> String {
    let cells = |column: usize| lines.iter().filter_map(move |line| line.get(column));
    let widths: Vec<usize> = (headings.iter().enumerate())
        .map(|(column, heading)| {
            cells(column).map(|cell| cell.chars().count()).fold(heading.chars().count(), usize::max)
        })
        .collect();
    let headings: Vec<String> = headings.iter().map(|&heading| heading.to_owned()).collect();
    std::iter::once(&headings).chain(lines).map(|line| aligned_line(line, &widths)).collect::<Vec<_>>().join("\n")
}

fn aligned_line(cells: &[String], widths: &[usize]) -> String {
    let mut text = String::new();
    for (column, (cell, &width)) in cells.iter().zip(widths).enumerate() {
        // Writing to a string cannot fail.
        let _ = if column == 0 { write!(text, "{cell:width$}") } else { write!(text, "  {cell:>width$}") };
    }
    text
}

#[cfg(test)]
mod tests {
    use super::{grouped, median};

    #[test]
    fn digits_are_grouped_by_three() {
        let texts = [0, 12, 999, 1000, 123_456, 1_234_567].map(grouped);
        assert_eq!(texts, ["0", "12", "999", "1,000", "123,456", "1,234,567"]);
    }

    #[test]
    fn a_median_is_in_the_middle() {
        let of = |values: &[f64]| median(values.iter().copied());
        assert_eq!(of(&[3.0]), 3.0);
        assert_eq!(of(&[3.0, 1.0]), 2.0);
        assert_eq!(of(&[3.0, 1.0, 10.0]), 3.0);
        assert_eq!(of(&[4.0, 3.0, 1.0, 10.0]), 3.5);
        assert!(of(&[]).is_nan());
    }
}
