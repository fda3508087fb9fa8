//! The command line: parse, call one function, print, exit code. clap is named here and below, nowhere else.

mod analyse;
mod answer;
mod arguments;
mod browser;
mod calibrate;
mod completions;
mod console;
mod diagnose;
mod doctor;
mod effects;
mod experiment;
mod export;
mod failure;
mod figures;
mod init;
mod inspect;
mod interrupt;
mod linearise;
mod live;
mod man;
mod node_steps;
mod predict;
mod progress;
mod report;
mod rest;
mod schema;
mod signals;
mod simulate;
mod sweep;
mod terminal;
mod threads;
mod view;
mod watch;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::{ColorChoice, CommandFactory, FromArgMatches, Parser, Subcommand};
use efam_store::escape::{escaped, is_hidden};

use arguments::Verbosity;
use console::Console;
use failure::{Failure, report};

/// Exit codes, as the help prints them.
const EXIT_CODES: &str = "Exit codes:
    0  success
    1  results could not be written or shown; or `efam doctor` found a fault
    2  the command line or the scenario is wrong
    3  a muscle file, a recording or other data are wrong
    4  the simulation or the search for a rest posture could not go on
  130  Ctrl-C: a simulation is saved up to there, whole shards of a sweep, and
       nothing else; a second Ctrl-C ends at once, and saves nothing
  143  the same by SIGTERM, 129 by SIGHUP, 152 by SIGXCPU, by which systems and
       schedulers end a job

Results and tables go to stdout; progress, warnings and errors to stderr.";

/// A cantilevered fluidic artificial muscle, simulated in the time domain.
#[derive(Parser)]
#[command(name = "efam", version, after_help = EXIT_CODES)]
struct Efam {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    verbosity: Verbosity,
}

#[derive(Subcommand)]
enum Command {
    /// Write a first scenario with comments, or a muscle file, which run without changes.
    Init(init::Init),
    /// Simulate a scenario and save the results in a new folder.
    Simulate(simulate::Simulate),
    /// Find parameters of a model from the releases of an experiment.
    Calibrate(calibrate::Calibrate),
    /// Find the missing physical effect: score, fit and validate candidates, and repair the model.
    Diagnose(diagnose::Diagnose),
    /// Predict how a calibrated muscle responds to a payload, with intervals.
    Predict(predict::Predict),
    /// Simulate many points of a design: here on all cores, or on a cluster.
    Sweep(sweep::Sweep),
    /// Open the Rerun recording of a finished run in the viewer.
    View(view::View),
    /// Compare runs, on a page and in numbers.
    Report(report::Report),
    /// Write a finished run for other programs: MATLAB, or tools for robots.
    Export(export::Export),
    /// Redraw the paper's Figures 4 to 9 from runs of our own.
    Figures(figures::Figures),
    /// List the physical effects, or show the page of one.
    Effects(effects::Effects),
    /// Write an experiment file from recordings, or check one.
    Experiment {
        #[command(subcommand)]
        what: OnExperiment,
    },
    /// Clean an experiment's recordings and analyse each release: frequency, damping, stiffness.
    Analyse(analyse::Analyse),
    /// Analyse each recording of a folder as it is saved, and keep one page up to date.
    Watch(watch::Watch),
    /// Summarise recordings of a motion-capture system.
    Inspect(inspect::Inspect),
    /// Show the rest posture of a scenario's rod.
    Statics(rest::Statics),
    /// Show the small vibrations about the rest posture.
    Modes(rest::Modes),
    /// Make a linear model about the rest posture, for a controller: poles, gains, matrices.
    Linearise(linearise::Linearise),
    /// Check this installation: features, threads, viewer, folder for results.
    Doctor(doctor::Doctor),
    /// Print the JSON schema of what a command prints with --json.
    Schema(schema::Schema),
    /// Print the shell's script for completions.
    Completions(completions::Completions),
    /// Print a manual page, or write all.
    Man(man::Manual),
}

#[derive(Subcommand)]
enum OnExperiment {
    /// Write a first experiment file from the recordings themselves.
    Init(experiment::Init),
    /// Clean the recordings, and show what was cut, masked and decided.
    Check(experiment::Check),
}

