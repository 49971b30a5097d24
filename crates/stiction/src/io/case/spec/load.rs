//! Keys of `[[fix]]`, `[[spring]]` and `[[load]]`.

use super::super::kind::{Kind, NOT_NEGATIVE, POSITIVE, Rules, choice, key};
use super::{FIELDS, ON, ON_DOC, POINT, REGION};

pub(super) static FIX: Rules = Rules {
    doc: "Prescribed displacements of a region.",
    one_of: &[],
    keys: &[
        key("on", REGION, ON, ON_DOC).required(),
        key("components", Kind::Text, "components = \"xy\"", "The components held, some of x, y, z (about an axis: r, t, z) in any order; all if absent."),
        key("axes", Kind::Either(&[AXES, Kind::Table(&CYLINDER)]), "axes = [[1, 1, 0], [0, 0, 1]]", "What the components count along, if not x, y, z of the mesh: directions of x and, in the plane of both, of y, of any length; or { point = [0, 0, 0], axis = [0, 0, 1] }, about which r is radial, t tangential and z axial. Expressions see x, y, z of the mesh all the same."),
        key("value", Kind::Either(&[Kind::List { of: &Kind::Field, from: 1, to: 3 }, Kind::Field]), "value = [0, 0, \"-1e-3*t\"]", "Their values, one for each of `components` in its order: numbers or expressions in x, y, z, t; 0 if absent. A single component needs no list.")
            .unit("length"),
        key("from", Kind::Text, "from = \"draw\"", "Name of the step with which the support begins: during that step it leads its nodes from where they stand to `value`; the first if absent."),
        key("until", Kind::Text, "until = \"press\"", "Name of the step at whose end the support is released; the last if absent."),
        key("condition", CONDITION, "condition = \"symmetry\"", "Instead of components and value: what the faces are."),
    ],
};

const AXES: Kind = Kind::List { of: &POINT, from: 2, to: 2 };

static CYLINDER: Rules = Rules {
    doc: "A line: displacements about it are radial (r), tangential (t) and axial (z).",
    one_of: &[],
    keys: &[
        key("point", POINT, "point = [0, 0, 0]", "A point of the line.").required().unit("length"),
        key("axis", POINT, "axis = [0, 0, 1]", "Its direction, of any length.").required(),
    ],
};

const CONDITION: Kind = choice(&[
    (
        "symmetry",
        "a plane of symmetry: no displacement along the normal of the faces, which are flat and may look anywhere",
    ),
    ("as-it-stands", "held where it stands when the step of `from` begins"),
    ("at-once", "`value` holds from the beginning of the step of `from`, which otherwise leads to it on a line"),
]);

pub(super) static SPRING: Rules = Rules {
    doc: "An elastic foundation: springs from boundary faces to the ground, in pressure and tension alike.",
    one_of: &[],
    keys: &[
        key("on", REGION, ON, "The faces: a group, a list of groups or { box = [[x0, y0, z0], [x1, y1, z1]] }.")
            .required(),
        key("normal", Kind::Number(NOT_NEGATIVE), "normal = 5e7", "Stiffness per area along the normal of the faces.")
            .default("0")
            .unit("stress per length"),
        key("tangential", Kind::Number(NOT_NEGATIVE), "tangential = 1e7", "Stiffness per area across the normal.")
            .default("0")
            .unit("stress per length"),
    ],
};

