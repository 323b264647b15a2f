//! The `tweeze` program: arguments to exit code.

fn main() -> std::process::ExitCode {
    tweeze::cli::run(std::env::args_os())
}