/// The program with its arguments, of which the first is its own name: as a program of its own, or within Python.
pub fn main(arguments: Vec<OsString>) -> ExitCode {
    signals::make_long_files_an_error();
    let color = Verbosity::color(arguments.iter().skip(1).cloned());
    let parsed = Efam::command().color(color).try_get_matches_from(&arguments);
    let efam = match parsed.and_then(|matches| Efam::from_arg_matches(&matches)) {
        Ok(efam) => efam,
        Err(error) => return answer(error, &arguments),
    };
    let console = Console::new(efam.verbosity.quiet, efam.verbosity.verbose);
    match run(efam.command, &console) {
        Ok(code) => code,
        Err(failure) => report(&failure, is_colored(efam.verbosity.color)),
    }
}

fn run(command: Command, console: &Console) -> Result<ExitCode, Failure> {
    if command.computes() {
        console.warn(threads::begin()?);
    }
    match command {
        Command::Init(args) => init::run(&args, console),
        Command::Simulate(args) => simulate::run(&args, console),
        Command::Calibrate(args) => calibrate::run(&args, console),
        Command::Diagnose(args) => diagnose::run(&args, console),
        Command::Predict(args) => predict::run(&args, console),
        Command::Sweep(args) => sweep::run(&args, console),
        Command::View(args) => view::run(&args),
        Command::Report(args) => report::run(&args, console),
        Command::Export(args) => export::run(&args, console),
        Command::Figures(args) => figures::run(&args, console),
        Command::Effects(args) => effects::run(&args, console),
        Command::Experiment { what: OnExperiment::Init(args) } => experiment::init(&args, console),
        Command::Experiment { what: OnExperiment::Check(args) } => experiment::check(&args, console),
        Command::Analyse(args) => analyse::run(&args, console),
        Command::Watch(args) => watch::run(&args, console),
        Command::Inspect(args) => inspect::run(&args, console),
        Command::Statics(args) => rest::statics(&args, console),
        Command::Modes(args) => rest::modes(&args, console),
        Command::Linearise(args) => linearise::run(&args, console),
        Command::Doctor(args) => doctor::run(&args, console),
        Command::Schema(args) => schema::run(&args),
        Command::Completions(args) => completions::run(&args, Efam::command()),
        Command::Man(args) => man::run(&args, Efam::command(), console),
    }
}

impl Command {
    /// Whether it may take several threads.
    fn computes(&self) -> bool {
        let only_prints = matches!(
            self,
            Command::Init(_)
                | Command::View(_)
                | Command::Effects(_)
                | Command::Schema(_)
                | Command::Completions(_)
                | Command::Man(_)
        );
        !only_prints
    }
}

/// Prints help, or what is wrong with the command line.
fn answer(error: clap::Error, arguments: &[OsString]) -> ExitCode {
    // The message contains what was typed. Where that would act on a terminal, it is typed visibly.
    let typed: Vec<String> = arguments.iter().map(|own| own.to_string_lossy().into_owned()).collect();
    let is_visible = !typed.iter().any(|own| own.contains(is_hidden));
    let visibly = || {
        Efam::command()
            .color(ColorChoice::Never)
            .try_get_matches_from(typed.iter().map(|own| escaped(own).into_owned()))
    };
    let error = if is_visible { error } else { visibly().err().unwrap_or(error) };
    let printed = error.print().and_then(|()| terminal::stdout().end());
    match printed {
        Err(failed) if !error.use_stderr() => report(&Failure::from(failed), false),
        _ => ExitCode::from(error.exit_code() as u8),
    }
}

