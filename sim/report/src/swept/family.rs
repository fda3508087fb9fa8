//! The points of a sweep as the cases of its page: what its sliders choose from, and how each moves.

use efam_store::columns::Cells;
use efam_sweeps::merge::Kept;
use efam_sweeps::plan::Plan;
use efam_sweeps::row::Point;
use efam_sweeps::work::{Simulate, Work};
use models::model::Model;

use crate::page::Family;
use crate::picture::{Rod, Rods, of_family, rod_of_case};
use crate::report::readable;

/// Points up to which each has a moving rod: with more the page would hold little else.
const MOST_RODS: usize = 24;

/// A slider for each parameter that varies, over the points that the pictures show; none of a sweep of diagnoses.
pub(super) fn family(plan: &Plan, kept: &Kept) -> Family {
    let Work::Simulate(own) = &plan.head.work else { return Family::default() };
    let given = plan.head.work.given();
    let varied = given.iter().filter(|column| !["point", "seed"].contains(&column.name.as_str()));
    varied.zip(&own.parameters).fold(Family::default(), |family, (column, path)| {
        let words = kept.columns.iter().position(|other| other.name == column.name).map(|k| &kept.cells[k]);
        match (kept.numbers(&column.name), words) {
            (Some(values), _) => {
                let (factor, unit) = readable(column.unit);
                family.by(path, unit, &values.iter().map(|value| factor * value).collect::<Vec<_>>())
            }
            (None, Some(Cells::Texts(words))) => {
                let words: Vec<String> = words.iter().map(|word| word.clone().unwrap_or_default()).collect();
                family.by_words(path, &words)
            }
            (None, _) => family,
        }
    })
}

/// The rods of a small sweep in motion: its rows hold numbers alone, so each point is simulated for it. Points that
/// cannot be simulated have none.
pub(super) fn rods(plan: &Plan) -> Option<Rods> {
    let Work::Simulate(own) = &plan.head.work else { return None };
    if plan.head.points > MOST_RODS {
        return None;
    }
    let mut points = plan.points().ok()?;
    let all: Vec<Point> =
        (0..plan.head.shards()).flat_map(|shard| points.of(shard).unwrap_or_default()).collect();
    let mut model = None;
    let rods: Vec<Rod> = all.iter().filter_map(|point| rod(own, point, &mut model)).collect();
    of_family(&model?, rods)
}

/// The rod of a point; the first that can be simulated leaves its model.
fn rod(own: &Simulate, point: &Point, model: &mut Option<Model>) -> Option<Rod> {
    let case = own.case(point).ok()?;
    let rod = rod_of_case(point.index, &format!("point {}", point.index), &case.model, &case.run);
    model.get_or_insert(case.model);
    rod
}
