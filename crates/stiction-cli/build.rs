//! What `stiction --version` says of the build: target, features, and the commit where it is built from a clone.

use std::env;
use std::path::Path;
use std::process::Command;

fn main() {
    let features = ["fclib", "plots", "report"];
    let on = |name: &&str| env::var_os(format!("CARGO_FEATURE_{}", name.to_uppercase())).is_some();
    let with = features.into_iter().filter(on).collect::<Vec<_>>().join(", ");
    let with = if with.is_empty() { "none".to_string() } else { with };
    let commit = commit().map_or(String::new(), |commit| format!("commit {commit}, "));
    let (version, target) = (env::var("CARGO_PKG_VERSION").unwrap(), env::var("TARGET").unwrap());
    println!("cargo::rustc-env=STICTION_BUILD={version} ({commit}{target}, features: {with})");
    println!("cargo::rerun-if-changed=build.rs");
}

/// The commit of the clone; a packed crate has none, even within a clone of something else.
fn commit() -> Option<String> {
    let root = Path::new("../..");
    if !root.join(".git").exists() {
        return None;
    }
    let git = |arguments: &[&str]| {
        let done = Command::new("git").arg("-C").arg(root).args(arguments).output().ok()?;
        done.status.success().then(|| String::from_utf8_lossy(&done.stdout).trim().to_string())
    };
    for name in ["HEAD", "logs/HEAD"] {
        let path = git(&["rev-parse", "--path-format=absolute", "--git-path", name])?;
        if Path::new(&path).exists() {
            println!("cargo::rerun-if-changed={path}");
        }
    }
    git(&["rev-parse", "--short=10", "HEAD"])
}
