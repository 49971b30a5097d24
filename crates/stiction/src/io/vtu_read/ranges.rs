//! Where the arrays of a file with raw appended data are, and any of its points and cells.

use std::collections::HashMap;
use std::ops::Range;

use super::assemble::{MOST_GROUPS, group_name, is_data, makes_groups};
use super::document::{Array, Document, Format, Section, document};
use super::types::{Role, role};
use super::xml::DAMAGED;
use crate::Error;
use crate::io::ranges::{Elements, Stored};
use crate::mesh::ascending;

/// A file whose arrays are where its head says.
pub(in crate::io) struct Layout {
    /// The file up to its appended data.
    head: Vec<u8>,
    /// Where these begin.
    data: u64,
    /// Nodes that all cells name.
    named: u64,
    pub groups: Vec<String>,
    /// Arrays of cells that make groups.
    grouping: Vec<Grouping>,
    length: u64,
}

/// An array that makes groups: its name, its values, which ascend, and the group of each.
struct Grouping {
    name: String,
    values: Vec<i64>,
    groups: Vec<u32>,
}

/// Values of a long array that are looked at together.
const AT_A_TIME: u64 = 1 << 20;

/// Finds the arrays of a file; none where it has to be read as a whole.
///
/// # Errors
/// If it is damaged.
pub(in crate::io) fn layout(file: &Stored) -> Result<Option<Layout>, Error> {
    let head = |bytes: Vec<u8>| {
        let read = bytes.len();
        // Without appended data there may be more to come.
        let begin = document(&bytes)?.appended.map(|(rest, base64)| (read - rest.len(), base64));
        let begin = begin.filter(|_| read > 0);
        begin.map(|(begin, base64)| (bytes, begin, base64)).ok_or_else(|| Error::new("", "no appended data", DAMAGED))
    };
    let Ok((mut head, begin, base64)) = file.head(0, head) else { return Ok(None) };
    head.truncate(begin);
    // An underscore ends the head: what is behind it is in the file.
    let mut layout =
        Layout { head, data: begin as u64, named: 0, groups: Vec::new(), grouping: Vec::new(), length: file.length };
    let whole = Layout { head: layout.head.clone(), grouping: Vec::new(), groups: Vec::new(), ..layout };
    let document = whole.document()?;
    let is_appended = |array: &Array| matches!(array.format, Format::Appended(_));
    let needed = [(Section::Points, "Points"), (Section::Cells, "types"), (Section::Cells, "offsets"), CONNECTIVITY];
    let needed = needed.into_iter().map(|(section, name)| document.needed(section, name));
    let (groups_of, mut others) =
        (|section| move |a: &&Array| a.section == section && is_data(a) && makes_groups(a), document.arrays.iter());
    if base64 || !needed.collect::<Result<Vec<_>, _>>()?.into_iter().all(is_appended) || document.cells == 0 {
        return Ok(None);
    }
    let ends = document.needed(Section::Cells, "offsets")?;
    let cells = document.cells as u64;
    let last = whole.integers(file, ends, cells - 1..cells, cells)?;
    layout.named = last.first().map_or(0, |&end| u64::try_from(end).unwrap_or(u64::MAX));
    for array in document.arrays.iter().filter(groups_of(Section::CellData)) {
        if !is_appended(array) {
            return Ok(None);
        }
        let Some(values) = whole.distinct(file, array, cells)? else { continue };
        let mask = values.iter().all(|value| [0, 1].contains(value));
        let mut group = |&value: &i64| {
            let name = group_name(&array.name, value, mask);
            let known = layout.groups.iter().position(|other| *other == name);
            known.unwrap_or_else(|| {
                layout.groups.push(name);
                layout.groups.len() - 1
            }) as u32
        };
        let groups = values.iter().map(&mut group).collect();
        layout.grouping.push(Grouping { name: array.name.clone(), values, groups });
    }
    // Groups of points are those of the whole: they must not be taken for groups of cells.
    let mixed = others.any(|array| {
        groups_of(Section::PointData)(&array) && layout.groups.iter().any(|group| group.starts_with(&array.name))
    });
    Ok((!mixed).then_some(layout))
}

const CONNECTIVITY: (Section, &str) = (Section::Cells, "connectivity");

