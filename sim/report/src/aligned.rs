//! Tables as a terminal shows them. The door to comfy-table.

use std::fmt;

use comfy_table::{CellAlignment, ColumnConstraint, ContentArrangement, Row, Table, Width, presets};

/// Letters of a line: no table is wider unless its numbers alone are.
const WIDTH: u16 = 80;
/// Letters between two columns.
const GAP: u16 = 2;
/// Letters that a column of words keeps at least, if it has as many.
const LEAST: u16 = 16;
/// Letters of a word, such as a key, that is never broken, at most.
const WHOLE: usize = 40;

/// How the cells of a column are aligned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// On the left; what is long goes on in the next line.
    Words,
    /// On the left, in one line.
    Name,
    /// On the right, in one line.
    Number,
}

/// A table whose columns never touch.
///
/// ```
/// use efam_report::aligned::{Aligned, Side};
///
/// let mut table = Aligned::new(&[("", Side::Words), ("tip x", Side::Number)]);
/// table.row(["release-15psi", "143.2 mm"]);
/// assert_eq!(table.to_string(), "                  tip x\nrelease-15psi  143.2 mm\n");
/// ```
pub struct Aligned {
    sides: Vec<Side>,
    table: Table,
    indent: u16,
    widths: Option<Vec<u16>>,
    /// Letters of the longest word of each column.
    longest: Vec<u16>,
}

impl Aligned {
    /// A table with these heads; without a line for them where all are empty.
    pub fn new(heads: &[(&str, Side)]) -> Self {
        let mut table = Table::new();
        table.load_preset(presets::NOTHING).set_content_arrangement(ContentArrangement::Dynamic);
        if heads.iter().any(|head| !head.0.is_empty()) {
            table.set_header(heads.iter().map(|head| head.0));
        }
        let longest = heads.iter().map(|head| longest_word(head.0)).collect();
        Self { sides: heads.iter().map(|head| head.1).collect(), table, indent: 0, widths: None, longest }
    }

    /// With so many spaces before each line.
    pub fn indented(self, indent: u16) -> Self {
        Self { indent, ..self }
    }

    /// With columns of these widths, gaps included, so that several tables have the same.
    pub fn with_widths(self, widths: &[u16]) -> Self {
        Self { widths: Some(widths.to_vec()), ..self }
    }

    /// One more row; cells that it lacks are empty.
    pub fn row<T: ToString>(&mut self, cells: impl IntoIterator<Item = T>) {
        let cells: Vec<String> = cells.into_iter().map(|own| own.to_string()).collect();
        for (longest, cell) in self.longest.iter_mut().zip(&cells) {
            *longest = longest_word(cell).max(*longest);
        }
        self.table.add_row(Row::from(cells));
    }

    /// Whether it has no rows.
    pub fn is_empty(&self) -> bool {
        self.table.is_empty()
    }

    /// The table as comfy-table sets it.
    fn set(&self) -> Table {
        let mut table = self.table.clone();
        table.discover_columns();
        let of_content = table.column_max_content_widths();
        let last = self.sides.len().saturating_sub(1);
        let gap = |k: usize| if k == last { 0 } else { GAP };
        let needed = |(k, (side, content)): (usize, (&Side, &u16))| match side {
            Side::Words => (*content).min(LEAST.max(self.longest[k])) + gap(k),
            _ => content.saturating_add(gap(k)),
        };
        let needed: Vec<u16> = self.sides.iter().zip(&of_content).enumerate().map(needed).collect();
        let all = needed.iter().fold(0, |sum: u16, own| sum.saturating_add(*own));
        let given = self.widths.iter().flatten().fold(0, |sum: u16, own| sum.saturating_add(*own));
        table.set_width(all.max(given).max(WIDTH.saturating_sub(self.indent)));
        for (k, column) in table.column_iter_mut().enumerate() {
            column.set_padding((0, gap(k)));
            let side = self.sides.get(k).copied().unwrap_or(Side::Words);
            if side == Side::Number {
                column.set_cell_alignment(CellAlignment::Right);
            }
            match self.widths.as_ref().and_then(|widths| widths.get(k)) {
                Some(width) => {
                    column.set_constraint(ColumnConstraint::Absolute(Width::Fixed(*width)));
                }
                None if side != Side::Words => {
                    column.set_constraint(ColumnConstraint::ContentWidth);
                }
                None => {
                    if let Some(needed) = needed.get(k) {
                        column.set_constraint(ColumnConstraint::LowerBoundary(Width::Fixed(*needed)));
                    }
                }
            }
        }
        table
    }
}

/// Letters of the longest word, as far as it is kept whole.
fn longest_word(text: &str) -> u16 {
    let letters = text.split_whitespace().map(|word| word.chars().count());
    letters.max().unwrap_or(0).min(WHOLE) as u16
}

impl fmt::Display for Aligned {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let indent = usize::from(self.indent);
        for line in self.set().lines() {
            match line.trim_end() {
                "" => writeln!(f)?,
                line => writeln!(f, "{:indent$}{line}", "")?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(name: &str) -> String {
        let heads =
            [("release", Side::Words), ("EI", Side::Number), ("marker", Side::Name), ("", Side::Words)];
        let mut table = Aligned::new(&heads).indented(2);
        table.row([name, "5.12 ± 0.03", "tip", "held out"]);
        table.row([
            "b",
            "123456.7 ± 0.1",
            "body:1",
            "kept, for it is the one that stands for all of its condition",
        ]);
        table.to_string()
    }

    #[test]
    fn columns_stand_apart_within_a_terminal() {
        let text = table("15 psi");
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "  release              EI  marker");
        assert_eq!(lines[1], "  15 psi      5.12 ± 0.03  tip     held out");
        assert_eq!(
            lines[2],
            "  b        123456.7 ± 0.1  body:1  kept, for it is the one that stands for all"
        );
        assert!(lines[3].trim().starts_with("of its condition"), "{text}");
        // Words give way, numbers do not.
        let text = table("a release with a name that alone takes as much as a whole line of a terminal has");
        assert!(text.lines().all(|line| line.chars().count() <= usize::from(WIDTH)), "{text}");
        assert!(text.contains("123456.7 ± 0.1  body:1  kept"), "{text}");
    }

    /// Keys of 34 letters beside 40 letters of a value leave none for more, and stay whole.
    #[test]
    fn a_word_is_not_broken() {
        let mut table = Aligned::new(&[("", Side::Words), ("", Side::Words), ("", Side::Number)]);
        let key = "effects.enclosed_air.inner_diameter";
        table.row([
            key,
            "the diameter of the air within the muscle, which the braid surrounds",
            "0.024892 m",
        ]);
        let text = table.to_string();
        assert!(text.starts_with(&format!("{key}  the diameter of the air")), "{text}");
        assert!(text.lines().all(|line| line.chars().count() <= usize::from(WIDTH)), "{text}");
    }

    /// Ten numbers of twelve letters take more than a line: none is broken, and the name stays readable.
    #[test]
    fn what_is_wider_than_a_terminal_is_wider() {
        let heads: Vec<(&str, Side)> =
            [("", Side::Words)].into_iter().chain([("number", Side::Number); 10]).collect();
        let mut table = Aligned::new(&heads);
        table.row(["a name of words"].into_iter().chain(["0.1 ± 0.0001"; 10]));
        let text = table.to_string();
        assert_eq!(text.lines().count(), 2, "{text}");
        assert_eq!(text.matches("  0.1 ± 0.0001").count(), 10, "{text}");
    }
}
