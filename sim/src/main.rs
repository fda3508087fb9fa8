//! The program `efam`.

mod cli;

fn main() -> std::process::ExitCode {
    cli::main()
}
