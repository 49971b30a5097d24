//! What shells and `man` get, and what `--version` says.

use std::process::Command;

use crate::folder::{CASE, Folder};

#[cfg(unix)]
#[test]
fn a_shell_completes_subcommands_and_options() {
    let folder = Folder::new("completions", CASE);
    let script = folder.run(&["completions", "bash"]);
    script.ends(0, &[]);
    std::fs::write(folder.path.join("stiction.bash"), &script.out).unwrap();
    let complete = |words: &str, last: usize| {
        let program = format!(
            "source ./stiction.bash; COMP_WORDS=({words}); COMP_CWORD={last}; cur=${{COMP_WORDS[{last}]}}; \
             _stiction stiction \"$cur\" \"\"; printf '%s\\n' \"${{COMPREPLY[@]}}\""
        );
        let done = Command::new("bash").args(["-c", &program]).current_dir(&folder.path).output().unwrap();
        String::from_utf8(done.stdout).unwrap().split_whitespace().map(String::from).collect::<Vec<_>>()
    };
    assert_eq!(complete("stiction so", 1), ["solve"]);
    assert_eq!(complete("stiction solve --acc", 2), ["--accuracy"]);
    for shell in ["zsh", "fish", "powershell", "elvish"] {
        folder.run(&["completions", shell]).ends(0, &[]);
    }
    folder.run(&["completions", "cmd"]).ends(2, &["bash"]);
}

#[test]
fn the_manual_page_has_every_subcommand_and_each_of_them_a_page_and_a_help() {
    let folder = Folder::new("man", CASE);
    let page = folder.run(&["man"]);
    page.ends(0, &[]);
    assert!(page.out.contains(".TH stiction 1"), "{}", page.out);
    let help = folder.run(&["--help"]).out;
    let listed = help.split("Commands:\n").nth(1).unwrap().lines().take_while(|line| !line.is_empty());
    let names: Vec<&str> = listed.map(|line| line.split_whitespace().next().unwrap()).collect();
    assert!(names.contains(&"solve") && names.len() > 8, "{names:?}");
    for name in names {
        // Hyphens are escaped in what `man` reads.
        assert!(page.out.contains(&format!("stiction\\-{name}(1)")), "{name}\n{}", page.out);
        if name != "help" {
            let own = folder.run(&["man", name]);
            own.ends(0, &[]);
            assert!(own.out.contains(&format!(".TH stiction-{name} 1")), "{}", own.out);
            let help = folder.run(&[name, "--help"]);
            help.ends(0, &[]);
            assert!(help.out.contains("Usage: "), "{}", help.out);
        }
    }
    folder.run(&["man", "sovle"]).ends(2, &["no subcommand", "solve"]);
}

#[test]
fn the_version_tells_the_build() {
    let folder = Folder::new("version", CASE);
    let (short, long) = (folder.run(&["-V"]), folder.run(&["--version"]));
    short.ends(0, &[]);
    long.ends(0, &[]);
    assert_eq!(short.out.trim(), format!("stiction {}", env!("CARGO_PKG_VERSION")));
    assert!(long.out.starts_with(short.out.trim()) && long.out.contains("features: "), "{}", long.out);
}
