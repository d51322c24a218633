//! The header: lines of a keyword and its values, up to and with `DATA`.

use std::collections::BTreeMap;
use std::vec::Vec;

use super::super::error::{counted, quote};
use super::super::{Fault, ParseError};

const KEYWORDS: [&str; 10] =
    ["VERSION", "FIELDS", "SIZE", "TYPE", "COUNT", "WIDTH", "HEIGHT", "VIEWPOINT", "POINTS", "DATA"];

/// What the data look like.
#[derive(Debug)]
pub(super) struct Header {
    pub(super) fields: Fields,
    pub(super) points: usize,
    pub(super) encoding: Encoding,
    /// Byte of the file that the data start at.
    pub(super) data_offset: usize,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    Binary,
    Compressed,
}

/// The fields that are read, and the size of all.
#[derive(Debug)]
pub(super) struct Fields {
    pub(super) xyz: [Field; 3],
    pub(super) intensity: Option<Field>,
    pub(super) ring: Option<Field>,
    /// Bytes of a point.
    pub(super) record_len: usize,
    /// Values of a point.
    pub(super) value_count: usize,
}

/// One value of a point.
#[derive(Debug, Clone, Copy)]
pub(super) struct Field {
    pub(super) kind: Kind,
    /// Bytes of a point's values before this.
    pub(super) offset: usize,
    /// Values of a point before this.
    pub(super) column: usize,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    F32,
    F64,
    I8,
    I16,
    I32,
    I64,
    U8,
    U16,
    U32,
    U64,
}

impl Kind {
    fn of(type_name: &str, size: &str) -> Option<Self> {
        Some(match (type_name, size) {
            ("F", "4") => Self::F32,
            ("F", "8") => Self::F64,
            ("I", "1") => Self::I8,
            ("I", "2") => Self::I16,
            ("I", "4") => Self::I32,
            ("I", "8") => Self::I64,
            ("U", "1") => Self::U8,
            ("U", "2") => Self::U16,
            ("U", "4") => Self::U32,
            ("U", "8") => Self::U64,
            _ => return None,
        })
    }

    pub(super) const fn len(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::F32 | Self::I32 | Self::U32 => 4,
            Self::F64 | Self::I64 | Self::U64 => 8,
        }
    }
}

/// A line's values and the byte they start at.
#[derive(Debug, Clone, Copy)]
struct Line<'a> {
    offset: usize,
    values: &'a str,
}

impl<'a> Line<'a> {
    fn words(self) -> Vec<&'a str> {
        self.values.split_ascii_whitespace().collect()
    }

    fn error(self, fault: Fault, expected: &str) -> ParseError {
        ParseError::new(fault, self.offset, quote(self.values), expected)
    }

    fn number(self) -> Result<usize, ParseError> {
        self.values.parse().map_err(|_| self.error(Fault::Header, "a number of points"))
    }
}

/// All lines by keyword.
struct Lines<'a> {
    lines: BTreeMap<&'static str, Line<'a>>,
    data_offset: usize,
}

impl Header {
    pub(super) fn parse(bytes: &[u8]) -> Result<Self, ParseError> {
        let lines = Lines::parse(bytes)?;
        lines.check_version()?;
        Ok(Self {
            fields: lines.fields()?,
            points: lines.points()?,
            encoding: lines.encoding()?,
            data_offset: lines.data_offset,
        })
    }
}

impl<'a> Lines<'a> {
    fn parse(bytes: &'a [u8]) -> Result<Self, ParseError> {
        let mut lines = BTreeMap::new();
        let mut offset = 0;
        while !lines.contains_key("DATA") {
            let (text, next_offset) = text_line(bytes, offset)?;
            if let Some((keyword, line)) = split_line(text, offset)?
                && lines.insert(keyword, line).is_some()
            {
                return Err(ParseError::new(Fault::Header, offset, keyword, "it only once"));
            }
            offset = next_offset;
        }
        Ok(Self { lines, data_offset: offset })
    }

