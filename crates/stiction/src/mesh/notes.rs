//! What a user should know about a mesh that can be used nevertheless.

use std::fmt;

/// Remarks made while a mesh was built, in the order of the build.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MeshNotes(pub Vec<MeshNote>);

/// One remark; its `Display` is a sentence without a full stop. Numbers of nodes and elements are those of the file.
#[derive(Debug, Clone, PartialEq)]
pub enum MeshNote {
    /// Nodes of no cell, which were dropped, and the first of them.
    OrphanNodes {
        /// How many.
        count: usize,
        /// The first of them.
        first: Vec<u64>,
    },
    /// A group in which nothing is left.
    EmptyGroup {
        /// Name of the group.
        group: String,
    },
    /// Nodes of a group that belong to no cell and were left out.
    GroupNodesDropped {
        /// Name of the group.
        group: String,
        /// How many.
        count: usize,
        /// The first of them.
        first: Vec<u64>,
    },
    /// Faces of a group that are the face of no cell; left out where a node belongs to no cell.
    LooseFaces {
        /// Name of the group.
        group: String,
        /// How many.
        count: usize,
    },
    /// Faces of a group that lie between two cells.
    InteriorFaces {
        /// Name of the group.
        group: String,
        /// How many.
        count: usize,
    },
    /// One name for things of several dimensions, which form one group.
    SharedName {
        /// Name of the group.
        group: String,
    },
    /// Boundary nodes closer than `distance` (length) to another, each with one such partner; the first pair.
    CoincidentNodes {
        /// How many pairs.
        pairs: usize,
        /// Length.
        distance: f64,
        /// The first of them.
        first: [u64; 2],
    },
    /// Faces of hexahedra that lie on triangles of tetrahedra without being joined to them, and the first hexahedra.
    UnjoinedFaces {
        /// How many.
        count: usize,
        /// The first of them.
        first: Vec<u64>,
    },
    /// Elements of lower dimension that a file holds outside any group: `what` in the singular, how many.
    Skipped {
        /// What it is.
        what: String,
        /// How many.
        count: usize,
    },
    /// Parts of a file that say nothing of the mesh, or nothing that is used.
    NotRead {
        /// What it is.
        what: Vec<String>,
    },
    /// Boundary edges of linear cells that were made round, and those that stay straight though the surface is curved there.
    RoundedFacets {
        /// How many were moved.
        moved: usize,
        /// By how much at most, length.
        most: f64,
        /// How many stay straight.
        straight: usize,
    },
    /// Faces all of whose corners supports hold in one direction, no one of which has them all.
    HeldPieceByPiece {
        /// How many.
        faces: usize,
    },
    /// Numbers in a set that no node or element has, and the first of them.
    UnknownMembers {
        /// Name of the group.
        group: String,
        /// How many.
        count: usize,
        /// The first of them.
        first: Vec<u64>,
    },
    /// A set that shares its `name` with another of other nodes, and the group it became.
    Renamed {
        /// The name that is shared.
        name: String,
        /// Name of the group.
        group: String,
    },
}

impl fmt::Display for MeshNotes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|note| writeln!(f, "{note}"))
    }
}

impl fmt::Display for MeshNote {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            MeshNote::OrphanNodes { count, first } => {
                write!(f, "{} dropped: no cell uses {}", many(*count, "node"), list(first, *count))
            }
            MeshNote::EmptyGroup { group } => write!(f, "group \"{group}\" is empty"),
            MeshNote::GroupNodesDropped { group, count, first } => {
                let nodes = many(*count, "node");
                write!(f, "group \"{group}\" lost {nodes} that no cell uses: {}", list(first, *count))
            }
            MeshNote::LooseFaces { group, count } => {
                write!(f, "group \"{group}\" has {} that no cell owns", many(*count, "face"))
            }
            MeshNote::InteriorFaces { group, count } => {
                write!(f, "group \"{group}\" has {} between two cells, not on the boundary", many(*count, "face"))
            }
            MeshNote::SharedName { group } => {
                write!(f, "\"{group}\" names sets of several dimensions, which form one group")
            }
            MeshNote::CoincidentNodes { pairs, distance, first: [a, b] } => {
                let pairs = many(*pairs, "pair");
                write!(f, "{pairs} of boundary nodes closer than {distance:.1e} are not joined, first {a} and {b}")
            }
            MeshNote::UnjoinedFaces { count, first } => {
                let faces = many(*count, "face");
                write!(f, "{faces} of hexahedra touch tetrahedra without being joined: {}", list(first, *count))
            }
            MeshNote::RoundedFacets { moved, most, straight } => {
                let stay = match straight {
                    0 => String::new(),
                    _ => format!("; {} where the surface is curved stay straight", many(*straight, "edge")),
                };
                write!(f, "{} of facets made round, by up to {most:.3e}{stay}", many(*moved, "edge"))
            }
            MeshNote::HeldPieceByPiece { faces } => {
                let what = "the corners are held by different supports: nothing holds what lies between them on finer meshes; name the nodes \
                            in one group, or give their displacements as an expression";
                write!(f, "at {} {what}", many(*faces, "face"))
            }
            MeshNote::Skipped { what, count } => write!(f, "{} in no group, not used", many(*count, what)),
            MeshNote::NotRead { what } => {
                let shown = what[..what.len().min(NAMES_SHOWN)].join(", ");
                let more = what.len().saturating_sub(NAMES_SHOWN);
                write!(f, "not read: {shown}{}", if more > 0 { format!(" and {more} more") } else { String::new() })
            }
            MeshNote::UnknownMembers { group, count, first } => {
                let numbers = many(*count, "number");
                write!(f, "group \"{group}\" lists {numbers} that nothing has: {}", list(first, *count))
            }
            MeshNote::Renamed { name, group } => {
                write!(f, "\"{name}\" names several sets with different nodes; one of them is called \"{group}\"")
            }
        }
    }
}

/// How many of the numbers of a list are shown.
pub(super) const SHOWN: usize = 5;

/// How many names of a list are shown.
const NAMES_SHOWN: usize = 12;

/// "1 node", "2 nodes".
pub(crate) fn many(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// "3, 7, 9 and 12 more".
pub(super) fn list(first: &[u64], count: usize) -> String {
    let shown: Vec<String> = first.iter().take(SHOWN).map(u64::to_string).collect();
    match count.saturating_sub(shown.len()) {
        0 => shown.join(", "),
        more => format!("{} and {more} more", shown.join(", ")),
    }
}
