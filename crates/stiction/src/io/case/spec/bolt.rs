//! Keys of `[[bolt]]`.

use super::super::kind::{Kind, Rules, key};
use super::{POINT, REGION};

pub(super) static BOLT: Rules = Rules {
    doc: "A bolt that is tightened: across a cut through its shank its two parts are drawn together along its axis.",
    one_of: &["force", "shortening"],
    keys: &[
        key("name", Kind::Text, "name = \"bolt 1\"", "Name in the results; that of its group if absent."),
        key(
            "on",
            REGION,
            "on = \"shank\"",
            "A group of faces between cells, which is the cut, or the cells of the bolt, which a plane cuts.",
        )
        .required(),
        key(
            "axis",
            POINT,
            "axis = [0, 0, 1]",
            "The axis, of any length; of a cut that is a group of faces their normal if absent.",
        ),
        key(
            "point",
            POINT,
            "point = [0, 0, 15]",
            "A point of the plane that cuts the cells; their middle along the axis if absent.",
        )
        .unit("length"),
        key("force", Kind::Field, "force = \"2e4*min(t, 1)\"", "Tension in the bolt; a number or an expression in t.")
            .unit("force"),
        key(
            "shortening",
            Kind::Field,
            "shortening = 0.02",
            "How far its parts are drawn together: turns of the nut times the pitch; a number or an expression in t.",
        )
        .unit("length"),
        key(
            "lock",
            Kind::Text,
            "lock = \"tighten\"",
            "Name of the step at whose end the bolt is locked: from then on its shortening stays, and its force follows from the loads.",
        ),
    ],
};
