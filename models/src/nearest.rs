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

/// The candidates that `name` may mean: those that have it as one of their words, parted by `_`, or else the nearest.
pub fn alike<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str> + Clone) -> Vec<&'a str> {
    let has = |candidate: &&str| candidate.split('_').any(|word| word == name);
    let own: Vec<&str> = candidates.clone().into_iter().filter(has).collect();
    if own.is_empty() { nearest(name, candidates).into_iter().collect() } else { own }
}

/// A question that offers candidates, such as "; did you mean `a`, `b` or `c`?"; nothing where there are none.
pub fn offer<'a>(candidates: impl IntoIterator<Item = &'a str>) -> String {
    let quoted: Vec<String> = candidates.into_iter().map(|candidate| format!("`{candidate}`")).collect();
    match &quoted[..] {
        [] => String::new(),
        [only] => format!("; did you mean {only}?"),
        [before @ .., last] => format!("; did you mean {} or {last}?", before.join(", ")),
    }
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

    #[test]
    fn a_word_of_several_names_offers_all_of_them() {
        let known = ["air_drag", "bend", "tip_drag", "dragged"];
        assert_eq!(alike("drag", known), ["air_drag", "tip_drag"]);
        assert_eq!(alike("bned", known), ["bend"]);
        assert_eq!(offer(alike("drag", known)), "; did you mean `air_drag` or `tip_drag`?");
        assert_eq!(offer(["a", "b", "c"]), "; did you mean `a`, `b` or `c`?");
        assert_eq!(offer(alike("friction", known)), "");
    }
}
