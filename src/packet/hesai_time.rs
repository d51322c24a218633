//! The clock of Hesai's packets.

/// Nanoseconds in a second.
const SECOND_NS: u64 = 1_000_000_000;

/// Time since 1970 from a packet's six date bytes and its microseconds, and after how long that
/// clock starts again (0: never).
///
/// The year counts from 1900 (the manuals) or 2000 (Pandar40P captures). A sensor that never saw a
/// clock sends whatever it likes: then only the microseconds count.
pub(super) fn unix_ns(date: [u8; 6], micros: u32) -> (u64, u64) {
    let micros_ns = u64::from(micros) * 1000;
    match seconds_since_1970(date) {
        Some(seconds) => (seconds * SECOND_NS + micros_ns, 0),
        None => (micros_ns % SECOND_NS, SECOND_NS),
    }
}

fn seconds_since_1970([year, month, day, hour, minute, second]: [u8; 6]) -> Option<u64> {
    let valid = (1..=12).contains(&month) && (1..=31).contains(&day) && hour < 24 && minute < 60 && second < 61;
    if !valid {
        return None;
    }
    let year = u32::from(year) + if year >= 70 { 1900 } else { 2000 };
    let days = days_since_1970(year, u32::from(month), u32::from(day));
    let clock = (u64::from(hour) * 60 + u64::from(minute)) * 60 + u64::from(second);
    Some(u64::from(days) * 86_400 + clock)
}

/// Days from 1970-01-01, in the Gregorian calendar; years from 1970 on.
fn days_since_1970(year: u32, month: u32, day: u32) -> u32 {
    // Years that start in March put the leap day last.
    let (year, month) = if month > 2 { (year, month - 3) } else { (year - 1, month + 9) };
    let leap_days = year / 4 - year / 100 + year / 400;
    year * 365 + leap_days + (month * 153 + 2) / 5 + day - 719_469
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_count_from_1970() {
        assert_eq!(days_since_1970(1970, 1, 1), 0);
        assert_eq!(days_since_1970(2000, 2, 29), 11_016);
        assert_eq!(days_since_1970(2024, 3, 1), 19_783);
    }

    #[test]
    fn a_date_that_is_none_leaves_the_microseconds() {
        assert_eq!(unix_ns([0; 6], 250), (250_000, SECOND_NS));
        assert_eq!(unix_ns([70, 1, 1, 0, 0, 1], 250), (SECOND_NS + 250_000, 0));
    }
}
