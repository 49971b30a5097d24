//! Compiles the shim with the flags that the compiler of MPI names.

#[cfg(feature = "mpi")]
use std::env;
#[cfg(feature = "mpi")]
use std::process::Command;

/// What `mpicc` (or the command in `MPICC`) would pass on: Open MPI answers `--showme`, MPICH `-show`.
#[cfg(feature = "mpi")]
fn flags(of: &str) -> Option<Vec<String>> {
    let compiler = env::var("MPICC").unwrap_or_else(|_| "mpicc".into());
    let ask = |option: &str| Command::new(&compiler).arg(option).output().ok().filter(|output| output.status.success());
    let output = ask(&format!("--showme:{of}")).or_else(|| ask("-show"))?;
    Some(String::from_utf8_lossy(&output.stdout).split_whitespace().map(String::from).collect())
}

fn main() {
    #[cfg(feature = "mpi")]
    shim();
}

#[cfg(feature = "mpi")]
fn shim() {
    println!("cargo:rerun-if-changed=c/shim.c");
    println!("cargo:rerun-if-env-changed=MPICC");
    let (Some(compile), Some(link)) = (flags("compile"), flags("link")) else {
        println!("cargo::error=there is no mpicc: install MPI (Debian: libopenmpi-dev), or name its compiler in MPICC");
        return;
    };
    let mut build = cc::Build::new();
    build.file("c/shim.c");
    for flag in compile.iter().filter(|flag| flag.starts_with("-I") || flag.starts_with("-D")) {
        build.flag(flag);
    }
    build.compile("stiction_mpi_shim");
    for flag in &link {
        if let Some(folder) = flag.strip_prefix("-L") {
            println!("cargo:rustc-link-search=native={folder}");
        } else if let Some(library) = flag.strip_prefix("-l") {
            println!("cargo:rustc-link-lib={library}");
        } else if flag.starts_with("-Wl,") {
            println!("cargo:rustc-link-arg={flag}");
        }
    }
}
