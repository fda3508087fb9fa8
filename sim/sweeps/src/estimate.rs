//! How many points a shard has, and how long a point takes.

use std::time::{Duration, Instant};

use efam_experiments::scenario::ScenarioError;

use super::design::Sampler;
use super::point::{case, run};
use super::request::{Subject, SweepRequest};

/// Points that are tried.
const TRIED: usize = 3;
/// Shards at most, unless more are requested: Slurm admits 1000 members of an array by default
/// (slurm.conf(5), MaxArraySize).
const MOST_SHARDS: usize = 1000;
/// Work that a shard of a cluster should hold at least: a scheduler takes a second or so to start it.
const LEAST_WORK: Duration = Duration::from_secs(30);

/// Points of a shard, unless more are requested. What is interrupted keeps whole shards, so they are as small as their
/// number admits. It depends on nothing that differs from machine to machine: a plan has one hash everywhere.
pub fn points_per_shard(points: usize) -> usize {
    points.div_ceil(MOST_SHARDS).max(1)
}

/// Processor time of a point: the mean of the first, the last, and one between. Nothing for diagnoses, of which a few
/// take three seconds and a few ten minutes.
/// # Errors
/// [`ScenarioError`] where a point cannot be made.
pub fn time_of_a_point(asked: &SweepRequest) -> Result<Option<Duration>, ScenarioError> {
    let Subject::Scenario(asked) = &asked.subject else { return Ok(None) };
    let sampler = Sampler::new(asked)?;
    let count = asked.points.min(TRIED);
    let begin = Instant::now();
    for k in 0..count {
        let index = if count > 1 { k * (asked.points - 1) / (count - 1) } else { 0 };
        let point = sampler.point(index)?;
        let make = |point: &_| {
            case(&asked.scenario, &asked.scenario_text, &asked.set, &sampler.paths, point)
                .map(|(case, _)| case)
        };
        run(make, &point);
    }
    Ok(Some(begin.elapsed() / count.max(1) as u32))
}

/// Points with which a shard holds enough work for a cluster, where that is more than it has.
pub fn points_for_a_cluster(points_per_shard: usize, time: Duration) -> Option<usize> {
    let points = LEAST_WORK.div_duration_f64(time.max(Duration::from_micros(1))).ceil() as usize;
    Some(points.next_power_of_two()).filter(|points| *points > points_per_shard)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_are_small_and_an_array_has_a_thousand_members_at_most() {
        for (points, expected) in [(1, 1), (209, 1), (1000, 1), (1001, 2), (10_000_000, 10_000)] {
            assert_eq!(points_per_shard(points), expected);
            assert!(points.div_ceil(expected) <= MOST_SHARDS);
        }
    }

    #[test]
    fn on_a_cluster_a_shard_holds_half_a_minute() {
        assert_eq!(points_for_a_cluster(1, Duration::from_millis(60)), Some(512));
        assert_eq!(points_for_a_cluster(1, Duration::from_secs(45)), None);
        assert_eq!(points_for_a_cluster(600, Duration::from_millis(60)), None);
    }
}
