//! Text to rows of cells: encoding, delimiter, decimal sign. The only file that names csv.

use csv::{Reader, ReaderBuilder, StringRecord};

use super::error::RecordingProblem;

/// Lines that are looked at to find the delimiter.
const SAMPLE: usize = 16;
/// Characters of a line that messages show.
const SHOWN: usize = 60;
/// What programs write in place of a number that is not there.
const LOST: [&str; 9] = ["na", "n/a", "#n/a", "null", "none", "-", "--", "#value!", "missing"];
/// Bytes at the start of a text in which UTF-16 without a mark shows.
const WIDE_SAMPLE: usize = 64;

/// Bytes as text; with what is to be said about its encoding.
pub(super) fn decode(mut bytes: Vec<u8>) -> Result<(String, Option<String>), RecordingProblem> {
    if let Some(from) = wide(&bytes) {
        let words = bytes.chunks_exact(2).map(|pair| from([pair[0], pair[1]]));
        let text = char::decode_utf16(words.skip_while(|word| *word == 0xfeff));
        let text = text.map(|letter| letter.unwrap_or(char::REPLACEMENT_CHARACTER)).collect();
        return Ok((text, Some("encoding: UTF-16, as its first bytes say".to_owned())));
    }
    if bytes.starts_with(b"\xef\xbb\xbf") {
        bytes.drain(..3);
    }
    let end = bytes.iter().rposition(|byte| *byte != 0).map_or(bytes.len(), |last| last + 1);
    if end < bytes.len() {
        bytes.truncate(end);
        let zeros = format!(
            "from byte {end} on the file has zeros, as a program leaves them that was cut off; what follows was not read"
        );
        let (text, encoding) = decode(bytes)?;
        return Ok((text, Some(encoding.map_or(zeros.clone(), |own| format!("{zeros}; {own}")))));
    }
    if let Some(offset) = no_letter(&bytes) {
        return Err(RecordingProblem::NotText { offset, byte: bytes[offset] });
    }
    // In its place: a long recording is not held twice.
    match String::from_utf8(bytes) {
        Ok(text) => Ok((text, None)),
        Err(error) => {
            let text = error.as_bytes().iter().map(|byte| char::from(*byte)).collect();
            Ok((text, Some("encoding: not UTF-8; letters beyond ASCII were read as Latin-1".to_owned())))
        }
    }
}

/// How two bytes are a word, if a text is in UTF-16: as its mark says, or zeros beside the letters of ASCII.
fn wide(bytes: &[u8]) -> Option<fn([u8; 2]) -> u16> {
    let is_beside = |zero: usize| {
        let mut pairs = bytes[..bytes.len().min(WIDE_SAMPLE)].chunks_exact(2);
        pairs.len() > 1 && pairs.all(|pair| pair[zero] == 0 && pair[1 - zero] != 0)
    };
    match bytes {
        [0xff, 0xfe, ..] => Some(u16::from_le_bytes),
        [0xfe, 0xff, ..] => Some(u16::from_be_bytes),
        _ if is_beside(1) => Some(u16::from_le_bytes),
        _ => is_beside(0).then_some(u16::from_be_bytes),
    }
}

/// Whether a text is in UTF-16.
pub(super) fn is_wide(bytes: &[u8]) -> bool {
    wide(bytes).is_some()
}

/// The first byte that no text has, in an encoding of bytes.
pub(super) fn no_letter(bytes: &[u8]) -> Option<usize> {
    let is_text =
        |byte: u8| byte >= 0x20 && byte != 0x7f || matches!(byte, b'\t' | b'\r' | b'\n' | 0x0c | 0x1a);
    bytes.iter().position(|byte| !is_text(*byte))
}

