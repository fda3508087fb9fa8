//! All shards of a sweep as one table, and what it says over all points.

use efam_store::StoreError;
use efam_store::added;
use efam_store::columns::{Cells, Column, CsvFile, Holds, ParquetFile, read};
use efam_store::escape::shell_word;
use efam_store::manifest::MANIFEST;
use efam_store::partial;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::SweepError;
use super::answers::Answers;
use super::plan::Plan;
use super::row::FAILED;
use super::shard::{Found, PART, SECONDS, file, folder, look};
use super::status::{SWEEP, array};
use super::work::Work;

/// The table of all points as text, if requested.
pub const CSV: &str = "sweep.csv";
/// Rows that are written at a time, whatever the shards: so they leave no trace in the table.
const ROWS: usize = 8192;
/// Points that are kept for quantiles and pictures, at most.
const KEPT: usize = 4096;
/// Reasons of failures that are reported, at most.
const REASONS: usize = 10;

/// Results of a sweep.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Merged {
    /// Name of the sweep.
    pub name: String,
    /// SHA-256 of its plan.
    pub plan_sha256: String,
    /// Points.
    pub points: usize,
    /// Those that have no answer.
    pub failed: usize,
    /// Why, the most frequent reason first.
    pub reasons: Vec<Reason>,
    /// Keys of the scenario that differ from point to point, as columns.
    pub parameters: Vec<Spread>,
    /// The numbers that runs or diagnoses say.
    pub numbers: Vec<Spread>,
    /// Answers of diagnoses; none of a sweep over a scenario.
    pub diagnosed: Option<Answers>,
    /// Caveats of the numbers.
    pub warnings: Vec<String>,
}

/// Why points failed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Reason {
    /// In words.
    pub reason: String,
    /// How many.
    pub points: usize,
    /// The first of them.
    pub first: usize,
}

/// How a number is spread over the points that have it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Spread {
    /// Its column.
    pub column: String,
    /// The key of the scenario, or what the number is, in words.
    pub name: String,
    /// SI unit; empty if dimensionless.
    pub unit: String,
    /// Points that have it.
    pub points: usize,
    /// The least.
    pub least: Option<f64>,
    /// The median, and the ends of the 95 % in the middle, between two points where none is there: of 4096 points evenly taken, where there
    /// are more.
    pub median: Option<f64>,
    /// The lower one.
    pub low_95: Option<f64>,
    /// The upper one.
    pub high_95: Option<f64>,
    /// The greatest.
    pub greatest: Option<f64>,
}

/// Some points of a sweep, evenly taken.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Kept {
    /// All columns.
    pub columns: Vec<Column>,
    /// Their cells.
    pub cells: Vec<Cells>,
}

impl Kept {
    /// The numbers of a column; none of words.
    pub fn numbers(&self, name: &str) -> Option<Vec<f64>> {
        let k = self.columns.iter().position(|column| column.name == name)?;
        match &self.cells[k] {
            Cells::Numbers(all) => Some(all.clone()),
            Cells::Counts(all) => Some(all.iter().map(|count| *count as f64).collect()),
            Cells::Texts(_) => None,
        }
    }
}

/// Puts all shards together, one after the other: only one is held at a time.
/// # Errors
/// [`SweepError::Incomplete`], [`SweepError::Foreign`], [`SweepError::Damaged`], [`SweepError::Results`].
pub fn merge(plan: &Plan, csv: bool, tell: &dyn Fn()) -> Result<(Merged, Kept), SweepError> {
    complete(plan)?;
    let head = &plan.head;
    let mut view = View::new(plan);
    let hash =
        [("plan_sha256", head.sha256.clone()), ("run", head.name.clone()), ("efam", head.efam.clone())];
    let columns = head.work.columns();
    let mut damaged = None;
    let mut shards = |take: &mut dyn FnMut(Vec<Cells>) -> std::io::Result<()>| {
        let mut rows = Rows::new(&columns);
        for shard in 0..head.shards() {
            let path = file(&plan.folder, shard);
            let cells = read(&path, &columns).map_err(|error| {
                damaged = Some(SweepError::Damaged { file: path, shard, reason: error.to_string() });
                std::io::Error::other("a shard is damaged")
            })?;
            rows.add(cells, take)?;
            tell();
        }
        rows.rest(take)
    };
    let written = added::add(&plan.folder, SWEEP, |file| {
        let mut file = ParquetFile::begin(file, &columns, &hash)?;
        shards(&mut |cells| {
            view.see(&cells);
            file.write(cells)
        })?;
        file.finish()
    });
    let written = written.and_then(|()| {
        if !csv {
            Ok(())
        } else {
            added::add(&plan.folder, CSV, |file| {
                let mut file = CsvFile::begin(file, &columns)?;
                shards(&mut |cells| file.write(&cells))?;
                file.finish()
            })
        }
    });
    if let Some(damaged) = damaged {
        return Err(damaged);
    }
    written.map_err(|error: StoreError| SweepError::from(error))?;
    for shard in 0..head.shards() {
        partial::clear(&folder(&plan.folder, shard), &[PART, SECONDS, MANIFEST]);
    }
    Ok(view.finish())
}

