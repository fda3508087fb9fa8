//! Many runs, several of them side by side.

use std::ops::ControlFlow;

use models::model::Model;
use models::pack::RODS;
use models::rods::{are_alike, can_be_packed};

use crate::integrate::side_by_side::SideBySide;
use crate::integrate::tableau::RODAS4;
use crate::integrate::{IntegrateError, Method};
use crate::run::Run;
use crate::trajectory::Trajectory;

use super::course::{Course, Next};
use super::{ForwardError, Sample, alone};

/// One of [many](forward_many) simulations.
#[derive(Clone, Copy)]
pub struct Job<'a> {
    /// The model.
    pub model: &'a Model,
    /// How to run it.
    pub run: &'a Run,
}

/// Models that are alike, from which on they are simulated side by side: a step of a whole pack costs about as much as
/// that of three rods alone.
const FEWEST: usize = 3;

/// Simulates many models on one thread; `observe` and `done` see the place of the run among the jobs, and `done` what
/// [`forward`](super::forward) gives for it.
///
/// Models that are alike but for the values of their parameters are integrated side by side, which takes about
/// half the time. Each run has the steps and the bits that it has alone. Those that cannot be packed run one after
/// another: with a pressure or a law that changes with time, with sensitivities, without any loss, or by a method other than
/// [`Method::Rodas4`]. Runs come to their ends in any order.
pub fn forward_many(
    jobs: &[Job],
    observe: &mut dyn FnMut(usize, &mut Sample) -> ControlFlow<()>,
    done: &mut dyn FnMut(usize, Result<Trajectory, ForwardError>),
) {
    for group in groups(jobs) {
        if group.len() < FEWEST || !can_be_side_by_side(&jobs[group[0]]) {
            for place in group {
                let Job { model, run } = jobs[place];
                done(place, alone(model, run, &mut |sample| observe(place, sample)));
            }
        } else {
            side_by_side(jobs, &group, observe, done);
        }
    }
}

/// Places of jobs that are alike; each of those that cannot be packed alone.
fn groups(jobs: &[Job]) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for (place, job) in jobs.iter().enumerate() {
        let is_own = |group: &&mut Vec<usize>| {
            let first = &jobs[group[0]];
            can_be_side_by_side(first) && are_alike(first.model, job.model)
        };
        let packed = can_be_side_by_side(job);
        match groups.iter_mut().filter(|_| packed).find(is_own) {
            Some(group) => group.push(place),
            None => groups.push(vec![place]),
        }
    }
    groups
}

fn can_be_side_by_side(job: &Job) -> bool {
    let Job { model, run } = job;
    run.method.of(model) == Method::Rodas4 && run.sensitivities.is_empty() && can_be_packed(model)
}

/// A run in a lane.
struct Own<'a> {
    place: usize,
    course: Course<'a>,
    stop: f64,
}

/// Runs models that are alike, with a new one wherever one has ended.
fn side_by_side(
    jobs: &[Job],
    group: &[usize],
    observe: &mut dyn FnMut(usize, &mut Sample) -> ControlFlow<()>,
    done: &mut dyn FnMut(usize, Result<Trajectory, ForwardError>),
) {
    let mut pack = SideBySide::new(&RODAS4, jobs[group[0]].model);
    let mut queue = group.iter().copied();
    let mut lanes: [Option<Own>; RODS] = [const { None }; RODS];
    loop {
        for (rod, lane) in lanes.iter_mut().enumerate() {
            while lane.is_none() {
                let Some(place) = queue.next() else { break };
                let Job { model, run } = jobs[place];
                match Course::new(model, run, run.method) {
                    Err(error) => done(place, Err(error)),
                    Ok((course, state)) => {
                        pack.put(rod, model, state, course.control());
                        *lane = Some(Own { place, course, stop: 0.0 });
                        end_or_go_on(&mut pack, rod, lane, None, observe, done);
                    }
                }
            }
        }
        if lanes.iter().all(Option::is_none) {
            return;
        }
        let stops = std::array::from_fn(|rod| lanes[rod].as_ref().map_or(0.0, |own| own.stop));
        let outcomes = pack.attempt(&stops);
        for (rod, outcome) in outcomes.into_iter().enumerate() {
            if outcome.is_some() {
                end_or_go_on(&mut pack, rod, &mut lanes[rod], outcome, observe, done);
            }
        }
    }
}

/// Takes note of a step that a rod has made, if it has, and ends its run where it is over.
fn end_or_go_on(
    pack: &mut SideBySide,
    rod: usize,
    lane: &mut Option<Own>,
    stepped: Option<Result<(), IntegrateError>>,
    observe: &mut dyn FnMut(usize, &mut Sample) -> ControlFlow<()>,
    done: &mut dyn FnMut(usize, Result<Trajectory, ForwardError>),
) {
    let Some(Own { place, mut course, .. }) = lane.take() else { return };
    let reached = pack.lane(rod);
    let followed = stepped.map_or(Ok(()), |stepped| course.follow(reached, stepped));
    let next = followed.map(|()| course.look(reached, None, &mut |sample| observe(place, sample)));
    match next {
        Ok(Next::Step(stop)) => {
            *lane = Some(Own { place, course, stop });
            return;
        }
        Ok(Next::Over) => done(place, course.done(None)),
        Err(error) => done(place, course.done(Some(error))),
    }
    pack.leave(rod);
}
