//! Keys of `[[fix]]` and `[[load]]`.

use super::super::kind::{Kind, Rules, key};
use super::{FIELDS, ON, ON_DOC, REGION};

pub(super) static FIX: Rules = Rules {
    doc: "Prescribed displacements of a region.",
    one_of: &[],
    keys: &[
        key("on", REGION, ON, ON_DOC).required(),
        key("components", Kind::Text, "components = \"xy\"", "The components held, some of x, y, z in any order.").default("\"xyz\""),
        key("value", Kind::Either(&[Kind::List { of: &Kind::Field, from: 1, to: 3 }, Kind::Field]), "value = [0, 0, \"-1e-3*t\"]", "Their values, one for each of `components` in its order: numbers or expressions in x, y, z, t; 0 if absent. A single component needs no list.")
            .unit("length"),
    ],
};

pub(super) static LOAD: Rules = Rules {
    doc: "A load on a region.",
    one_of: &["traction", "pressure", "force", "gravity"],
    keys: &[
        key(
            "on",
            REGION,
            ON,
            "Where it acts: boundary faces, or for gravity volume groups (everywhere if absent). A group, a list of groups or { box = [[x0, y0, z0], [x1, y1, z1]] }.",
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
        key("gravity", FIELDS, "gravity = [0, 0, -9.81]", "Acceleration, acting on the density of the materials.")
            .unit("acceleration"),
        key("temperature", TEMPERATURE, "temperature = 80", "Temperature."),
    ],
};

const TEMPERATURE: Kind = Kind::Absent {
    what: "thermal loads are not available in this version",
    remedy: "use traction, pressure, force or gravity",
};
