//! What a person should know of a posed contact and did not ask.

use std::collections::HashSet;

use super::facts::ContactFacts;
use super::regions;
use super::surfaces::shared;
use super::travel::travel_rounding;
use crate::contact::{
    ContactSurface, Counterpart, InitialGap, Obstacle, PairFacts, Role, SurfaceFacts, SurfaceFriction,
};
use crate::fem::{Material, notes};
use crate::io::case::{Case, ContactSpec, CouplingSpec};
use crate::io::text::{number, triple};
use crate::mesh::{Mesh, MeshNotes};

/// What helps where several contacts want the same nodes.
pub(crate) const SEVERAL_CONTACTS: &str =
    "name all that they meet in one contact, against = [\"..\", \"..\"], or let `slave` name the other surfaces";
/// A contact that loses more than one of so many of the nodes that touch is told.
const LEAST_OF_TAKEN: usize = 3;

/// What notes are made of.
pub(crate) struct Noted<'a> {
    pub mesh: &'a MeshNotes,
    /// That of the nodes which contacts and couplings name.
    pub nodes_of: &'a Mesh,
    pub materials: &'a [Material],
    /// The cells of each, as of [`cells_of_materials`](crate::fem::cells_of_materials).
    pub used: Vec<[bool; 3]>,
    pub contacts: &'a [ContactFacts],
    pub surfaces: &'a [ContactSurface],
    /// The contact of the case that each surface is of, by the name of the surface.
    pub specs: &'a [ContactSpec],
    /// What the motions of supports have in common, length.
    pub travel: [f64; 3],
    /// Contacts whose `search` a solve has found too short, and what it is instead; length.
    pub widened: &'a [(String, f64)],
    pub case: &'a Case,
}

impl Noted<'_> {
    /// What a person should know of the posed case and did not ask, one sentence each.
    pub(crate) fn sentences(&self) -> Vec<String> {
        let mut all: Vec<String> = self.mesh.0.iter().map(ToString::to_string).collect();
        all.extend(notes(self.materials, &self.used));
        all.extend(self.contacts.iter().flat_map(ContactFacts::notes));
        all.extend(self.rigid_contact());
        for (a, b, count) in shared(self.surfaces) {
            all.push(format!("contacts \"{a}\" and \"{b}\" share {count} faces: check that both are meant"));
        }
        let moving = self.specs.iter().filter(|contact| contact.motion.is_some());
        all.extend(
            moving.map(|contact| format!("contact \"{}\": the gap above is before its obstacle moves", contact.name)),
        );
        for contact in self.specs {
            if let Some(step) = contact.bonded_until.and_then(|step| self.case.steps.get(step)) {
                let what = format!("bonded until the step {:?} ends, then as above", step.name);
                all.push(format!("contact \"{}\": {what}", contact.name));
            }
        }
        if self.travel != [0.0; 3] {
            all.push(format!(
                "the supports travel together by {}: solved in a frame that travels with them, gaps and slips are known to {} only",
                triple(self.travel),
                number(travel_rounding(self.travel))
            ));
        }
        all.extend(self.widened.iter().map(|(name, search)| {
            let what = "the surfaces meet farther apart than they were looked for";
            format!("contact \"{name}\": {what}; `search` is {} now", number(*search))
        }));
        all.extend(self.case.notes.iter().cloned());
        all
    }

    /// Contact points that rigid couplings move: forces of more than three on a rigid face, or two on a rigid line, are not determined.
    fn rigid_contact(&self) -> Vec<String> {
        let rigid = self.case.couplings.iter().filter(|spec| spec.is_rigid());
        let of_coupling = |spec: &CouplingSpec| {
            let nodes: HashSet<u32> =
                regions::nodes(self.nodes_of, &spec.on, &spec.spot).unwrap_or_default().into_iter().collect();
            let name = spec.name.clone();
            let presses = |contact: &&ContactFacts| contact.friction != SurfaceFriction::Bonded;
            self.contacts.iter().filter(presses).filter_map(move |contact| {
                let count = contact.surface.nodes.iter().filter(|node| nodes.contains(node)).count();
                (count > 1).then(|| {
                    let with_friction = match contact.friction {
                        SurfaceFriction::None => "",
                        _ => "; friction there, and what it does to displacements, may differ with it",
                    };
                    let remedy = match contact.surface.pair {
                        Some(_) => "; let `slave` name the other surface",
                        None => "",
                    };
                    format!(
                        "contact \"{}\": {count} points are at nodes of the rigid coupling \"{name}\": where several of \
                         them press, the sum and the moment of their forces are determined, not each force and its \
                         pressure{with_friction}{remedy}",
                        contact.surface.name
                    )
                })
            })
        };
        rigid.flat_map(of_coupling).collect()
    }
}