impl Layout {
    fn document(&self) -> Result<Document<'_>, Error> {
        document(&self.head)
    }

    /// Points and cells.
    pub(in crate::io) fn sizes(&self) -> [u64; 2] {
        self.document().map_or([0; 2], |document| [document.points as u64, document.cells as u64])
    }

    /// The values of an array that makes groups, ascending; none if it is one of other numbers.
    fn distinct(&self, file: &Stored, array: &Array, count: u64) -> Result<Option<Vec<i64>>, Error> {
        let mut distinct: Vec<i64> = Vec::new();
        for from in (0..count).step_by(AT_A_TIME as usize) {
            for value in self.integers(file, array, from..count.min(from + AT_A_TIME), count)? {
                if let Err(at) = distinct.binary_search(&value) {
                    distinct.insert(at, value);
                }
                if distinct.len() > MOST_GROUPS {
                    return Ok(None);
                }
            }
        }
        let numbers = distinct.len() as u64 == count && count > 2;
        Ok((!numbers).then_some(distinct))
    }

    /// Numbers and places of some points.
    pub(in crate::io) fn nodes(&self, file: &Stored, range: Range<u64>) -> Result<(Vec<u64>, Vec<[f64; 3]>), Error> {
        let document = self.document()?;
        let array = document.needed(Section::Points, "Points")?;
        let count = 3 * document.points as u64;
        let part = Part::of(self, file, (&document, array), 3 * range.start..3 * range.end, count)?;
        let floats = part.document(&document).floats(&part.array(array), part.count)?;
        let places = floats[part.own].as_chunks::<3>().0.to_vec();
        Ok(((range.start + 1..range.end + 1).collect(), places))
    }

    /// Some cells.
    pub(in crate::io) fn elements(&self, file: &Stored, range: Range<u64>) -> Result<Elements, Error> {
        let document = self.document()?;
        let cells = document.cells as u64;
        let integers = |name: &str, range: Range<u64>, count: u64| {
            self.integers(file, document.needed(Section::Cells, name)?, range, count)
        };
        let codes = integers("types", range.clone(), cells)?;
        let mut from = match range.start {
            0 => 0,
            first => number(integers("offsets", first - 1..first, cells)?.first().copied().unwrap_or(0)),
        };
        let ends: Vec<u64> = integers("offsets", range.clone(), cells)?.into_iter().map(number).collect();
        let (begin, end) = (from, ends.last().copied().unwrap_or(from));
        if begin > end || !ends.is_sorted() || end > self.named {
            return Err(Error::new("", "the cells do not follow one another", DAMAGED));
        }
        let nodes = integers(CONNECTIVITY.1, begin..end, self.named)?;
        let (mut labels, mut found) = (Labels::new(self, file, (&document, range))?, Elements::with(Vec::new()));
        for (i, (code, end)) in codes.into_iter().zip(ends).enumerate() {
            if end < from {
                return Err(Error::new("", "the cells do not follow one another", DAMAGED));
            }
            // As if they were counted from 1.
            let cell = &nodes[(from - begin) as usize..(end - begin) as usize];
            let node = |&k: &usize| number(cell[k]).saturating_add(1);
            let set = labels.set(i, &mut found.sets);
            from = end;
            match role(u8::try_from(code).unwrap_or(u8::MAX), cell.len()) {
                Role::Cell(kind, order) => {
                    let cells = found.of_kind(kind);
                    cells.nodes.extend(order.iter().map(node));
                    cells.sets.push(set);
                }
                Role::Face(order) => {
                    let mut corners = [u64::MAX; 4];
                    corners.iter_mut().zip(order).for_each(|(corner, k)| *corner = node(k));
                    found.faces.push((corners, set));
                }
                Role::Nodes => found.nodes.extend((0..cell.len()).map(|k| (node(&k), set))),
                Role::Refused(what, remedy) => {
                    return Err(Error::new("", format!("cells that cannot be used: {what}"), remedy));
                }
            }
        }
        Ok(found)
    }

    /// Some of the `count` whole numbers of an array.
    fn integers(&self, file: &Stored, array: &Array, range: Range<u64>, count: u64) -> Result<Vec<i64>, Error> {
        let document = self.document()?;
        let part = Part::of(self, file, (&document, array), range, count)?;
        let all = part.document(&document).integers(&part.array(array), part.count, |n| n)?;
        Ok(all[part.own].to_vec())
    }
}

/// What is negative is beyond all numbers.
fn number(n: i64) -> u64 {
    u64::try_from(n).unwrap_or(u64::MAX)
}

/// The sets of groups that cells are in.
struct Labels<'a> {
    /// The arrays that make groups, and their values of the cells.
    of: Vec<(&'a Grouping, Vec<i64>)>,
    known: HashMap<Vec<u32>, u32>,
    /// The last cell that was not like the one before it, and its set.
    last: Option<(usize, u32)>,
}

impl<'a> Labels<'a> {
    fn new(layout: &'a Layout, file: &Stored, (document, range): (&Document, Range<u64>)) -> Result<Labels<'a>, Error> {
        let of = |grouping: &'a Grouping| {
            let is = |array: &&Array| array.section == Section::CellData && array.name == grouping.name;
            let missing = || Error::new("", format!("array \"{}\" is not there", grouping.name), DAMAGED);
            let array = document.arrays.iter().find(is).ok_or_else(missing)?;
            Ok((grouping, layout.integers(file, array, range.clone(), document.cells as u64)?))
        };
        let of = layout.grouping.iter().map(of).collect::<Result<_, Error>>()?;
        Ok(Labels { of, known: HashMap::new(), last: None })
    }

