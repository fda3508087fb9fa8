//! The known name that a misspelt one most likely meant, for error messages.

/// The candidate most like `name`, if any is like it enough to be worth offering.
///
/// Two names are alike enough if fewer than half of their letters differ, a swap of neighbours
/// counting once; of equals the first wins.
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let mut best = (0.5, None);
    let letters = name.chars().count();
    for candidate in candidates {
        // Too long or too short to be like it; the distance of a very long name takes much time and memory.
        if letters.abs_diff(candidate.chars().count()) > letters.max(candidate.len()) / 2 {
            continue;
        }
        let likeness = strsim::normalized_damerau_levenshtein(name, candidate);
        if likeness > best.0 {
            best = (likeness, Some(candidate));
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offers_the_misspelt_name_and_nothing_far_from_it() {
        let known = ["stretch", "bend", "gravity"];
        assert_eq!(nearest("gravtiy", known), Some("gravity"));
        assert_eq!(nearest("bned", known), Some("bend"));
        assert_eq!(nearest("friction", known), None);
    }
}
