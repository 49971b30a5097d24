//! The program `stiction`.

fn main() -> std::process::ExitCode {
    stiction_cli::run_command(std::env::args_os()).into()
}
