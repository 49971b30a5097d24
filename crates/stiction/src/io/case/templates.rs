//! Commented cases to start from.

/// A case to start from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Template {
    pub name: &'static str,
    /// One line.
    pub description: &'static str,
    /// The text of the case file.
    pub text: &'static str,
}

/// All templates; the first is the one taken when none is named.
pub fn templates() -> &'static [Template] {
    &[
        Template {
            name: "block",
            description: "a block pressed onto a plane and pushed sideways by its top",
            text: include_str!("templates/block.toml"),
        },
        Template {
            name: "brick",
            description: "the model problem of Haslinger, Dostal and Kucera: a clamped brick on a rigid foundation",
            text: include_str!("templates/brick.toml"),
        },
        Template {
            name: "punch",
            description: "a block pressed onto a rigid sphere",
            text: include_str!("templates/punch.toml"),
        },
        Template {
            name: "pair",
            description: "a stamp pressed onto a block and dragged along it, both deformable",
            text: include_str!("templates/pair.toml"),
        },
    ]
}
