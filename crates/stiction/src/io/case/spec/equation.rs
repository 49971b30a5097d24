//! Keys of `[[equation]]`.

use super::super::kind::{ANY, Kind, Rules, choice, key};
use super::{POINT, REGION};

pub(super) static EQUATION: Rules = Rules {
    doc: "A linear equation between displacements of nodes: the sum of factor times displacement over all terms is `value`.",
    one_of: &[],
    keys: &[
        key(
            "terms",
            Kind::Tables(&TERM),
            "terms = [{ on = { point = [0, 0, 1] }, along = \"z\", factor = 1 }, { on = { point = [1, 0, 1] }, along = \"z\", factor = -1 }]",
            "What is added up.",
        )
        .required(),
        key("value", Kind::Field, "value = \"1e-3*t\"", "What the sum is: a number or an expression in t.")
            .default("0")
            .unit("length times factor"),
    ],
};

static TERM: Rules = Rules {
    doc: "A displacement and its factor.",
    one_of: &[],
    keys: &[
        key(
            "on",
            REGION,
            "on = { point = [0, 0, 1] }",
            "The node nearest to a point, or groups of nodes: of several the sum of their displacements.",
        )
        .required(),
        key("along", Kind::Either(&[ALONG, POINT]), "along = \"x\"", "Along x, y, z, or in a direction of any length.")
            .required(),
        key("factor", Kind::Number(ANY), "factor = -1", "Its factor.").default("1"),
    ],
};

const ALONG: Kind =
    choice(&[("x", "displacement along x"), ("y", "displacement along y"), ("z", "displacement along z")]);
