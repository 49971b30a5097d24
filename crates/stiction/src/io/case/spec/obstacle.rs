//! Keys of the rigid obstacles of `[[contact]]`.

use super::super::kind::{ANY, Key, Kind, Limits, POSITIVE, Rules, choice, key};
use super::mesh::TURN;
use super::{FIELDS, POINT};

pub(super) static OBSTACLE: Rules = Rules {
    doc: "A rigid obstacle.",
    one_of: &["plane", "sphere", "cylinder", "surface"],
    keys: &[
        key("plane", Kind::Table(&PLANE), "plane = { point = [0, 0, 0], normal = [0, 0, 1] }", "A half space."),
        key("sphere", Kind::Table(&SPHERE), "sphere = { center = [0, 0, -1], radius = 1 }", "A sphere."),
        key(
            "cylinder",
            Kind::Table(&CYLINDER),
            "cylinder = { point = [0, 0, -1], axis = [0, 1, 0], radius = 1 }",
            "A cylinder without ends.",
        ),
        key(
            "surface",
            Kind::Text,
            "surface = \"die.stl\"",
            "A file of triangles, .stl (text or binary) or .obj, open or closed, relative to the folder of the case file. Its normals point towards the body.",
        ),
        key("scale", Kind::Number(POSITIVE), "scale = 1e-3", "Of a surface: factor on its coordinates.").default("1"),
        key(
            "turn",
            Kind::Table(&TURN),
            "turn = { axis = [0, 0, 1], degrees = 30 }",
            "Of a surface: turns it about a line, after it was scaled.",
        ),
        key("move", POINT, "move = [0, 0, 1]", "Of a surface: moves it, after it was turned.")
            .default("[0, 0, 0]")
            .unit("length"),
        SURFACE_SIDE,
        key(
            "feature_angle",
            Kind::Number(ANGLE),
            "feature_angle = 30",
            "Of a surface: where it bends by more it has an edge, elsewhere it stands for a smooth surface.",
        )
        .default("30")
        .unit("degree"),
        key(
            "motion",
            FIELDS,
            "motion = [0, 0, \"-0.1*t\"]",
            "Translation of the obstacle from where it is given; numbers or expressions in t. Small: the gap changes along its normal.",
        )
        .unit("length"),
    ],
};

const ANGLE: Limits = Limits { low: 0.0, low_included: true, high: 180.0, high_included: true, ..ANY };

const SURFACE_SIDE: Key = key(
    "side",
    choice(&[
        ("outside", "the normals of the triangles point towards the body"),
        ("inside", "they point away from it"),
    ]),
    "side = \"outside\"",
    "Of a surface: on which of its sides the body lies.",
)
.default("\"outside\"");

static PLANE: Rules = Rules {
    doc: "A rigid half space.",
    one_of: &[],
    keys: &[
        key("point", POINT, "point = [0, 0, 0]", "A point of its surface.").required().unit("length"),
        key(
            "normal",
            POINT,
            "normal = [0, 0, 1]",
            "The normal that points out of the obstacle, towards the body; of any length.",
        )
        .required(),
    ],
};

const RADIUS: Key = key("radius", Kind::Number(POSITIVE), "radius = 1", "The radius.").required().unit("length");
const SIDE: Key = key(
    "side",
    choice(&[("outside", "the body lies outside"), ("inside", "the body lies inside, as in a bore")]),
    "side = \"outside\"",
    "On which side of the surface the body lies.",
)
.default("\"outside\"");

static SPHERE: Rules = Rules {
    doc: "A rigid sphere.",
    one_of: &[],
    keys: &[key("center", POINT, "center = [0, 0, -1]", "The centre.").required().unit("length"), RADIUS, SIDE],
};

static CYLINDER: Rules = Rules {
    doc: "A rigid cylinder without ends.",
    one_of: &[],
    keys: &[
        key("point", POINT, "point = [0, 0, -1]", "A point of the axis.").required().unit("length"),
        key("axis", POINT, "axis = [0, 1, 0]", "The direction of the axis, of any length.").required(),
        RADIUS,
        SIDE,
    ],
};
