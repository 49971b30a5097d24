//! Keys of the rigid obstacles of `[[contact]]`.

use super::super::kind::{Key, Kind, POSITIVE, Rules, key};
use super::{FIELDS, POINT};

pub(super) static OBSTACLE: Rules = Rules {
    doc: "A rigid obstacle.",
    one_of: &["plane", "sphere", "cylinder"],
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
            "motion",
            FIELDS,
            "motion = [0, 0, \"-0.1*t\"]",
            "Translation of the obstacle from where it is given; numbers or expressions in t. Small: the gap changes along its normal.",
        )
        .unit("length"),
    ],
};

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
    Kind::Choice {
        names: &[("outside", "the body lies outside"), ("inside", "the body lies inside, as in a bore")],
        absent: &[],
    },
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