/// Whether errors are coloured.
fn is_colored(choice: ColorChoice) -> bool {
    match choice {
        ColorChoice::Always => true,
        ColorChoice::Never => false,
        ColorChoice::Auto => {
            let is_unwanted = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
            terminal::is_watched() && !is_unwanted
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Words of a command line as a shell splits it; quotes hold words together, and may be within one.
    fn words(line: &str) -> Vec<String> {
        let (mut words, mut word, mut quote) = (Vec::new(), String::new(), None);
        for letter in line.chars() {
            match (letter, quote) {
                (' ', None) => words.push(std::mem::take(&mut word)),
                ('"' | '\'', None) => quote = Some(letter),
                (_, Some(end)) if letter == end => quote = None,
                _ => word.push(letter),
            }
        }
        words.push(word);
        words.retain(|word| !word.is_empty());
        words
    }

    /// Commands that do something, by their words.
    fn leaves(command: &clap::Command, name: &str, all: &mut Vec<(String, clap::Command)>) {
        for below in command.get_subcommands() {
            leaves(below, &format!("{name} {}", below.get_name()), all);
        }
        if !command.is_subcommand_required_set() {
            all.push((name.to_owned(), command.clone()));
        }
    }

    fn parses(line: &str) {
        // What follows a pipe or a comment is the shell's.
        let own = line.split(['|', '>', '#']).next().expect("a split has one");
        match Efam::try_parse_from(words(own)) {
            // Help is an answer, too.
            Err(error) if error.use_stderr() => panic!("{line}\n{error}"),
            _ => {}
        }
    }

    #[test]
    fn the_command_line_is_consistent() {
        Efam::command().debug_assert();
    }

    #[test]
    fn every_command_has_examples_that_parse() {
        let mut all = Vec::new();
        leaves(&Efam::command(), "efam", &mut all);
        assert!(all.len() > 10, "{}", all.len());
        for (name, command) in all {
            let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
            let examples: Vec<_> =
                help.lines().map(str::trim).filter(|line| line.starts_with("efam ")).collect();
            assert!(
                examples.iter().any(|line| line.starts_with(&name)),
                "{name}: its help has no example of it:\n{help}"
            );
            for example in examples {
                parses(example);
            }
            let wide = help.lines().find(|line| line.chars().count() > 80);
            assert_eq!(wide, None, "{name}: wraps on a terminal of 80 columns");
        }
    }

    #[test]
    fn all_that_prints_json_has_a_schema() {
        let mut all = Vec::new();
        leaves(&Efam::command(), "", &mut all);
        let prints = |command: &clap::Command| command.get_arguments().any(|own| own.get_id() == "json");
        let mut printing: Vec<_> = all.iter().filter(|own| prints(&own.1)).map(|own| own.0.trim()).collect();
        let mut published = schema::SCHEMAS.map(|(command, _)| command);
        printing.sort_unstable();
        published.sort_unstable();
        assert_eq!(printing, published);
    }

    /// Text of README and of every page of the book below a folder.
    fn documents(folder: &std::path::Path) -> String {
        let entries = std::fs::read_dir(folder).expect("a folder of the project");
        let mut text = String::new();
        for path in entries.map(|entry| entry.expect("an entry").path()) {
            if path.is_dir() {
                text += &documents(&path);
            } else if path.extension().is_some_and(|own| own == "md") {
                text += &std::fs::read_to_string(&path).expect("text");
            }
        }
        text
    }

    #[test]
    fn what_the_documents_show_parses() {
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let text = std::fs::read_to_string(root.join("README.md")).expect("it is there");
        let text = text + "\n" + &documents(&root.join("docs/src"));
        // Inside fenced blocks; a continued line is one with the next.
        let blocks = text.split("\n```sh\n").skip(1).filter_map(|part| part.split("\n```").next());
        let lines: Vec<_> = blocks.flat_map(str::lines).filter(|line| line.starts_with("efam ")).collect();
        assert!(lines.len() > 60, "{}", lines.len());
        for line in lines {
            parses(&line.replace(" || echo", " # echo"));
        }
    }

    #[test]
    fn the_first_word_on_colour_is_found_wherever_it_stands() {
        let color = |line: &str| Verbosity::color(words(line).into_iter().map(Into::into));
        assert_eq!(color("simulate a.toml --color never"), ColorChoice::Never);
        assert_eq!(color("--color=always simulat"), ColorChoice::Always);
        assert_eq!(color("simulate --colour=always"), ColorChoice::Auto);
        assert_eq!(color("simulate -- --color=always"), ColorChoice::Auto);
        assert_eq!(color("simulate --color"), ColorChoice::Auto);
    }
}
