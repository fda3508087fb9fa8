//! How many points a shard should have: some are tried, and timed.

use std::time::Instant;

use super::asked::{Asked, Subject};
use super::design::Sampler;
use super::point::{case, run};
use crate::scenario::ScenarioError;

/// Points that are tried.
const TRIED: usize = 3;
/// Work that a shard should hold at least, µs of one processor: a scheduler takes a second or so to start it.
const LEAST_WORK: u64 = 30_000_000;
/// Shards at most, unless more are asked for: as many members as Slurm admits in an array unless told otherwise.
const MOST_SHARDS: usize = 1000;

/// What a diagnosis is taken to need, µs: a few take three seconds and a few ten minutes, so that trying some says
/// little, and takes long. With this each has a shard of its own, while there are no more than an array has members.
const A_DIAGNOSIS: u64 = 30_000_000;

/// Processor time of a point, µs: the mean of the first, the last, and one between, where these are simulations.
/// # Errors
/// [`ScenarioError`] where a point cannot be made.
pub fn microseconds_per_point(asked: &Asked) -> Result<u64, ScenarioError> {
    let Subject::Scenario(asked) = &asked.subject else { return Ok(A_DIAGNOSIS) };
    let sampler = Sampler::new(asked)?;
    let count = asked.points.min(TRIED);
    let mut all = 0;
    for k in 0..count {
        let index = if count > 1 { k * (asked.points - 1) / (count - 1) } else { 0 };
        let point = sampler.point(index)?;
        let begin = Instant::now();
        let make = |point: &_| {
            case(&asked.scenario, &asked.scenario_text, &asked.set, &sampler.paths, point)
                .map(|(case, _)| case)
        };
        run(make, &point);
        all += begin.elapsed().as_micros() as u64;
    }
    Ok((all / count as u64).max(1))
}

/// Points of a shard that holds half a minute of work: a power of two, so that the plan is not another each time.
pub fn points_per_shard(points: usize, microseconds_per_point: u64) -> usize {
    let of_work = LEAST_WORK.div_ceil(microseconds_per_point.max(1)) as usize;
    of_work.next_power_of_two().max(points.div_ceil(MOST_SHARDS))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shard_holds_half_a_minute_and_an_array_a_thousand_members() {
        for (points, microseconds) in [(2000, 60_000), (10, 3_000_000), (10_000_000, 60_000), (5, 90_000_000)]
        {
            let own = points_per_shard(points, microseconds);
            assert!(own as u64 * microseconds >= LEAST_WORK, "{points} {microseconds}: {own}");
            assert!(points.div_ceil(own) <= MOST_SHARDS, "{points} {microseconds}: {own}");
        }
        assert_eq!(points_per_shard(2000, 60_000), 512);
    }
}