pub(super) static LOAD: Rules = Rules {
    doc: "A load on a region.",
    one_of: &["traction", "pressure", "force", "moment", "nodal", "hydrostatic", "gravity", "rotation", "temperature"],
    keys: &[
        key(
            "on",
            REGION,
            ON,
            "Where it acts: boundary faces, for gravity, rotation and temperature volume groups (everywhere if absent), for nodal any nodes, also { point = [x, y, z] }. A group, a list of groups or { box = [[x0, y0, z0], [x1, y1, z1]] }.",
        ),
        key(
            "traction",
            FIELDS,
            "traction = [0, 0, \"-1e6*x\"]",
            "Force per area; numbers or expressions in x, y, z, t.",
        )
        .unit("stress"),
        key(
            "pressure",
            Kind::Field,
            "pressure = 1e5",
            "Force per area against the outward normal; a number or an expression.",
        )
        .unit("stress"),
        key(
            "force",
            FIELDS,
            "force = [0, 0, -1000]",
            "Total force, spread evenly over the area; numbers or expressions in t.",
        )
        .unit("force"),
        key(
            "moment",
            FIELDS,
            "moment = [0, 0, 50]",
            "Total moment, alone or beside `force`, spread as the traction a + b x r, with r from the centroid of the faces; numbers or expressions in t.",
        )
        .beside("force")
        .unit("force times length"),
        key(
            "about",
            POINT,
            "about = [0, 0, 0]",
            "The point through which `force` acts and about which `moment` turns; the centroid of the faces if absent.",
        )
        .unit("length"),
        key(
            "nodal",
            Kind::List { of: &Kind::Either(&[Kind::Field, Kind::Table(&NODAL)]), from: 3, to: 3 },
            "nodal = [0, 0, -5]",
            "Force at each node of the region, or of the mesh if `on` is absent: numbers, expressions in x, y, z, t, or { array = \"F\", ramp = \"t\" }.",
        )
        .unit("force"),
        key(
            "hydrostatic",
            Kind::Table(&HYDROSTATIC),
            "hydrostatic = { weight = 9810, level = 2 }",
            "Pressure of a liquid on the faces below its level.",
        ),
        key("gravity", FIELDS, "gravity = [0, 0, -9.81]", "Acceleration, acting on the density of the materials.")
            .unit("acceleration"),
        key(
            "rotation",
            Kind::Table(&ROTATION),
            "rotation = { axis = [0, 0, 1], speed = 314 }",
            "Centrifugal load of a steady turn, acting on the density of the materials.",
        ),
        key(
            "temperature",
            Kind::Either(&[Kind::Field, Kind::Table(&TEMPERATURE)]),
            "temperature = \"20 + 60*t\"",
            "Temperature of the cells, which strains them by `expansion` of their material: a number, an expression in x, y, z, t, or { array = \"T\" }.",
        )
        .unit("temperature"),
    ],
};

static NODAL: Rules = Rules {
    doc: "A component of the force at nodes, given by the mesh file.",
    one_of: &[],
    keys: &[
        key("array", Kind::Text, "array = \"F\"", "Name of an array of numbers on the points of the mesh file.")
            .required(),
        key("ramp", Kind::Field, "ramp = \"t\"", "What it is multiplied by: a number or an expression in t.")
            .default("1"),
    ],
};

static HYDROSTATIC: Rules = Rules {
    doc: "A liquid at rest.",
    one_of: &[],
    keys: &[
        key("weight", Kind::Number(POSITIVE), "weight = 9810", "Density times gravity.")
            .required()
            .unit("force per volume"),
        key(
            "level",
            Kind::Field,
            "level = \"2*t\"",
            "Height of its surface along `up`; a number or an expression in t.",
        )
        .required()
        .unit("length"),
        key("up", POINT, "up = [0, 0, 1]", "The direction up, of any length.").default("[0, 0, 1]"),
    ],
};

static ROTATION: Rules = Rules {
    doc: "A steady turn about a line.",
    one_of: &[],
    keys: &[
        key("axis", POINT, "axis = [0, 0, 1]", "The direction of the line, of any length.").required(),
        key("point", POINT, "point = [0, 0, 0]", "A point of the line.").default("[0, 0, 0]").unit("length"),
        key("speed", Kind::Field, "speed = 314", "Radians per time; a number or an expression in t.")
            .required()
            .unit("1/time"),
    ],
};

static TEMPERATURE: Rules = Rules {
    doc: "A temperature given by the mesh file.",
    one_of: &[],
    keys: &[
        key(
            "array",
            Kind::Text,
            "array = \"T\"",
            "Name of an array of numbers of the mesh file, on its points or its cells (.vtu, .msh).",
        )
        .required(),
        key(
            "ramp",
            Kind::Field,
            "ramp = \"t\"",
            "The part of the way from the reference temperature to the array: a number or an expression in t.",
        )
        .default("1"),
    ],
};
