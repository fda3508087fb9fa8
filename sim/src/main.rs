//! The program `efam`.

fn main() -> std::process::ExitCode {
    efam::cli::main(std::env::args_os().collect())
}
