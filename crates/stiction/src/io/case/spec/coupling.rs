//! Keys of `[[coupling]]`.

use super::super::kind::{Kind, Rules, choice, key};
use super::{FIELDS, ON_DOC, POINT, REGION};

pub(super) static COUPLING: Rules = Rules {
    doc: "A face that moves with a reference point, which has three displacements and three rotations. Rotations are small: displacements are linear in them.",
    one_of: &[],
    keys: &[
        key("name", Kind::Text, "name = \"grip\"", "Name in the results; that of its group if absent."),
        key("on", REGION, "on = \"z-max\"", ON_DOC).required(),
        key("point", POINT, "point = [0, 0, 50]", "The reference point.").required().unit("length"),
        key("kind", KIND, "kind = \"rigid\"", "How the nodes follow the point.").default("\"rigid\""),
        key(
            "components",
            Kind::Text,
            "components = \"z\"",
            "With kind = \"rigid\": the displacements of the nodes that follow the point, some of x, y, z; all if absent.",
        ),
        key(
            "motion",
            Kind::Table(&MOTION),
            "motion = { x = 0, z = \"-1e-3*t\" }",
            "Displacements of the point that are prescribed; the others are free.",
        )
        .unit("length"),
        key(
            "rotation",
            Kind::Table(&MOTION),
            "rotation = { x = 0, y = 0 }",
            "Rotations of the point that are prescribed, about x, y, z; the others are free.",
        )
        .unit("radians"),
        key("force", FIELDS, "force = [0, 0, \"-1000*t\"]", "Force at the point; numbers or expressions in t.")
            .default("[0, 0, 0]")
            .unit("force"),
        key("moment", FIELDS, "moment = [0, 50, 0]", "Moment at the point; numbers or expressions in t.")
            .default("[0, 0, 0]")
            .unit("force times length"),
        key(
            "from",
            Kind::Text,
            "from = \"draw\"",
            "Name of the step with which `motion` and `rotation` begin, from where the point stands then; the first if absent.",
        ),
        key(
            "until",
            Kind::Text,
            "until = \"press\"",
            "Name of the step at whose end they are released; the last if absent.",
        ),
    ],
};

const KIND: Kind = choice(&[
    ("rigid", "all nodes of the region move with the point as one rigid body"),
    (
        "distributing",
        "force and moment are spread over boundary faces as the traction a + b x r, and the point moves as the faces do in the mean: they stay as soft as they are",
    ),
]);

static MOTION: Rules = Rules {
    doc: "Components along or about x, y, z: numbers or expressions in t.",
    one_of: &[],
    keys: &[
        key("x", Kind::Field, "x = 0", "Along or about x; free if absent."),
        key("y", Kind::Field, "y = 0", "Along or about y; free if absent."),
        key("z", Kind::Field, "z = \"1e-3*t\"", "Along or about z; free if absent."),
    ],
};