/// Refuses a sweep that is not whole.
fn complete(plan: &Plan) -> Result<(), SweepError> {
    let shards = plan.head.shards();
    let mut missing = Vec::new();
    for shard in 0..shards {
        let file = file(&plan.folder, shard);
        match look(plan, shard) {
            Found::Whole => {}
            Found::Missing => missing.push(shard),
            Found::Foreign(hash) => return Err(SweepError::Foreign { file, hash }),
            Found::Damaged(reason) => return Err(SweepError::Damaged { file, shard, reason }),
        }
    }
    if missing.is_empty() {
        Ok(())
    } else {
        Err(SweepError::Incomplete {
            missing: missing.len(),
            shards,
            array: array(&missing),
            how: format!("efam sweep run --plan {}", shell_word(&plan.folder)),
        })
    }
}

/// Rows between shards of any size and pieces of one size.
struct Rows {
    waiting: Vec<Cells>,
}

impl Rows {
    fn new(columns: &[Column]) -> Self {
        Self { waiting: columns.iter().map(|column| column.holds.none()).collect() }
    }

    fn add(
        &mut self,
        cells: Vec<Cells>,
        take: &mut dyn FnMut(Vec<Cells>) -> std::io::Result<()>,
    ) -> std::io::Result<()> {
        self.waiting.iter_mut().zip(cells).for_each(|(own, more)| own.append(more));
        while self.waiting[0].len() >= ROWS {
            let piece = self.waiting.iter_mut().map(|cells| cells.take(ROWS)).collect();
            take(piece)?;
        }
        Ok(())
    }

    fn rest(mut self, take: &mut dyn FnMut(Vec<Cells>) -> std::io::Result<()>) -> std::io::Result<()> {
        let count = self.waiting[0].len();
        if count == 0 {
            return Ok(());
        }
        take(self.waiting.iter_mut().map(|cells| cells.take(count)).collect())
    }
}

/// What is seen of the rows as they go by.
struct View<'a> {
    plan: &'a Plan,
    /// Columns that points have before anything is done.
    given: usize,
    kept: Kept,
    answers: Option<Answers>,
    spreads: Vec<Option<Spread>>,
    reasons: Vec<Reason>,
    failed: usize,
    warned: usize,
    seen: usize,
}

impl<'a> View<'a> {
    fn new(plan: &'a Plan) -> Self {
        let work = &plan.head.work;
        let (columns, given) = (work.columns(), work.given().len());
        let is_number = |column: &Column| {
            let is_varied = !["point", "seed"].contains(&column.name.as_str());
            is_varied && !matches!(column.holds, Holds::Texts)
        };
        let spread = |column: &Column| {
            is_number(column).then(|| Spread {
                column: column.name.clone(),
                name: work.meaning(&column.name),
                unit: column.unit.to_owned(),
                ..Spread::default()
            })
        };
        Self {
            plan,
            given,
            spreads: columns.iter().map(spread).collect(),
            answers: matches!(work, Work::Diagnose(_)).then(Answers::default),
            kept: Kept { cells: columns.iter().map(|column| column.holds.none()).collect(), columns },
            reasons: Vec::new(),
            failed: 0,
            warned: 0,
            seen: 0,
        }
    }

