//! The arrays of a grid and where their numbers stand.

use super::xml::{DAMAGED, Event, Tag, Xml};
use crate::Error;
use crate::io::newlines;

/// Where an array belongs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Section {
    Points,
    Cells,
    PointData,
    CellData,
}

/// How the numbers of an array are written.
#[derive(Debug, Clone, Copy)]
pub(super) enum Format<'a> {
    Ascii(&'a [u8]),
    /// Base64 between the tags.
    Binary(&'a [u8]),
    /// Bytes behind the mark of the appended data.
    Appended(u64),
}

/// Kinds of numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Number {
    Float,
    Signed,
    Unsigned,
}

#[derive(Debug, Clone)]
pub(super) struct Array<'a> {
    pub section: Section,
    pub name: String,
    pub number: Number,
    /// Bytes a number.
    pub size: usize,
    pub components: usize,
    pub format: Format<'a>,
    /// Counted from 1.
    pub line: usize,
}

/// The grid as it is written.
#[derive(Default)]
pub(super) struct Document<'a> {
    pub big: bool,
    /// Bytes of the numbers that head binary data, 4 or 8.
    pub header: usize,
    pub zlib: bool,
    pub points: usize,
    pub cells: usize,
    pub arrays: Vec<Array<'a>>,
    /// What follows the mark of the appended data, and whether it is base64.
    pub appended: Option<(&'a [u8], bool)>,
    /// Bytes of the whole file.
    pub length: usize,
}

/// Memory that a file may ask for: so many times its bytes, and so much besides. Regular meshes of boxes, which compress
/// better than any other, take six times the file.
const FACTOR: usize = 10;
const BESIDES: usize = 64 << 20;

impl Document<'_> {
    /// Refuses what would take `bytes` of memory where zlib has made few of them: its promise, up to a thousand times what is
    /// stored, is checked before anything is decompressed. What is not compressed is in the file itself.
    pub(super) fn admit(&self, what: &str, bytes: f64) -> Result<(), Error> {
        let most = FACTOR.saturating_mul(self.length).saturating_add(BESIDES) as f64;
        if !self.zlib || bytes <= most {
            return Ok(());
        }
        let what = format!(
            "{what} would take {:.0} MB, which is out of proportion to a file of {:.1} MB",
            bytes / 1e6,
            self.length as f64 / 1e6
        );
        Err(Error::new("", what, "if it is right, save it without compression (ParaView: Compressor Type None)"))
    }
}

const PARAVIEW: &str = "open it in ParaView and save it as one .vtu (File > Save Data)";

/// Finds all arrays; decodes none.
pub(super) fn document(bytes: &[u8]) -> Result<Document<'_>, Error> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let start = bytes.trim_ascii_start();
    if start.is_empty() {
        return Err(Error::new("", "the file is empty", "was writing it interrupted?"));
    }
    if start[0] != b'<' {
        let (what, remedy) = if start.starts_with(b"# vtk") {
            ("this is a legacy VTK file, not a .vtu", PARAVIEW)
        } else {
            ("this is not a VTU file: it does not begin with <VTKFile", "export it again as .vtu")
        };
        return Err(Error::new("", what, remedy));
    }
    let mut xml = Xml { bytes, pos: 0 };
    let mut document = Document { header: 4, length: bytes.len(), ..Document::default() };
    let (mut file, mut pieces, mut section) = (false, 0, None);
    while let Some(event) = xml.next()? {
        match event {
            Event::Start(tag) => match tag.name {
                b"VTKFile" => {
                    file_tag(&xml, &tag, &mut document)?;
                    file = true;
                }
                b"Piece" => {
                    let count = |key| count(&xml, &tag, key);
                    let (points, cells) = (count("NumberOfPoints")?, count("NumberOfCells")?);
                    // writers of distributed meshes leave empty pieces
                    pieces += usize::from(points > 0 || cells > 0);
                    if pieces > 1 {
                        return Err(xml.fail_at(tag.pos, "the grid consists of several pieces", PARAVIEW));
                    }
                    if points > 0 || cells > 0 {
                        (document.points, document.cells) = (points, cells);
                    } else {
                        passed(&mut xml, &tag, "an element")?;
                    }
                }
                b"Points" => section = Some(Section::Points),
                b"Cells" => section = Some(Section::Cells),
                b"PointData" => section = Some(Section::PointData),
                b"CellData" => section = Some(Section::CellData),
                b"FieldData" => drop(passed(&mut xml, &tag, "an element")?),
                b"DataArray" if section.is_some() => {
                    if let Some(section) = section {
                        let array = array(&mut xml, &tag, section)?;
                        document.arrays.extend(array);
                    }
                }
                b"AppendedData" => {
                    appended(&mut xml, &tag, &mut document)?;
                    break;
                }
                _ => {}
            },
            Event::End(b"Points" | b"Cells" | b"PointData" | b"CellData") => section = None,
            Event::End(_) | Event::Text(_) => {}
        }
    }
    if !file || pieces == 0 {
        let what = if file { "the grid has no piece with points" } else { "there is no <VTKFile>" };
        return Err(xml.fail_at(xml.pos, what, DAMAGED));
    }
    Ok(document)
}

