//! Keys of `[[cyclic]]`.

use super::super::kind::{Kind, POSITIVE, Rules, key};
use super::{POINT, REGION};

pub(super) static CYCLIC: Rules = Rules {
    doc: "Cyclic symmetry: the body is one of `sectors` equal sectors around an axis, and loads and displacements are the same in all of them. The nodes of one cut follow those of the other, turned by one sector.",
    one_of: &[],
    keys: &[
        key("on", REGION, "on = \"cut-1\"", "The nodes of one cut.").required(),
        key("against", REGION, "against = \"cut-0\"", "The nodes of the other cut; a node on the axis belongs to both.")
            .required(),
        key("sectors", Kind::Whole { from: 2, to: 1_000_000 }, "sectors = 12", "How many sectors make up the whole.")
            .required(),
        key("axis", POINT, "axis = [0, 0, 1]", "Direction of the axis, of any length.").required(),
        key("point", POINT, "point = [0, 0, 0]", "A point of the axis.").default("[0, 0, 0]").unit("length"),
        key(
            "search",
            Kind::Number(POSITIVE),
            "search = 1e-3",
            "How far apart nodes of the two cuts may be, turned upon one another; 1e-4 of the diagonal of the mesh if absent.",
        )
        .unit("length"),
    ],
};
