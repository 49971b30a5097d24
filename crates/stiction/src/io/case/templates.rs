//! Commented cases to start from.

/// A case to start from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Template {
    /// The name `stiction new --from` takes.
    pub name: &'static str,
    /// One line.
    pub description: &'static str,
    /// The text of the case file.
    pub text: &'static str,
    /// Files beside it which it names: name and contents.
    pub files: &'static [(&'static str, &'static str)],
}

macro_rules! template {
    ($name:literal, $description:literal $(, $file:literal)*) => {
        Template {
            name: $name,
            description: $description,
            text: include_str!(concat!("templates/", $name, ".toml")),
            files: &[$(($file, include_str!(concat!("templates/", $file)))),*],
        }
    };
}

/// All templates; the first is the one taken when none is named.
pub fn templates() -> &'static [Template] {
    &[
        template!("block", "a block pressed onto a plane and pushed sideways by its top"),
        template!("brick", "the model problem of Haslinger, Kučera and Dostál: a clamped brick on a rigid foundation"),
        template!("sphere", "a block pressed onto a rigid sphere: the contact of Hertz with friction"),
        template!("punch", "a flat square punch pressed into a block"),
        template!("pair", "a stamp pressed onto a block and dragged along it, both deformable"),
        template!("press-fit", "a hub pressed onto a hollow shaft"),
        template!("flange", "a bolted flange that a pipe pulls open, in load steps"),
        template!("bearing-seat", "a bearing ring in its housing under the load of its balls"),
        template!("wedge", "a block on a slope, pushed up it by its weight times a factor"),
        template!("foundation", "a block that stands free on elastic ground, in the wind"),
        template!("gasket", "a lid with a gasket, bolted and then put under pressure, in load steps"),
        template!("die", "the nose of a die from an STL file, pressed into a strip and dragged along it", "die.stl"),
        template!("pad", "a pad pressed onto a surface that then slides, in load steps"),
    ]
}
