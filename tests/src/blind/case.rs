//! A case of a blind bench: an experiment with something hidden in it, or nothing, or an effect removed from
//! the catalogue.

use std::collections::BTreeMap;

use efam_inference::calibrate::{CalibrateError, Problem};
use efam_inference::diagnose::plan::{Prospect, plan};
use models::effects::by_name;

use crate::twin::drawn::Plan;
use crate::twin::hidden::{self, Hidden, IN_CATALOGUE};
use crate::twin::random::Random;

/// Effects of one law. Two differ only in the range of its time, and a relaxation with equal times is the same. A catalogue without one
/// of them still has the law.
const ONE_LAW: [&str; 3] = ["creep", "viscoelastic", "relaxation"];

/// One question.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Case {
    /// What is hidden, with its size in what is typical.
    pub hidden: Vec<(&'static str, f64)>,
    /// Whether it is removed from the catalogue.
    pub is_robbed: bool,
    /// Whether the start is far off and the mesh coarse.
    pub is_decoyed: bool,
    /// Whether releases differ as they do in a laboratory.
    pub is_of_a_laboratory: bool,
    /// Seed of the experiment.
    pub seed: u64,
}

impl Case {
    /// One with nothing hidden; every other seed has a poor start on a coarse mesh.
    pub fn empty(seed: u64) -> Self {
        Self { is_decoyed: seed.is_multiple_of(2), seed, ..Self::default() }
    }

    /// One with an effect hidden.
    pub fn of(name: &'static str, size: f64, seed: u64) -> Self {
        Self { hidden: vec![(name, size)], seed, ..Self::default() }
    }

    /// How it is drawn.
    pub fn plan(&self, with_body: bool) -> Plan {
        let of = |(name, size): &(&'static str, f64)| Hidden::named(name, *size);
        let hidden: Vec<Hidden> = self.hidden.iter().filter_map(of).collect();
        let usual = Plan::usual(&hidden);
        let usual = if self.is_of_a_laboratory { usual.of_a_laboratory() } else { usual };
        if with_body { usual.with_body() } else { usual }
    }

    /// In words.
    pub fn name(&self) -> String {
        let names: Vec<String> =
            self.hidden.iter().map(|(name, size)| format!("{name} x {size:.2}")).collect();
        match (names.is_empty(), self.is_robbed, self.is_decoyed) {
            (true, _, false) => "nothing".to_owned(),
            (true, _, true) => "nothing, decoy".to_owned(),
            (_, true, _) => format!("{}, not in the catalogue", names.join(" + ")),
            _ => names.join(" + "),
        }
    }

    /// Whether the catalogue of the diagnosis holds everything that is hidden.
    pub fn is_known(&self) -> bool {
        !self.is_robbed && self.hidden.iter().all(|(name, _)| by_name(name).is_some())
    }

    /// What is put out of the catalogue: the hidden effect, and what is the same law.
    pub fn excluded(&self) -> Vec<String> {
        let names = self.hidden.iter().filter(|_| self.is_robbed);
        let of = |(name, _): &(&'static str, f64)| {
            if ONE_LAW.contains(name) { ONE_LAW.to_vec() } else { vec![*name] }
        };
        names.flat_map(of).map(str::to_owned).collect()
    }
}

/// Names of effects that are hidden alone: those of the catalogue that no baseline fits.
pub fn kinds() -> impl Iterator<Item = &'static str> {
    hidden::all(1.0)
        .into_iter()
        .take(IN_CATALOGUE)
        .map(|(name, _)| name)
        .filter(|name| !["frame_tilt", "clamp_tilt"].contains(name))
}

/// Names of effects that no catalogue holds.
pub fn strangers() -> impl Iterator<Item = &'static str> {
    hidden::all(1.0).into_iter().skip(IN_CATALOGUE).map(|(name, _)| name)
}

/// From which size on, in what is typical, an effect is detectable, and from which it is separable from all others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// It is seen.
    pub detectable_from: f64,
    /// It is separable from others; 5 standard deviations apart.
    pub separable_from: f64,
    /// The largest plausible.
    pub largest: f64,
}

impl Limits {
    /// The same where the noise is some times as large.
    pub fn at_noise(self, times: f64) -> Self {
        let Limits { detectable_from, separable_from, largest } = self;
        Self { detectable_from: detectable_from * times, separable_from: separable_from * times, largest }
    }

    /// Distance of an effect of a size from its nearest, standard deviations.
    pub fn distance(&self, size: f64) -> f64 {
        5.0 * size / self.separable_from
    }

    /// A size between one and a hundred detection limits, as often in any octave, but believable.
    pub fn drawn(&self, random: &mut Random) -> f64 {
        let largest = (100.0 * self.detectable_from).min(self.largest).max(self.detectable_from);
        (random.between(self.detectable_from.ln(), largest.ln())).exp()
    }
}

/// The limits of all kinds in an experiment, as `efam diagnose --plan` foresees them.
/// # Errors
/// [`CalibrateError`] for one that cannot be simulated.
pub fn limits(problem: &Problem) -> Result<BTreeMap<&'static str, Limits>, CalibrateError> {
    let prospects = plan(problem, None, &|_| ())?;
    let of = |name: &'static str| {
        let typical = Hidden::named(name, 1.0)?;
        let is_its = |own: &&Prospect| {
            let is_near = |(name, value): (&str, f64)| {
                let mut tried = own.tried.iter().filter(|(own, _)| own == name);
                tried.all(|(_, tried)| (tried / value).ln().abs() < 0.8)
            };
            own.effect == name && own.parameter == typical.parameter() && typical.beside().is_none_or(is_near)
        };
        let prospect = prospects.iter().find(is_its)?;
        let typical = typical.strength().abs();
        let limits = Limits {
            detectable_from: prospect.detectable_from / typical,
            separable_from: prospect.separable_from / typical,
            largest: prospect.largest_plausible.map_or(f64::INFINITY, |largest| largest / typical),
        };
        limits.detectable_from.is_finite().then_some((name, limits))
    };
    Ok(kinds().filter_map(of).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_law_is_removed_under_all_its_names() {
        let without = |name| Case { is_robbed: true, ..Case::of(name, 1.0, 1) }.excluded();
        assert_eq!(without("creep"), ONE_LAW);
        assert_eq!(without("dahl"), ["dahl"]);
        assert!(Case::of("creep", 1.0, 1).excluded().is_empty());
    }
}
