//! Blind bench of the diagnosis: experiments drawn by the twin, with effects hidden in them or none, are
//! diagnosed, and what is said is counted. `cargo run --release -p efam-tests --bin blind_bench -- --help`.

use std::collections::{BTreeMap, HashMap};
use std::fs;
use std::panic::catch_unwind;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use efam_inference::calibrate::Problem;
use efam_inference::diagnose::verdict::Gap;
use efam_inference::diagnose::{DiagnosisSettings, diagnose};
use efam_sweeps::answers::Answers;
use efam_sweeps::plan::Plan as SweepPlan;
use tests::blind::answer::Answer;
use tests::blind::case::{Case, Limits, kinds, limits, strangers};
use tests::blind::files::with_hold;
use tests::blind::truth::{self, TRUTH, Truth};
use tests::blind::{decoyed, files, problem, setup, tally};
use tests::twin::drawn::Plan;
use tests::twin::random::Random;

/// Draws experiments with effects hidden in them, runs the diagnosis, and counts what it says.
///
/// With --write it writes them as files instead, for `efam sweep`, and with --score it counts what that said.
#[derive(Parser)]
struct Words {
    /// First seed; each set has the next.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Sets of each kind with one effect hidden.
    #[arg(long, default_value_t = 1)]
    each: u64,
    /// Sets with nothing hidden.
    #[arg(long, default_value_t = 0)]
    nothing: u64,
    /// Sets of each kind that is removed from the catalogue, and of each that it never had.
    #[arg(long, default_value_t = 0)]
    unknown: u64,
    /// Sets with two effects hidden.
    #[arg(long, default_value_t = 0)]
    pairs: u64,
    /// Sets of each kind with something off in the setup, written as recordings and cleaned; these alone.
    #[arg(long, value_name = "SETS")]
    setup: Option<u64>,
    /// Size, in what is typical; drawn between one and a hundred detection limits if not given.
    #[arg(long)]
    size: Option<f64>,
    /// Names of effects that are hidden; all if not given.
    #[arg(long, value_delimiter = ',')]
    kinds: Vec<String>,
    /// Releases that differ as in a laboratory: each from the horizontal made twice, a base that wanders, effects that are
    /// not quite as large as their laws say.
    #[arg(long)]
    laboratory: bool,
    /// Three markers on the body beside the tip's.
    #[arg(long)]
    body: bool,
    /// End with an error where a false name was given, or a separable effect was not named.
    #[arg(long)]
    strict: bool,
    /// Write the experiments below this folder, with a sweep.toml, and diagnose nothing.
    #[arg(long, value_name = "DIR", conflicts_with = "score")]
    write: Option<PathBuf>,
    /// Count what a sweep said of the experiments below this folder.
    #[arg(long, value_name = "DIR")]
    score: Option<PathBuf>,
    /// Folder of that sweep [default: swept below that of --score].
    #[arg(long, value_name = "DIR", requires = "score")]
    swept: Option<PathBuf>,
    /// Say what is being done, and show the candidates that were fitted.
    #[arg(long)]
    tell: bool,
}