/// A text whose cells are separated by blanks, with tabs in their place; nothing for another one.
pub(super) fn without_blanks(text: &str) -> Option<String> {
    let is_number = |word: &str| {
        word.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '-' | '+' | '.'))
            && word.chars().all(|c| c.is_ascii_digit() || ":.,+-eE".contains(c))
            && !word.ends_with(',')
            // A comma is a decimal sign here, and separates no cells.
            && (!word.contains(',') || word.matches([',', '.']).count() == 1)
            || word.eq_ignore_ascii_case("nan")
    };
    let lines: Vec<&str> = sample(text);
    let is_row =
        |line: &&&str| line.split_whitespace().nth(1).is_some() && line.split_whitespace().all(is_number);
    let is_blank = !lines.iter().any(|line| line.trim().contains(['\t', ';']))
        && 3 * lines.iter().filter(is_row).count() >= lines.len().max(1);
    is_blank.then(|| {
        let mut tabs = String::with_capacity(text.len());
        for line in text.split_inclusive('\n') {
            for (k, word) in line.split_whitespace().enumerate() {
                tabs.extend((k > 0).then_some('\t'));
                tabs.push_str(word);
            }
            tabs.push('\n');
        }
        tabs
    })
}

/// The first lines that are not blank.
fn sample(text: &str) -> Vec<&str> {
    text.lines().filter(|line| !line.trim().is_empty()).take(SAMPLE).collect()
}

/// The delimiter that a first line `sep=;` states, as spreadsheets write and read it.
fn stated_delimiter(text: &str) -> Option<u8> {
    let line = text.lines().next()?.trim_matches(['"', '\r']);
    let mark = line.get(..4).filter(|word| word.eq_ignore_ascii_case("sep=")).and_then(|_| line.get(4..))?;
    match mark {
        "\t" | "\\t" => Some(b'\t'),
        _ => mark.bytes().next().filter(|byte| mark.len() == 1 && byte.is_ascii_punctuation()),
    }
}

/// The delimiter of a text: tab, semicolon or comma, whichever is first found in most of its first lines.
fn delimiter(text: &str) -> u8 {
    let lines = sample(text);
    let with = |mark: char| lines.iter().filter(|line| line.contains(mark)).count();
    let is_common = |mark: char| 2 * with(mark) >= lines.len().max(1) || with(mark) > with(',');
    // Commas may be decimal signs beside the other two, but not the other way round.
    if is_common('\t') {
        b'\t'
    } else if is_common(';') {
        b';'
    } else {
        b','
    }
}

/// The rows of a text, one at a time.
pub(super) struct Rows<'t> {
    text: &'t str,
    reader: Reader<&'t [u8]>,
    record: StringRecord,
    is_held: bool,
    line: u64,
    /// Between cells.
    pub delimiter: u8,
    /// Whether blanks separated the cells, so that a cell which is not there cannot be seen.
    pub is_strict: bool,
}

impl<'t> Rows<'t> {
    pub(super) fn new(text: &'t str) -> Self {
        let stated = stated_delimiter(text);
        let delimiter = stated.unwrap_or_else(|| delimiter(text));
        let mut builder = ReaderBuilder::new();
        let builder = builder.has_headers(false).flexible(true).delimiter(delimiter);
        let reader = builder.from_reader(text.as_bytes());
        let record = StringRecord::new();
        let mut rows = Self { text, reader, record, is_held: false, line: 1, delimiter, is_strict: false };
        if stated.is_some() {
            // The line that states it. What cannot be read is found again in the next.
            let _ = rows.read();
        }
        rows
    }

    /// Goes on to the next row that is not an empty line; false at the end.
    pub(super) fn read(&mut self) -> Result<bool, RecordingProblem> {
        if std::mem::take(&mut self.is_held) {
            return Ok(true);
        }
        let unreadable = |error: csv::Error| RecordingProblem::Unreadable(std::io::Error::other(error));
        let is_row = self.reader.read_record(&mut self.record).map_err(unreadable)?;
        if is_row {
            self.line = self.find_line();
        }
        Ok(is_row)
    }

