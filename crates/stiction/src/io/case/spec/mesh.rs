//! Keys of `[mesh]` and its parts.

use super::super::kind::{ANY, Key, Kind, Limits, POSITIVE, Rules, choice, key};
use super::{POINT, VALUES};
use crate::mesh::MOST_DEGREES;

pub(super) static MESH: Rules = Rules {
    doc: "Where the mesh comes from.",
    one_of: &["block", "ring", "file", "parts"],
    keys: &[
        MESH_BLOCK,
        MESH_RING,
        MESH_FILE,
        key(
            "parts",
            Kind::Named(&PART),
            "[mesh.parts.ring]",
            "Several meshes under names of your choice; the group z-max of the part ring is called ring.z-max, and ring are all its cells.",
        ),
        MESH_SCALE,
        MESH_TURN,
        MESH_MOVE,
    ],
};

static PART: Rules = Rules {
    doc: "A part of the mesh.",
    one_of: &["block", "ring", "file"],
    keys: &[MESH_BLOCK, MESH_RING, MESH_FILE, MESH_SCALE, MESH_TURN, MESH_MOVE],
};

const MESH_BLOCK: Key = key(
    "block",
    Kind::Table(&BLOCK),
    "block = { size = [3, 1, 1], cells = [24, 8, 8] }",
    "A box of cells with the groups x-min, x-max, y-min, y-max, z-min, z-max and body.",
);
const MESH_RING: Key = key(
    "ring",
    Kind::Table(&RING),
    "ring = { radii = [20, 40], height = 10, degrees = 90, cells = [4, 24, 2] }",
    "A piece of a ring or tube about the z axis, from the x axis towards the y axis, with the groups inner, outer, start, end, z-min, z-max and body.",
);
const MESH_FILE: Key = key(
    "file",
    Kind::Text,
    "file = \"part.msh\"",
    "A mesh file, .msh (Gmsh 2.2, 4.1), .inp (Abaqus, CalculiX) or .vtu, relative to the folder of the case file.",
);
const MESH_SCALE: Key =
    key("scale", Kind::Number(POSITIVE), "scale = 1e-3", "Factor on the coordinates of the file.").default("1");
const MESH_TURN: Key = key(
    "turn",
    Kind::Table(&TURN),
    "turn = { axis = [0, 0, 1], degrees = 30 }",
    "Turns the mesh about a line, after it was scaled.",
);
const MESH_MOVE: Key =
    key("move", POINT, "move = [0, 0, 1]", "Moves the mesh, after it was turned.").default("[0, 0, 0]").unit("length");

pub(super) static TURN: Rules = Rules {
    doc: "A turn about a line.",
    one_of: &[],
    keys: &[
        key("axis", POINT, "axis = [0, 0, 1]", "The direction of the line, of any length.").required(),
        key("degrees", Kind::Number(ANY), "degrees = 30", "The angle, as a right-handed screw along the axis.")
            .required()
            .unit("degree"),
        key("point", POINT, "point = [0, 0, 0]", "A point of the line.").default("[0, 0, 0]").unit("length"),
    ],
};

static BLOCK: Rules = Rules {
    doc: "A box of cells.",
    one_of: &[],
    keys: &[
        key("size", VALUES, "size = [3, 1, 1]", "Lengths of the edges along x, y, z.")
            .required()
            .unit("length"),
        key("cells", CELLS, "cells = [24, 8, 8]", "Number of cells (boxes, before any cut into tetrahedra) along x, y, z.")
            .required(),
        key("element", ELEMENT, "element = \"tet4\"", "The element.").default("\"tet4\""),
        key("split", SPLIT, "split = \"five\"", "How each box is cut into tetrahedra; only for tet4 and tet10, where \"five\" is the default."),
        key("parity", Kind::Whole { from: 0, to: 1 }, "parity = 0", "For split = \"five\": at 0 (the default) the central tetrahedron of the cell at the origin stands on the corners 100 010 001 111, at 1 on the other four."),
        key("origin", POINT, "origin = [0, 0, 0]", "The lowest corner.").default("[0, 0, 0]").unit("length"),
        key("grading", GRADINGS, "grading = [1, 1, 5]", "Length of the last cell over that of the first along x, y, z; between them the lengths form a geometric sequence.")
            .default("[1, 1, 1]"),
    ],
};

static RING: Rules = Rules {
    doc: "A piece of a ring or tube: a box of cells bent about the z axis.",
    one_of: &[],
    keys: &[
        key(
            "radii",
            Kind::List { of: &Kind::Number(POSITIVE), from: 2, to: 2 },
            "radii = [20, 40]",
            "Inner and outer radius.",
        )
        .required()
        .unit("length"),
        key("height", Kind::Number(POSITIVE), "height = 10", "Length along z, from z = 0.").required().unit("length"),
        key(
            "degrees",
            Kind::Number(RING_ANGLE),
            "degrees = 90",
            "The angle it spans; of a whole ring take a half between planes of symmetry.",
        )
        .required()
        .unit("degree"),
        key("cells", CELLS, "cells = [4, 24, 2]", "Number of cells along the radius, around and along z.").required(),
        key("element", ELEMENT, "element = \"hex8\"", "The element.").default("\"tet4\""),
        key("split", SPLIT, "split = \"five\"", "How each box is cut into tetrahedra, as for a block."),
        key("parity", Kind::Whole { from: 0, to: 1 }, "parity = 0", "For split = \"five\", as for a block."),
        key(
            "grading",
            GRADINGS,
            "grading = [5, 1, 1]",
            "Length of the last cell over that of the first along the radius, around and along z.",
        )
        .default("[1, 1, 1]"),
    ],
};

/// The largest angle is that of [`crate::mesh::MOST_DEGREES`].
const RING_ANGLE: Limits = Limits { low: 0.0, low_included: false, high: MOST_DEGREES, high_included: true, ..ANY };

const CELLS: Kind = Kind::List { of: &Kind::Whole { from: 1, to: 100_000 }, from: 3, to: 3 };
const GRADINGS: Kind = Kind::List { of: &Kind::Number(GRADING), from: 3, to: 3 };
const GRADING: Limits = Limits { low: 1e-3, low_included: true, high: 1e3, high_included: true, ..ANY };

const ELEMENT: Kind = Kind::Choice {
    names: &[
        ("tet4", "linear tetrahedra"),
        ("hex8", "trilinear hexahedra"),
        ("tet10", "quadratic tetrahedra"),
        ("hex20", "quadratic hexahedra with 20 nodes"),
        ("wedge6", "linear wedges along z, two in each box"),
        ("wedge15", "quadratic wedges with 15 nodes"),
    ],
    absent: &[("hex27", "use \"hex20\"")],
};
const SPLIT: Kind = choice(&[
    ("five", "five tetrahedra, mirrored from box to box"),
    ("six", "six tetrahedra around the diagonal from the lowest to the highest corner"),
]);
