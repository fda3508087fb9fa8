//! The program `efam`.

fn main() -> std::process::ExitCode {
    sim::cli::main(std::env::args_os().collect())
}