/// What kind of file it is and how binary data are written.
fn file_tag(xml: &Xml, tag: &Tag, document: &mut Document) -> Result<(), Error> {
    let fail = |what: String, remedy: &str| Err(xml.fail_at(tag.pos, what, remedy));
    let kind = tag.get("type").unwrap_or_default();
    if kind != "UnstructuredGrid" {
        return fail(format!("this is a file of type \"{kind}\", not an UnstructuredGrid"), PARAVIEW);
    }
    document.big = match tag.get("byte_order").as_deref() {
        None | Some("LittleEndian") => false,
        Some("BigEndian") => true,
        Some(other) => return fail(format!("the byte order \"{other}\" is not known"), DAMAGED),
    };
    document.header = match tag.get("header_type").as_deref() {
        None | Some("UInt32") => 4,
        Some("UInt64") => 8,
        Some(other) => return fail(format!("the header type \"{other}\" is not known"), DAMAGED),
    };
    document.zlib = match tag.get("compressor").as_deref() {
        None | Some("") => false,
        Some("vtkZLibDataCompressor") => true,
        Some(other) => {
            let remedy = "save it with zlib or without compression (ParaView: Compressor Type ZLib)";
            return fail(format!("the compression {other} cannot be read"), remedy);
        }
    };
    Ok(())
}

fn count(xml: &Xml, tag: &Tag, key: &str) -> Result<usize, Error> {
    let value = tag.get(key).unwrap_or_default();
    let count = value.parse().ok().filter(|&n: &usize| n < u32::MAX as usize);
    count.ok_or_else(|| xml.fail_at(tag.pos, format!("{key} is \"{value}\", which is no number of them"), DAMAGED))
}

/// Moves behind the end of an element and returns its text, not that of elements within it; `thing` names it.
fn passed<'a>(xml: &mut Xml<'a>, tag: &Tag, thing: &str) -> Result<&'a [u8], Error> {
    let mut text: &[u8] = b"";
    let mut depth = usize::from(!tag.closed);
    while depth > 0 {
        match xml.next()? {
            Some(Event::Start(inner)) => depth += usize::from(!inner.closed),
            Some(Event::End(_)) => depth -= 1,
            Some(Event::Text(piece)) if depth == 1 && text.trim_ascii().is_empty() => text = piece,
            Some(Event::Text(_)) => {}
            None => return Err(xml.fail_at(tag.pos, format!("{thing} does not end"), DAMAGED)),
        }
    }
    Ok(text)
}

/// An array; `None` if it holds words.
fn array<'a>(xml: &mut Xml<'a>, tag: &Tag<'a>, section: Section) -> Result<Option<Array<'a>>, Error> {
    let text = passed(xml, tag, "the array")?;
    let name = tag.get("Name").unwrap_or_default();
    let fail = |what: String| Err(xml.fail_at(tag.pos, format!("array \"{name}\": {what}"), DAMAGED));
    let kind = tag.get("type").unwrap_or_default();
    let (number, size) = match kind.as_str() {
        "Float32" => (Number::Float, 4),
        "Float64" => (Number::Float, 8),
        "Int8" => (Number::Signed, 1),
        "Int16" => (Number::Signed, 2),
        "Int32" => (Number::Signed, 4),
        "Int64" => (Number::Signed, 8),
        "UInt8" => (Number::Unsigned, 1),
        "UInt16" => (Number::Unsigned, 2),
        "UInt32" => (Number::Unsigned, 4),
        "UInt64" => (Number::Unsigned, 8),
        "String" => return Ok(None),
        _ => return fail(format!("the type \"{kind}\" is not known")),
    };
    let components = match tag.get("NumberOfComponents").map(|c| c.parse::<usize>()) {
        None => 1,
        Some(Ok(components @ 0..=1000)) => components.max(1),
        Some(_) => return fail("NumberOfComponents is no number".into()),
    };
    let format = match tag.get("format").as_deref() {
        None | Some("ascii") => Format::Ascii(text),
        Some("binary") => Format::Binary(text),
        Some("appended") => match tag.get("offset").map(|o| o.parse()) {
            Some(Ok(offset)) => Format::Appended(offset),
            _ => return fail("the offset is no number".into()),
        },
        Some(other) => return fail(format!("the format \"{other}\" is not known")),
    };
    let line = 1 + newlines(&xml.bytes[..tag.pos]);
    Ok(Some(Array { section, name, number, size, components, format, line }))
}

/// The bytes behind the underscore.
fn appended<'a>(xml: &mut Xml<'a>, tag: &Tag, document: &mut Document<'a>) -> Result<(), Error> {
    let base64 = match tag.get("encoding").as_deref() {
        Some("raw") => false,
        None | Some("base64") => true,
        Some(other) => return Err(xml.fail_at(tag.pos, format!("the encoding \"{other}\" is not known"), DAMAGED)),
    };
    let rest = &xml.bytes[xml.pos..];
    match rest.iter().position(|b| !b.is_ascii_whitespace()) {
        Some(mark) if rest[mark] == b'_' => {
            document.appended = Some((&rest[mark + 1..], base64));
            Ok(())
        }
        _ => Err(xml.fail_at(xml.pos, "the appended data do not begin with an underscore", DAMAGED)),
    }
}