/// Says that other contacts use many nodes of a surface.
fn much_taken(s: &SurfaceFacts, of: &str) -> Option<String> {
    let [stay, taken] = s.near;
    (taken * LEAST_OF_TAKEN > stay + taken).then(|| {
        let what = format!("other contacts use {taken} of the {} nodes{of} that touch", stay + taken);
        format!("contact \"{}\": {what}; {SEVERAL_CONTACTS}", s.name)
    })
}

impl ContactFacts {
    /// Why two surfaces have no contact point between them; `None` where they have.
    pub(crate) fn why_no_point(&self) -> Option<String> {
        let pair = self.surface.pair.as_ref().filter(|_| self.surface.points == 0)?;
        Some(format!("contact \"{}\" has no point: {}", self.surface.name, nothing(self, pair)))
    }

    /// What is probably not what was meant.
    pub(crate) fn warning(&self) -> Option<String> {
        let s = &self.surface;
        if s.points > 0 && s.facing_away == s.points {
            let all = format!("all {} points face away from the obstacle, which meets nothing then", s.points);
            return Some(format!("contact \"{}\": {all}; turn its normal around, or set its `side`", s.name));
        }
        let slave = self.surface.pair.as_ref().map(|pair| &self.names[usize::from(pair.slave == Role::Against)]);
        much_taken(&self.surface, &slave.map_or(String::new(), |slave| format!(" of {slave}")))
    }

    /// What a person should know about the pair, one sentence each.
    pub(crate) fn notes(&self) -> Vec<String> {
        let s = &self.surface;
        if let Some(pair) = &s.pair {
            let notes = of_pair(self, pair).into_iter();
            return notes.map(|note| format!("contact \"{}\": {note}", s.name)).collect();
        }
        let mut notes = Vec::new();
        if let Counterpart::Obstacle(Obstacle::Surface(surface)) = &self.against {
            if surface.collapsed > 0 {
                let what = "triangles of the obstacle have two corners at the same place and are left out";
                notes.push(format!("contact \"{}\": {} {what}", s.name, surface.collapsed));
            }
            if surface.stitched > 0 {
                let what = "corners at the border of the obstacle's triangles lie on others but for rounding and are joined to them";
                notes.push(format!("contact \"{}\": {} {what}", s.name, surface.stitched));
            }
            if surface.is_room() {
                let what = "the body lies within the closed surface of the obstacle";
                notes.push(format!("contact \"{}\": {what}", s.name));
            }
        }
        let mut note = |count: usize, what: String| {
            if count > 0 {
                notes.push(format!("contact \"{}\": {}", s.name, what));
            }
        };
        let dropped = s.clamped + s.held_along_normal;
        let why = match s.clamped {
            0 => "are held along the normal".to_string(),
            all if all == dropped => "are fixed".to_string(),
            some => format!("are held along the normal, {some} of them altogether,"),
        };
        let area = number(s.dropped_area);
        note(dropped, format!("{dropped} nodes {why} and carry no contact force; they stand for the area {area}"));
        let guided = if self.friction == SurfaceFriction::None { 0 } else { s.guided };
        note(guided, format!("{guided} points are guided: friction acts in their free directions only"));
        note(s.taken, format!("{} nodes are used by another contact", s.taken));
        behind(s).into_iter().for_each(|what| note(s.behind, what));
        note(s.beyond, format!("{} nodes lie beyond the border of the obstacle and meet nothing", s.beyond));
        let away = s.looking_away;
        note(away, format!("{away} nodes are on faces that look away from the obstacle, and carry no contact force"));
        let back = "triangles of the obstacle turn their backs to the body, nearer than those that are met";
        note(s.behind_backs, format!("at {} points {back}: turn them around, or set its `side`", s.behind_backs));
        // All of them are a warning.
        note(
            if s.facing_away < s.points { s.facing_away } else { 0 },
            format!("{} points face away from the obstacle; check the normal or `side` of the obstacle", s.facing_away),
        );
        notes
    }
}

