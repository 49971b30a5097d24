//! From lines to a deck.

use std::borrow::Cow;

use super::Include;
use super::cards::Card;
use super::deck::{Deck, FaceLabel, Instance, Kind, Members, Motion, Name, Part, Sets};
use super::elements::Role;
use super::keyword::{Data, Fields, Keyword, Piece, Pieces};
use super::lines::{label, label_of, listed, ranges, surface};
use crate::Error;
use crate::io::newlines;
use crate::io::number::float;

/// Includes within includes, and includes altogether: more are taken for a file that includes itself.
const DEEPEST_INCLUDE: usize = 16;
const MOST_INCLUDES: usize = 1000;
/// Keywords of nodes, elements and sets: each may need a thousand bytes, far more than its line may have.
const MOST_KEYWORDS: usize = 100_000;
/// Keywords that a note can name; nobody reads more.
const MOST_SKIPPED: usize = 1000;
/// Parts and instances.
const MOST_INSTANCES: usize = 10_000;
/// Names of sets within sets, for the same reason.
const MOST_NAMES: usize = 1_000_000;

/// Cards that say nothing of the mesh: each takes a hundred times the memory of the shortest line.
const MOST_CARDS: usize = 100_000;

/// Keywords that make or move nodes and elements: skipping them would give another mesh.
const REFUSED: [&str; 9] =
    ["NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "SYSTEM", "SYMMETRICMODELGENERATION", "SUBSTRUCTUREGENERATE"];

/// What the data lines that follow mean.
#[derive(Clone, Copy)]
enum Section {
    Skipped,
    /// The last card.
    Kept,
    Nodes,
    /// The last block of the part.
    Elements,
    /// The last members of the set of that number.
    Set {
        kind: Kind,
        number: usize,
        generate: bool,
    },
    /// The last instance; how many of its lines were read.
    Instance {
        lines: usize,
    },
}

struct Reader<'a> {
    deck: Deck,
    include: Include<'a>,
    /// The part that is open, 0 for none.
    part: usize,
    /// The instance that is open.
    instance: Option<String>,
    section: Section,
    /// Sets that nodes or elements are added to as they come.
    into: Option<String>,
    /// Names of the files that are open, but the first.
    open: Vec<String>,
    includes: usize,
    keywords: usize,
    /// Names of sets within sets.
    names: usize,
}

/// Everything an input and its includes say: of the mesh, and with `keep` the other cards too.
pub(super) fn deck(file: Cow<[u8]>, include: Include, keep: bool) -> Result<Deck, Error> {
    let bytes = &*file;
    let start = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    if start.is_empty() {
        return Err(Error::new("", "the file is empty", "was writing it interrupted?"));
    }
    // A complete deck may have a title in front of its first keyword.
    if start[0] != b'*' && !(keep && memchr::memmem::find(start, b"\n*").is_some()) {
        let what = "this is not an Abaqus or CalculiX input: it does not begin with a keyword such as *NODE";
        return Err(Error::new("", what, "export it again as .inp, or name the file with its own ending"));
    }
    let cards = keep.then(Vec::new);
    let deck = Deck { parts: vec![Part::default()], instances: Vec::new(), skipped: Vec::new(), bytes: 0, cards };
    let mut reader = Reader {
        deck,
        include,
        part: 0,
        instance: None,
        section: Section::Skipped,
        into: None,
        open: Vec::new(),
        includes: 0,
        keywords: 0,
        names: 0,
    };
    match file {
        Cow::Borrowed(bytes) => reader.file(bytes)?,
        Cow::Owned(bytes) => reader.own_file(bytes)?,
    }
    Ok(reader.deck)
}