    /// Goes on to the next row that is not blank; false at the end.
    pub(super) fn read_filled(&mut self) -> Result<bool, RecordingProblem> {
        while self.read()? {
            if !self.is_blank() {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Lets the next reading return this row again.
    pub(super) fn hold(&mut self) {
        self.is_held = true;
    }

    /// All cells, to keep.
    pub(super) fn keep(&self) -> Vec<String> {
        self.cells().map(str::to_owned).collect()
    }

    /// Whether most of the row is numbers, or blank as where they are lost.
    pub(super) fn is_data(&self) -> bool {
        let (mut filled, mut values, mut numbers) = (0, 0, 0);
        for cell in self.cells().filter(|cell| !cell.is_empty()) {
            let is_clock = cell.contains(':') && cell.starts_with(|c: char| c.is_ascii_digit());
            let is_value = is_clock || Numbers::default().read(cell, 0).is_ok();
            filled += 1;
            values += usize::from(is_value);
            numbers += usize::from(is_value && cell.contains(|c: char| c.is_ascii_digit()));
        }
        numbers > 0 && 2 * values >= filled
    }

    /// Cells up to the last that is not empty.
    pub(super) fn filled(&self) -> usize {
        let last = (0..self.record.len()).rev().find(|at| !self.cell(*at).is_empty());
        last.map_or(0, |last| last + 1)
    }

    /// Whether the first cell is a number.
    pub(super) fn is_numeric(&self) -> bool {
        matches!(Numbers::default().read(self.cell(0), 0), Ok(Some(_)))
    }

    /// Whether the text ends in this row without the end of a line.
    pub(super) fn is_open(&self) -> bool {
        self.reader.position().byte() as usize == self.text.len() && !self.text.ends_with(['\n', '\r'])
    }

    /// Line of the row, from 1; after the end, that of the last row.
    pub(super) fn line(&self) -> u64 {
        self.line
    }

    fn find_line(&self) -> u64 {
        let Some(start) = self.record.position() else { return 1 };
        // The position is that of the end of the row before: line ends and empty lines follow it.
        let after = self.text.as_bytes().get(start.byte() as usize..).unwrap_or_default();
        let ends = after.iter().take_while(|byte| matches!(byte, b'\r' | b'\n'));
        start.line() + ends.filter(|byte| **byte == b'\n').count() as u64
    }

    /// A cell without blanks around it; empty beyond the end of the row.
    pub(super) fn cell(&self, column: usize) -> &str {
        self.record.get(column).unwrap_or_default().trim()
    }

    /// All cells without blanks around them.
    pub(super) fn cells(&self) -> impl Iterator<Item = &str> {
        self.record.iter().map(str::trim)
    }

    /// Cells in the row, empty ones included.
    pub(super) fn width(&self) -> usize {
        self.record.len()
    }

    /// Whether all cells are empty.
    pub(super) fn is_blank(&self) -> bool {
        self.cells().all(str::is_empty)
    }

    /// The first cell, if it is a word and the only one.
    pub(super) fn title(&self) -> Option<&str> {
        let first = self.cell(0);
        let is_word = first.starts_with(char::is_alphabetic);
        (is_word && self.cells().skip(1).all(str::is_empty)).then_some(first)
    }

    /// The row as it is there, cut short for a message.
    pub(super) fn start(&self) -> String {
        let separator = if self.delimiter == b'\t' { " " } else { "," };
        let mut text = String::new();
        for cell in self.cells() {
            if text.len() > SHOWN {
                break;
            }
            let before = if text.is_empty() { "" } else { separator };
            text = text + before + cell;
        }
        short(&text)
    }

    /// Length of the whole text, bytes.
    pub(super) fn length(&self) -> usize {
        self.text.len()
    }
}

/// A text cut short for a message.
pub(super) fn short(text: &str) -> String {
    match text.char_indices().nth(SHOWN) {
        None => text.to_owned(),
        Some((end, _)) => format!("{}…", &text[..end]),
    }
}

/// A number of a header, with either decimal sign.
pub(super) fn in_header(text: &str) -> Option<f64> {
    text.replace(',', ".").parse().ok()
}

/// Whether a cell names what follows it in its row.
pub(super) fn is_label(cell: &str) -> bool {
    cell.starts_with(char::is_alphabetic) && Numbers::default().read(cell, 0).is_err()
}

/// Reads cells as numbers, and watches their decimal signs.
#[derive(Default)]
pub(super) struct Numbers {
    point: Option<(u64, String)>,
    comma: Option<(u64, String)>,
}

/// A cell that is no number.
#[derive(Debug)]
pub(super) struct NotANumber;

/// Whether a cell says in a word that there is no number, such as `lost`, `?`, `-nan(ind)`, `1.#QNAN` or `#DIV/0!`.
pub(super) fn is_word(cell: &str) -> bool {
    let has_digit = !cell.contains('#') && cell.contains(|c: char| c.is_ascii_digit());
    !has_digit && Numbers::default().read(cell, 0).is_err()
}

impl Numbers {
    /// The number in a cell; nothing where it is blank or says that there is none.
    pub(super) fn read(&mut self, cell: &str, line: u64) -> Result<Option<f64>, NotANumber> {
        if cell.is_empty() {
            return Ok(None);
        }
        if let Ok(number) = cell.parse::<f64>() {
            if self.point.is_none() && cell.contains('.') {
                self.point = Some((line, cell.to_owned()));
            }
            return Ok(number.is_finite().then_some(number));
        }
        if let Some((whole, rest)) = cell.split_once(',')
            && !whole.contains('.')
            && let Ok(number) = format!("{whole}.{rest}").parse::<f64>()
        {
            if self.comma.is_none() {
                self.comma = Some((line, cell.to_owned()));
            }
            return Ok(Some(number));
        }
        if LOST.iter().any(|word| cell.eq_ignore_ascii_case(word)) {
            return Ok(None);
        }
        // A minus sign as word processors write it, and Fortran's D before an exponent.
        let plain = cell.replace('\u{2212}', "-").replace(['d', 'D'], "e");
        if plain == cell || !plain.contains(|c: char| c.is_ascii_digit()) {
            return Err(NotANumber);
        }
        self.read(&plain, line)
    }

    /// What is to be said about decimal signs.
    pub(super) fn finding(self) -> Result<Option<String>, RecordingProblem> {
        match (self.point, self.comma) {
            (Some((point_line, point)), Some((comma_line, comma))) => {
                Err(RecordingProblem::MixedDecimals { point, point_line, comma, comma_line })
            }
            (None, Some((line, value))) => {
                Ok(Some(format!("decimal sign: a comma, as in `{value}` in line {line}")))
            }
            _ => Ok(None),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_counted_over_empty_ones_and_all_line_ends() {
        for end in ["\n", "\r\n"] {
            let text = ["a,b", "", "c,d", "", "", "e,f"].join(end);
            let mut rows = Rows::new(&text);
            let mut lines = Vec::new();
            while rows.read().unwrap() {
                lines.push(rows.line());
            }
            assert_eq!(lines, [1, 3, 6], "{end:?}");
        }
    }

    #[test]
    fn delimiters_are_told_from_decimal_commas() {
        assert_eq!(delimiter("t_s;x_m\n0,0;0,1\n0,1;0,2\n"), b';');
        assert_eq!(delimiter("t_s\tx_m\n0,0\t0,1\n"), b'\t');
        assert_eq!(delimiter("Title\nDate:\n\nTRAJECTORIES\n100,Hz\n,LFHD,,\n"), b',');
        assert_eq!(delimiter(""), b',');
    }

    #[test]
    fn numbers_are_told_from_words() {
        let mut numbers = Numbers::default();
        for (cell, value) in
            [("-1e-3", Some(-1e-3)), ("", None), ("NaN", None), ("n/a", None), ("7", Some(7.0))]
        {
            assert_eq!(numbers.read(cell, 1).unwrap(), value, "{cell}");
        }
        assert!(numbers.read("1.2.3", 1).is_err() && numbers.read("1.234,5", 1).is_err());
        assert_eq!(numbers.read("0,25", 4).unwrap(), Some(0.25));
        assert!(numbers.finding().unwrap().unwrap().contains("line 4"));

        let mut both = Numbers::default();
        both.read("1,234", 2).unwrap();
        both.read("0.5", 3).unwrap();
        let message = both.finding().unwrap_err().to_string();
        assert!(message.starts_with("mixes decimal signs: `0.5` in line 3, `1,234` in line 2"), "{message}");
    }
}
