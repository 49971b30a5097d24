//! What sets hold once the sets they name are looked up.

use std::collections::HashMap;
use std::rc::Rc;

use super::deck::{Deck, FaceLabel, Kind, Members, Set, Sets};
use super::place::{BESIDES, Model, TIMES_INPUT};
use crate::Error;

/// Sets within sets: more are taken for a set that holds itself.
const DEEPEST: usize = 64;
/// Numbers that nothing has which are passed in the time of one that something has.
const GAP: usize = 16;

/// Members of a set, as numbers in the model.
#[derive(Default)]
pub(in crate::io) struct Found {
    /// Nodes, ascending.
    pub nodes: Vec<u32>,
    /// Elements, ascending.
    pub elements: Vec<u32>,
    /// Elements and which of their faces (surfaces).
    pub sides: Vec<(u32, u8)>,
    /// Elements all whose boundary faces belong to a surface.
    pub skin: Vec<u32>,
    /// Labels that nothing has.
    pub missing: Vec<u32>,
}

/// A set in a scope: scope, kind, number.
type Key = (usize, Kind, usize);

pub(in crate::io) struct Resolver<'a> {
    deck: &'a Deck,
    model: &'a Model,
    known: HashMap<Key, Rc<Found>>,
    /// Members that may still be listed before memory would be out of proportion to the input.
    left: usize,
    /// Numbers that ranges may still visit.
    visits: usize,
}

impl<'a> Resolver<'a> {
    pub(super) fn new(deck: &'a Deck, model: &'a Model) -> Self {
        let left = (TIMES_INPUT * deck.bytes + BESIDES) / size_of::<u32>();
        Resolver { deck, model, known: HashMap::new(), left, visits: left }
    }

    /// The members of the set called `name` as cards of that scope call it, `None` if there is none.
    pub(in crate::io) fn find(&mut self, scope: usize, kind: Kind, name: &str) -> Option<Result<Rc<Found>, Error>> {
        let key = self.named(scope, kind, name)?;
        Some(self.members(key))
    }

    /// The node or element with that number in a scope.
    pub(in crate::io) fn labelled_in(&self, scope: usize, label: u32, node: bool) -> Option<u32> {
        find(self.model, scope, label, node)
    }

    /// A node or element as cards call it: by `INSTANCE.17`.
    pub(in crate::io) fn qualified(&self, name: &str, node: bool) -> Option<u32> {
        let (scope, label) = self.labelled(name)?;
        find(self.model, scope, label, node)
    }

