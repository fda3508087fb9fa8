//! `efam completions`: what a shell has to know to complete our command lines.

use std::io::Write;
use std::process::ExitCode;

use clap::{Args, Command};
use clap_complete::{Shell, generate};

use super::failure::Failure;
use super::terminal::stdout;

const HELP: &str = "Examples:
  efam completions bash > ~/.local/share/bash-completion/completions/efam
  efam completions zsh > ~/.zfunc/_efam
  efam completions fish > ~/.config/fish/completions/efam.fish
  efam completions powershell >> $PROFILE";

#[derive(Args)]
#[command(after_help = HELP)]
pub struct Completions {
    /// For which shell.
    shell: Shell,
}

/// Prints the completions of a command line.
pub fn run(args: &Completions, mut efam: Command) -> Result<ExitCode, Failure> {
    let name = efam.get_name().to_owned();
    // Not straight to stdout: what is not read any longer would panic there.
    let mut text = Vec::new();
    generate(args.shell, &mut efam, name, &mut text);
    stdout().write_all(&text)?;
    Ok(ExitCode::SUCCESS)
}