    /// The set of cell `i` of the range.
    fn set(&mut self, i: usize, sets: &mut Vec<Vec<u32>>) -> u32 {
        if let Some((other, set)) = self.last
            && self.of.iter().all(|(_, values)| values[other] == values[i])
        {
            return set;
        }
        let group = |(grouping, values): &(&Grouping, Vec<i64>)| {
            grouping.values.binary_search(&values[i]).ok().map(|at| grouping.groups[at])
        };
        let groups = ascending(self.of.iter().filter_map(group));
        let set = *self.known.entry(groups).or_insert_with_key(|groups| {
            sets.push(groups.clone());
            sets.len() as u32 - 1
        });
        self.last = Some((i, set));
        set
    }
}

/// Some numbers of an array, as the appended data of a file of their own.
struct Part {
    appended: Vec<u8>,
    /// How many there are, and which of them were asked for.
    count: usize,
    own: Range<usize>,
    /// Bytes of the file.
    length: usize,
}

impl Part {
    /// Of an array of `count` numbers.
    fn of(
        layout: &Layout,
        file: &Stored,
        (document, array): (&Document, &Array),
        range: Range<u64>,
        count: u64,
    ) -> Result<Part, Error> {
        let wrong =
            || Error::new("", format!("array \"{}\" has not the numbers that it should have", array.name), DAMAGED);
        let (size, width) = (array.size as u64, document.header as u64);
        let Format::Appended(offset) = array.format else { return Err(wrong()) };
        let at = layout.data.checked_add(offset).ok_or_else(wrong)?;
        let heads = |first: u64, many: u64| {
            let bytes = file
                .bytes(at.checked_add(width * first).ok_or_else(wrong)?, many.checked_mul(width).ok_or_else(wrong)?)?;
            Ok::<_, Error>(
                bytes.chunks_exact(document.header).map(|bytes| read(bytes, document.big)).collect::<Vec<u64>>(),
            )
        };
        let (needed, length) = (count.checked_mul(size).ok_or_else(wrong)?, layout.length as usize);
        if range.start > range.end || range.end > count {
            return Err(wrong());
        }
        let wanted = size * range.start..size * range.end;
        if !document.zlib {
            if heads(0, 1)?[0] != needed {
                return Err(wrong());
            }
            let mut appended = written(wanted.end - wanted.start, document);
            appended.extend(
                file.bytes((at + width).checked_add(wanted.start).ok_or_else(wrong)?, wanted.end - wanted.start)?,
            );
            let count = (range.end - range.start) as usize;
            return Ok(Part { appended, count, own: 0..count, length });
        }
        if wanted.is_empty() {
            return Ok(Part { appended: written(0, document), count: 0, own: 0..0, length });
        }
        let [blocks, block, partial] = heads(0, 3)?[..] else { return Err(wrong()) };
        let last = if partial == 0 { block } else { partial };
        let whole = blocks.checked_sub(1).and_then(|full| full.checked_mul(block)?.checked_add(last));
        if block == 0 || block % size != 0 || whole != Some(needed) {
            return Err(wrong());
        }
        let (from, to) = (wanted.start / block, wanted.end.div_ceil(block));
        let sizes = heads(3, blocks)?;
        let sum = |sizes: &[u64]| sizes.iter().try_fold(0u64, |sum, &size| sum.checked_add(size)).ok_or_else(wrong);
        let begin = [at, 3 * width, blocks * width, sum(&sizes[..from as usize])?];
        let own = &sizes[from as usize..to as usize];
        let ends = if to == blocks { partial } else { 0 };
        let mut appended: Vec<u8> =
            [to - from, block, ends].iter().chain(own).flat_map(|&n| written(n, document)).collect();
        appended.extend(file.bytes(sum(&begin)?, sum(own)?)?);
        let first = (from * block / size) as usize;
        let count = ((to - from - 1) * block + if to == blocks { last } else { block }) / size;
        let own = range.start as usize - first..range.end as usize - first;
        Ok(Part { appended, count: count as usize, own, length })
    }

    fn document(&self, of: &Document) -> Document<'_> {
        let Document { big, header, zlib, .. } = *of;
        Document {
            big,
            header,
            zlib,
            length: self.length,
            appended: Some((&self.appended, false)),
            ..Document::default()
        }
    }

    fn array(&self, of: &Array) -> Array<'_> {
        let Array { section, number, size, components, line, .. } = *of;
        Array { section, name: of.name.clone(), number, size, components, format: Format::Appended(0), line }
    }
}

/// A number that heads binary data, as it is read from bytes.
fn read(bytes: &[u8], big: bool) -> u64 {
    let place = |k: usize| if big { bytes.len() - 1 - k } else { k };
    (0..bytes.len()).fold(0, |sum, k| sum | u64::from(bytes[place(k)]) << (8 * k))
}

/// The same as it is written.
fn written(number: u64, document: &Document) -> Vec<u8> {
    let mut bytes = number.to_le_bytes()[..document.header].to_vec();
    if document.big {
        bytes.reverse();
    }
    bytes
}