    /// The name of a set as its first line spells it.
    pub(in crate::io) fn spelling(&self, scope: usize, kind: Kind, name: &str) -> Option<&'a str> {
        self.named(scope, kind, name).map(|key| self.set(key).name.as_str())
    }

    /// All sets of a kind that cards of that scope can name.
    pub(in crate::io) fn names(&self, scope: usize, kind: Kind) -> Vec<&'a str> {
        self.sets(scope, kind).list.iter().map(|set| set.name.as_str()).collect()
    }

    fn set(&self, (scope, kind, number): Key) -> &'a Set {
        &self.sets(scope, kind).list[number]
    }

    fn sets(&self, scope: usize, kind: Kind) -> &'a Sets {
        &self.deck.parts[self.model.scopes[scope].part].sets[kind as usize]
    }

    /// The members of a set.
    pub(super) fn members(&mut self, key: Key) -> Result<Rc<Found>, Error> {
        self.at_depth(key, 0)
    }

    fn at_depth(&mut self, key: Key, depth: usize) -> Result<Rc<Found>, Error> {
        if let Some(found) = self.known.get(&key) {
            return Ok(found.clone());
        }
        let set = self.set(key);
        let fail = |what: String, remedy: &str| {
            let kind = ["node set", "element set", "surface"][key.1 as usize];
            Error::new(format!("{kind} {} ({})", set.name, set.place), what, remedy)
        };
        if depth > DEEPEST {
            return Err(fail("it holds itself, or sets are nested too deeply".into(), "list the members themselves"));
        }
        let mut found = Found::default();
        for members in &set.members {
            // an error of a set within this one has its place already
            let placed = |e: Error| if e.place.is_empty() { fail(e.what, &e.remedy) } else { e };
            self.add(key, members, depth, &mut found).map_err(placed)?;
        }
        for list in [&mut found.nodes, &mut found.elements, &mut found.skin, &mut found.missing] {
            list.sort_unstable();
            list.dedup();
        }
        let count = found.nodes.len() + found.elements.len() + found.skin.len() + 2 * found.sides.len();
        let Some(left) = self.left.checked_sub(count) else {
            return Err(fail("the sets hold far more than the input".into(), "list each member in few sets"));
        };
        self.left = left;
        let found = Rc::new(found);
        self.known.insert(key, found.clone());
        Ok(found)
    }

    fn add(&mut self, key: Key, members: &Members, depth: usize, out: &mut Found) -> Result<(), Error> {
        let scope = match &members.instance {
            Some(name) => self.scope(name).ok_or_else(|| {
                Error::new("", format!("there is no instance {name}"), "name an *INSTANCE of the assembly")
            })?,
            None => key.0,
        };
        let nodal = key.1 == Kind::Nodes || members.nodal;
        for &label in &members.labels {
            let list = if nodal { &mut out.nodes } else { &mut out.elements };
            match find(self.model, scope, label, nodal) {
                Some(index) => list.push(index),
                None => out.missing.push(label),
            }
        }
        self.ranges(scope, members, nodal, out)?;
        for &(label, face) in &members.faces {
            match (find(self.model, scope, label, false), face) {
                (Some(element), FaceLabel::Side(side)) => out.sides.push((element, side)),
                (Some(element), FaceLabel::Boundary) => out.skin.push(element),
                (None, _) => out.missing.push(label),
            }
        }
        for name in &members.names {
            if let Some(inner) = self.named(scope, name.kind, &name.name) {
                let inner = self.at_depth(inner, depth + 1)?;
                self.append(&inner, key.1, name.kind, name.face, out)?;
            } else if let Some((scope, label)) = self.labelled(&name.name) {
                let single = find(self.model, scope, label, nodal);
                match (single, key.1, name.face) {
                    (None, ..) => out.missing.push(label),
                    (Some(node), ..) if nodal => out.nodes.push(node),
                    (Some(element), Kind::Surface, FaceLabel::Side(side)) => out.sides.push((element, side)),
                    (Some(element), Kind::Surface, FaceLabel::Boundary) => out.skin.push(element),
                    (Some(element), ..) => out.elements.push(element),
                }
            } else {
                let what = format!("it names \"{}\", which is no set of the input", name.name);
                return Err(Error::new("", what, "define it, or correct its name"));
            }
        }
        Ok(())
    }

    /// Members of another set.
    fn append(
        &self,
        inner: &Found,
        kind: Kind,
        inner_kind: Kind,
        face: FaceLabel,
        out: &mut Found,
    ) -> Result<(), Error> {
        let had = out.nodes.len() + out.elements.len() + out.skin.len() + 2 * out.sides.len();
        let more = inner.nodes.len() + inner.elements.len() + inner.skin.len() + 2 * inner.sides.len();
        if had + more > self.left {
            return Err(Error::new("", "the sets hold far more than the input", "list each member in few sets"));
        }
        match (kind, inner_kind, face) {
            // the nodes of elements
            (Kind::Nodes, Kind::Elements, _) => {
                out.nodes.extend(inner.elements.iter().flat_map(|&e| self.model.element_nodes(e)));
            }
            (Kind::Surface, Kind::Elements, FaceLabel::Side(side)) => {
                out.sides.extend(inner.elements.iter().map(|&e| (e, side)));
            }
            (Kind::Surface, Kind::Elements, FaceLabel::Boundary) => out.skin.extend(&inner.elements),
            _ => {
                out.nodes.extend(&inner.nodes);
                out.elements.extend(&inner.elements);
                out.sides.extend(&inner.sides);
                out.skin.extend(&inner.skin);
            }
        }
        Ok(())
    }

    /// All numbers of `first, last, step` that something has.
    fn ranges(&mut self, scope: usize, members: &Members, nodal: bool, out: &mut Found) -> Result<(), Error> {
        let scope_of = only_one(self.model, scope, nodal);
        let labels = &self.model.scopes[scope_of];
        let mut ranges = members.ranges.clone();
        // ranges without gaps are joined where they overlap
        ranges.sort_unstable_by_key(|r| (r[2], r[0]));
        ranges.dedup_by(|next, kept| {
            let joined = next[2] == 1 && kept[2] == 1 && next[0] <= kept[1].saturating_add(1);
            if joined {
                kept[1] = kept[1].max(next[1]);
            }
            joined
        });
        let list = if nodal { &mut out.nodes } else { &mut out.elements };
        for [first, last, step] in ranges {
            let mut at = first;
            while let Some(label) = labels.next(at, nodal).filter(|&l| l <= last) {
                let cost = 1 + (label - at) as usize / GAP;
                let Some(left) = self.visits.checked_sub(cost) else {
                    return Err(Error::new("", "its ranges overlap again and again", "list each member once"));
                };
                self.visits = left;
                // the next number of the range that is not below this label
                let steps = (label - first).div_ceil(step);
                let Some(wanted) = steps.checked_mul(step).and_then(|d| first.checked_add(d)) else { break };
                let mut next = Some(wanted);
                if wanted == label {
                    list.extend(labels.find(label, nodal));
                    next = label.checked_add(1);
                }
                let Some(next) = next else { break };
                at = next;
            }
        }
        Ok(())
    }

    fn scope(&self, instance: &str) -> Option<usize> {
        let named = |scope: &super::place::Scope| !scope.name.is_empty() && scope.name.eq_ignore_ascii_case(instance);
        self.model.scopes.iter().position(named)
    }

    /// The set called `name` as seen from a scope: its own, one of the assembly, `INSTANCE.NAME`, or of the only part.
    fn named(&self, scope: usize, kind: Kind, name: &str) -> Option<Key> {
        let within = |scope: usize, name: &str| self.sets(scope, kind).find(name).map(|number| (scope, kind, number));
        let qualified = || {
            let (instance, rest) = name.split_once('.')?;
            within(self.scope(instance)?, rest)
        };
        let single = || (self.model.scopes.len() == 2).then(|| within(1, name)).flatten();
        within(scope, name).or_else(|| within(0, name)).or_else(qualified).or_else(single)
    }

    /// `INSTANCE.17`.
    fn labelled(&self, name: &str) -> Option<(usize, u32)> {
        let (instance, label) = name.split_once('.')?;
        Some((self.scope(instance)?, label.parse().ok()?))
    }
}

/// A label of what stands in no part may mean the only instance.
fn only_one(model: &Model, scope: usize, nodal: bool) -> usize {
    let empty = || model.scopes[0].next(0, nodal).is_none();
    if scope == 0 && model.scopes.len() == 2 && empty() { 1 } else { scope }
}

fn find(model: &Model, scope: usize, label: u32, nodal: bool) -> Option<u32> {
    model.scopes[only_one(model, scope, nodal)].find(label, nodal)
}