impl Reader<'_> {
    fn file(&mut self, bytes: &[u8]) -> Result<(), Error> {
        self.deck.bytes += bytes.len();
        for piece in Pieces::new(bytes) {
            match piece {
                Piece::Keyword(keyword) => self.keyword(&keyword)?,
                Piece::Data(data) => self.data(data)?,
            }
        }
        Ok(())
    }

    /// The same with bytes that are given back as they are read: text takes twice the memory of what it says.
    fn own_file(&mut self, mut bytes: Vec<u8>) -> Result<(), Error> {
        self.deck.bytes += bytes.len();
        let (mut left, mut line) = Pieces::new(&bytes).left();
        loop {
            let mut pieces = Pieces::from(&bytes[bytes.len() - left..], line);
            match pieces.next() {
                Some(Piece::Keyword(keyword)) => self.keyword(&keyword)?,
                Some(Piece::Data(data)) => self.data(data)?,
                None => return Ok(()),
            }
            (left, line) = pieces.left();
            let read = bytes.len() - left;
            if read > bytes.len() / 8 {
                bytes.drain(..read);
                bytes.shrink_to_fit();
            }
        }
    }

    fn keyword(&mut self, keyword: &Keyword) -> Result<(), Error> {
        if ["NODE", "ELEMENT", "NSET", "ELSET", "SURFACE"].contains(&keyword.name.as_str()) {
            self.keywords += 1;
        }
        if self.keywords > MOST_KEYWORDS {
            let what = format!("there are more than {MOST_KEYWORDS} keywords of nodes, elements and sets");
            return Err(Error::new(keyword.place(), what, "write elements of one type and set under one *ELEMENT"));
        }
        match keyword.name.as_str() {
            "INCLUDE" => return self.follow(keyword),
            "NODE" => self.nodes_begin(keyword)?,
            "ELEMENT" => self.elements_begin(keyword)?,
            "NSET" => self.set_begin(keyword, Kind::Nodes, "NSET")?,
            "ELSET" => self.set_begin(keyword, Kind::Elements, "ELSET")?,
            "SURFACE" => self.surface_begin(keyword)?,
            "PART" | "INSTANCE" if self.deck.parts.len() + self.deck.instances.len() > MOST_INSTANCES => {
                let what = format!("there are more than {MOST_INSTANCES} parts and instances");
                return Err(Error::new(keyword.place(), what, "write the assembled mesh without instances"));
            }
            "PART" => {
                self.deck.parts.push(Part { name: keyword.needed("NAME")?.to_string(), ..Part::default() });
                self.part = self.deck.parts.len() - 1;
                self.section = Section::Skipped;
            }
            "INSTANCE" => self.instance_begin(keyword)?,
            "ENDPART" | "ASSEMBLY" | "ENDASSEMBLY" | "ENDINSTANCE" => {
                (self.part, self.instance, self.section) = (0, None, Section::Skipped);
            }
            // a title for people
            "HEADING" if self.deck.cards.is_none() => self.section = Section::Skipped,
            name if REFUSED.contains(&name) => {
                let what = format!("*{} makes or moves nodes or elements and cannot be read", keyword.title);
                return Err(Error::new(keyword.place(), what, "write the input with all nodes and elements in it"));
            }
            _ if self.deck.cards.is_some() => self.keep(keyword)?,
            _ => self.skip(&keyword.title),
        }
        if matches!(self.section, Section::Nodes | Section::Elements) && keyword.get("INPUT").is_some() {
            self.follow(keyword)?;
        }
        Ok(())
    }

    /// Keeps a card for who reads the model.
    fn keep(&mut self, keyword: &Keyword) -> Result<(), Error> {
        let files: String = self.open.iter().map(|file| format!("{file}, ")).collect();
        let card = Card { keyword: keyword.clone(), files, part: self.part, data: Vec::new() };
        let Some(cards) = &mut self.deck.cards else { return Ok(()) };
        if cards.len() >= MOST_CARDS {
            let what = format!("there are more than {MOST_CARDS} cards");
            return Err(Error::new(keyword.place(), what, "gather lines of one kind under one keyword"));
        }
        cards.push(card);
        self.section = Section::Kept;
        Ok(())
    }

    /// Notes a keyword that is not read.
    fn skip(&mut self, title: &str) {
        self.section = Section::Skipped;
        let title = format!("*{title}");
        if self.deck.skipped.len() < MOST_SKIPPED && !self.deck.skipped.contains(&title) {
            self.deck.skipped.push(title);
        }
    }

    /// Reads the file a keyword names.
    fn follow(&mut self, keyword: &Keyword) -> Result<(), Error> {
        let name = keyword.needed("INPUT")?;
        self.includes += 1;
        let what = if self.open.iter().any(|open| open == name) || self.open.len() >= DEEPEST_INCLUDE {
            format!("\"{name}\" is included within itself, or more than {DEEPEST_INCLUDE} files deep")
        } else if self.includes > MOST_INCLUDES {
            format!("more than {MOST_INCLUDES} files are included")
        } else {
            match (self.include)(name) {
                Ok(bytes) if !is_part_of_deck(&bytes) => {
                    format!("the file \"{name}\" it includes holds neither keywords nor numbers")
                }
                Ok(bytes) => {
                    self.open.push(name.to_string());
                    self.file(&bytes).map_err(|e| e.at(name))?;
                    self.open.pop();
                    return Ok(());
                }
                Err(why) => format!("the file \"{name}\" it includes cannot be read ({why})"),
            }
        };
        let remedy = "put the file beside the input, and write its name as it is on the disk";
        Err(Error::new(keyword.place(), what, remedy))
    }

    fn part(&mut self) -> &mut Part {
        &mut self.deck.parts[self.part]
    }

    /// The place of a keyword with the file it is in, for messages after everything has been read.
    fn place(&self, keyword: &Keyword) -> String {
        self.open.iter().map(|file| format!("{file}, ")).collect::<String>() + &keyword.place()
    }

    /// Nodes and elements of an instance would need numbers of their own.
    fn outside_instance(&self, keyword: &Keyword) -> Result<(), Error> {
        match &self.instance {
            None => Ok(()),
            Some(name) => {
                let what = format!("instance {name} has nodes or elements of its own");
                Err(Error::new(keyword.place(), what, "put them into its part"))
            }
        }
    }

    fn nodes_begin(&mut self, keyword: &Keyword) -> Result<(), Error> {
        self.outside_instance(keyword)?;
        if let Some(system) = keyword.get("SYSTEM").filter(|s| !s.eq_ignore_ascii_case("R")) {
            let what = format!("the nodes are given in the system {system}, and only cartesian ones can be read");
            return Err(Error::new(keyword.place(), what, "write cartesian coordinates"));
        }
        self.section = Section::Nodes;
        self.add_into(keyword, Kind::Nodes, "NSET");
        Ok(())
    }

    fn elements_begin(&mut self, keyword: &Keyword) -> Result<(), Error> {
        self.outside_instance(keyword)?;
        let name = keyword.needed("TYPE")?.to_uppercase();
        match Role::of(&name) {
            Role::Refused(what, remedy) => {
                let what = format!("elements of type {name} cannot be used ({what})");
                return Err(Error::new(keyword.place(), what, remedy));
            }
            Role::Skipped if self.deck.cards.is_some() => self.keep(keyword)?,
            Role::Skipped => self.skip(&format!("ELEMENT, TYPE={name}")),
            role => {
                let place = self.place(keyword);
                let block = super::deck::Block { role, type_name: name, labels: Vec::new(), nodes: Vec::new(), place };
                self.part().blocks.push(block);
                self.section = Section::Elements;
            }
        }
        self.add_into(keyword, Kind::Elements, "ELSET");
        Ok(())
    }

    /// Makes the set that nodes or elements name at their keyword.
    fn add_into(&mut self, keyword: &Keyword, kind: Kind, parameter: &str) {
        self.into = keyword.get(parameter).filter(|name| !name.is_empty()).map(String::from);
        if let Some(name) = self.into.clone() {
            let place = self.place(keyword);
            self.sets(kind).at(&name, || place.clone()).members.push(Members::default());
        }
    }

    fn sets(&mut self, kind: Kind) -> &mut Sets {
        &mut self.part().sets[kind as usize]
    }

    fn set_begin(&mut self, keyword: &Keyword, kind: Kind, parameter: &str) -> Result<(), Error> {
        let name = keyword.needed(parameter)?;
        let mut members = self.members(keyword);
        if let Some(elset) = keyword.get("ELSET").filter(|_| kind == Kind::Nodes) {
            members.names.push(Name { name: elset.into(), kind: Kind::Elements, face: FaceLabel::Boundary });
        }
        self.begin(keyword, kind, name, members, keyword.get("GENERATE").is_some());
        Ok(())
    }

    /// From now on lines belong to `members` of the set called `name`.
    fn begin(&mut self, keyword: &Keyword, kind: Kind, name: &str, members: Members, generate: bool) {
        let place = self.place(keyword);
        let set = self.sets(kind).at(name, || place.clone());
        set.internal |= keyword.get("INTERNAL").is_some();
        set.members.push(members);
        let number = self.sets(kind).find(name).unwrap_or(0);
        self.section = Section::Set { kind, number, generate };
    }

    fn members(&self, keyword: &Keyword) -> Members {
        let instance = keyword.get("INSTANCE").map(String::from).or_else(|| self.instance.clone());
        Members { instance, ..Members::default() }
    }

    fn surface_begin(&mut self, keyword: &Keyword) -> Result<(), Error> {
        let name = keyword.needed("NAME")?;
        let kind = keyword.get("TYPE").unwrap_or("ELEMENT").to_uppercase();
        if kind != "ELEMENT" && kind != "NODE" {
            if self.deck.cards.is_some() {
                return self.keep(keyword);
            }
            self.skip(&format!("SURFACE, TYPE={kind}"));
            return Ok(());
        }
        if let Some(how) = keyword.get("COMBINE").filter(|how| !how.eq_ignore_ascii_case("UNION")) {
            let what = format!("surface {name} is made by COMBINE={how}, and only UNION can be read");
            return Err(Error::new(keyword.place(), what, "list its faces"));
        }
        let members = Members { nodal: kind == "NODE", ..self.members(keyword) };
        // of a union the lines name surfaces: recognised by `generate`, which surfaces do not have otherwise
        self.begin(keyword, Kind::Surface, name, members, keyword.get("COMBINE").is_some());
        Ok(())
    }

    fn instance_begin(&mut self, keyword: &Keyword) -> Result<(), Error> {
        let name = keyword.needed("NAME").or_else(|e| keyword.needed("INSTANCE").map_err(|_| e))?.to_string();
        if keyword.get("LIBRARY").is_some() {
            let what = format!("instance {name} comes from the results of another analysis");
            return Err(Error::new(keyword.place(), what, "write its part into the input"));
        }
        let part = keyword.needed("PART")?;
        let Some(part) = self.deck.parts.iter().skip(1).position(|p| p.name.eq_ignore_ascii_case(part)) else {
            let names: Vec<&str> = self.deck.parts.iter().skip(1).map(|p| p.name.as_str()).collect();
            let what = format!("instance {name} is of part {part}, which does not stand before it");
            return Err(Error::new(keyword.place(), what, format!("parts so far: {}", names.join(", "))));
        };
        self.deck.instances.push(Instance { name: name.clone(), part: part + 1, motion: Motion::default() });
        (self.part, self.instance, self.section) = (0, Some(name), Section::Instance { lines: 0 });
        Ok(())
    }

    fn data(&mut self, data: Data) -> Result<(), Error> {
        let fields = Fields::new(data);
        match self.section {
            Section::Skipped => Ok(()),
            Section::Kept => {
                if let Some(card) = self.deck.cards.as_mut().and_then(|cards| cards.last_mut()) {
                    card.data.push((data.line, data.bytes.to_vec()));
                }
                Ok(())
            }
            Section::Nodes => self.nodes(fields, data.bytes),
            Section::Elements => self.elements(fields, data.bytes),
            Section::Set { kind, number, generate } => {
                let set = &mut self.sets(kind).list[number];
                match (kind, generate) {
                    (Kind::Surface, union) => surface(set, fields, union)?,
                    (_, true) => ranges(set, fields)?,
                    (_, false) => listed(set, fields, kind)?,
                }
                self.names += set.members.last().map_or(0, |members| members.names.len());
                if self.names <= MOST_NAMES {
                    return Ok(());
                }
                let what = format!("more than {MOST_NAMES} names of sets within sets");
                Err(Error::new(format!("line {}", data.line), what, "list the members themselves"))
            }
            Section::Instance { lines } => self.motion(fields, lines),
        }
    }

    /// Lines `number, x, y, z`; coordinates that are missing are zero.
    fn nodes(&mut self, mut fields: Fields, bytes: &[u8]) -> Result<(), Error> {
        let into = self.into.clone();
        let part = self.part();
        let before = part.nodes.len();
        // no node is shorter than six bytes, so that blank lines do not reserve memory
        let lines = (1 + newlines(bytes)).min(1 + bytes.len() / 6);
        part.nodes.reserve(lines);
        part.node_labels.reserve(lines);
        while fields.more() {
            let label = label(&mut fields, "the number of a node")?;
            let mut x = [0.0; 3];
            for (c, x) in x.iter_mut().enumerate() {
                match fields.field() {
                    Some([]) => {}
                    Some(word) => *x = float(word).ok_or_else(|| fields.not_a(word, ["x", "y", "z"][c]))?,
                    None if c == 0 => return Err(fields.fail(format!("node {label} has no coordinates"))),
                    None => break,
                }
            }
            part.node_labels.push(label);
            part.nodes.push(x);
            fields.next_line();
        }
        if let Some(name) = into {
            let Part { sets, node_labels, .. } = part;
            if let Some(members) = sets[Kind::Nodes as usize].at(&name, String::new).members.last_mut() {
                members.labels.extend_from_slice(&node_labels[before..]);
            }
        }
        Ok(())
    }

    /// Numbers of an element and of its nodes, which may go on over the next lines.
    fn elements(&mut self, mut fields: Fields, bytes: &[u8]) -> Result<(), Error> {
        let into = self.into.clone();
        let Part { blocks, sets, .. } = self.part();
        let elsets = &mut sets[Kind::Elements as usize];
        let Some(block) = blocks.last_mut() else { return Ok(()) };
        let (before, k) = (block.labels.len(), block.role.nodes());
        // the shortest element: one digit and one comma a number
        let lines = newlines(bytes).min(bytes.len() / (2 * (k + 1)));
        block.labels.reserve(lines + 1);
        block.nodes.reserve((lines + 1) * k);
        while fields.more() {
            let number = label(&mut fields, "the number of an element")?;
            for i in 0..k {
                let node = loop {
                    match fields.field() {
                        Some(word) => break label_of(&fields, word, "the number of a node")?,
                        None => fields.next_line(),
                    }
                    if !fields.more() {
                        return Err(fields.fail(format!("element {number} has {i} nodes instead of {k}")));
                    }
                };
                block.nodes.push(node);
            }
            if fields.field().is_some_and(|word| !word.is_empty()) {
                return Err(fields.fail(format!("element {number} has more than {k} nodes")));
            }
            block.labels.push(number);
            fields.next_line();
        }
        if let Some(members) = into.and_then(|name| elsets.at(&name, String::new).members.last_mut()) {
            members.labels.extend_from_slice(&block.labels[before..]);
        }
        Ok(())
    }

    /// A line of a translation, then one of two points on an axis and an angle in degrees.
    fn motion(&mut self, mut fields: Fields, mut lines: usize) -> Result<(), Error> {
        while fields.more() {
            let mut values = Vec::new();
            while let Some(word) = fields.field() {
                let number = if word.is_empty() { Some(0.0) } else { float(word) };
                values.push(number.filter(|x| x.is_finite()).ok_or_else(|| fields.not_a(word, "a number"))?);
            }
            let motion = self.deck.instances.last_mut().map(|instance| &mut instance.motion);
            match (lines, &values[..], motion) {
                (0, &[x, y, z], Some(motion)) => motion.translation = [x, y, z],
                (1, &[a, b, c, d, e, f, degrees], Some(motion)) if [a, b, c] != [d, e, f] => {
                    motion.rotation = Some(([a, b, c], [d, e, f], degrees));
                }
                _ => {
                    let what = "an instance is placed by a line of 3 numbers and one of 7: a translation, two points of an axis and an angle";
                    return Err(fields.fail(what));
                }
            }
            lines += 1;
            fields.next_line();
        }
        self.section = Section::Instance { lines };
        Ok(())
    }
}

/// Whether a file begins as decks do, with a keyword or a number. Of any other nothing is shown, not even in a message.
fn is_part_of_deck(bytes: &[u8]) -> bool {
    let start = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    start.first().is_none_or(|c| b"*+-.,".contains(c) || c.is_ascii_digit())
}
