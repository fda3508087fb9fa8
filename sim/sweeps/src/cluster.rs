//! For a cluster: which shard a task is, and the scripts of an array of them.

use std::path::Path;

use efam_store::escape::is_hidden;

/// Variables by which schedulers give a task its place in an array, and from which number they count: Slurm, PBS,
/// Grid Engine, AWS Batch.
const PLACES: [(&str, usize); 4] = [
    ("SLURM_ARRAY_TASK_ID", 0),
    ("PBS_ARRAY_INDEX", 0),
    ("SGE_TASK_ID", 1), // its arrays cannot begin with 0
    ("AWS_BATCH_JOB_ARRAY_INDEX", 0),
];
/// What Grid Engine gives a job that is no array.
const NONE: &str = "undefined";

/// The shard that a scheduler requests, and the variable that says so.
/// # Errors
/// What is wrong with it.
pub fn array_place(
    variable: impl Fn(&str) -> Option<String>,
) -> Result<Option<(usize, &'static str)>, String> {
    for (name, first) in PLACES {
        let Some(text) = variable(name).filter(|text| text != NONE && !text.is_empty()) else { continue };
        let place = text.parse::<usize>().ok().and_then(|place| place.checked_sub(first));
        let place = place.ok_or_else(|| {
            format!("{name} = {text}: must be a number from {first} on; unset it, or give --shard")
        })?;
        return Ok(Some((place, name)));
    }
    Ok(None)
}

/// The script of an array whose members are shards. What they print goes to `log` in the folder of the plan.
/// # Errors
/// Why a path cannot be in a script.
pub fn array_script(name: &str, program: &Path, folder: &Path) -> Result<String, String> {
    let (log, program, plan) = (option(folder)?, quoted(program)?, quoted(folder)?);
    Ok(format!(
        "#!/bin/sh\n\
         #SBATCH --job-name={name}\n\
         #SBATCH --cpus-per-task=1\n\
         #SBATCH --requeue\n\
         #SBATCH --open-mode=append\n\
         #SBATCH --output=\"{log}/log/%A_%a.txt\"\n\
         # By hand: sbatch --array=LIST THIS, where LIST is what `efam sweep status` prints.\n\
         export RAYON_NUM_THREADS=\"${{SLURM_CPUS_PER_TASK:-1}}\"\n\
         exec {program} sweep run --quiet --plan {plan}\n",
    ))
}

/// The script of the job that puts all together, to be handed in after any end of the array.
/// # Errors
/// Why a path cannot be in a script.
pub fn merge_script(name: &str, program: &Path, folder: &Path) -> Result<String, String> {
    let (log, program, plan) = (option(folder)?, quoted(program)?, quoted(folder)?);
    Ok(format!(
        "#!/bin/sh\n\
         #SBATCH --job-name={name}-merge\n\
         #SBATCH --output=\"{log}/log/%j-merge.txt\"\n\
         exec {program} sweep merge --plan {plan}\n",
    ))
}

/// A path as one word of a shell.
fn quoted(path: &Path) -> Result<String, String> {
    Ok(format!("'{}'", plain(path)?.replace('\'', "'\\''")))
}

/// A path within the double quotes of an option in a script. Slurm ends an option at `"`, takes `\` from before any
/// sign, and reads `%` as a part of a pattern, so such a folder is refused.
///
/// Source: sbatch(1), "filename pattern"; slurm, src/sbatch/opt.c, `_get_argument`.
fn option(folder: &Path) -> Result<&str, String> {
    let text = plain(folder)?;
    match text.chars().find(|c| "\"%\\".contains(*c)) {
        None => Ok(text),
        Some(c) => Err(refusal(folder, &format!("a `{c}`, which Slurm reads as a sign of its own"))),
    }
}

/// A path whose text is one line. A line break would end an option, and make a command of what follows.
fn plain(path: &Path) -> Result<&str, String> {
    let text = path.to_str().ok_or_else(|| refusal(path, "bytes that are not UTF-8"))?;
    match text.chars().find(|c| is_hidden(*c)) {
        None => Ok(text),
        Some(c) => Err(refusal(path, &format!("the character {}", c.escape_unicode()))),
    }
}

fn refusal(path: &Path, what: &str) -> String {
    format!(
        "{}: has {what} in its path, so no job script can name it; rename it, or use another folder",
        path.display()
    )
}

/// The number of the job that `sbatch --parsable` has printed: `42`, or `42;cluster`.
pub fn job(printed: &str) -> Option<&str> {
    let number = printed.trim().split(';').next().unwrap_or_default();
    (!number.is_empty() && number.chars().all(|c| c.is_ascii_digit())).then_some(number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_task_finds_its_shard_whatever_the_scheduler() {
        let asks = |name: &'static str, value: &'static str| {
            array_place(|own| (own == name).then(|| value.to_owned())).map(|place| place.map(|place| place.0))
        };
        assert_eq!(asks("SLURM_ARRAY_TASK_ID", "7"), Ok(Some(7)));
        assert_eq!(asks("PBS_ARRAY_INDEX", "0"), Ok(Some(0)));
        assert_eq!(asks("SGE_TASK_ID", "1"), Ok(Some(0)));
        assert_eq!(asks("SGE_TASK_ID", "undefined"), Ok(None));
        assert_eq!(asks("AWS_BATCH_JOB_ARRAY_INDEX", "12"), Ok(Some(12)));
        // Of a single member that is handed in again, it says 1.
        assert_eq!(asks("SLURM_ARRAY_TASK_COUNT", "1"), Ok(None));
        let wrong = asks("SGE_TASK_ID", "0").unwrap_err();
        assert!(wrong.starts_with("SGE_TASK_ID = 0: must be a number from 1 on"), "{wrong}");
        assert!(asks("SLURM_ARRAY_TASK_ID", "x").is_err());
    }

    #[test]
    fn scripts_hold_together_whatever_the_folder_is_called() {
        let script = array_script("s", Path::new("/opt/efam"), Path::new("/home/o'neil/my sweep")).unwrap();
        assert!(
            script.ends_with("'/opt/efam' sweep run --quiet --plan '/home/o'\\''neil/my sweep'\n"),
            "{script}"
        );
        assert!(script.contains("#SBATCH --output=\"/home/o'neil/my sweep/log/%A_%a.txt\"\n"), "{script}");
        for folder in ["/a\nrm -rf x", "/a\u{1b}", "/50%", "/a\"b", "/a\\b", "/a\u{202e}b"] {
            for script in [array_script, merge_script] {
                let refusal = script("s", Path::new("/opt/efam"), Path::new(folder)).unwrap_err();
                assert!(refusal.contains("no job script can name it"), "{refusal}");
            }
        }
        assert_eq!((job("42\n"), job("42;lab\n"), job("error")), (Some("42"), Some("42"), None));
    }
}