    fn get(&self, keyword: &'static str) -> Result<Line<'a>, ParseError> {
        let missing = || {
            let found = std::format!("a header without {keyword}");
            ParseError::new(Fault::Header, self.data_offset, found, "one before DATA")
        };
        self.lines.get(keyword).copied().ok_or_else(missing)
    }

    fn check_version(&self) -> Result<(), ParseError> {
        let line = self.get("VERSION")?;
        match line.values {
            "0.7" | ".7" | "0.6" | ".6" | "0.5" | ".5" => Ok(()),
            _ => Err(line.error(Fault::Header, "a version from 0.5 to 0.7")),
        }
    }

    fn encoding(&self) -> Result<Encoding, ParseError> {
        let line = self.get("DATA")?;
        match line.values {
            "ascii" => Ok(Encoding::Ascii),
            "binary" => Ok(Encoding::Binary),
            "binary_compressed" => Ok(Encoding::Compressed),
            _ => Err(line.error(Fault::Header, "ascii, binary or binary_compressed")),
        }
    }

    /// POINTS, which may be left out, is WIDTH times HEIGHT.
    fn points(&self) -> Result<usize, ParseError> {
        let (width, height) = (self.get("WIDTH")?, self.get("HEIGHT")?);
        let product = width.number()?.checked_mul(height.number()?);
        let line = *self.lines.get("POINTS").unwrap_or(&height);
        let points = if self.lines.contains_key("POINTS") { Some(line.number()?) } else { product };
        match points {
            Some(points) if product == Some(points) => Ok(points),
            _ => {
                let expected = std::format!("width x height = {} x {}", width.values, height.values);
                Err(line.error(Fault::PointCount, &expected))
            }
        }
    }

    fn fields(&self) -> Result<Fields, ParseError> {
        let names = self.get("FIELDS")?;
        let words = names.words();
        let kinds = self.kinds(words.len())?;
        let counts = self.counts(words.len())?;
        let mut table = FieldTable { names, known: BTreeMap::new(), offset: 0, column: 0 };
        for ((name, kind), count) in words.into_iter().zip(kinds).zip(counts) {
            table.add(name, kind, count)?;
        }
        Ok(Fields {
            xyz: [table.coordinate("x")?, table.coordinate("y")?, table.coordinate("z")?],
            intensity: table.single("intensity").or_else(|| table.single("i")),
            ring: table.single("ring").or_else(|| table.single("channel")),
            record_len: table.offset,
            value_count: table.column,
        })
    }

    fn kinds(&self, fields: usize) -> Result<Vec<Kind>, ParseError> {
        let types = self.get("TYPE")?;
        let type_names = words_for(types, fields)?;
        let sizes = words_for(self.get("SIZE")?, fields)?;
        let kind = |(type_name, size): (&&str, &&str)| {
            Kind::of(type_name, size).ok_or_else(|| {
                let found = std::format!("type {} of size {}", quote(type_name), quote(size));
                ParseError::new(Fault::Fields, types.offset, found, "F of 4 or 8, I or U of 1, 2, 4 or 8")
            })
        };
        type_names.iter().zip(&sizes).map(kind).collect()
    }

    /// COUNT may be left out: one value a field.
    fn counts(&self, fields: usize) -> Result<Vec<usize>, ParseError> {
        let Some(&line) = self.lines.get("COUNT") else {
            return Ok(std::vec![1; fields]);
        };
        let count = |word: &&str| {
            let count = word.parse().ok().filter(|&count| count > 0);
            count.ok_or_else(|| line.error(Fault::Fields, "numbers from 1 up"))
        };
        words_for(line, fields)?.iter().map(count).collect()
    }
}

/// The fields so far.
struct FieldTable<'a> {
    names: Line<'a>,
    /// Each with its number of values.
    known: BTreeMap<&'a str, (Field, usize)>,
    offset: usize,
    column: usize,
}

impl<'a> FieldTable<'a> {
    fn add(&mut self, name: &'a str, kind: Kind, count: usize) -> Result<(), ParseError> {
        let field = Field { kind, offset: self.offset, column: self.column };
        // Padding is named `_` any number of times.
        if name != "_" && self.known.insert(name, (field, count)).is_some() {
            return Err(self.error(&std::format!("only one field {}", quote(name))));
        }
        let field_end = kind.len().checked_mul(count).and_then(|len| self.offset.checked_add(len));
        let Some((offset, column)) = field_end.zip(self.column.checked_add(count)) else {
            return Err(self.error("points of fewer bytes than memory has"));
        };
        (self.offset, self.column) = (offset, column);
        Ok(())
    }

    /// A field of many values is no coordinate.
    fn single(&self, name: &str) -> Option<Field> {
        let &(field, count) = self.known.get(name)?;
        (count == 1).then_some(field)
    }

    fn coordinate(&self, name: &str) -> Result<Field, ParseError> {
        self.single(name).ok_or_else(|| self.error(&std::format!("a field {name} of one value")))
    }

    fn error(&self, expected: &str) -> ParseError {
        self.names.error(Fault::Fields, expected)
    }
}

/// The line that starts at `offset`, and where the next does.
fn text_line(bytes: &[u8], offset: usize) -> Result<(&str, usize), ParseError> {
    let rest = &bytes[offset..];
    let len = rest.iter().position(|&byte| byte == b'\n').ok_or_else(|| {
        let found = "the end of the input";
        ParseError::new(Fault::Header, bytes.len(), found, "a header that ends in a line DATA")
    })?;
    let text = core::str::from_utf8(&rest[..len]).map_err(|error| {
        let found = "bytes that are no text";
        ParseError::new(Fault::Header, offset + error.valid_up_to(), found, "a PCD header")
    })?;
    Ok((text, offset + len + 1))
}

/// A line's keyword and values; `None` for a comment, an empty line, and keywords of other programs.
fn split_line(text: &str, offset: usize) -> Result<Option<(&'static str, Line<'_>)>, ParseError> {
    let word = text.split_ascii_whitespace().next().unwrap_or_default();
    // Files of the first versions say COLUMNS.
    let name = if word == "COLUMNS" { "FIELDS" } else { word };
    let Some(keyword) = KEYWORDS.into_iter().find(|&keyword| keyword == name) else {
        let foreign = word.bytes().all(|byte| byte.is_ascii_uppercase() || byte == b'_');
        let skipped = foreign || word.starts_with('#');
        return if skipped { Ok(None) } else { Err(no_keyword(word, offset)) };
    };
    let values = text.trim_ascii_start()[word.len()..].trim_ascii();
    let values_offset = offset + (values.as_ptr().addr() - text.as_ptr().addr());
    Ok(Some((keyword, Line { offset: values_offset, values })))
}

fn no_keyword(word: &str, offset: usize) -> ParseError {
    let expected = std::format!("a line of a PCD header: {}", KEYWORDS.join(", "));
    ParseError::new(Fault::Header, offset, quote(word), expected)
}

fn words_for(line: Line<'_>, fields: usize) -> Result<Vec<&str>, ParseError> {
    let words = line.words();
    if words.len() == fields {
        return Ok(words);
    }
    let found = counted(words.len(), "value");
    let expected = std::format!("one for each of {}", counted(fields, "field"));
    Err(ParseError::new(Fault::Fields, line.offset, found, expected))
}
