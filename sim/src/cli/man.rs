//! `efam man`: manual pages, one a command, from the same source as the help.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, Command};
use clap_mangen::Man;
use efam_store::StoreError;
use efam_store::atomic::{write_new, write_whole};
use efam_store::disk::File;

use super::console::Console;
use super::failure::Failure;
use super::schema::lacking;
use super::terminal::stdout;

const HELP: &str = "Examples:
  efam man simulate | man -l -
  efam man experiment check
  efam man --out ~/.local/share/man/man1";

#[derive(Args)]
#[command(after_help = HELP)]
pub struct Manual {
    /// The page of a command [default: that of efam].
    #[arg(conflicts_with = "out")]
    command: Vec<String>,
    /// Folder for all pages, one a command.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace existing pages.
    #[arg(long, requires = "out")]
    overwrite: bool,
}

/// Prints a page, or writes all.
pub fn run(args: &Manual, efam: Command, console: &Console) -> Result<ExitCode, Failure> {
    let mut efam = efam.disable_help_subcommand(true);
    // Names of pages are those of the whole way to a command.
    efam.build();
    let mut pages = Vec::new();
    collect(&efam, &mut pages)?;
    match &args.out {
        Some(folder) => write(folder, args.overwrite, &pages, console)?,
        None => {
            let file = [&["efam".to_owned()], &args.command[..]].concat().join("-") + ".1";
            let page = pages.iter().find(|(name, _)| *name == file);
            let names =
                || pages.iter().filter_map(|(name, _)| Some(words(name)).filter(|own| !own.is_empty()));
            let (_, page) = page.ok_or_else(|| lacking("page of", &args.command.join(" "), names()))?;
            stdout().write_all(page)?;
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// The command that a page is of, as it is typed.
fn words(file: &str) -> String {
    let name = file.trim_start_matches("efam").trim_end_matches(".1");
    name.replace('-', " ").trim().to_owned()
}

/// File names and pages of a command and all below it.
fn collect(command: &Command, pages: &mut Vec<(String, Vec<u8>)>) -> io::Result<()> {
    let man = Man::new(command.clone());
    let mut page = Vec::new();
    man.render(&mut page)?;
    pages.push((man.get_filename(), page));
    command.get_subcommands().try_for_each(|below| collect(below, pages))
}

/// Writes all pages into a folder, or none where one is there already.
fn write(
    folder: &Path,
    overwrite: bool,
    pages: &[(String, Vec<u8>)],
    console: &Console,
) -> Result<(), Failure> {
    let taken = pages.iter().map(|(name, _)| folder.join(name)).find(|path| path.exists());
    if let (Some(path), false) = (taken, overwrite) {
        return Err(StoreError::Exists { folder: path }.into());
    }
    for (name, page) in pages {
        let path = folder.join(name);
        let write = |file: &mut File| file.write_all(page);
        if overwrite {
            write_whole(&path, write)?
        } else {
            write_new(&path, write)?
        }
        console.detail(format!("written: {}", path.display()));
    }
    if !console.quiet {
        writeln!(stdout(), "{} pages in {}", pages.len(), folder.display())?;
    }
    Ok(())
}
