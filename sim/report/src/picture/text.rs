//! Text cut to the room that it has, and numbers of ticks.

/// Text of that many letters at most, its end cut off where it is longer.
pub fn shortened(text: &str, most: usize) -> String {
    if text.chars().count() > most {
        text.chars().take(most.saturating_sub(1)).chain(['…']).collect()
    } else {
        text.to_owned()
    }
}

/// Lines of that many letters at most, broken between words.
pub fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let line = lines.last_mut().expect("there is always one");
        if !line.is_empty() && line.chars().count() + 1 + word.chars().count() > width {
            lines.push(word.to_owned());
        } else {
            line.push_str(if line.is_empty() { "" } else { " " });
            line.push_str(word);
        }
    }
    lines
}

/// A tick's number: no more digits than it has, a true minus, no sign on zero.
pub fn tick(value: f64) -> String {
    let text = format!("{:.6}", value);
    match text.trim_end_matches('0').trim_end_matches('.') {
        "-0" => "0".to_owned(),
        text => text.replace('-', "\u{2212}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_keeps_to_its_room() {
        assert_eq!(
            (shortened("abcdef", 6), shortened("abcdefg", 6)),
            ("abcdef".to_owned(), "abcde…".to_owned())
        );
        assert_eq!(wrapped("one two three", 7), ["one two", "three"]);
    }

    #[test]
    fn ticks_have_a_true_minus_and_no_signed_zero() {
        for (value, text) in
            [(-0.0, "0"), (-1e-12, "0"), (-150.0, "−150"), (0.30000000000000004, "0.3"), (20.0, "20")]
        {
            assert_eq!(tick(value), text);
        }
    }
}