fn main() -> ExitCode {
    let words = Words::parse();
    let begin = Instant::now();
    if let Some(sets) = words.setup {
        setups(&words, sets);
        return ExitCode::SUCCESS;
    }
    let answers = match (&words.score, &words.write) {
        (Some(folder), _) => {
            scored(folder, words.swept.clone().unwrap_or_else(|| folder.join("swept")).as_path())
        }
        (None, Some(folder)) => write(folder, &words).map(|()| Vec::new()),
        (None, None) => Ok(asked(&words, begin)),
    };
    let answers = match answers {
        Ok(answers) => answers,
        Err(error) => {
            eprintln!("error: {error}");
            return ExitCode::FAILURE;
        }
    };
    if words.write.is_some() {
        return ExitCode::SUCCESS;
    }
    println!("\n{}\n{:.0} s in all", tally::told(&answers), begin.elapsed().as_secs_f64());
    let is_good =
        |answer: &Answer| !answer.has_a_false_name() && (answer.is_right() || !answer.is_separable());
    if words.strict && !answers.iter().all(is_good) { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}

/// Cases, each with what is foreseen of it; and the noise that this is for, m.
fn foreseen(words: &Words, plan: impl Fn(&Case) -> Plan) -> (Vec<(Case, Option<Limits>)>, f64) {
    let nominal = problem(&plan(&Case { is_of_a_laboratory: words.laboratory, ..Case::default() }).draw(1));
    let limits = limits(&nominal).expect("the usual experiment can be simulated");
    let own = |case: &Case| case.hidden.first().and_then(|(name, _)| limits.get(name)).copied();
    let cases = cases(words, &limits).into_iter().map(|case| (case.clone(), own(&case))).collect();
    (cases, noise(&nominal))
}

/// Diagnoses what is off in setups, and counts what is named.
fn setups(words: &Words, sets: u64) {
    let folder = std::env::temp_dir().join(format!("blind-bench-{}", std::process::id()));
    let mut seeds = words.seed..;
    for (kind, (name, _)) in setup::KINDS.iter().enumerate() {
        if !words.kinds.is_empty() && !words.kinds.iter().any(|own| own == name) {
            continue;
        }
        let ask = |seed| setup::ask(setup::hidden(kind, seed), seed, &folder.join(format!("{seed}")));
        let told = |answer: &Result<setup::Answer, String>| match answer {
            Ok(answer) => println!("{}", answer.told()),
            Err(why) => println!("{name}: {why}"),
        };
        let answers: Vec<_> =
            seeds.by_ref().take(sets as usize).map(ask).inspect(told).filter_map(Result::ok).collect();
        let right = answers.iter().filter(|answer| answer.is_right()).count();
        println!("{name}: named {right} of {}", answers.len());
    }
    // What is left is of no use to anybody.
    let _ = fs::remove_dir_all(folder);
}

/// Runs the diagnosis here.
fn asked(words: &Words, begin: Instant) -> Vec<Answer> {
    let (cases, usual) = foreseen(words, |case| case.plan(words.body));
    cases.iter().filter_map(|(case, limits)| ask(case, *limits, usual, words, begin)).collect()
}

/// Writes experiments as files.
fn write(folder: &Path, words: &Words) -> Result<(), String> {
    let plan = |case: &Case| with_hold(case.plan(words.body));
    let (cases, usual) = foreseen(words, plan);
    let put = |name: &str, text: String| {
        let file = folder.join(name);
        let made = file.parent().map_or(Ok(()), fs::create_dir_all);
        made.and_then(|()| fs::write(&file, text)).map_err(|error| format!("{}: {error}", file.display()))
    };
    let mut truths = Vec::new();
    for (k, (case, limits)) in cases.into_iter().enumerate() {
        let (name, drawn) = (format!("{:04}", k + 1), plan(&case).draw(case.seed));
        let mut problem = problem(&drawn);
        let limits = limits.map(|limits| limits.at_noise(noise(&problem) / usual));
        if case.is_decoyed {
            decoyed(&mut problem);
        }
        for (file, text) in files::recordings(&problem) {
            put(&format!("{name}/{file}"), text)?;
        }
        put(&format!("{name}/experiment.toml"), files::experiment(&name, &problem, &drawn))?;
        truths.push((format!("{name}/experiment.toml"), Truth::new(case, limits)));
    }
    put(TRUTH, truth::text(&truths))?;
    put("sweep.toml", files::sweep("blind-bench", &truths))?;
    let (count, folder) = (truths.len(), folder.display());
    println!("{count} experiments below {folder}; diagnose them, here or on a cluster, and count:");
    println!("  efam sweep {folder}/sweep.toml --out {folder}/swept");
    println!("  blind_bench --score {folder}");
    Ok(())
}

/// What a sweep said of experiments that were written.
fn scored(folder: &Path, swept: &Path) -> Result<Vec<Answer>, String> {
    let file = folder.join(TRUTH);
    let text = fs::read_to_string(&file).map_err(|error| format!("{}: {error}", file.display()))?;
    let truths = truth::read(&text).map_err(|line| {
        format!("{}:{line}: says not what is hidden; write the bench anew", file.display())
    })?;
    let plan = SweepPlan::open(swept).map_err(|error| error.to_string())?;
    let said = Answers::read(&plan).ok_or_else(|| {
        let swept = swept.display();
        format!("{swept}: has no table of diagnoses; make it: efam sweep merge --plan {swept}")
    })?;
    let said: HashMap<&str, _> = said.experiments.iter().map(|own| (own.experiment.as_str(), own)).collect();
    let mut answers = Vec::new();
    for (file, truth) in truths {
        let Some(own) = said.get(file.as_str()) else {
            return Err(format!("{}: knows nothing of {file}; sweep this bench", swept.display()));
        };
        if let Some(why) = &own.failed {
            println!("{:44} {:5}  {why}", truth.case.name(), truth.case.seed);
        }
        answers.extend(Answer::swept(truth, own).inspect(report));
    }
    Ok(answers)
}

type AllLimits = BTreeMap<&'static str, Limits>;

fn cases(words: &Words, limits: &AllLimits) -> Vec<Case> {
    let is_asked = |name: &&str| words.kinds.is_empty() || words.kinds.iter().any(|asked| asked == name);
    let mut random = Random::new(7_000_000 + words.seed);
    let mut seeds = words.seed..;
    let mut seed = move || seeds.next().unwrap_or_default();
    let mut size = |name: &str| {
        let drawn = limits.get(name).map_or(1.0, |limits| limits.drawn(&mut random));
        words.size.unwrap_or(drawn)
    };
    let mut all: Vec<Case> = (0..words.nothing).map(|_| Case::empty(seed())).collect();
    for name in kinds().filter(is_asked) {
        all.extend((0..words.each).map(|_| Case::of(name, size(name), seed())));
    }
    for name in kinds().filter(is_asked) {
        let robbed = |size: f64, seed: u64| Case { is_robbed: true, ..Case::of(name, size, seed) };
        all.extend((0..words.unknown).map(|_| robbed(size(name), seed())));
    }
    for name in strangers().filter(is_asked) {
        all.extend((0..words.unknown).map(|_| Case::of(name, words.size.unwrap_or(1.0), seed())));
    }
    // Both of a pair can be seen and separated from others at what is typical.
    let clear: Vec<&'static str> = kinds()
        .filter(is_asked)
        .filter(|name| limits.get(name).is_some_and(|own| own.distance(1.0) >= 10.0))
        .collect();
    let mut draw = Random::new(8_000_000 + words.seed);
    let mut pick = |count: usize| ((draw.share() * count as f64) as usize).min(count - 1);
    for _ in 0..words.pairs {
        let first = clear[pick(clear.len())];
        let others: Vec<_> = clear.iter().filter(|name| **name != first).collect();
        let second = *others[pick(others.len())];
        let size = words.size.unwrap_or(1.0);
        all.push(Case { hidden: vec![(first, size), (second, size)], ..Case::of(first, size, seed()) });
    }
    for case in &mut all {
        case.is_of_a_laboratory = words.laboratory;
    }
    all
}

/// Noise of the recordings, m.
fn noise(problem: &Problem) -> f64 {
    let tracks = || problem.trials.iter().flat_map(|trial| &trial.release.tracks);
    tracks().map(|track| track.noise).sum::<f64>() / tracks().count() as f64
}

/// `usual` is the noise that the limits are for, m.
fn ask(case: &Case, limits: Option<Limits>, usual: f64, words: &Words, begin: Instant) -> Option<Answer> {
    let tell = |what: &str| {
        if words.tell {
            eprintln!("{:8.1} s  {what}", begin.elapsed().as_secs_f64());
        }
    };
    // A large effect can soften the rod so much that it buckles, and the beam cannot integrate that.
    let Ok(drawn) = catch_unwind(|| case.plan(words.body).draw(case.seed)) else {
        println!("{:44} {:5}  cannot be drawn", case.name(), case.seed);
        return None;
    };
    let mut problem = problem(&drawn);
    let limits = limits.map(|limits| limits.at_noise(noise(&problem) / usual));
    if case.is_decoyed {
        decoyed(&mut problem);
    }
    let settings = DiagnosisSettings { excluded: case.excluded(), ..DiagnosisSettings::default() };
    let start = Instant::now();
    let outcome = match diagnose(&problem, &settings, &tell) {
        Ok(outcome) => outcome,
        Err(error) => {
            println!("{:44} {:5}  {error}", case.name(), case.seed);
            return None;
        }
    };
    let truth = Truth::new(case.clone(), limits);
    let answer = Answer::new(truth, &drawn, outcome, start.elapsed().as_secs_f64());
    report(&answer);
    if words.tell {
        details(&answer);
    }
    Some(answer)
}

fn report(answer: &Answer) {
    let distance = answer.distance.map_or(String::new(), |distance| format!("D {distance:.1}"));
    let [fitted, locked] = answer.noise_free;
    let strength = answer.relative_strength().map_or(String::new(), |(found, [low, high])| {
        format!("  {found:.3} of the strength ({low:.3} to {high:.3})")
    });
    println!(
        "{:44} {:5} {distance:>8}  {:50} noise-free {fitted:.3}, held out {locked:.3}  {:.1} s{strength}",
        answer.case.name(),
        answer.case.seed,
        answer.said(),
        answer.seconds
    );
}

/// What was looked at in the first round, and how it looked.
fn details(answer: &Answer) {
    let diagnosis = &answer.diagnosis;
    println!("      {}", diagnosis.summary);
    for Gap { release, held_out, before_mm, after_mm, before, after, .. } in &diagnosis.gap {
        let of = if *held_out { "held out" } else { "fitted" };
        println!(
            "      {release} {of}: {before_mm:.3} to {after_mm:.3} mm, {before:.2} to {after:.2} of the noise"
        );
    }
    diagnosis.warnings.iter().for_each(|warning| println!("      {warning}"));
    for (number, round) in diagnosis.rounds.iter().enumerate() {
        for own in &round.candidates {
            println!(
                "      {} {:20} by features {:7.1}  by samples {:7.1}  {}",
                number + 1,
                own.name,
                own.features,
                own.all.unwrap_or(f64::NAN),
                own.rejected.as_deref().unwrap_or("chosen"),
            );
        }
    }
}
