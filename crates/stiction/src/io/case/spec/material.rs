//! Keys of `[materials.NAME]`.

use super::super::kind::{ANY, Kind, Limits, NOT_NEGATIVE, POSITIVE, Rules, key};
use super::GROUPS;

pub(super) static MATERIAL: Rules = Rules {
    doc: "An isotropic linear elastic material.",
    one_of: &[],
    keys: &[
        key("young", Kind::Number(POSITIVE), "young = 210e9", "Young's modulus.").required().unit("stress"),
        key("poisson", Kind::Number(POISSON), "poisson = 0.3", "Poisson's ratio.").required(),
        key("density", Kind::Number(NOT_NEGATIVE), "density = 7850", "Mass per volume, on which gravity acts.")
            .default("0")
            .unit("mass per volume"),
        key(
            "on",
            GROUPS,
            "on = \"body\"",
            "The volume group or groups of this material; may be left out if there is only one material.",
        ),
        key("formulation", FORMULATION, "formulation = \"auto\"", "How the strain of hexahedra is integrated.")
            .default("\"auto\""),
        key("expansion", EXPANSION, "expansion = 12e-6", "Thermal expansion."),
    ],
};

const POISSON: Limits = Limits {
    low: -1.0,
    high: 0.5,
    remedy: "most metals have about 0.3, rubber nearly 0.5",
    special: Some((
        0.5,
        "poisson = 0.5 is an incompressible material, whose pressure the displacements do not determine",
        "use a value just below, for instance 0.49 with hex8 cells, where formulation = \"b-bar\" avoids locking",
    )),
    ..ANY
};
const FORMULATION: Kind = Kind::Choice {
    names: &[
        ("auto", "b-bar where poisson exceeds 0.45, full elsewhere"),
        ("full", "2 x 2 x 2 Gauss points"),
        ("b-bar", "the volumetric strain is averaged over the cell, which avoids locking"),
    ],
    absent: &[],
};
const EXPANSION: Kind = Kind::Absent {
    what: "thermal expansion is not available in this version",
    remedy: "take `expansion` out, or prescribe the displacement it would cause in a [[fix]]",
};
