//! The smaller commands.

use crate::folder::{CASE, Folder, two_cubes};

#[test]
fn new_refuses_to_overwrite_and_names_its_choices() {
    let folder = Folder::new("new", CASE);
    folder.run(&["new", "."]).ends(2, &["case.toml", "exists already"]);
    assert_eq!(std::fs::read_to_string(folder.path.join("case.toml")).unwrap(), CASE);
    folder.run(&["new", "x", "--from", "brik"]).ends(2, &["did you mean \"brick\"?"]);
    assert_eq!(folder.names(), ["case.toml"]);
    let list = folder.run(&["new", "--list"]);
    assert!(list.out.lines().count() >= 3 && list.out.contains("brick"));
    folder.run(&["new"]).ends(2, &["FOLDER"]);
}

#[test]
fn schema_is_json() {
    let run = Folder::new("schema", CASE).run(&["schema"]);
    let schema: serde_json::Value = serde_json::from_str(&run.out).unwrap();
    assert!(schema["properties"]["contact"].is_object());
}

#[test]
fn mesh_info_tells_groups_and_volume() {
    let folder = Folder::new("info", CASE);
    folder.write("part.msh", two_cubes());
    let run = folder.run(&["mesh", "info", "part.msh"]);
    run.ends(0, &[]);
    for word in ["2 hex8", "volume      2", "bottom", "0 open", "between two cells"] {
        assert!(run.out.contains(word), "{word}: {}", run.out);
    }
    folder.run(&["mesh", "info", "case.toml"]).ends(2, &[".toml cannot be read"]);
    folder.run(&["mesh", "info", "none.msh"]).ends(2, &["none.msh"]);
}

#[test]
fn no_arguments_show_the_help() {
    let run = Folder::new("help", CASE).run(&[]);
    run.ends(2, &["Usage"]);
}
