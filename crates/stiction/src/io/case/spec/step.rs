//! Keys of `[[step]]`.

use super::super::kind::{Kind, POSITIVE, Rules, key};

pub(super) static STEP: Rules = Rules {
    doc: "A stretch of the time axis, which begins at 0 or where the step before it ends.",
    one_of: &[],
    keys: &[
        key("name", Kind::Text, "name = \"press\"", "Name of the step in the results; \"step 1\" and so on if absent."),
        key("until", Kind::Number(POSITIVE), "until = 1", "The time t at its end.").required().unit("time"),
        key(
            "increments",
            Kind::Whole { from: 1, to: 100_000 },
            "increments = 4",
            "In how many equal increments of time it is solved; one that cannot be solved is halved.",
        )
        .default("1"),
    ],
};
