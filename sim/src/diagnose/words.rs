//! The answer in words.

use super::verdict::{Diagnosis, Verdict};

/// One paragraph for a person.
pub(super) fn summary(diagnosis: &Diagnosis) -> String {
    let names =
        || diagnosis.effects.iter().map(|added| added.effect.as_str()).collect::<Vec<_>>().join(" and ");
    match diagnosis.verdict {
        Verdict::NothingMissing => {
            "Nothing is missing that these recordings could show: no effect of the catalogue lowers the gap by more than noise does.".to_owned()
        }
        Verdict::Named => format!("{} is missing.", names()),
        Verdict::Class => {
            let others: Vec<_> = diagnosis.members.iter().map(|member| member.effect.as_str()).collect();
            format!("{} is missing, or what does the same to these recordings: {}.", names(), others.join(", "))
        }
        Verdict::Unknown => "Something is missing that the catalogue does not hold.".to_owned(),
    }
}