/// Nodes that meet the counterpart of another contact first.
fn behind(s: &SurfaceFacts) -> Option<String> {
    (s.behind > 0)
        .then(|| format!("{} nodes have the counterpart of another contact in front of them and meet that", s.behind))
}

/// What a person should know about a pair, one sentence each.
fn of_pair(contact: &ContactFacts, pair: &PairFacts) -> Vec<String> {
    let s = &contact.surface;
    let mut notes = Vec::new();
    if s.points == 0 {
        notes.push(nothing(contact, pair));
    }
    let mut note = |count: usize, why: &str| {
        if count > 0 {
            notes.push(format!("{count} nodes {why}: their neighbours carry the pressure there"));
        }
    };
    note(s.clamped, "are fixed");
    note(s.held_along_normal, "are held along the normal");
    note(pair.shared, "belong to both surfaces");
    note(s.taken, "are used by another contact");
    note(pair.barely_covered, "hardly look at the other surface or lie beyond its edge");
    notes.extend(behind(s));
    if s.dropped_area > 0.0 {
        notes.push(format!(
            "the area {} carries no contact force: its nodes are all held or used",
            number(s.dropped_area)
        ));
    }
    if s.guided > 0 && contact.friction != SurfaceFriction::None {
        notes.push(format!("{} points are guided: friction acts in their free directions only", s.guided));
    }
    if s.held_along_surface > 0 {
        let what = "points are held along the surface by a support: friction acts on it and on the other body";
        notes.push(format!("{} {what}", s.held_along_surface));
    }
    let deep = -s.gap_min;
    let size = pair.face_size[0].min(pair.face_size[1]);
    if s.points > 0 && deep > size {
        let what = "the surfaces overlap by";
        notes.push(format!("{what} {}, more than a face ({}); check positions and units", number(deep), number(size)));
    } else if s.overlapping > 0 && as_meshed(contact) {
        let what = format!("the meshes overlap by up to {}, which presses the bodies apart", number(deep));
        notes.push(format!("{what}; gap = \"closed\" would ignore it"));
    }
    if pair.averted && s.points > 0 && pair.uncovered > s.points {
        notes.push("parts of the surfaces look the same way instead of at one another".into());
    }
    notes
}

fn as_meshed(contact: &ContactFacts) -> bool {
    let gap = match &contact.against {
        Counterpart::Surface(master) => &master.gap,
        Counterpart::Obstacle(_) => &InitialGap::Uniform(0.0),
    };
    *gap == InitialGap::AsMeshed && contact.friction != SurfaceFriction::Bonded
}

/// Why there is no contact point at all.
fn nothing(contact: &ContactFacts, pair: &PairFacts) -> String {
    let [on, against] = &contact.names;
    let s = &contact.surface;
    if s.points + s.taken == 0 && s.behind > 0 {
        return format!("between {on} and {against} there is everywhere the counterpart of another contact");
    }
    if pair.covered_area > 0.0 {
        return format!("no node of {on} and {against} can carry contact: all are held or used by other contacts");
    }
    if pair.averted {
        return format!("{on} and {against} look the same way and cannot touch; name the sides that face one another");
    }
    let away = pair.nearest.map_or(String::new(), |d| format!(", the nearest points are {} apart", number(d)));
    let reach = number(pair.search);
    format!("{on} and {against} nowhere face one another within {reach}{away}; check positions, or set `search`")
}
