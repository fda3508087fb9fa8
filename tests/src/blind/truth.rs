//! What is hidden in the experiments of a bench, as a file beside them that no diagnosis reads.

use std::fmt::Write;

use super::case::{Case, Limits};
use crate::twin::hidden;

/// The file.
pub const TRUTH: &str = "truth.csv";

const NAMES: &str = "experiment,seed,hidden,robbed,decoyed,laboratory,distance,visible";

/// What there is to say of a case.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth {
    /// The case.
    pub case: Case,
    /// Distance of what is hidden from its nearest, standard deviations, where that was foreseen.
    pub distance: Option<f64>,
    /// Whether it is large enough to be seen.
    pub is_visible: bool,
}

impl Truth {
    /// As it is foreseen.
    pub fn new(case: Case, limits: Option<Limits>) -> Self {
        let size = case.hidden.first().map_or(0.0, |(_, size)| *size);
        Self {
            distance: limits.map(|limits| limits.distance(size)),
            is_visible: limits.is_none_or(|limits| size >= limits.detectable_from),
            case,
        }
    }
}

/// The file of experiments and what is hidden in each.
pub fn text(all: &[(String, Truth)]) -> String {
    let mut text = NAMES.to_owned();
    for (file, Truth { case, distance, is_visible }) in all {
        let hidden: Vec<String> = case.hidden.iter().map(|(name, size)| format!("{name}={size:?}")).collect();
        let (hidden, seed) = (hidden.join(" + "), case.seed);
        let distance = distance.map_or(String::new(), |distance| format!("{distance:?}"));
        let _ = write!(
            text,
            "\n{file},{seed},{hidden},{},{},{},{distance},{is_visible}",
            case.is_robbed, case.is_decoyed, case.is_of_a_laboratory
        );
    }
    text + "\n"
}

/// What such a file says; or its line that says nothing.
/// # Errors
/// The number of the line, from one.
pub fn read(text: &str) -> Result<Vec<(String, Truth)>, usize> {
    if text.lines().next() != Some(NAMES) {
        return Err(1);
    }
    text.lines().enumerate().skip(1).map(|(k, line)| read_line(line).ok_or(k + 1)).collect()
}

fn read_line(line: &str) -> Option<(String, Truth)> {
    let cells: Vec<&str> = line.split(',').collect();
    let [file, seed, hidden, robbed, decoyed, laboratory, distance, visible] = cells[..] else { return None };
    let known = hidden::all(1.0).map(|(name, _)| name);
    let one = |text: &str| {
        let (name, size) = text.split_once('=')?;
        Some((*known.iter().find(|known| **known == name)?, size.parse().ok()?))
    };
    let hidden = hidden.split(" + ").filter(|text| !text.is_empty()).map(one).collect::<Option<_>>()?;
    let distance = if distance.is_empty() { None } else { Some(distance.parse().ok()?) };
    let case = Case {
        hidden,
        is_robbed: robbed.parse().ok()?,
        is_decoyed: decoyed.parse().ok()?,
        is_of_a_laboratory: laboratory.parse().ok()?,
        seed: seed.parse().ok()?,
    };
    Some((file.to_owned(), Truth { case, distance, is_visible: visible.parse().ok()? }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read() {
        let one = Truth {
            case: Case { is_robbed: true, ..Case::of("dahl", 0.1 + 0.2, 7) },
            distance: Some(1.0 / 3.0),
            is_visible: false,
        };
        let mut pair = Truth::new(Case::empty(8), None);
        pair.case.hidden = vec![("dahl", 1.0), ("sloshing", 2.0)];
        let all = vec![("a/experiment.toml".to_owned(), one), ("b/experiment.toml".to_owned(), pair)];
        assert_eq!(read(&text(&all)), Ok(all.clone()));
        assert_eq!(read(&text(&all).replace("dahl=1.0", "doll=1.0")), Err(3));
        assert_eq!(read(""), Err(1));
    }
}
