//! Time as names and marks give it.

use std::time::{SystemTime, UNIX_EPOCH};

/// Time as `20260131T235959Z`, which sorts as it reads; before 1970, which only a clock that was never set shows,
/// the beginning of that year.
pub fn utc(time: SystemTime) -> String {
    let seconds = time.duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    let (days, second) = (seconds / 86_400, seconds % 86_400);
    let [year, month, day] = calendar(days);
    let [hour, minute, second] = [second / 3600, second / 60 % 60, second % 60];
    format!("{year:04}{month:02}{day:02}T{hour:02}{minute:02}{second:02}Z")
}

/// Year, month and day of a number of days after 1 January 1970.
///
/// The year begins in March, so that the leap day is its last.
/// Source: Hinnant, chrono-compatible low-level date algorithms, `civil_from_days`.
fn calendar(days: u64) -> [u64; 3] {
    let days = days + 719_468;
    let (era, of_era) = (days / 146_097, days % 146_097);
    let year_of_era = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let march_month = (5 * of_year + 2) / 153;
    let day = of_year - (153 * march_month + 2) / 5 + 1;
    let month = if march_month < 10 { march_month + 3 } else { march_month - 9 };
    [era * 400 + year_of_era + u64::from(month <= 2), month, day]
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn the_calendar_knows_its_leap_days() {
        for (days, date) in [
            (0, [1970, 1, 1]),
            (58, [1970, 2, 28]),
            (59, [1970, 3, 1]),
            (11_016, [2000, 2, 29]),
            (20_454, [2026, 1, 1]),
        ] {
            assert_eq!(calendar(days), date, "{days}");
        }
    }

    #[test]
    fn a_clock_that_was_never_set_is_no_reason_to_stop() {
        assert_eq!(utc(UNIX_EPOCH - Duration::from_secs(86_400)), "19700101T000000Z");
        assert_eq!(utc(UNIX_EPOCH + Duration::from_secs(1_709_251_199)), "20240229T235959Z");
    }
}
