//! Numbers as instruments, spreadsheets and languages write them.

use std::borrow::Cow;

/// What stands before the fraction of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decimal {
    /// `1.5`
    Point,
    /// `1,5`
    Comma,
    /// Neither was seen in the look-ahead of a table whose cells no comma separates: both are taken.
    Open,
}

/// What points of a column may be whose cells no comma or blank separates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Points {
    /// Decimal.
    Clear,
    /// `1.184` among whole numbers of three digits: thousands or a fraction.
    Whole,
    /// The same, where whole numbers come after `1.184` and its like alone.
    Grouped,
}

impl Points {
    /// Whether a cell may be thousands.
    pub(crate) fn leave_open(self, cell: &[u8]) -> bool {
        match self {
            Self::Clear => false,
            Self::Whole => str::from_utf8(cell).is_ok_and(|text| is_grouped(text, '.')),
            Self::Grouped => is_hundreds(cell),
        }
    }
}

/// Whether it is a whole number of three digits.
pub(crate) fn is_hundreds(cell: &[u8]) -> bool {
    let digits = cell.strip_prefix(b"-").unwrap_or(cell);
    digits.len() == 3 && digits.iter().all(u8::is_ascii_digit) && !digits.starts_with(b"0")
}

/// Missing and unusable values of R, pandas, Excel (also German), databases and C.
const MISSING: [&str; 24] = [
    "na",
    "n/a",
    "#n/a",
    "<na>",
    "null",
    "none",
    "nil",
    "-",
    "--",
    "---",
    "?",
    "#num!",
    "#div/0!",
    "#value!",
    "#ref!",
    "#nv",
    "#zahl!",
    "#wert!",
    "nan(ind)",
    "nan(snan)",
    "1.#qnan",
    "1.#ind",
    "1.#snan",
    "nan",
];
/// What helps where a point or a comma may be either.
pub(crate) const THOUSANDS: &str = "it may be thousands or a fraction: write it without a thousands separator and with a decimal point";
/// Longest text of a number.
const LONGEST: usize = 64;

/// The number in a cell: NaN for a spelling of a missing value, `None` for a blank cell and for text.
pub(crate) fn parse(cell: &[u8], decimal: Decimal) -> Option<f64> {
    let text = str::from_utf8(cell).ok()?;
    if decimal != Decimal::Comma
        && let Ok(value) = text.parse()
    {
        return Some(value);
    }
    if is_missing(text) {
        return Some(f64::NAN);
    }
    match text.strip_prefix(['+', '-']).unwrap_or(text).to_ascii_lowercase().as_str() {
        "1.#inf" if text.starts_with('-') => return Some(f64::NEG_INFINITY),
        "1.#inf" => return Some(f64::INFINITY),
        _ => {}
    }
    if decimal == Decimal::Point {
        return None;
    }
    plain(text, decimal).parse().ok()
}

pub(crate) fn is_missing(text: &str) -> bool {
    let bare = text.strip_prefix(['+', '-']).filter(|rest| rest.len() > 2).unwrap_or(text);
    text.len() <= 10 && MISSING.iter().any(|word| bare.eq_ignore_ascii_case(word))
}

/// The text with a decimal point, where it is a number that means one thing; otherwise as it is.
pub(crate) fn plain(text: &str, decimal: Decimal) -> Cow<'_, str> {
    let is_comma = decimal != Decimal::Point
        && text.len() <= LONGEST
        && text.bytes().filter(|byte| *byte == b',').count() == 1
        && !text.contains('.')
        && !text.ends_with(',')
        && !(decimal == Decimal::Open && is_grouped(text, ','));
    // A point where commas are decimal groups thousands.
    let no_number = decimal == Decimal::Comma && text.contains('.');
    if is_comma {
        Cow::Owned(text.replacen(',', ".", 1))
    } else if no_number {
        Cow::Owned(format!("'{text}"))
    } else {
        Cow::Borrowed(text)
    }
}

/// Whether `mark` may group thousands in it: `1,250` and `1.250.000`, but not `0,250` and `1,25`.
pub(crate) fn is_grouped(text: &str, mark: char) -> bool {
    let digits = text.trim_start_matches(['+', '-']);
    let mut groups = digits.split(mark);
    let first = groups.next().unwrap_or_default();
    let is_number = |group: &str| group.bytes().all(|byte| byte.is_ascii_digit());
    let mut count = 0;
    (1..=3).contains(&first.len())
        && is_number(first)
        && !first.starts_with('0')
        && groups.all(|group| {
            count += 1;
            let last = group.split(['.', ',']).next().unwrap_or_default();
            last.len() == 3 && is_number(last)
        })
        && count > 0
}

/// Whether it is a number with groups of thousands, or may be.
pub(crate) fn has_thousands(text: &str) -> bool {
    [',', '.', '\'', ' ', '\u{a0}', '\u{202f}'].into_iter().any(|mark| is_grouped(text, mark))
}

/// What helps where a cell is no number; `otherwise` where nothing is known about it.
pub(crate) fn remedy(text: &str, decimal: Decimal, otherwise: &'static str) -> &'static str {
    let digits = text.bytes().any(|byte| byte.is_ascii_digit());
    let only =
        |marks: &[u8]| text.bytes().all(|byte| byte.is_ascii_digit() || marks.contains(&byte));
    if !digits {
        return otherwise;
    }
    if text.contains(',') && !text.contains('.') && !is_grouped(text, ',') && only(b",+-eE") {
        return "write a decimal point, or separate the cells with semicolons or tabs";
    }
    if [',', '.'].into_iter().any(|mark| is_grouped(text, mark)) {
        return match decimal {
            Decimal::Point | Decimal::Open => THOUSANDS,
            Decimal::Comma => {
                "a point that groups thousands is not read: write the number without it"
            }
        };
    }
    if only(b" .,'+-_") || text.contains(['\'', '\u{a0}', '\u{202f}']) {
        return "thousands separators are not read: write the number without them";
    }
    if text.contains(':') || (text.matches(['-', '/']).count() == 2 && only(b"-/ TZ.:")) {
        return "a date or a time of day is not read: write seconds, or leave the column out and give --rate HZ";
    }
    otherwise
}

/// Cells of one column: whether all fractions are equally long, and the longest of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Digits {
    rows: usize,
    fraction: Option<usize>,
    fixed: bool,
    longest: usize,
    blank: bool,
}

impl Digits {
    pub(crate) fn see(&mut self, cell: &[u8]) {
        let fraction = fraction(cell);
        self.fixed =
            fraction.is_some() && (self.rows == 0 || self.fixed && self.fraction == fraction);
        self.fraction = fraction;
        self.longest = self.longest.max(magnitude(cell));
        self.blank |= cell.is_empty();
        self.rows += 1;
    }

    /// Whether a cell at the end of a file without a last line end may be the beginning of a longer one.
    pub(crate) fn may_be_cut(&self, cell: &[u8]) -> bool {
        if cell.is_empty() {
            return !self.blank;
        }
        if self.fixed && self.rows > 1 {
            return fraction(cell) != self.fraction;
        }
        self.rows >= 8 && magnitude(cell) < self.longest
    }
}

/// Characters behind the decimal sign.
fn fraction(cell: &[u8]) -> Option<usize> {
    let sign = cell.iter().position(|byte| matches!(byte, b'.' | b','))?;
    Some(cell.len() - sign - 1)
}

fn magnitude(cell: &[u8]) -> usize {
    cell.len() - usize::from(matches!(cell.first(), Some(b'-' | b'+')))
}