    fn see(&mut self, cells: &[Cells]) {
        for (spread, cells) in self.spreads.iter_mut().zip(cells) {
            let Some(spread) = spread else { continue };
            for value in cells.numbers().filter(|value| !value.is_nan()) {
                spread.points += 1;
                spread.least = Some(spread.least.map_or(value, |least| least.min(value)));
                spread.greatest = Some(spread.greatest.map_or(value, |greatest| greatest.max(value)));
            }
        }
        if let Some(answers) = &mut self.answers {
            answers.see(&self.kept.columns, cells);
        }
        let column = |name: &str| self.kept.columns.iter().position(|own| own.name == name);
        let text = |name: &str, row: usize| {
            let k = column(name)?;
            if let Cells::Texts(all) = &cells[k] { all[row].clone() } else { None }
        };
        let every = self.plan.head.points.div_ceil(KEPT);
        let mut taken = Vec::new();
        for row in 0..cells[0].len() {
            let point = self.seen + row;
            if point.is_multiple_of(every) {
                taken.push(row);
            }
            self.warned += usize::from(text("warnings", row).is_some());
            if text("status", row).as_deref() != Some(FAILED) {
                continue;
            }
            self.failed += 1;
            let reason = text("reason", row).unwrap_or_default();
            match self.reasons.iter().position(|own| own.reason == reason) {
                Some(k) => self.reasons[k].points += 1,
                // What names its own numbers is another reason at each point.
                None if self.reasons.len() >= KEPT => {}
                None => self.reasons.push(Reason { reason, points: 1, first: point }),
            }
        }
        self.kept.cells.iter_mut().zip(cells).for_each(|(own, cells)| own.append(cells.some(&taken)));
        self.seen += cells[0].len();
    }

    fn finish(mut self) -> (Merged, Kept) {
        for (spread, cells) in self.spreads.iter_mut().zip(&self.kept.cells) {
            let Some(spread) = spread else { continue };
            let mut all: Vec<f64> = cells.numbers().filter(|value| !value.is_nan()).collect();
            all.sort_by(f64::total_cmp);
            [spread.low_95, spread.median, spread.high_95] =
                [0.025, 0.5, 0.975].map(|share| between(&all, share));
        }
        self.reasons.sort_by_key(|reason| std::cmp::Reverse(reason.points));
        self.reasons.truncate(REASONS);
        let said = self.spreads.split_off(self.given).into_iter().flatten().collect();
        let parameters = self.spreads.into_iter().flatten().collect();
        if let Some(answers) = &mut self.answers {
            answers.finish(self.plan);
        }
        let head = &self.plan.head;
        let mut warnings = head.warnings.clone();
        if self.failed > 0 {
            let (failed, points) = (self.failed, head.points);
            warnings.push(format!(
                "{failed} of {points} points could not be {}; each says why",
                head.work.done()
            ));
        }
        if self.warned > 0 {
            let (warned, points) = (self.warned, head.points);
            warnings.push(format!(
                "{warned} of {points} points have warnings of their own, in the column `warnings`"
            ));
        }
        let merged = Merged {
            name: head.name.clone(),
            plan_sha256: head.sha256.clone(),
            points: head.points,
            failed: self.failed,
            reasons: self.reasons,
            parameters,
            numbers: said,
            diagnosed: self.answers,
            warnings,
        };
        (merged, self.kept)
    }
}

/// The quantile of sorted values, on the line between its two neighbours: of few points neither is in the middle.
fn between(sorted: &[f64], share: f64) -> Option<f64> {
    let at = sorted.len().checked_sub(1)? as f64 * share;
    let (low, high) = (sorted[at.floor() as usize], sorted[at.ceil() as usize]);
    Some(low + at.fract() * (high - low))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_of_an_even_number_lies_between_two() {
        let loads = [0.0, 40.0, 80.0, 120.0, 160.0, 200.0];
        let found = [0.0, 0.025, 0.5, 1.0].map(|share| between(&loads, share));
        assert_eq!(found, [0.0, 5.0, 100.0, 200.0].map(Some));
        assert_eq!((between(&[7.0], 0.975), between(&[], 0.5)), (Some(7.0), None));
    }
}
